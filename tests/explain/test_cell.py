"""What is said about a cell, on tables small enough to check by hand."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.documents import presets
from app.explain.cell import (
    ACTION_NAMES,
    HuntShown,
    OptionReading,
    SkillReading,
    moment_of,
    policy_of,
    reading_at,
)
from app.explain.cell_html import hunts_html, options_html, reading_html, rose_svg
from app.explain.chain import Chain, Link, action_text, chain_html, chain_of, ending_text, sum_text
from app.explain.worth import Unit
from app.live import snapshot
from app.live.snapshot import Snapshot
from app.picture.look import OF_TRIAL, Look
from app.picture.shading import FARTHEST_STEPS
from app.picture.theme import LIGHT
from learners.commands import SetParameter
from learners.hunts import Hunt, success_map
from learners.names import MOVES
from learners.run import Run
from sim.geometry import N_MOVES, STAY
from sim.world import CAPTURE, FLIGHT, TIMEOUT, board_xy
from tests.support.person import words
from tests.support.tables import (
    APPROACH,
    CIRCLE,
    EAST,
    MOVE_EAST,
    MOVE_NORTH,
    MOVE_WEST,
    NORTH,
    WEST,
    moment,
    valued,
    way_from_behind,
)

MINUS = "\N{MINUS SIGN}"


@pytest.fixture
def behind() -> Snapshot:
    return way_from_behind()


# Names


def test_moves_have_the_names_of_their_ways() -> None:
    assert ACTION_NAMES[STAY] == "stay"
    assert ACTION_NAMES[MOVE_EAST] == "move east"
    assert ACTION_NAMES[0] == "move south-west"
    assert ACTION_NAMES[8] == "move north-east"
    assert len(set(ACTION_NAMES)) == N_MOVES


# A reading


def test_the_reading_of_a_known_cell(behind: Snapshot) -> None:
    visits = behind.visits.copy()
    visits[EAST, 1, WEST] = [7, 3]
    first_reach = behind.first_reach.copy()
    first_reach[EAST, 1, WEST] = 4
    known = replace(behind, visits=visits, first_reach=first_reach)
    reading = reading_at(known, 6, 10, EAST)
    assert (reading.ring, reading.direction, reading.heading) == (1, WEST, EAST)
    assert reading.options == (
        OptionReading("approach", 80.0, 7, True),
        OptionReading("circle clockwise", 5.0, 3, False, place=1),
    )
    approach, circle = reading.skills
    assert (approach.name, approach.greedy) == ("approach", (MOVE_EAST,))
    assert approach.q[MOVE_EAST] == 1
    assert circle.greedy == tuple(range(N_MOVES))
    assert reading.first_reach == 4
    assert reading.outcome == CAPTURE
    assert not reading.seen


def test_a_cell_before_the_prey_is_seen_and_hunts_from_it_end_in_flight(behind: Snapshot) -> None:
    reading = reading_at(behind, 14, 10, EAST)
    assert reading.seen
    assert reading.outcome == FLIGHT
    assert reading.first_reach is None
    assert not reading_at(behind, 15, 10, EAST).seen
    assert not reading_at(behind, 14, 10, WEST).seen


def test_a_reading_names_all_options_that_tie(behind: Snapshot) -> None:
    reading = reading_at(behind, 10, 2, NORTH)
    assert [option.greedy for option in reading.options] == [True, True]


def test_a_reading_leaves_out_what_has_not_joined(behind: Snapshot) -> None:
    without = behind.selection_q.copy()
    without[..., CIRCLE] = -np.inf
    alone = replace(behind, selection_q=without, present=("approach",))
    reading = reading_at(alone, 6, 10, EAST)
    assert [option.name for option in reading.options] == ["approach"]
    assert [skill.name for skill in reading.skills] == ["approach"]


def test_a_reading_of_moves_has_nine_options_and_no_skill() -> None:
    reading = reading_at(valued(moment(MOVES), {(EAST, 1, WEST, MOVE_EAST): 3}), 6, 10, EAST)
    assert [option.name for option in reading.options] == list(ACTION_NAMES)
    assert [option.greedy for option in reading.options].index(True) == MOVE_EAST
    assert reading.skills == ()


def test_a_reading_of_commands_has_all_five_and_what_each_obeys_by() -> None:
    taken = snapshot.take(Run(presets.load("feudal", ["world.size=40"]), 1), "feudal", 0)
    skill_q = np.zeros_like(taken.skill_q)
    skill_q[4, WEST, :, :, MOVE_NORTH] = 0.5
    skill_q[2, :, :, :, MOVE_EAST] = 0.25
    taken = replace(taken, skill_q=skill_q)
    reading = reading_at(taken, 6, 10, WEST)
    names = ["counterclockwise", "clockwise", "inwards", "outwards", "search"]
    assert [option.name for option in reading.options] == names
    assert [skill.name for skill in reading.skills] == names
    assert reading.skills[2].greedy == (MOVE_EAST,)
    assert reading.skills[4].greedy == (MOVE_NORTH,)
    # Only the search tells headings apart.
    other = reading_at(taken, 6, 10, EAST)
    assert other.skills[2].greedy == (MOVE_EAST,)
    assert other.skills[4].greedy == tuple(range(N_MOVES))


def test_success_is_read_off_a_map_if_there_is_one(behind: Snapshot) -> None:
    outcomes = success_map(behind.world, policy_of(behind))
    assert outcomes is not None
    assert reading_at(behind, 6, 10, EAST, outcomes).outcome == CAPTURE
    outcomes[EAST, 10, 6] = TIMEOUT
    assert reading_at(behind, 6, 10, EAST, outcomes).outcome == TIMEOUT


def test_a_command_makes_another_moment_though_no_step_is_made() -> None:
    run = Run(moment().spec, seed=1)
    before = snapshot.take(run, "by hand", 0)
    assert moment_of(snapshot.take(run, "by hand", 0)) == moment_of(before)
    run.apply(SetParameter("world.vision_radius", 0.0))
    after = snapshot.take(run, "by hand", 0)
    assert after.step == before.step
    assert moment_of(after) != moment_of(before)


@pytest.mark.parametrize(("x", "y"), [(-1, 0), (0, 20), (20, 3)])
def test_there_is_nothing_to_read_off_the_grid(behind: Snapshot, x: int, y: int) -> None:
    with pytest.raises(ValueError, match="off the grid"):
        reading_at(behind, x, y, EAST)
    with pytest.raises(ValueError, match="off the grid"):
        chain_of(behind, x, y, EAST)


# Why this value?


def texts(chain: Chain) -> list[str]:
    return [f"{action_text(link)}: {sum_text(link)}" for link in chain.links]


def test_a_chain_leads_to_the_capture_that_feeds_it(behind: Snapshot) -> None:
    chain = chain_of(behind, 3, 10, EAST)
    assert chain.ending == "capture"
    assert [(link.x, link.y) for link in chain.links] == [(x, 10) for x in range(3, 10)]
    assert chain.last == (10, 10)
    # By hand: 0.9 * 60 = 54; 0.9 * 80 = 72; 0.9 * 99 = 89.1; and 100 where the trial ends.
    assert texts(chain) == [
        "approach, move east: 0 + 0.9 × 60 = 54 (6 steps); Q = 60",
        "approach, move east: 0 + 0.9 × 80 = 72 (3 steps); Q = 60",
        "approach, move east: 0 + 0.9 × 80 = 72 (3 steps); Q = 80",
        "approach, move east: 0 + 0.9 × 80 = 72 (3 steps); Q = 80",
        "approach, move east: 0 + 0.9 × 80 = 72 (3 steps); Q = 80",
        "approach, move east: 0 + 0.9 × 99 = 89.1 (1 step); Q = 80",
        "approach, move east: 100 + 0.9 × 0 = 100; Q = 99",
    ]
    assert "caught" in ending_text(chain)


def test_a_chain_leads_to_the_flight_that_is_feared(behind: Snapshot) -> None:
    chain = chain_of(behind, 16, 10, EAST)
    assert chain.ending == "flight"
    assert texts(chain) == [
        f"approach, move west: 0 + 0.9 × {MINUS}45 = {MINUS}40.5; Q = {MINUS}20",
        f"approach, move west: {MINUS}50 + 0.9 × 0 = {MINUS}50; Q = {MINUS}45",
    ]
    assert chain.last == (14, 10)
    assert "flees" in ending_text(chain)


def test_the_numbers_are_those_of_the_parameters_as_they_are(behind: Snapshot) -> None:
    learner = behind.spec.learner.model_copy(update={"gamma": 0.5})
    world = behind.world._replace(capture_reward=np.float32(7))
    changed = replace(behind, spec=behind.spec.model_copy(update={"learner": learner}), world=world)
    chain = chain_of(changed, 8, 10, EAST)
    assert texts(chain) == [
        "approach, move east: 0 + 0.5 × 99 = 49.5 (1 step); Q = 80",
        "approach, move east: 7 + 0.5 × 0 = 7; Q = 99",
    ]


def test_skills_are_read_and_followed_by_what_they_see_themselves() -> None:
    """Two cells of one state of the selection, in which the skill tells two states apart."""
    taken = moment(skill_n_distances=8)
    assert taken.skill_q.shape == (2, 8, 8, N_MOVES)
    taken = valued(taken, {(EAST, 2, WEST, APPROACH): 9})
    # The edges of the skills' rings, from the fourth on: 5.00, 6.99, 9.19.
    near, far = reading_at(taken, 4, 10, EAST), reading_at(taken, 2, 10, EAST)
    assert (near.ring, near.direction) == (far.ring, far.direction) == (2, WEST)
    assert (near.of_skills, far.of_skills) == ((4, WEST), (5, WEST))
    skill_q = np.zeros_like(taken.skill_q)
    skill_q[APPROACH, 4, WEST, MOVE_EAST] = 5
    skill_q[APPROACH, 5, WEST, MOVE_NORTH] = 7
    taken = replace(taken, skill_q=skill_q)
    assert reading_at(taken, 4, 10, EAST).skills[APPROACH].greedy == (MOVE_EAST,)
    assert reading_at(taken, 2, 10, EAST).skills[APPROACH].greedy == (MOVE_NORTH,)
    assert chain_of(taken, 4, 10, EAST).links[0].move == MOVE_EAST
    assert chain_of(taken, 2, 10, EAST).links[0].move == MOVE_NORTH
    assert "Skills sense ring 5, direction 5." in said(taken, 4, 10)


def test_nothing_is_said_of_the_skills_sensors_where_they_are_the_selections() -> None:
    taken = moment()
    assert reading_at(taken, 4, 10, EAST).of_skills is None
    assert "Skills sense" not in said(taken, 4, 10)
    moves = moment(MOVES, skill_n_distances=8)
    assert "Skills sense" not in said(moves, 4, 10)


def with_moves(taken: Snapshot, skill: int, moves: dict[tuple[int, int], list[int]]) -> Snapshot:
    """The same moment with other greedy moves of a skill, by ``(ring, direction)``."""
    skill_q = taken.skill_q.copy()
    for (ring, direction), greedy in moves.items():
        skill_q[skill, ring, direction] = 0
        skill_q[skill, ring, direction, greedy] = 1
    return replace(taken, skill_q=skill_q)


def test_a_chain_that_goes_in_a_circle_says_where(behind: Snapshot) -> None:
    # In the second ring the way leads out, in the third it leads in.
    astray = with_moves(behind, APPROACH, {(1, WEST): [MOVE_WEST]})
    chain = chain_of(astray, 3, 10, EAST)
    assert chain.ending == "loop"
    assert [(link.x, link.y) for link in chain.links] == [(3, 10), (4, 10), (5, 10)]
    assert chain.last == (4, 10)
    assert texts(chain)[-1] == "approach, move west: 0 + 0.9 × 60 = 54 (6 steps); Q = 80"
    assert "Back to (4, 10)" in ending_text(chain)


def test_a_chain_that_stays_is_a_circle_of_one(behind: Snapshot) -> None:
    chain = chain_of(with_moves(behind, APPROACH, {(2, WEST): [STAY]}), 3, 10, EAST)
    assert chain.ending == "loop"
    assert texts(chain) == ["approach, stay: 0 + 0.9 × 60 = 54 (6 steps); Q = 60"]
    assert chain.last == (3, 10)


def test_where_moves_tie_a_chain_goes_on_to_a_new_cell(behind: Snapshot) -> None:
    # From (4, 10) the way back to (3, 10) is as greedy as the way on, and so is staying.
    tied = with_moves(behind, APPROACH, {(2, WEST): [MOVE_WEST, STAY, MOVE_EAST]})
    chain = chain_of(tied, 4, 10, EAST)
    assert chain.ending == "capture"
    assert [link.x for link in chain.links] == [4, 5, 6, 7, 8, 9]
    # With only staying and going back to choose from, it goes to the new cell all the same.
    back = with_moves(behind, APPROACH, {(2, WEST): [MOVE_WEST, STAY]})
    assert chain_of(back, 4, 10, EAST).links[0].move == MOVE_WEST


def test_a_new_cell_is_preferred_to_one_that_is_worth_more(behind: Snapshot) -> None:
    # At (4, 10) going back to (5, 10) would be worth more than going on to (3, 10).
    ways = {(1, WEST): [MOVE_WEST], (2, WEST): [MOVE_WEST, MOVE_EAST]}
    chain = chain_of(with_moves(behind, APPROACH, ways), 5, 10, EAST)
    assert [link.x for link in chain.links] == [5, 4, 3, 2, 1]
    assert (chain.ending, chain.last) == ("unknown", (0, 10))


def test_where_options_tie_a_chain_takes_the_one_that_feeds_the_value(behind: Snapshot) -> None:
    tied = valued(behind, {(EAST, 0, WEST, CIRCLE): 99})
    chain = chain_of(tied, 9, 10, EAST)
    assert texts(chain) == ["approach, move east: 100 + 0.9 × 0 = 100; Q = 99"]


def test_a_chain_ends_where_nothing_is_known(behind: Snapshot) -> None:
    nowhere = chain_of(behind, 10, 2, EAST)
    assert (nowhere.ending, nowhere.links, nowhere.last) == ("unknown", (), (10, 2))
    assert ending_text(nowhere).startswith("Nothing is known here yet")
    # Ring 3 knows something, and the ring that it leads to does not.
    edge = valued(moment(), {(EAST, 3, WEST, APPROACH): 2})
    chain = chain_of(edge, 0, 10, EAST)
    assert texts(chain) == ["approach, move east: 0 + 0.9 × 0 = 0; Q = 2"]
    assert (chain.ending, chain.last) == ("unknown", (1, 10))
    assert ending_text(chain) == "At (1, 10) nothing is known yet."


def test_a_chain_is_followed_only_so_far(behind: Snapshot) -> None:
    chain = chain_of(behind, 3, 10, EAST, limit=3)
    assert (chain.ending, len(chain.links), chain.last) == ("limit", 3, (6, 10))
    assert "only 3 links" in ending_text(chain)


def test_a_chain_of_moves_names_each_move_once() -> None:
    known = valued(moment(MOVES), {(EAST, 0, WEST, MOVE_EAST): 90, (EAST, 1, WEST, MOVE_EAST): 70})
    chain = chain_of(known, 8, 10, EAST)
    assert texts(chain) == [
        "move east: 0 + 0.9 × 90 = 81 (2 steps); Q = 70",
        "move east: 100 + 0.9 × 0 = 100; Q = 90",
    ]
    assert [board_xy(known.world, cell) for cell in chain.cells] == [(8, 10), (9, 10), (10, 10)]


# HTML


def said(taken: Snapshot, x: int, y: int, heading: int = EAST, **look: Any) -> str:
    """What is said of a cell, without marks."""
    return words(reading_html(reading_at(taken, x, y, heading), Look(**look)))


def test_the_unit_of_the_colour_comes_first_and_then_the_value(behind: Snapshot) -> None:
    # 100 * 0.9 ** n is 80 for n = 2.1.
    assert said(behind, 6, 10).startswith("Cell (6, 10): about 2 steps from a capture (value 80).")
    assert said(behind, 14, 10).startswith(
        "Cell (14, 10): the predator expects to be seen (value \N{MINUS SIGN}45)."
    )
    assert said(behind, 10, 2).startswith("Cell (10, 2): nothing is known yet (value 0).")
    far = valued(behind, {(EAST, 1, WEST, APPROACH): 1e-30, (EAST, 1, WEST, CIRCLE): -1})
    farthest = f"more than {FARTHEST_STEPS:.0f} steps from a capture (value 1e\N{MINUS SIGN}30)"
    assert f": {farthest}." in said(far, 6, 10)


@pytest.mark.parametrize(
    ("layer", "lead"),
    [
        ("option", "with circle clockwise now, about 28 steps from a capture (value 5)."),
        ("chosen", "it takes approach."),
        ("visits", "0 steps so far began in this state, of 0."),
        ("reach", "never worth anything so far."),
        ("success", "a hunt from here ends in capture."),
        ("value", "about 2 steps from a capture (value 80)."),
    ],
)
def test_what_the_layer_shows_comes_first(behind: Snapshot, layer: str, lead: str) -> None:
    text = said(behind, 6, 10, layer=layer, option=CIRCLE)
    assert text.startswith(f"Cell (6, 10): {lead}")
    assert text.lower().count("about 2 steps from a capture (value 80).") == 1


@pytest.mark.parametrize(
    ("x", "y", "heading", "where"),
    [
        (6, 10, EAST, "Straight behind the prey, 4 cells away; the prey does not see it."),
        (14, 10, EAST, "Straight ahead of the prey, 4 cells away; the prey sees it."),
        (10, 12, EAST, "On the prey's left, 2 cells away;"),
        (6, 10, NORTH, "On the prey's left, 4 cells away;"),
        (7, 7, EAST, "Behind the prey, on its right, 4 cells away;"),
        (10, 10, EAST, "Here is the prey."),
    ],
)
def test_a_place_is_said_as_the_prey_has_it(
    behind: Snapshot, x: int, y: int, heading: int, where: str
) -> None:
    assert where in said(behind, x, y, heading)


def test_what_is_sensed_counts_from_one(behind: Snapshot) -> None:
    assert "ring 2 of 4, direction 5 of 8, prey facing east." in said(behind, 6, 10)


def test_the_heading_of_the_numbers_is_said_where_the_picture_is_of_all(behind: Snapshot) -> None:
    assert "colours sum up all eight headings" in said(behind, 6, 10)
    assert "eight headings" not in said(behind, 6, 10, frame=OF_TRIAL)


def test_a_sum_adds_up_as_it_is_shown() -> None:
    link = Link(1, 2, "approach", MOVE_EAST, 0.0, 0.9, 0.07294, 0.0661, UNIT)
    assert sum_text(link) == "0 + 0.9 × 0.0729 = 0.0656 (70 steps); Q = 0.0661"


UNIT = Unit(reward=100.0, gamma=0.9)
BLACK = re.compile(r"black|#000\b|#000000|rgb\(0, ?0, ?0\)", re.IGNORECASE)


def links(count: int) -> Chain:
    link = Link(1, 2, "approach", MOVE_EAST, 0.0, 0.9, 50.0, 44.0, UNIT)
    return Chain((link,) * count, tuple(range(count + 1)), (3, 2), "capture")


def test_a_short_chain_is_shown_in_full() -> None:
    html = chain_html(links(12))
    assert html.count("<li") == 12
    assert "more" not in html


def test_a_long_chain_is_folded_in_its_middle() -> None:
    html = chain_html(links(40))
    assert html.count("<li") == 13
    assert "28 more" in html
    assert [int(n) for n in re.findall(r'<li value="(\d+)"', html)] == [
        *range(1, 9),
        *range(37, 41),
    ]


def test_a_rose_points_where_its_petals_are_longest() -> None:
    q = [0.0] * N_MOVES
    q[MOVE_NORTH], q[MOVE_WEST] = 2.0, 1.0
    svg = rose_svg(q, [MOVE_NORTH])
    petals = re.findall(r'x2="([-\d.]+)" y2="([-\d.]+)" stroke="([^"]+)"', svg)
    ends = {(float(x), float(y)): paint for x, y, paint in petals}
    assert len(ends) == 8
    # North is up, and up is where y falls.
    assert ends.pop((0.0, -40.0)) != "currentColor"
    assert set(ends.values()) == {"currentColor"}
    assert (-27.0, 0.0) in ends
    assert "<title>move north: 2</title>" in svg


def test_a_rose_of_equal_values_has_equal_petals() -> None:
    svg = rose_svg([3.0] * N_MOVES, range(N_MOVES))
    ends = re.findall(r'x2="([-\d.]+)" y2="([-\d.]+)"', svg)
    lengths = [np.hypot(float(x), float(y)) for x, y in ends]
    np.testing.assert_allclose(lengths, lengths[0], atol=0.1)


def test_ties_are_named(behind: Snapshot) -> None:
    reading = reading_at(behind, 6, 10, EAST)
    two = OptionReading("one", 1, 0, True), OptionReading("two", 1, 0, True)
    three = *two, OptionReading("three", 0, 0, False)
    assert "Tied" not in options_html(replace(reading, options=three[1:]))
    assert "one, two" in options_html(replace(reading, options=three))
    assert "all of them" in options_html(replace(reading, options=two))


def test_names_are_escaped() -> None:
    evil = "<script>alert(1)</script>"
    link = Link(1, 2, evil, MOVE_EAST, 0.0, 0.9, 50.0, 44.0, UNIT)
    reading = replace(
        reading_at(moment(), 1, 2, EAST),
        options=(OptionReading(evil, 0.0, 0, True), OptionReading(evil, 0.0, 0, True)),
        skills=(SkillReading(evil, (0.0,) * N_MOVES, (0,)),),
    )
    for html in (
        chain_html(Chain((link,), (0, 1), (3, 2), "capture")),
        reading_html(reading, Look()),
    ):
        assert "<script" not in html
        assert "&lt;script&gt;" in html


def test_nothing_is_painted_black(behind: Snapshot) -> None:
    for taken in (behind, moment(MOVES)):
        reading = reading_html(reading_at(taken, 6, 10, EAST), Look())
        assert "&lt;" not in reading
        html = reading + chain_html(chain_of(taken, 6, 10, EAST))
        assert not BLACK.search(html)
        assert html.count("<div") == html.count("</div>")


def shown(outcome: int, steps: int = 2) -> HuntShown:
    hunt = Hunt(np.arange(steps + 1), np.zeros(steps, np.uint8), np.zeros(steps, np.uint8), outcome)
    return HuntShown(3, 4, EAST, hunt)


def test_few_hunts_are_named_and_many_are_counted() -> None:
    few = hunts_html([shown(CAPTURE), shown(FLIGHT, steps=1)], LIGHT)
    assert "from (3, 4), prey facing east: capture after 2 steps" in few
    assert "flight after 1 step<" in few
    many = hunts_html([shown(CAPTURE)] * 9 + [shown(TIMEOUT)], LIGHT)
    assert "10 hunts" in many
    assert "9 captures" in many
    assert "1 time-out<" in many
    assert "flight" not in many
