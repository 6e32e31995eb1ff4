"""The section of a report that has a verdict on each finding, beside what the thesis says."""

from collections.abc import Sequence
from itertools import groupby

from app.analysis.estimates import bootstrap_rng
from app.charts.wording import shown_estimate, shown_p
from app.report.document import Count, Page, details, grouped_table, table, words
from app.results import findings, spread, thesis
from app.results.findings import FAILS, HOLDS, LEAST_SEEDS, UNDECIDED, Judged
from app.results.read import Reader
from app.results.thesis import Placed
from app.util.html import Markup, element, joined
from app.words.numbers import counted

_CLASSES = {HOLDS: "holds", FAILS: "fails", UNDECIDED: "undecided"}
_HEADER = (
    *("what the thesis says", "what is tested", "asked for", "measured [95\N{NO-BREAK SPACE}%]"),
    *("n", "verdict", "after Holm"),
)


def write_findings(page: Page, reader: Reader, placed: Placed) -> None:
    """Write a section on the findings, and put their tally at the head of the page.

    Args:
        page: to write on.
        reader: of the logs of the runs.
        placed: the runs of the thesis's learners in its worlds.
    """
    effects = [(f, thesis.effect_of(f, reader, placed, bootstrap_rng())) for f in thesis.FINDINGS]
    every = findings.judged((f, effect) for f, effect in effects if effect is not None)
    absent = [f for f, effect in effects if effect is None]
    decidable = [judged for judged in every if judged.effect.estimate.n >= LEAST_SEEDS]
    few = [judged for judged in every if judged.effect.estimate.n < LEAST_SEEDS]
    _count(page, every, len(absent))
    parts: list[Markup] = []
    if every and not decidable:
        # First, since all that follows is undecided.
        parts.append(element("p", _TOO_FEW, class_="warning"))
    if every:
        parts.append(element("p", _rule(len(every))))
    parts += _tables(decidable)
    if few:
        are = "is" if len(few) == 1 else "are"
        summary = (
            f"{counted(len(few), 'finding')} {are} undecided for having fewer than"
            f" {LEAST_SEEDS} seeds"
        )
        parts.append(details(summary, joined(_tables(few))))
    if spread.TIMED in placed:
        parts.append(element("p", _SPREAD_RULE))
    if absent:
        summary = f"{counted(len(absent), 'finding')} of which a part was not run"
        rows = [(f.claim, f"{f.topic} ({f.section})", words(f.sentence)) for f in absent]
        header = ("finding", "part", "what the thesis says")
        parts.append(details(summary, table(header, rows)))
    page.say("Findings", *parts)


def _count(page: Page, every: Sequence[Judged], n_absent: int) -> None:
    if not every:
        return
    verdicts = [judged.verdict for judged in every]
    corrected = [judged.corrected_verdict for judged in every]
    counts = [
        Count(verdicts.count(HOLDS), "findings hold", "holds"),
        Count(verdicts.count(FAILS), "do not hold", "fails"),
        Count(verdicts.count(UNDECIDED), "undecided"),
    ]
    if verdicts.count(UNDECIDED) < len(verdicts):
        counts += [
            Count(corrected.count(HOLDS), "hold after Holm's correction", "holds"),
            Count(corrected.count(FAILS), "do not, after it", "fails"),
        ]
    page.count(*counts, *([Count(n_absent, "not run here")] if n_absent else []))


def _tables(every: Sequence[Judged]) -> list[Markup]:
    """A table for each section of the thesis, with its sentences."""
    found: list[Markup] = []
    for (section, topic), here in groupby(
        every, lambda judged: (judged.finding.section, judged.finding.topic)
    ):
        groups = [
            (words(sentence), [_row(judged) for judged in of_sentence])
            for sentence, of_sentence in groupby(here, lambda judged: judged.finding.sentence)
        ]
        found.append(element("h3", f"{topic} (section {section})"))
        found.append(grouped_table(_HEADER, groups))
    return found


def _row(judged: Judged) -> Sequence[object]:
    finding, effect = judged.finding, judged.effect
    n = counted(effect.estimate.n, "pair" if _is_paired(judged) else "seed")
    # By a p that is below 0.001 and one that is far below it nothing more is known.
    corrected = f"{judged.corrected_verdict} (p {_p(judged.corrected_p)})"
    return (
        words(finding.claim),
        element("span", finding.wanted, class_="few"),
        shown_estimate(effect.estimate, finding.unit.form),
        n,
        element("span", judged.verdict, class_=_CLASSES[judged.verdict]),
        element("span", corrected, class_=_CLASSES[judged.corrected_verdict]),
    )


def _p(p: float) -> str:
    shown = shown_p(p)
    return shown if shown.startswith("<") else f"= {shown}"


def _is_paired(judged: Judged) -> bool:
    """Whether runs were paired by seed; a quantity on its own has none to pair."""
    return judged.effect.paired and len(judged.finding.terms) > 1


def _rule(n_findings: int) -> str:
    return (
        "Each finding is a quantity, or a difference of quantities, and a condition on it. Rewards"
        f" are means per trial, from a flight (\N{MINUS SIGN}50) to a capture (100). How large a"
        " difference has to be follows from the words of the finding, by one rule that was fixed"
        " before these runs were made: a word of order asks for more than"
        f" {findings.SMALL:g}, a strong one for more than {findings.WIDE:g}, and what is said to be"
        f" close differs by less than {findings.WIDE:g}. A finding on something else than reward or"
        " the reach of value names a number of its own, chosen by what earlier runs had shown. A"
        " finding holds if the whole 95 % interval"
        " meets the condition, does not hold if none of it does, and is undecided otherwise, and"
        f" whenever there are fewer than {LEAST_SEEDS} seeds, where no bootstrap interval is wide"
        " enough. Differences are of runs of the same seed, where at least half of the runs of each"
        f" learner have a partner: n counts pairs then, and else seeds. Of {n_findings} findings"
        " some may come out by chance, and the intervals are not corrected for that; the last"
        " column is, by Holm's procedure: the chance that any of its verdicts is wrong is at most"
        " 5 %. Its p is that of a two-sided t test against the bound (by seed, or Welch's), and of"
        " two one-sided ones where a difference is to lie within it."
    )


_TOO_FEW = (
    f"So few seeds decide nothing: {LEAST_SEEDS} are the least that can (--seeds {LEAST_SEEDS}),"
    " and to tell close learners apart it takes more (--seeds 30)."
)
_SPREAD_RULE = (
    "The spread of value is measured in the timed learner, in the prey's own frame, which takes"
    " the eight headings together. A state has a value if it is worth more than nothing: if some"
    " way to a capture has been found from it. Value has reached a place if more than half of its"
    " states have one, and has not if fewer than a quarter have. The ring lies"
    f" {spread.RIGHT_FLANK.cells} from the prey, outside of its visual field; it is open if"
    " there is a sector of it that value has not reached, and closed if there is none. A flank is"
    " the sector of 15 degrees at a right angle to where the prey looks, and the one behind it;"
    " ahead to the right are the four sectors next to the one straight ahead. The equivalent"
    " distance to capture is the number of steps that a value stands for."
)
