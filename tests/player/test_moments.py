"""A moment as it is sent: the hunt, what is named, and what is read beside the board."""

import re
from dataclasses import replace

import pytest

from app.documents import presets
from app.live import snapshot
from app.live.opening import Opening
from app.live.session import Session
from app.live.snapshot import Snapshot, TrialEnd
from app.live.status import Status
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import ALL, FOLDED, OF_TRIAL, Look
from app.picture.theme import DARK, LIGHT, OUTCOME_SHAPES
from app.player.boards import ground_sent, over_sent, world_key, world_sent
from app.player.moments import manner_of, moment_sent, words_sent
from learners.run import Run
from sim.world import CAPTURE, board_xy, cell_at

SIZE = 40
SPEC = presets.load("timed", [f"world.size={SIZE}"])


def moment(trial: int = 20, steps: int = 5) -> Snapshot:
    run = Run(SPEC, seed=1)
    run.advance(until_trial=trial)
    run.advance(max_steps=steps)
    return snapshot.take(run, "timed", 0)


@pytest.fixture
def status() -> Status:
    """Of a session that stands still, and was never begun."""
    return replace(Session(SPEC, "timed", 1, 1000.0, False).status, preparing=False)


def test_the_predator_is_sent_where_it_is_with_the_way_that_it_came() -> None:
    taken = moment()
    sent = ground_sent(taken, Look(frame=OF_TRIAL), Extras())
    hunt = sent["hunt"]
    x, y = board_xy(taken.world, taken.cell)
    assert hunt["predator"] == [x - SIZE // 2, y - SIZE // 2]
    assert hunt["trail"][-2:] == hunt["predator"]
    assert len(hunt["trail"]) == 2 * len(taken.trail)
    assert (sent["prey"], hunt["turned"]) == (taken.heading, False)
    folded = ground_sent(taken, Look(), Extras())
    assert (folded["prey"], folded["round"]) == (0, True)
    assert folded["hunt"]["turned"] == (taken.heading != 0)


def test_there_is_no_hunt_where_none_is_wished_or_all_headings_are_seen() -> None:
    taken = moment()
    assert ground_sent(taken, Look(frame=ALL), Extras())["hunt"] is None
    without = ground_sent(taken, Look(hunts=False), Extras())["hunt"]
    assert (without["predator"], without["trail"], without["ends"]) == (None, [], [])
    assert ground_sent(taken, Look(trail=False), Extras())["hunt"]["trail"] == []


def test_a_trial_that_has_just_ended_is_shown_where_the_learner_rests() -> None:
    taken = replace(
        moment(steps=0), ends=(TrialEnd(19, cell_at(moment().world, 20, 20), 0, CAPTURE),)
    )
    rests = ground_sent(taken, Look(), Extras(), rests=True)["hunt"]
    assert rests["ended"]["shape"] == OUTCOME_SHAPES[CAPTURE]
    assert [word for word, *_ in rests["words"]] == ["caught"]
    assert "ended" not in ground_sent(taken, Look(), Extras())["hunt"]


def test_prey_and_predator_are_named_as_long_as_they_are_to_be_met(status: Status) -> None:
    opening = replace(status, opening=Opening(1, 3, rising=False))
    assert manner_of(opening) == (True, True)
    words = moment_sent(opening, Look(), Extras())["board"]["hunt"]["words"]
    assert [word for word, *_ in words] == ["what it sees", "prey", "predator"]
    rising = replace(status, playing=True, opening=Opening(3, 3, rising=True))
    assert manner_of(rising) == (False, False)
    assert manner_of(moment()) == (True, False)


def test_lines_are_of_the_view_that_they_were_found_in() -> None:
    taken = moment()
    looks = [
        Look(layer=layer, frame=frame)
        for layer in ("value", "reach", "flow")
        for frame in (FOLDED, 0, 1, ALL)
    ]
    views = [ground_sent(taken, look, Extras())["view"] for look in looks]
    assert len(set(views)) == len(views)
    assert [over_sent(taken, look, Extras())["over"] for look in looks] == views


def test_what_is_drawn_over_a_layer_is_sent_where_it_is_wished() -> None:
    taken = moment()
    assert over_sent(taken, Look(layer="now"), Extras())["lines"] == []
    for wish in ("grid", "sensors", "start_zone", "paths"):
        lines = over_sent(taken, Look(layer="now", **{wish: True}), Extras())["lines"]
        assert lines, wish
        assert all(len(piece) >= 4 for line in lines for piece in line["points"])


def test_arrows_have_a_tail_and_a_head() -> None:
    lines = over_sent(moment(), Look(layer="flow", frame=0), Extras())["lines"]
    assert lines
    assert all(line["arrows"] and len(piece) == 4 for line in lines for piece in line["points"])


def test_a_world_is_known_by_all_that_is_drawn_of_it() -> None:
    settings = ("world.size=41", "world.n_directions=16", "world.vision_radius=20")
    others = [
        *(presets.load("timed", [f"world.size={SIZE}", setting]).world for setting in settings),
        presets.load("timed", [f"world.size={SIZE}", "world.skill_n_distances=9"]).world,
    ]
    assert len({world_key(world) for world in (SPEC.world, *others)}) == 1 + len(others)
    same = presets.load("standard_q", [f"world.size={SIZE}", "world.capture_reward=7"]).world
    assert world_sent(same) == world_sent(SPEC.world)


@pytest.mark.parametrize("key", LAYERS)
def test_what_is_read_beside_a_board_is_there_for_each_layer(key: str, status: Status) -> None:
    taken = moment()
    for of in (taken, replace(status, snapshot=taken)):
        words = words_sent(of, Look(layer=key, frame=ALL), Extras())
        assert (words["step"], words["trial"]) == (taken.step, taken.trial)
        assert words["caption"]
        assert "pounce-legend" in words["legend"]
        assert "Success" in words["readings"]
        assert words["described"].startswith(f"The board, {SIZE} by {SIZE} cells")
        assert LAYERS[key].title in words["described"]
        assert "<" not in words["described"]
    assert words_sent(status, Look(), Extras())["sentence"].startswith("Paused.")
    assert not words_sent(taken, Look(), Extras())["sentence"].startswith("Paused.")


def test_colours_are_those_of_the_theme() -> None:
    for theme in (LIGHT, DARK):
        sent = ground_sent(moment(), Look(theme=theme), Extras())["theme"]
        assert sent["dark"] == theme.is_dark
        assert sent["predator"] == f"rgb({','.join(map(str, theme.predator))})"
        assert all(re.fullmatch(r"rgb\(\d+,\d+,\d+\)", sent[name]) for name in theme._fields)
