"""The sentence says what is going on: on moments made by hand, and on real runs."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from app.documents import presets
from app.explain import sentence
from app.explain.sentence import RECENT_REACH_TRIALS, Front
from app.explain.shape import shape_of
from app.live import snapshot
from app.live.held import Opened
from app.live.places import Behind
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.status import Status
from learners.commands import (
    Command,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    StopExploring,
)
from learners.control import Episode
from learners.measures import Endings
from learners.run import Run
from learners.spec import RunSpec
from sim import geometry
from sim.spec import N_HEADINGS, WorldSpec
from tests.support.schedules import ruled_spec

SEEDS = (1, 2, 3)


def spec_of(*settings: str, preset: str = "timed") -> RunSpec:
    """A preset."""
    return presets.load(preset, settings)


def status_of(run: Run, **parts: object) -> Status:
    """A playing session at the moment that a run is at, with some parts replaced."""
    return status_at(snapshot.take(run, "timed", 0), **parts)


def status_at(taken: Snapshot, **parts: object) -> Status:
    """A playing session at a moment, with some parts replaced."""
    idle = Session(taken.spec, "timed", seed=1, speed=100.0, playing=True).status
    return replace(idle, snapshot=taken, preparing=False, **parts)


def in_words(status: Status) -> str:
    """The sentence as a plain text."""
    return sentence.said(status).striptags()


def sentence_at(run: Run, trial: int) -> str:
    """The sentence when a run gets to a trial."""
    run.advance(until_trial=trial)
    return in_words(status_of(run))


# Where the front is

WORLD = WorldSpec(n_distances=3)
DEGREES = 360 // WORLD.n_directions


def reached(*places: tuple[int, float], heading: int = 0, trial: int = 0) -> np.ndarray:
    """Trials of first reach: so many degrees from straight behind the prey, in some rings."""
    reach = np.full((N_HEADINGS, WORLD.n_distances, WORLD.n_directions), -1, np.int32)
    for ring, from_behind in places:
        bearing = 180 + from_behind + 45 * heading
        reach[heading, ring, int(bearing / DEGREES) % WORLD.n_directions] = trial
    return reach


def front_of(reach: np.ndarray, trial: int = 0) -> Front:
    """The front at a trial."""
    return sentence.front(WORLD, reach, trial)


@pytest.mark.parametrize(
    ("from_behind", "expected"),
    [
        (0, Front(0, 0, 0, 0)),
        (15, Front(1, 0, 0, 0)),
        (60, Front(1, 0, 0, 0)),
        (90, Front(1, 0, 1, 0)),
        (-15, Front(0, 1, 0, 0)),
        (-90, Front(0, 1, 1, 0)),
        (105, Front(0, 0, 0, 1)),
        (180, Front(0, 0, 0, 1)),
        (-105, Front(0, 0, 0, 1)),
    ],
)
@pytest.mark.parametrize("heading", [0, 3, 6])
def test_a_place_counts_by_its_side_and_by_the_preys_sight(
    from_behind: float, expected: Front, heading: int
) -> None:
    # Counter-clockwise of straight behind, for a prey that looks right, is the lower half.
    assert front_of(reached((0, from_behind), heading=heading)) == expected


def test_what_lies_beyond_the_preys_sight_is_out_of_it_even_in_front() -> None:
    outer = geometry.ring_edges(WORLD)
    assert outer[0] < WORLD.vision_radius < outer[1]
    assert front_of(reached((2, 180 - 45))) == Front(1, 0, 1, 0)


def test_only_what_was_reached_lately_belongs_to_the_front() -> None:
    reach = reached((0, 15), trial=500)
    assert front_of(reach, 500 + RECENT_REACH_TRIALS - 1).counterclockwise == 1
    assert front_of(reach, 500 + RECENT_REACH_TRIALS) == Front(0, 0, 0, 0)


def test_each_heading_counts_on_its_own() -> None:
    both = np.maximum(reached((0, -30), heading=2), reached((0, -30), heading=5))
    assert front_of(both) == Front(0, 2, 0, 0)


# Sentences on moments made by hand


def spreading(*places: tuple[int, float]) -> Status:
    """A moment at which value rose lately in some places, for all headings."""
    spec = spec_of("world.n_distances=3")
    reach = np.maximum.reduce([reached(*places, heading=heading) for heading in range(N_HEADINGS)])
    taken = snapshot.take(Run(spec, seed=1), "timed", 0)
    quiet = replace(taken.control, frozen_until=0)
    return status_at(
        replace(
            taken,
            first_reach=reach,
            value=(reach >= 0).astype(np.float32),
            control=quiet,
            selection_frozen=False,
            recent=Endings(captures=1, flights=1, timeouts=2),
        )
    )


BEHIND = [(0, -30), (0, -15), (0, 15), (0, 30)]


def test_growth_behind_the_prey_is_a_cone() -> None:
    assert in_words(spreading(*BEHIND)) == (
        "One skill: approach. Value spreads back from the prey as a cone: from there it sees nobody"
        " come."
    )


def test_growth_on_both_sides_is_a_ring() -> None:
    both = [(1, 90), (1, -90), (1, 105), (1, -105)]
    said = in_words(spreading(*both, *BEHIND))
    assert said.endswith("Value spreads to both sides round the prey, on its way to a ring.")


def test_growth_to_one_side_goes_counter_clockwise() -> None:
    one_side = [(1, 60), (1, 75), (1, 90), (1, 105)]
    said = in_words(spreading(*one_side, *BEHIND))
    assert said.endswith("Value spreads counter-clockwise: an arm grows out of the cone.")


def test_growth_to_the_other_side_goes_clockwise() -> None:
    other_side = [(1, -60), (1, -75), (1, -90), (1, -105)]
    said = in_words(spreading(*other_side, *BEHIND))
    assert "Value spreads clockwise: an arm" in said


def test_growth_in_sight_of_the_prey_goes_inwards() -> None:
    in_front = [(0, 120), (0, 150), (0, 180), (0, -150), (0, -120)]
    said = in_words(spreading(*in_front, *BEHIND))
    assert said.endswith(". Value spreads inwards, into what the prey sees.")


@pytest.mark.parametrize(
    ("from_behind", "shape"),
    [
        (range(-45, 46, 15), "it is a cone behind the prey;"),
        (range(-45, 121, 15), "it is a cone behind the prey with an arm round it;"),
        (range(-45, 196, 15), "it is a ring round the prey with a gap;"),
        (range(-180, 180, 15), "nearly all round the prey is filled;"),
        ((), "only a few places have any yet;"),
    ],
)
def test_growth_that_is_over_is_said_with_its_shape_and_the_success(
    from_behind: Sequence[int], shape: str
) -> None:
    places = [(ring, degrees) for degrees in from_behind for ring in range(3)]
    status = spreading(*places, (0, 0))
    later = replace(status.snapshot, trial=RECENT_REACH_TRIALS)
    assert in_words(replace(status, snapshot=later)) == (
        f"One skill: approach. Value hardly spreads any more: {shape} 25% of recent hunts end in"
        " capture."
    )


def test_before_the_first_capture_nothing_is_worth_anything() -> None:
    run = Run(spec_of(preset="hierarchical_3"), seed=1)
    assert in_words(status_of(run)) == (
        "Three skills: approach, circle clockwise and avoid."
        " No prey has been caught yet, so no place is of any value."
    )


def test_primitive_moves_are_no_skills() -> None:
    run = Run(spec_of(preset="standard_q"), seed=1)
    assert in_words(status_of(run)).startswith("Nine moves, no skills. No prey has been")


def test_commands_are_no_skills() -> None:
    run = Run(spec_of(preset="feudal"), seed=1)
    said = in_words(status_of(run))
    assert said.startswith(
        "A manager with five commands, no skills. A command holds until the predator leaves the"
        " region. No prey has been"
    )


def test_two_skills_and_three_are_listed_in_the_order_in_which_they_came() -> None:
    run = Run(spec_of(), seed=1)
    run.apply(FollowSchedule(False))  # and with it the explorations that it would bring
    run.apply(Introduce("avoid", 0))
    assert in_words(status_of(run)).startswith("Two skills: approach and avoid.")
    run.apply(Introduce("circle_clockwise", 0))
    assert in_words(status_of(run)).startswith(
        "Three skills: approach, avoid and circle clockwise."
    )


def test_the_first_skill_is_said_to_be_practised_first() -> None:
    assert in_words(status_of(Run(spec_of(), seed=1))) == (
        "One skill: approach. It is practised until trial 300; what places are worth is learned"
        " after that."
    )


def test_a_skill_that_is_new_is_said_to_be_practised_while_the_selection_is_frozen() -> None:
    assert sentence_at(Run(spec_of(), seed=1), 12_001).endswith(
        "Circle clockwise is new and practised first: the selection is frozen until trial 12,300."
    )


@pytest.mark.parametrize(
    ("commands", "expected"),
    [
        ([FreezeSelection(True)], "Frozen by hand: the selection."),
        (
            [FreezeSkills(True)],
            "Frozen by hand: the skills. Besides, the selection is frozen until trial 300, so"
            " nothing is learned.",
        ),
        (
            [FreezeSelection(True), FreezeSkills(True)],
            "Frozen by hand: the selection and the skills, so nothing is learned.",
        ),
        (
            [FreezeSelection(True), FreezeSkills(True), FollowSchedule(False)],
            "Frozen by hand: the selection and the skills, so nothing is learned. The schedule is"
            " off: no skill joins by itself.",
        ),
    ],
)
def test_all_that_is_held_still_or_off_is_said(commands: list[Command], expected: str) -> None:
    run = Run(spec_of(), seed=1)
    for command in commands:
        run.apply(command)
    assert in_words(status_of(run)) == f"One skill: approach. {expected}"


def test_skills_that_are_frozen_alone_leave_value_its_way() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=1_000)
    run.apply(FreezeSkills(True))
    assert ". Frozen by hand: the skills. Value spreads" in in_words(status_of(run))


def test_an_exploration_is_said_with_its_end() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=1_000)
    run.apply(Explore("approach", 250, 0.75))
    explored = "Forced exploration until trial 1,250: approach in 75% of the steps"
    assert f". {explored}. Value" in in_words(status_of(run))
    run.apply(StopExploring("approach"))
    assert explored not in in_words(status_of(run))


def test_what_an_exploration_costs_is_said_where_there_are_other_skills() -> None:
    run = Run(spec_of(preset="hierarchical_3"), seed=1)
    run.apply(Explore("approach", 250, 0.75))
    run.apply(Explore("avoid", 100, 0.5))
    assert (
        "Forced exploration: avoid in 50% of the steps (until trial 100), approach in 75% of the"
        " others (until trial 250), so rewards fall."
    ) in in_words(status_of(run))


def test_an_exploration_by_context_is_said_with_where_it_acts_and_costs_little() -> None:
    run = Run(spec_of(preset="hierarchical_3"), seed=1)
    run.apply(Explore("avoid", 100, 0.5, 1.0))
    assert (
        "Forced exploration until trial 100: avoid in 50% of the steps where nothing else is worth"
        " more than 1."
    ) in in_words(status_of(run))


def test_a_skill_that_has_just_joined_by_a_rule_is_said_to_have() -> None:
    run = Run(ruled_spec("trials=2000"), 5)
    run.advance(until_trial=440)
    assert "Circle clockwise has joined by its rule, and is practised first" in in_words(
        status_of(run)
    )


def test_while_a_script_teaches_it_is_said_until_when() -> None:
    run = Run(spec_of(preset="hierarchical_3_taught"), seed=1)
    run.advance(until_trial=299)
    said = "Taught until trial 300: a script shows it which skill to take."
    assert said in in_words(status_of(run))
    run.advance(until_trial=300)
    assert "Taught" not in in_words(status_of(run))


def test_before_the_first_hunt_it_is_said_which_skill_learns_alone() -> None:
    run = Run(spec_of("schedule.pretrain=1000", preset="hierarchical_3"), seed=1)
    run.advance(max_steps=1_500)
    assert in_words(status_of(run)) == (
        "Before the first hunt each skill learns alone: circle clockwise until step 2,000, of"
        " 3,000."
    )
    run.advance(max_steps=1_500)
    assert "alone" not in in_words(status_of(run))


def test_an_exploration_is_over_when_its_last_trial_is() -> None:
    run = Run(spec_of(), seed=1)
    run.apply(Explore("approach", 500, 0.75))
    assert "approach in 75%" in sentence_at(run, 499)
    assert "approach in 75%" not in sentence_at(run, 500)


def test_a_pause_comes_first() -> None:
    run = Run(spec_of(), seed=1)
    playing = in_words(status_of(run))
    assert in_words(status_of(run, playing=False)) == f"Paused. {playing}"


def test_the_end_of_a_run_comes_first() -> None:
    run = Run(spec_of("trials=700"), seed=1)
    run.advance()
    over = in_words(status_of(run, playing=False, finished=True))
    assert over.startswith("The 700 trials are over. One skill: approach. Value spreads")


def test_an_error_says_where_it_stopped_and_nothing_else() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=1_234)
    status = status_of(run, playing=False, error="ValueError: no such luck")
    assert in_words(status) == (
        "An error stopped the learner at trial 1,234; what it has learned is kept."
    )


@pytest.mark.parametrize(
    ("behind", "expected"),
    [
        (Behind("", 2_150, 300_000), "The past, trial 1,000."),
        (Behind("no avoid", 2_150, 300_000), "Branch, trial 1,000."),
    ],
)
def test_that_a_moment_is_not_now_comes_before_all_else(behind: Behind, expected: str) -> None:
    run = Run(spec_of(), seed=1)
    now = sentence_at(run, 1_000)
    for live in (
        {"playing": True},
        {"playing": False},
        {"playing": False, "finished": True},
        {"playing": False, "error": "ValueError: no such luck"},
        {"preparing": True},
    ):
        # Whatever the live run does, it is not what is shown.
        status = replace(status_of(run), behind=behind, **live)
        assert in_words(status) == f"{expected} {now}"
        assert sentence.said(status).startswith('<b class="pounce-behind">')


@pytest.mark.parametrize(
    ("behind", "expected"),
    [
        (Behind("", 2_150, 300_000), "2,150 trials behind"),
        (Behind("", 1, 70), "1 trial behind"),
        (Behind("", 0, 12), "12 steps behind"),
        (Behind("no avoid", -30, -900), "30 trials ahead"),
        # More steps in as many trials: it is no other time for that.
        (Behind("no avoid", 0, 714_120), "level with the live run"),
        (Behind("no avoid", 0, 0), "level with the live run"),
    ],
)
def test_how_far_a_moment_is_from_now(behind: Behind, expected: str) -> None:
    assert sentence.how_far(behind) == expected


def test_compiling_is_said_while_it_lasts() -> None:
    run = Run(spec_of(), seed=1)
    preparing = replace(status_of(run), preparing=True)
    assert in_words(preparing).startswith("Getting ready: ")


def test_a_success_share_is_not_a_number_before_the_first_trial_has_ended() -> None:
    taken = snapshot.take(Run(spec_of(), seed=1), "timed", 0)
    assert np.isnan(sentence.success_share(taken))
    assert sentence.success_share(replace(taken, recent=Endings(1, 2, 1))) == 0.25


# Where a run of an experiment is from

NAME = "figure_4_1: timed, seed 3"
RECORDED = "3fa9c1d2" + "0" * 56


def test_a_run_that_is_being_made_again_is_said_to_be() -> None:
    opened = Opened(NAME, 1_000, RECORDED, same=None)
    assert sentence.provenance(opened) == "Making figure_4_1: timed, seed 3 again …"


def test_a_run_that_came_out_as_in_the_results_is_said_to_be_that_run() -> None:
    opened = Opened(NAME, 1_000, RECORDED, same=True, found=RECORDED)
    assert sentence.provenance(opened) == (
        "This is figure_4_1: timed, seed 3, as it ended: digest 3fa9c1d2, as in the results."
    )


def test_a_run_that_came_out_otherwise_is_said_with_both_digests() -> None:
    opened = Opened(NAME, 1_000, RECORDED, same=False, found="0b1c2d3e" + "f" * 56)
    assert sentence.provenance(opened) == (
        "This is figure_4_1: timed, seed 3, made again, but its tables differ from the results"
        " (digest 3fa9c1d2 there, 0b1c2d3e here): another version of pounce made them."
    )


# Terms


def test_the_terms_of_a_sentence_are_explained() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=14_600)
    explained = re.findall(r'data-term="([^"]*)"', sentence.said(status_of(run)))
    assert explained == ["skill", "forced exploration", "selection", "freeze"]
    run.advance(until_trial=17_000)
    assert "value" in re.findall(r'data-term="([^"]*)"', sentence.said(status_of(run)))


def test_the_name_of_a_skill_is_no_markup() -> None:
    run = Run(spec_of(), seed=1)
    run.apply(Explore("approach", 10, 0.5))
    episodes = (Episode("<b>approach</b>", 0.5, 10),)
    taken = snapshot.take(run, "timed", 0)
    sly = replace(taken, control=replace(taken.control, episodes=episodes))
    assert "<b>" not in sentence.said(status_at(sly))
    assert "<b>approach</b> in 50%" in in_words(status_at(sly))


def test_the_task_says_who_hunts_whom_and_what_ends_a_hunt() -> None:
    task = sentence.TASK.striptags()
    for word in ("predator", "catch a prey", "sees only", "from behind", "flees"):
        assert word in task
    assert len(task) < 150, "two lines of the stage"


# Sentences on real runs


@pytest.mark.parametrize("seed", SEEDS)
def test_approach_alone_makes_a_cone(seed: int) -> None:
    run = Run(spec_of(), seed)
    for trial in (600, 1_000, 2_000, 4_000, 6_000):
        assert sentence_at(run, trial).startswith(
            "One skill: approach. Value spreads back from the prey as a cone"
        )


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("size", [60, 120])
def test_exploring_the_circle_makes_an_arm_counter_clockwise(seed: int, size: int) -> None:
    run = Run(spec_of(f"world.size={size}"), seed)
    assert sentence_at(run, 13_500) == (
        "Two skills. Forced exploration until trial 14,000: circle clockwise in 95% of the steps,"
        " so rewards fall. Value spreads counter-clockwise: an arm grows out of the cone."
    )


def test_one_skill_that_widens_its_cone_on_one_side_makes_no_arm() -> None:
    said = sentence_at(Run(spec_of(), 3), 9_000)
    assert said.endswith("Value spreads counter-clockwise, at the edge of the cone.")


@pytest.mark.parametrize("seed", SEEDS)
def test_the_picture_is_a_cone_an_arm_a_ring_with_a_gap_and_filled(seed: int) -> None:
    run = Run(spec_of(), seed)
    shapes: list[str] = []
    for trial in (6_000, 14_500, 24_000, 48_000):
        run.advance(until_trial=trial)
        taken = snapshot.take(run, "timed", 0)
        shapes.append(shape_of(taken.spec.world, taken.value))
    assert shapes == ["cone", "arm", "open ring", "filled"]
    said = in_words(status_of(run))
    assert "Value hardly spreads any more: nearly all round the prey is filled; " in said
    assert said.endswith(" of recent hunts end in capture.")


@pytest.mark.parametrize("seed", SEEDS)
def test_approach_alone_makes_a_cone_in_a_world_of_eight_directions(seed: int) -> None:
    run = Run(spec_of("world.n_directions=8"), seed)
    for trial in (600, 1_000, 2_000, 4_000):
        assert "Value spreads back from the prey as a cone" in sentence_at(run, trial)


@pytest.mark.parametrize("seed", SEEDS)
def test_exploring_the_circle_makes_an_arm_in_a_world_of_eight_directions(seed: int) -> None:
    said = sentence_at(Run(spec_of("world.n_directions=8"), seed), 13_500)
    assert said.endswith("an arm grows out of the cone.")
