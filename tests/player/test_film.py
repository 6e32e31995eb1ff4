"""A film gives back, to the last colour and point, what was put into it."""

import base64
import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.live.snapshot import take
from app.picture.look import Look
from app.picture.theme import DARK, LIGHT
from app.player.boards import board_sent, world_sent
from app.player.film import PLANES, Film, Shot, View
from app.player.reel import FRAMES, LAYERS_SHOWN, NOTHING, recorded_run, shots_of, stops_of
from app.player.sketch import colours_on
from tests.support.films import unpacked
from tests.support.replays import small_branchy, small_recorded
from tests.support.schedules import small_spec


def read_back(board: dict[str, Any]) -> dict[str, Any]:
    """A board as JSON has it, with each plane that is as the first."""
    found = json.loads(json.dumps(board))
    return dict.fromkeys(PLANES, found["colours"]) | found


def same(shots: list[Shot], found: list[Shot]) -> None:
    assert len(shots) == len(found)
    for shot, back in zip(shots, found, strict=True):
        assert back._replace(views={}) == shot._replace(views={})
        assert back.views.keys() == shot.views.keys()
        for name, view in shot.views.items():
            assert back.views[name].texts == view.texts
            for one, other in (
                (view.light, back.views[name].light),
                (view.dark, back.views[name].dark),
            ):
                assert read_back(other) == read_back(one)


@pytest.mark.parametrize("preset", ["timed", "standard_q"])
def test_what_is_unpacked_is_what_was_filmed(preset: str) -> None:
    if preset == "timed":
        recorded = small_branchy()
    else:
        from app.documents import presets

        settings = ("world.size=30", "world.n_distances=6", "world.step_limit=60", "trials=300")
        recorded = recorded_run(presets.load(preset, settings), preset, 3)
    shots = list(shots_of(recorded, stops_of(recorded, 14)))
    film = Film()
    for shot in shots:
        film.add(shot)
    same(shots, unpacked(film.packed(range(len(shots)))))
    some = [0, 3, len(shots) - 1]
    same([shots[place] for place in some], unpacked(film.packed(some)))


def test_a_film_shows_at_each_moment_what_the_layer_paints() -> None:
    recorded = small_recorded()
    stops = stops_of(recorded, 6)
    film = Film()
    for shot in shots_of(recorded, stops):
        film.add(shot)
    world = world_sent(small_spec().world)
    for stop, shot in zip(stops, unpacked(film.packed(range(len(stops)))), strict=True):
        run = recorded.pasts[0].run_at(stop.step)
        assert run is not None
        snapshot = take(run, "timed", 0)
        for layer in LAYERS_SHOWN:
            for name, frame in FRAMES.items():
                view = shot.views[f"{layer}/{name}"]
                for theme, board in ((LIGHT, view.light), (DARK, view.dark)):
                    look = Look(theme, layer, frame=frame)
                    # On dark pages as well, though lines there are inked anew.
                    assert read_back(board_sent(snapshot, look, NOTHING)) == read_back(board)
        folded = shot.views["value/turned"].light
        from app.picture.layers import LAYERS

        picture = LAYERS["value"].paint(snapshot, Look(), NOTHING)
        size = world["size"]
        assert np.array_equal(colours_on(folded, world, size).reshape(-1, 3), picture.colours)


def test_a_view_of_more_colours_than_a_byte_tells_apart_is_exact_too() -> None:
    rng = np.random.default_rng(0)
    film, shots = Film(), list[Shot]()
    for number in range(5):
        boards = [
            {
                "colours": base64.b64encode(rng.integers(0, 256, 900, np.uint8).tobytes()).decode(),
                "lines": [],
                "hunt": None,
                "labels": [],
            }
            for _ in range(2)
        ]
        shots.append(Shot(0, number, number, (), {"a": View(*boards, ())}))
        film.add(shots[-1])
    same(shots, unpacked(film.packed(range(5))))


points = st.lists(st.integers(-9_000, 9_000).map(lambda n: n / 100), min_size=2, max_size=8)
lines = st.lists(
    st.fixed_dictionaries(
        {
            "colour": st.sampled_from(["rgb(1,2,3)", "rgb(4,5,6)"]),
            "width": st.sampled_from([1.0, 2.5]),
            "points": st.lists(points.map(lambda p: p[: len(p) // 2 * 2]), max_size=3),
        }
    ),
    max_size=3,
)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(lines, st.booleans(), st.text(max_size=5)), min_size=1, max_size=4))
def test_any_lines_and_texts_come_back(moments: list[tuple[Any, bool, str]]) -> None:
    film, shots = Film(), list[Shot]()
    for number, (drawn, has_dots, text) in enumerate(moments):
        planes = ["colours", "dots"] if has_dots else ["colours"]
        board: dict[str, Any] = {
            plane: base64.b64encode(bytes([number, place, 7] * 4)).decode()
            for place, plane in enumerate(planes)
        }
        hunt = {"trail": [0.5, 1.0, 2.25, 3.0], "ends": [text]} if has_dots else None
        board |= {"lines": drawn, "labels": [[text, 1.5, 2]], "hunt": hunt}
        shots.append(Shot(0, number, number, (text,), {"a": View(board, board, (text, "b"))}))
        film.add(shots[-1])
    same(shots, unpacked(film.packed(range(len(shots)))))
