"""What layers show of learners that select by a rule, keep choices, have traces or a manager."""

import dataclasses
import functools
from typing import Any

import numpy as np
import pytest

from app.documents import presets
from app.live import snapshot
from app.live.snapshot import HeldChoice, Snapshot
from app.picture.colours import OPTION_COLOURS, TRACES, amount_colours, css
from app.picture.counted import counted_by
from app.picture.giving_way import costs, minds
from app.picture.layer import Extras, Picture
from app.picture.layers import LAYERS
from app.picture.look import FOLDED, OF_TRIAL, Look
from app.picture.theme import LIGHT
from learners.comparators.feudal import Commanded
from learners.kernel import rows
from learners.run import Run
from sim.geometry import MOVES, N_MOVES
from sim.spec import N_HEADINGS

SIZE = 120
APPETITE, FEAR = 0, 1
EAST, WEST = (MOVES.tolist().index(way) for way in ([1, 0], [-1, 0]))
LACKING = {
    "timed": {"stake", "traces"},
    "standard_q": {"skill", "stake", "traces"},
    "static_appetite_fear": {"option", "advantage", "change", "traces"},
    "q_lambda": {"skill", "stake"},
    "feudal": {"stake"},
    "timed_held": {"stake"},
    "standard_q_held": {"skill", "stake"},
}


@functools.cache
def fresh(preset: str, *settings: str) -> Snapshot:
    """A moment before the first step."""
    return snapshot.take(Run(presets.load(preset, settings), 1), preset, 0)


def paint(key: str, moment: Snapshot, **look: Any) -> Picture:
    return LAYERS[key].paint(moment, Look(layer=key, **look), Extras())


def words(key: str, moment: Snapshot, **look: Any) -> tuple[str, str]:
    """Legend and caption."""
    layer, looking = LAYERS[key], Look(layer=key, **look)
    legend = layer.legend(moment, looking, Extras()).striptags()
    return legend, layer.caption(moment, looking, Extras())


def colour_at(picture: Picture, east: int, north: int) -> list[int]:
    return picture.colours.reshape(SIZE, SIZE, 3)[60 + north, 60 + east].tolist()


def at_odds(rule: str = "collective", *, fears: float = -50.0, wins: float = 1.0) -> Snapshot:
    """Appetite gains by going east in all places, of which fear dreads as much everywhere."""
    run = Run(presets.load("static_appetite_fear", [f"learner.selection={rule}"]), 1)
    run.advance(max_steps=1)
    values = rows.values(run.state.skills)
    half = len(values) // 2
    values[:, :N_MOVES] = 0
    values[:half, EAST] = wins
    values[half:, EAST] = fears
    rows.rescan_all(run.state.skills, run.state.skill_words)
    return snapshot.take(run, "static_appetite_fear", 0)


# What there is to see of whom ---------------------------------------------------------------


@pytest.mark.parametrize("preset", LACKING)
def test_what_makes_no_sense_is_in_the_list_with_the_reason(preset: str) -> None:
    moment = fresh(preset)
    learner = moment.spec.learner
    assert {key for key, layer in LAYERS.items() if layer.lacks(learner)} == LACKING[preset]
    for key in LACKING[preset]:
        layer, lack = LAYERS[key], LAYERS[key].lacks(learner)
        assert lack is not None
        assert layer.listed(learner) == f"{layer.title_of(learner)} ({lack.word})"
        legend, caption = words(key, moment)
        assert caption == lack.why
        assert lack.word in legend
        assert (paint(key, moment).colours == LIGHT.unknown).all()
        assert len(caption) <= 160


def test_names_of_layers_are_those_of_what_they_show() -> None:
    named = {preset: fresh(preset).spec.learner for preset in LACKING}
    chosen = {preset: LAYERS["chosen"].listed(learner) for preset, learner in named.items()}
    assert chosen["timed"] == "Chosen skill"
    assert chosen["standard_q"] == chosen["q_lambda"] == "Chosen move"
    assert chosen["feudal"] == "Commands of the manager"
    assert chosen["static_appetite_fear"] == "Who decides"
    assert LAYERS["value"].listed(named["static_appetite_fear"]) == "Best happiness"
    assert LAYERS["traces"].listed(named["q_lambda"]) == "Eligibility now"
    assert LAYERS["traces"].listed(named["feudal"]) == "Command that holds"
    assert LAYERS["traces"].listed(named["timed_held"]) == "Choice that holds"
    by_w = presets.load("static_appetite_fear", ["learner.selection=w_learning"]).learner
    assert LAYERS["stake"].listed(by_w) == "W values"


@pytest.mark.parametrize(
    ("preset", "noun"),
    [
        ("timed", "steps"),
        ("standard_q_held", "steps"),
        ("timed_held", "choices"),
        ("feudal", "commands"),
        ("q_lambda", "steps"),
    ],
)
def test_a_value_counts_what_it_is_discounted_by(preset: str, noun: str) -> None:
    legend, _ = words("value", fresh(preset))
    counted = counted_by(fresh(preset).spec.learner)
    assert counted is not None
    assert counted.nouns == noun
    assert f"as {noun} to capture" in legend
    assert f"{counted.lines[0]:.0f}, {counted.lines[1]:.0f} and" in legend


def test_the_happiest_of_skills_says_nothing_of_how_far_a_capture_is() -> None:
    legend, caption = words("value", at_odds())
    assert "Own reward" in legend
    assert "to capture" not in legend
    assert "No table says what a place is worth" in caption


def test_what_counts_other_things_cannot_be_set_against_another() -> None:
    one, other = fresh("timed"), fresh("timed_held")
    layer = LAYERS["change"]
    extras = Extras(since=other, names=("timed_held", "timed"))
    assert "cannot be" in layer.caption(one, Look(layer="change"), extras)


