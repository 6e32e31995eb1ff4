"""A section of a report on runs that a stop condition ended: when they met it, if they did."""

from collections.abc import Sequence

from app.analysis.passages import Passage
from app.documents.experiment_spec import Stop
from app.report.document import Page, table
from app.report.parts import MOST_ROWS, REACHED_RULE, left_out, reached_cell
from app.results.read import Group, Reader, Trace
from app.util.html import element


def write_stops(page: Page, reader: Reader, groups: Sequence[Group]) -> None:
    """Write a section on how long runs took until they met their stop condition.

    Args:
        page: to write on.
        reader: of their logs.
        groups: all variants; those without a stop condition have no part in it.
    """
    stopped = [(group, stop) for group in groups if (stop := group.runs[0].origin.stop) is not None]
    if not stopped:
        return
    conditions = " ".join(dict.fromkeys(_in_words(stop) for _, stop in stopped))
    rows = [(group.label, *_cells(reader.traces(group.runs))) for group, _ in stopped[:MOST_ROWS]]
    page.say(
        "Steps until the condition was met",
        element("p", f"{conditions} {REACHED_RULE} {_CENSORED}"),
        table(("variant", "n", "steps until then [95 %]", "trials until then [95 %]"), rows),
        left_out(len(stopped)),
    )


_CENSORED = (
    "The length of a run, wherever it is shown, is that at which it ended, by the condition or"
    " without it."
)


def _in_words(stop: Stop) -> str:
    return (
        f"A run ended once {stop.success * 100:g} % of its last {stop.trials:,} trials were"
        f" captures, which was looked at every {stop.every:,} trials."
    )


def _cells(traces: Sequence[Trace]) -> Sequence[object]:
    by_trials, by_steps = (
        [Passage(trace.ended[place], trace.met is None) for trace in traces] for place in (0, 1)
    )
    return len(traces), reached_cell(by_steps), reached_cell(by_trials)
