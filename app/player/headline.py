"""What is said of a moment beside the board: the task, what goes on, and the readings."""

import math
from collections.abc import Iterable
from typing import Final, NamedTuple

from markupsafe import Markup

from app.explain import sentence
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.metrics.course import GREEDY_HUNTS, NO_CURVE, GreedyCurve
from app.schedule.forced import forced_now, forced_until, where_in_short
from app.util.html import element, joined
from app.words.glossary import term
from app.words.numbers import NONE, rate_in_short, shown_number
from app.words.plain import plain
from learners import measures

TASK_HTML: Final = sentence.TASK
"""What the learner is to do, in one line."""


class _Number(NamedTuple):
    """One of the numbers that are read."""

    label: Markup | str
    value: str
    hint: str


def sentence_html(status: Status, said: Markup) -> str:
    """The one sentence (:func:`sentence.said`), and what is not kept, and where a run of an
    experiment is from."""
    parts = [element("div", said)]
    if status.journal is not None:
        parts.append(element("div", status.journal, class_="pounce-unkept"))
    if status.behind is not None:
        # The rest is of how the live run stands.
        return str(joined(parts, ""))
    if status.error:
        parts.append(element("b", status.error))
    if status.opened is not None:
        # A name may be long, and without a blank.
        style = "margin-top:0.4em;overflow-wrap:anywhere"
        parts.append(element("div", sentence.provenance(status.opened), style=style))
    return str(joined(parts, ""))


def numbers_html(status: Status, viewers: int = 1, greedy: GreedyCurve = NO_CURVE) -> str:
    """The readings: those that matter first and large, the others small below them."""
    snapshot = status.snapshot
    greedy_reward, measured = math.nan, "not measured yet"
    n_by_then = int((greedy.step <= snapshot.step).sum())
    # What was measured before a branch began is not what it came to.
    if n_by_then and not _forked_since(status, int(greedy.step[n_by_then - 1])):
        newest = n_by_then - 1
        greedy_reward = float(greedy.reward[newest])
        measured = f"measured at trial {greedy.trial[newest]:,}, step {greedy.step[newest]:,}"
        if newest < greedy.without_progress.size:
            share = 100 * greedy.without_progress[newest]
            measured += f". Steps into cells in which the same hunt has been before: {share:.0f} %"
    large = [
        *_main_numbers(snapshot),
        _Number(
            term("greedy", "Greedy"),
            shown_number(greedy_reward, ".1f"),
            f"Mean reward of {GREEDY_HUNTS:,} hunts without random moves, in which nothing is"
            f" explored or learned; {measured}",
        ),
    ]
    reached = int((snapshot.value > 0).sum())
    small = [
        _Number(term("step", "Steps"), f"{snapshot.step:,}", "Moves that were learned from so far"),
        _Number(
            "Steps/s" if status.behind is None else "Live steps/s",
            rate_in_short(status.steps_per_s),
            "Moves of the live run in the last second",
        ),
        _Number(
            joined([term("state", "States"), " of ", term("value")], ""),
            f"{reached:,}",
            f"States worth more than 0, of {snapshot.value.size:,}",
        ),
    ]
    if viewers > 1:
        hint = "Browsers that see and steer this learner"
        small.append(_Number("Viewers", f"{viewers}", hint))
    return _numbers(_not_now(status), _row(large), _forced(snapshot), _row(small, "small"))


def _forked_since(status: Status, step: int) -> bool:
    """Whether the line that is shown branched off after a step, and goes on from there."""
    if status.behind is None or not status.behind.branch:
        return False
    number, here = status.snapshot.generation, status.snapshot.step
    return any(o.number == number and step <= o.fork_step < here for o in status.lines)


def _not_now(status: Status) -> Markup | str:
    """That these are no numbers of now, where that is so."""
    behind = status.behind
    if behind is None:
        return ""
    where = behind.branch or term("the past", "The past")
    return element(
        "div", joined([where, ": ", sentence.how_far(behind)], ""), class_="pounce-behind"
    )


def readings_html(snapshot: Snapshot) -> str:
    """The few numbers that stand beside the board, and whether exploration is forced.

    What a lesson alone has to be read is among them: of the first places, most lie under the prey
    or on one another.
    """
    known = f"{int((snapshot.value > 0).sum()):,}"
    hint = f"Of {snapshot.value.size:,}, for each heading of the prey"
    places = _Number("Places worth something", known, hint)
    return _numbers(
        _row(_main_numbers(snapshot)), _forced(snapshot), _row([places], "small places")
    )


def _numbers(*rows: Markup | str) -> str:
    # viser sends plain texts alone, and no markup.
    return str(element("div", joined(rows, ""), class_="pounce-numbers"))


def _main_numbers(snapshot: Snapshot) -> list[_Number]:
    caught = sentence.success_share(snapshot)
    return [
        _Number(term("trial", "Trial"), f"{snapshot.trial:,}", "Hunts that have ended"),
        _Number(
            term("success", "Success"),
            NONE if math.isnan(caught) else f"{caught:.0%}",
            f"Share of the last {measures.RECENT_TRIALS} trials that ended in capture",
        ),
        _Number(
            term("reward", "Reward"),
            shown_number(snapshot.recent_reward, ".1f"),
            f"Mean reward per trial over the last {measures.RECENT_TRIALS}, random moves,"
            " explorations and all",
        ),
    ]


def _row(numbers: Iterable[_Number], size: str = "large") -> Markup:
    cells = (
        element(
            "div",
            element("div", number.label) + element("div", number.value, title=number.hint),
        )
        for number in numbers
    )
    return element("div", joined(cells, ""), class_=size)


def _forced(snapshot: Snapshot) -> Markup | str:
    """A word on why rewards say little for now, where they do."""
    forced = forced_now(snapshot)
    ended = forced_until(snapshot)
    taught_until = snapshot.control.taught_until
    if taught_until > snapshot.trial:
        content = joined([term("teaching", "Taught"), f" by a script until trial {taught_until:,}"])
        hint = "Success and reward are those of a learner whose skills a script chooses"
        return element("div", content, class_="forced", title=hint)
    if forced:
        skills = ", ".join(
            f"{plain(one.skill)} {one.probability:.0%}{where_in_short(one.value_at_most)}"
            for one in forced
        )
        said = f": {skills}"
    elif ended > max(snapshot.trial - measures.RECENT_TRIALS, 0):
        said = f" until trial {ended:,} is in these numbers"
    else:
        return ""
    content = joined([term("forced exploration", "Forced exploration"), said], "")
    hint = "Success and reward are those of a learner that is made to take a skill"
    return element("div", content, class_="forced", title=hint)