# Rules --------------------------------------------------------------------------------------


def test_who_gives_way_is_whom_the_move_costs_something() -> None:
    moment = at_odds()
    # East is worth 1 to appetite and -50 to fear: together all other moves are worth more.
    lost = costs(moment)
    assert lost[APPETITE] == pytest.approx(1.0)
    assert lost[FEAR] == pytest.approx(0.0)
    assert minds(moment)[APPETITE].all()
    assert not minds(moment)[FEAR].any()
    picture = paint("chosen", moment)
    assert colour_at(picture, -20, 5) == OPTION_COLOURS[FEAR].astype(int).tolist()
    assert "Which skill has its way" in words("chosen", moment)[1]
    # And where the happiest decides, fear pays for it.
    moment = at_odds("best_happiness")
    assert costs(moment)[FEAR] == pytest.approx(50.0)
    picture = paint("chosen", moment)
    assert colour_at(picture, -20, 5) == OPTION_COLOURS[APPETITE].astype(int).tolist()


def test_where_a_move_costs_nobody_anything_they_agree() -> None:
    moment = at_odds(fears=0.0)
    assert not minds(moment).any()
    picture = paint("chosen", moment)
    colour = colour_at(picture, -20, 5)
    assert colour not in (LIGHT.unknown, *OPTION_COLOURS.astype(int).tolist())
    assert f"background:{css(np.array(colour))}" in str(
        LAYERS["chosen"].legend(moment, Look(layer="chosen"), Extras())
    )
    assert "they agree" in picture.names


def test_the_cost_of_giving_way_is_of_the_skill_that_is_chosen() -> None:
    moment = at_odds()
    appetite, fear = (paint("stake", moment, option=skill) for skill in (APPETITE, FEAR))
    assert colour_at(appetite, -20, 5) != list(LIGHT.unknown)
    assert (fear.colours == LIGHT.unknown).all()
    assert "appetite gives way" in words("stake", moment, option=APPETITE)[1]
    assert "nowhere now" in words("stake", moment, option=FEAR)[1]


def test_what_has_only_something_to_lose_shows_what_it_fears() -> None:
    moment = at_odds()
    legend, caption = words("skill", moment, option=FEAR)
    assert "worst move" in legend
    assert "-50" in legend
    assert "learned to fear" in caption
    worst = colour_at(paint("skill", moment, option=FEAR), -20, 5)
    mild = colour_at(paint("skill", at_odds(fears=-5.0), option=FEAR), -20, 5)
    # Both in the colour of flight, the worse the more of it.
    assert (
        np.abs(np.subtract(worst, LIGHT.flight)).sum()
        < np.abs(np.subtract(mild, LIGHT.flight)).sum()
    )


def test_a_skill_that_sees_headings_is_shown_as_all_else_is() -> None:
    layer, learner = LAYERS["skill"], fresh("feudal").spec.learner
    assert layer.heeded(Look(layer="skill", option=4, frame=FOLDED), learner).frame == FOLDED
    assert layer.heeded(Look(layer="skill", option=0, frame=FOLDED), learner).frame == OF_TRIAL


# What is kept -------------------------------------------------------------------------------


def test_traces_are_where_the_hunt_has_just_come_through() -> None:
    base = fresh("q_lambda")
    traces = np.zeros((*base.value.shape, 9), np.float32)
    ring, direction = 8, 8
    traces[base.heading, ring, direction, EAST] = 1.0
    moment = dataclasses.replace(base, eligibility=traces)
    for frame in (FOLDED, OF_TRIAL):
        colours = paint("traces", moment, frame=frame).colours
        full = np.rint(amount_colours(TRACES, LIGHT)[-1]).astype(np.uint8)
        assert (colours == full).all(axis=-1).any()
    assert "begins without traces" in words("traces", base)[1]
    assert "just come through" in words("traces", moment)[1]


def test_the_region_of_the_command_that_holds_is_coloured() -> None:
    moment = dataclasses.replace(fresh("feudal"), commanded=Commanded(2, 9, 12))
    colours = paint("traces", moment, frame=OF_TRIAL).colours
    share = (colours != LIGHT.unknown).any(axis=-1).mean()
    # A region of 3 by 3 of 18 rings and 24 sectors.
    assert 0 < share < 0.1
    assert "Inwards was commanded here 12 steps ago" in words("traces", moment)[1]


def test_the_place_of_the_choice_that_holds_is_coloured() -> None:
    base = fresh("standard_q_held")
    state = (base.heading * 18 + 9) * 24 + 3
    moment = dataclasses.replace(base, held=HeldChoice(EAST, state, 3))
    assert (paint("traces", moment).colours != LIGHT.unknown).any()
    caption = words("traces", moment)[1]
    assert caption.startswith("Moving east was chosen here 3 steps ago")
    assert "one is made with the next step" in words("traces", base)[1]


def test_a_run_that_keeps_choices_says_which() -> None:
    run = Run(presets.load("standard_q_held"), 1)
    seen: set[int] = set()
    for _ in range(40):
        run.advance(max_steps=1)
        held = snapshot.take(run, "standard_q_held", 0).held
        if held is not None:
            assert 1 <= held.steps < 10
            assert 0 <= held.state < N_HEADINGS * 18 * 24
            seen.add(held.steps)
    assert len(seen) > 1


def test_lines_part_the_regions_of_a_manager() -> None:
    (line,) = paint("chosen", fresh("feudal")).over().contours
    # Arcs between rings of regions, and rays between their sectors.
    away = np.unique(np.round(np.hypot(*line.segments.reshape(-1, 2).T), 3))
    assert len(away) > 5
    assert "Lines: regions" in words("chosen", fresh("feudal"))[0]
    assert paint("chosen", fresh("timed")).over().contours == ()
