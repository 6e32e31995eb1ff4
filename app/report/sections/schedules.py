"""A section of a report on when skills join, and when they are explored."""

from collections.abc import Sequence

from app.charts.paper.drawing import drawn
from app.charts.read import schedules_of
from app.report.document import Page
from app.report.parts import MOST_LINES
from app.results.read import Group


def write_schedules(page: Page, groups: Sequence[Group]) -> None:
    """Write a section on the schedules of variants, if any has one and a picture takes them all.

    Args:
        page: to write on.
        groups: all variants; those with the same schedule share it.
    """
    chart = schedules_of(groups)
    if not 0 < len({lane.variant for lane in chart.lanes}) <= MOST_LINES:
        return
    small = page.small_print(
        "As planned, in trials. While the selection is frozen, the skills go on learning; while a"
        " skill is explored, it is taken in each step with the probability that is given."
    )
    drawing = drawn("schedules", chart, small)
    several = len({lane.variant for lane in chart.lanes}) > 1
    caption = f"The {'schedules' if several else 'schedule'}, with a lane for each skill"
    page.say("When skills join", page.picture("schedules", caption, drawing))
