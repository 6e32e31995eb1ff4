"""Lines in rows, and which marks lie on which."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from app.charts.bar.tree import in_rows, marks_on
from app.live.places import LineSeen, Mark, Place


def line(number: int, parent: int | None = None, fork: int = 0) -> LineSeen:
    """A line that is known for 1,000 steps of ten a trial."""
    return LineSeen(number, parent, fork, fork // 10, f"line {number}", 1_000, 100, 5.0, "", False)


def rows(*lines: LineSeen) -> list[int]:
    return [each.number for each in in_rows(lines)]


def test_each_line_follows_the_one_that_it_branched_off_the_last_of_several_first() -> None:
    tree = (line(1), line(2, 1, 300), line(3, 1, 700), line(4, 2, 500), line(5, 1, 500))
    assert rows(*tree) == [1, 3, 5, 2, 4]


def test_a_line_whose_parent_is_gone_begins_a_tree() -> None:
    assert rows(line(1), line(4, 3, 200), line(5, 4, 300)) == [4, 5, 1]


@given(st.lists(st.tuples(st.integers(0, 7), st.integers(0, 1_000)), max_size=8))
def test_no_stroke_to_a_line_crosses_another_line(forks: list[tuple[int, int]]) -> None:
    tree = [line(0)]
    for number, (parent, step) in enumerate(forks, 1):
        of = tree[parent % len(tree)]
        # A line cannot branch off before its parent did.
        tree.append(line(number, of.number, max(step, of.fork_step)))
    found = in_rows(tree)
    assert sorted(each.number for each in found) == list(range(len(tree)))
    place = {each.number: row for row, each in enumerate(found)}
    for each in found[1:]:
        assert each.parent is not None
        above = place[each.parent]
        between = found[above + 1 : place[each.number]]
        assert above < place[each.number]
        assert all(other.fork_step >= each.fork_step for other in between)


def test_a_mark_lies_on_its_line_and_on_those_that_branched_off_later() -> None:
    tree = (line(1), line(2, 1, 300), line(3, 2, 600))
    places = [(1, 100), (1, 300), (1, 301), (2, 600), (2, 601), (3, 900), (9, 5)]
    marks = [Mark(n, Place(*place), 0, "") for n, place in enumerate(places)]
    on = {number: [mark.number for mark in marks_on(number, tree, marks)] for number in (1, 2, 3)}
    assert on == {1: [0, 1, 2], 2: [0, 1, 3, 4], 3: [0, 1, 3, 5]}
    assert all(one < other for found in on.values() for one, other in pairwise(found))


def test_of_a_parent_that_branched_off_later_nothing_is_the_childs() -> None:
    # A branch of a branch may begin before its parent left the line that both come from.
    tree = (line(1), line(2, 1, 600), line(3, 2, 300))
    marks = [Mark(1, Place(1, 200), 0, ""), Mark(2, Place(1, 500), 0, "")]
    assert [mark.number for mark in marks_on(3, tree, marks)] == [1]
