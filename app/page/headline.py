"""What is said of a moment beside the board: the one sentence, and the readings."""

import math
from typing import Final

from app.explain import sentence
from app.live.session import Status
from app.metrics.course import GREEDY_HUNTS, NO_CURVE, GreedyCurve
from app.server.pulse import Reading
from app.util.html import escaped
from app.words.numbers import NONE, counted, in_short, shown_number, speed_in_words
from learners import measures

TASK_HTML: Final = (
    "A predator learns to catch a prey that sees only what lies before it: it must come from"
    " behind, unseen."
)
"""What the learner is to do, in one line."""


def sentence_html(status: Status) -> str:
    """The one sentence, and where a run of an experiment is from."""
    text = escaped(sentence.sentence(status))
    origin = ""
    if status.opened is not None:
        # A name may be long, and without a blank.
        origin = (
            '<div style="margin-top:0.4em;overflow-wrap:anywhere">'
            f"{escaped(sentence.provenance(status.opened))}</div>"
        )
    error = f"<b>{escaped(status.error)}</b>" if status.error else ""
    return f"<div>{text}</div>{error}{origin}"


def numbers_html(status: Status, viewers: int = 1, greedy: GreedyCurve = NO_CURVE) -> str:
    """The readings."""
    snapshot = status.snapshot
    greedy_reward, measured = math.nan, "not measured yet"
    if greedy.step.size:
        greedy_reward = float(greedy.reward[-1])
        measured = f"measured at trial {greedy.trial[-1]:,}, step {greedy.step[-1]:,}"
    caught = sentence.success_share(snapshot)
    reached = int((snapshot.value > 0).sum())
    parts = [
        _number("Trial", f"{snapshot.trial:,}", "Trials that have ended"),
        _number("Steps", f"{snapshot.step:,}", "Learning steps so far"),
        _number("Steps/s", in_short(status.steps_per_s), "Learning steps in the last second"),
        _number("Viewers", str(viewers), "Browsers that see and steer this learner"),
        _number(
            "Success",
            NONE if math.isnan(caught) else f"{caught:.0%}",
            f"Share of the last {measures.RECENT_TRIALS} trials that ended in capture",
        ),
        _number(
            "Reward",
            shown_number(snapshot.recent_reward, ".1f"),
            f"Mean reward per trial over the last {measures.RECENT_TRIALS}, random moves,"
            " explorations and all",
        ),
        _number(
            "Greedy",
            shown_number(greedy_reward, ".1f"),
            f"Mean reward of {GREEDY_HUNTS:,} hunts without random moves, in which nothing is"
            f" explored or learned; {measured}",
        ),
        _number(
            "States of value",
            f"{reached:,}",
            f"States worth more than 0, of {snapshot.value.size:,}",
        ),
    ]
    return (
        '<div style="display:grid;grid-template-columns:repeat(4,auto);gap:0.35em 0.6em;'
        f'justify-content:space-between;padding:0 0.7em">{"".join(parts)}</div>'
    )


def _number(label: str, value: str, hint: str) -> str:
    return (
        f'<div title="{escaped(hint)}">'
        f'<div style="opacity:0.65;font-size:0.78em;white-space:nowrap">{label}</div>'
        f'<div style="font-size:1.15em;font-variant-numeric:tabular-nums">{value}</div></div>'
    )


def clock_html(reading: Reading, status: Status, viewers: int) -> str:
    """The honest clock."""
    behind = f"{reading.behind_s:.1f} s behind" if reading.behind_s > 0.05 else "up to date"
    seeing = counted(viewers, "viewer")
    return (
        '<div style="padding:0 0.7em;font-size:0.8em;line-height:1.5">'
        f"{speed_in_words(status.steps_per_s)}; {reading.drawing_share:.0%} of the time is spent on"
        f" drawing.<br>This browser: {reading.frame_rate:.1f} frames/s, {reading.frames_sent} sent"
        f" and {reading.frames_skipped} skipped in 5 s, {behind}."
        f"<br>{seeing} of this session.</div>"
    )
