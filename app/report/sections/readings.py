"""A section of a report on how the thesis was read: what depends on it, and what does not."""

from collections.abc import Sequence

from app.charts.model import NOTHING, Dot, Dots
from app.charts.paper.drawing import drawn
from app.charts.wording import shown_estimate
from app.report.document import Page, details, table
from app.report.parts import bars_note
from app.results import readings
from app.results.read import Reader
from app.results.readings import QUANTITIES, RING_CLOSED, Dependence, Reading
from app.util.html import Markup, element, joined
from app.words.numbers import NONE, counted

_CLASSES = {"robust": "holds", "fitted": "fails", "open": "undecided"}
_RULE = (
    "The thesis leaves points open that had to be settled before anything could be run. The lab"
    " settled them by trying what was plausible and keeping what came closest to the thesis, so"
    " what comes out was in part put in. Here each point is settled otherwise, and the findings of"
    " the standard world are judged again, by the same margins. A finding is robust if it holds"
    " under every reading, fitted if it holds as read here and does not under some other, and open"
    " where neither can be said: it does not hold as read here, or is undecided somewhere."
)


_DASH = (
    "A dash stands where something was not measured: the regions in which the spread of value is"
    " looked at are made of the rings that the lab's own reading has."
)


def write_readings(page: Page, reader: Reader, found: Sequence[Reading]) -> None:
    """Write a section on ways to read the thesis.

    Args:
        page: to write on.
        reader: of the logs.
        found: the readings, the lab's own first.
    """
    page.tell("reading the thesis otherwise")
    rows = [
        (reading, [readings.quantity_of(quantity, reader, reading) for quantity in QUANTITIES])
        for reading in found
    ]
    cells = [
        (
            reading.label,
            reading.point or NONE,
            *(
                NONE if estimate is None else shown_estimate(estimate, quantity.form)
                for quantity, estimate in zip(QUANTITIES, of_reading, strict=True)
            ),
        )
        for reading, of_reading in rows
    ]
    columns = {
        quantity.title: [
            Dot(reading.label, of_reading[place] or NOTHING) for reading, of_reading in rows
        ]
        for place, quantity in enumerate(QUANTITIES)
    }
    bars = bars_note(dot.estimate for dots in columns.values() for dot in dots)
    small = page.small_print(
        f"Mean over n runs (seeds) under each reading. {bars} The ring is closed where the share is"
        f" above {RING_CLOSED:g}."
    )
    drawing = drawn("readings", Dots(columns), small)
    header = ("reading", "what it settles otherwise", *(f"{q.title} [95 %]" for q in QUANTITIES))
    depending = readings.dependences(reader, found)
    if depending:
        page.lead(_tally(depending))
    page.say(
        "How the thesis was read",
        element("p", _RULE),
        _verdicts(depending),
        page.picture("readings", "The same quantities under each way to read the thesis", drawing),
        table(header, cells),
        element("p", _DASH, class_="minor"),
    )


_ORDER = {"fitted": 0, "robust": 1, "open": 2}
"""Those that the reading made come first."""


def _tally(found: Sequence[Dependence]) -> str:
    """How many findings depend on the reading."""
    counts = {standing: sum(d.standing == standing for d in found) for standing in _ORDER}
    return (
        f"Of {counted(len(found), 'finding')} of the standard world, {counts['robust']} are robust,"
        f" {counts['fitted']} are fitted and {counts['open']} are open."
    )


def _verdicts(found: Sequence[Dependence]) -> Markup:
    """How many findings depend on the reading, and each of them; nothing where none was tested."""
    if not found:
        return Markup()
    rows = [
        (
            dependence.finding.claim,
            element("span", dependence.standing, class_=_CLASSES[dependence.standing]),
            dependence.verdicts[readings.OWN],
            "; ".join(dependence.failing) or NONE,
            "; ".join(dependence.undecided) or NONE,
            len(dependence.verdicts),
        )
        for dependence in sorted(found, key=lambda d: _ORDER[d.standing])
    ]
    header = (
        *("finding", "standing", readings.OWN, "does not hold with", "undecided with"),
        "readings",
    )
    listed = details("Each finding under all readings", table(header, rows))
    return joined([element("p", _tally(found)), listed])
