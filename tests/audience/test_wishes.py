"""What a page of the audience may wish, and what comes of it."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.audience.wishes import (
    MOST_MOMENTS,
    OFFERED,
    Follow,
    LookAround,
    Wish,
    look_of,
    offer_of,
    offered_step,
)
from app.live.snapshot import take
from app.picture.layers import LAYERS
from app.picture.look import OF_TRIAL
from app.picture.theme import DARK, LIGHT
from learners.run import Run
from tests.support.live import preset_of

DECODER = msgspec.json.Decoder(Wish)


def test_a_page_says_what_it_wishes() -> None:
    assert DECODER.decode('{"do": "follow", "dark": true}') == Follow(True)
    wish = '{"do": "look", "dark": false, "layer": "reach", "of": 1, "frame": 3, "step": 70}'
    assert DECODER.decode(wish) == LookAround(False, "reach", 1, 3, 70)


@pytest.mark.parametrize(
    "message",
    [
        '{"do": "follow"}',
        '{"do": "follow", "dark": 1}',
        '{"do": "follow", "dark": true, "step": 3}',
        '{"do": "look", "dark": true, "step": -1}',
        '{"do": "look", "dark": true, "step": 1.5}',
        '{"do": "look", "dark": true, "frame": -3}',
        '{"do": "look", "dark": true, "frame": 8}',
        '{"do": "look", "dark": true, "of": 64}',
        '{"do": "look", "dark": true, "layer": "' + "x" * 33 + '"}',
        '{"do": "look", "dark": true, "line": 1}',
        '{"do": "play", "direction": 1}',
        '{"do": "seek", "step": 1}',
    ],
)
def test_nothing_else_is_a_wish(message: str) -> None:
    with pytest.raises(msgspec.MsgspecError):
        DECODER.decode(message)


def test_a_look_is_one_that_is_offered() -> None:
    for layer in (*LAYERS, "nothing"):
        look = look_of(LookAround(False, layer, 5, 2))
        assert look.layer in OFFERED
        chosen = LAYERS[look.layer]
        assert look.option == (5 if chosen.about != "nothing" else 0)
        assert look.frame == (2 if "frame" in chosen.heeds else OF_TRIAL)
        assert look.theme == LIGHT
    assert look_of(LookAround(True)).theme == DARK


@given(st.integers(0, 2**53), st.integers(0, 10**9), st.lists(st.integers(0, 10**9), max_size=5))
def test_few_moments_are_told_apart(step: int, end: int, events: list[int]) -> None:
    found = offered_step(step, end, tuple(events))
    assert 0 <= found <= end
    assert found == min(step, end) or min(step, end) not in events
    # The one before, and near.
    assert 0 <= min(step, end) - found <= 2 * end / MOST_MOMENTS


@given(st.integers(1, 10**7))
def test_there_are_no_more_of_them(end: int) -> None:
    steps = range(0, end, max(end // 5_000, 1))
    assert len({offered_step(step, end, ()) for step in steps}) <= MOST_MOMENTS + 1


@given(st.integers(0, 10**6), st.integers(1, 10**6), st.integers(0, 10**6))
def test_a_line_that_grows_has_no_moments_between(step: int, end: int, more: int) -> None:
    later = offered_step(step, end + more, ())
    assert offered_step(later, end, ()) == later or later > end


def test_what_can_be_chosen_is_what_a_learner_has() -> None:
    for name, skills in (("timed", 3), ("standard_q", 0)):
        offer = offer_of(take(Run(preset_of(name), 0), name, 1))
        layers = {layer["key"]: layer for layer in offer["layers"]}  # type: ignore[index]
        assert set(layers) <= set(OFFERED)
        assert ("skill" in layers) == bool(skills)
        assert len(layers["option"]["of"]) == (skills or 9)
