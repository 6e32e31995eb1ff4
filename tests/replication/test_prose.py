"""What the page on the replication says in words, held against the numbers that it says it of.

The words of the template are the same whatever comes out, so whoever makes the replication again,
and finds one of these tests failing, has a sentence to mend there.
"""

import re

import pytest

from app.replication.page import Found
from app.replication.write import NUMBERS
from tests.support.pages import ROOT


@pytest.fixture(scope="module")
def kept() -> Found:
    return Found.from_json((ROOT / "docs" / NUMBERS).read_text("utf-8"))


def test_no_number_goes_by_the_name_of_a_table(kept: Found) -> None:
    assert kept.texts.keys().isdisjoint(kept.tables)


def number(shown: str) -> float:
    """The number that a text begins with."""
    found = re.match(r"[-\N{MINUS SIGN}]?[\d.,]+", shown)
    assert found is not None
    return float(found[0].replace("\N{MINUS SIGN}", "-").replace(",", ""))


def of(kept: Found, name: str) -> float:
    return number(kept.texts[name])


def rows_of(kept: Found, table: str, column: str) -> dict[tuple[str, str], str]:
    """A column of a table by the first two."""
    header, rows = kept.tables[table]
    place = [*header].index(column)
    return {(row[0], row[1]): row[place] for row in rows}


def test_that_timed_is_far_above_three_skills_at_the_horizon_is_robust(kept: Found) -> None:
    claim = "timed at 5.5 M steps is above three skills from the start by a wide margin"
    rows = {row[0]: row[1] for row in kept.tables["dependences"].rows}
    assert rows[claim] == "robust"


@pytest.mark.parametrize(
    ("low", "high", "column"),
    [
        ("timed, tuned for the end", "standard Q, tuned for the end", "horizon_reward"),
        ("standard Q, tuned for speed", "timed, tuned for speed", "horizon_area"),
        ("standard Q, thesis", "timed, thesis", "horizon_reward"),
    ],
)
def test_the_baselines_rank_as_is_said(kept: Found, low: str, high: str, column: str) -> None:
    assert of(kept, f"baselines: {low}: {column}") < of(kept, f"baselines: {high}: {column}")


def test_no_world_is_left_in_which_timed_ends_above_every_standard_q(kept: Found) -> None:
    ends = rows_of(kept, "baselines elsewhere", "end: lead")
    hopeful = [lead for (_, both), lead in ends.items() if both.endswith("hopeful")]
    assert len(hopeful) == 5
    assert all(number(lead) < 0 for lead in hopeful)


@pytest.mark.parametrize("world", ["standard", "size 150"])
def test_timed_is_faster_than_each_of_them_where_it_is_said_to_be(kept: Found, world: str) -> None:
    areas = rows_of(kept, "baselines elsewhere", "area: lead")
    leads = [lead for (where, _), lead in areas.items() if where == world]
    assert len(leads) == 3
    assert all(number(lead) > 0 for lead in leads)


def test_with_the_coarsest_sensors_a_flat_learner_is_ahead_in_both(kept: Found) -> None:
    for column in ("end: lead", "area: lead"):
        found = rows_of(kept, "baselines elsewhere", column)
        assert any(number(lead) < 0 for (where, _), lead in found.items() if "8 x 6" in where)


def test_explorations_that_overlap_do_the_harm_and_not_joining_together(kept: Found) -> None:
    ends = {
        (joined, explored): of(kept, f"together: {joined}, {explored}: final_reward")
        for joined in ("in turn", "together")
        for explored in ("in turn", "together")
    }
    in_turn = ends["in turn", "in turn"]
    assert in_turn - 5 < ends["together", "in turn"] < in_turn
    assert ends["in turn", "together"] < ends["together", "in turn"]
    assert ends["together", "together"] < ends["in turn", "together"]


def test_early_skills_have_to_join_in_turn(kept: Found) -> None:
    in_turn, together = (
        of(kept, f"together: early: {how}, in turn: horizon_reward")
        for how in ("in turn", "together")
    )
    assert in_turn > together + 15


def test_some_numbers_of_a_schedule_matter_and_others_do_not(kept: Found) -> None:
    is_bold = [["**" in share for share in row[1:]] for row in kept.tables["effects"].rows]
    assert any(map(any, is_bold))
    assert not all(map(any, is_bold))


def test_three_skills_have_less_at_the_horizon_than_in_the_end(kept: Found) -> None:
    end, at = (
        of(kept, f"figure_4_1: hierarchical_3: {c}") for c in ("final_reward", "horizon_reward")
    )
    assert at < end


def test_a_level_is_touched_before_it_is_kept(kept: Found) -> None:
    first, kept_to = (of(kept, f"figure_4_1: timed: {c}_to_70") for c in ("first", "steps"))
    assert first <= kept_to
