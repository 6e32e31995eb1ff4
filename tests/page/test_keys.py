"""Which keys act where a lesson shows a few controls."""

from app.documents.lesson_cards import CONTROLS
from app.page.keys import KEYS, keys_of
from app.picture.layers import LAYERS as PICTURED


def test_a_lessons_keys_are_those_of_its_controls() -> None:
    assert keys_of([]) == []
    assert keys_of(["play", "speed", "layer.value", "inspect"]) == [
        "Digit1",
        "KeyJ",
        "KeyK",
        "Space",
    ]
    assert set(keys_of(["all"])) == {key.name for key in KEYS}


def test_every_control_has_its_own_keys_and_no_others() -> None:
    with_keys = {name: set(keys_of([name])) for name in CONTROLS if name != "all"}
    for name, keys in with_keys.items():
        for other, others in with_keys.items():
            assert name == other or not keys & others, (name, other)
    # The first ten layers have a digit each.
    digits = [keys_of([f"layer.{layer}"]) for layer in list(PICTURED)[:10]]
    assert all(len(keys) == 1 for keys in digits)
