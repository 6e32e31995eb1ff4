"""Of runs side by side, what is said of one, of two, and how a look is one for all of them."""

import math
from typing import Any

from app.charts.bar.rule import outlook_in_words
from app.explain.divergence import divergence_in_words, same_in_words
from app.explain.sentence import success_share
from app.live.divergence import Divergence
from app.live.racer import Stand
from app.live.snapshot import Snapshot
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.picture.options import option_names
from app.schedule.forced import forced_now, where_in_short
from app.words.numbers import NONE, shown_number
from app.words.plain import named, plain

_STANDS = {
    "finished": "its trials are over",
    "known": "no more is known",
    "gone": "it is not there any more",
}
"""Where a run stands that does not go on with the others."""


def run_sent(
    snapshot: Snapshot,
    stand: Stand,
    greedy: tuple[int, float] | None,
    digest: str,
    leads: bool,
    is_now: bool = True,
) -> dict[str, Any]:
    """What is read of one run, in few words each.

    Args:
        snapshot: the moment.
        stand: where it stands.
        greedy: step and reward of the newest measurement; None before the first.
        digest: of its tables; "" where that is not known.
        leads: whether none has a better reward.
        is_now: whether that is where the runs are.
    """
    caught = success_share(snapshot)
    return {
        "trial": f"{snapshot.trial:,}",
        "reward": shown_number(snapshot.recent_reward, ".1f"),
        "success": NONE if math.isnan(caught) else f"{caught:.0%}",
        "greedy": NONE if greedy is None else shown_number(greedy[1], ".1f"),
        "measured": "not measured yet" if greedy is None else f"measured at step {greedy[0]:,}",
        "stand": f"Step {snapshot.step:,}: {_STANDS[stand]}"
        if stand
        else under_way(snapshot, is_now),
        "digest": digest,
        "leads": leads,
    }


def under_way(snapshot: Snapshot, is_now: bool) -> str:
    """What is done to a run from outside, or else what a rule waits for; in a few words."""
    if snapshot.control.taught_until > snapshot.trial:
        return f"Taught until trial {snapshot.control.taught_until:,}"
    forced = forced_now(snapshot)
    if forced:
        one = forced[0]
        where = where_in_short(one.value_at_most)
        return f"Explored: {plain(one.skill)} {one.probability:.0%}{where}"
    waited = next((one for one in snapshot.watched if one.until is None), None)
    if waited is None:
        return ""
    what = f"{named(waited.skill)} joins below {waited.rule.below:g}"
    return f"{what}: {outlook_in_words(waited, is_now)}"


def looks_with(look: Look, named: Snapshot, snapshot: Snapshot) -> Look:
    """A look at another run: an option is the one of the same name there, or else the first.

    Args:
        look: as the browser has it, with an option of ``named``.
        named: a moment of the run whose options there were to choose from.
        snapshot: the run.
    """
    names, own = option_names(named), option_names(snapshot)
    name = names[look.option] if look.option < len(names) else ""
    look = look._replace(option=own.index(name) if name in own else 0)
    return LAYERS[look.layer].heeded(look, snapshot.spec.learner)


def apart_said(found: Divergence | None, names: tuple[str, str], step: int, trial: int) -> str:
    """Where two runs first went different ways, in a sentence.

    Args:
        found: that; None if no difference is known.
        names: of both.
        step: how far they have come.
        trial: the running one there, of the first.
    """
    if found is None:
        return same_in_words(step, trial)
    return divergence_in_words(found, *names)
