"""What is going on now, in words: read off the state, never off a script."""

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np
from markupsafe import Markup

from app.explain.shape import Shape, bearings, shape_of, unseen
from app.live.held import Opened
from app.live.places import Behind
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.picture.giving_way import has_rule, minds
from app.schedule.forced import Forced, forced_now
from app.util.html import element, joined
from app.words.glossary import term
from app.words.numbers import counted
from app.words.plain import RULES_IN_WORDS, joined_by_and, named, plain
from learners.names import COMMANDS
from learners.policies.alone import Alone, alone_at
from sim import geometry
from sim.spec import WorldSpec

TASK: Final = joined(
    [
        "A predator learns, hunt by hunt, to catch a prey that sees only what is in front of it: it"
        " must come from behind, for once seen, the prey ",
        term("flight", "flees"),
        ".",
    ],
    "",
)
"""What all of this is about, as HTML: who hunts whom, what ends a hunt, and why that is hard."""

RECENT_REACH_TRIALS = 1_000
_DIGEST_SHOWN = 8
"""Characters of a digest that tell it from others at a glance."""
_BESIDE = np.radians(75)
"""Farther than this from straight behind the prey is beside the cone."""
_STANDING_SHARE = 1 / 170
"""Value that lately rose in fewer of the states than this has stopped spreading."""
_EVERYWHERE = 0.995
"""Of the places that they know: skills that agree in so many do so nearly everywhere."""
_NEARLY_ALL = 0.95
"""In more of the places in which skills are at odds than this one is said to have its way."""
_LEAN = 1 / 3
"""A front that grows so much more on one side than on the other goes round the prey, ..."""
_ROUND = 1 / 12
"""... if so much of it is beside the prey already."""


class Front(NamedTuple):
    """Where value first rose lately, as numbers of states in the prey's own frame.

    The first two count places out of the prey's sight, by the side of the line straight behind it.
    """

    counterclockwise: int
    clockwise: int
    beside: int
    """Those of both sides whose whole sector lies more than 75 degrees from straight behind."""
    inside: int
    """In the prey's visual field."""


def front(world: WorldSpec, first_reach: np.ndarray, trial: int) -> Front:
    """Count the states whose value first rose within the last ``RECENT_REACH_TRIALS`` trials."""
    turned = geometry.fold(first_reach, world.n_directions)
    fresh = ((turned >= 0) & (turned > trial - RECENT_REACH_TRIALS)).sum(axis=0)
    from_behind = bearings(world) - np.pi
    half = np.pi / world.n_directions
    out_of_sight = unseen(world)
    out = np.where(out_of_sight, fresh, 0)
    return Front(
        counterclockwise=int(out[:, from_behind > 1e-9].sum()),
        clockwise=int(out[:, from_behind < -1e-9].sum()),
        beside=int(out[:, np.abs(from_behind) - half > _BESIDE].sum()),
        inside=int(fresh[~out_of_sight].sum()),
    )


_COUNTS: Final = {1: "One", 2: "Two", 3: "Three"}


def success_share(snapshot: Snapshot) -> float:
    """Share of the recent trials that ended in capture; NaN before the first has ended."""
    total = sum(snapshot.recent)
    return snapshot.recent.captures / total if total else float("nan")


def _has_skills(snapshot: Snapshot) -> bool:
    return bool(snapshot.spec.learner.skills)


def _repertoire(snapshot: Snapshot) -> Markup:
    if not _has_skills(snapshot):
        is_manager = snapshot.spec.learner.options == COMMANDS
        what = "A manager with five commands" if is_manager else "Nine moves"
        parts = [_said(f"{what}, no ", term("skill", "skills"), "."), _manner(snapshot)]
        return joined([part for part in parts if part], " ")
    names = [plain(introduction.skill) for introduction in snapshot.control.introductions]
    if not names:
        return _said("No ", term("skill"), " yet.")
    word = term("skill", "skill" if len(names) == 1 else "skills")
    count = _COUNTS.get(len(names), str(len(names)))
    # What is explored is named anyway, and all of it must fit in two lines.
    which = "" if forced_now(snapshot) else f": {joined_by_and(names)}"
    manner = "" if forced_now(snapshot) else _manner(snapshot)
    return joined([part for part in (_said(f"{count} ", word, f"{which}."), manner) if part], " ")


def _manner(snapshot: Snapshot) -> str:
    """How it chooses, or learns of its choices, where that is not anew and once in each step."""
    learner = snapshot.spec.learner
    if learner.selection != "learned":
        return f"No table selects: each move is {RULES_IN_WORDS[learner.selection]}."
    if learner.options == COMMANDS:
        return "A command holds until the predator leaves the region."
    if learner.trace_decay is not None:
        return "Each reward reaches the moves that led to it."
    held = learner.held
    if held is None:
        return ""
    if held.until == "steps":
        return f"A choice is kept for {counted(held.most, 'step')}."
    return f"A choice is kept until the place changes, {counted(held.most, 'step')} at most."


def _explored(snapshot: Snapshot) -> Markup | str:
    """Which skills the learner is made to take, and what follows from it."""
    forced = forced_now(snapshot)
    if not forced:
        return ""
    # Of one skill it is made to take what it would take anyway, and where nothing is known there is
    # little to lose.
    costs = len(snapshot.present) > 1 and any(one.value_at_most is None for one in forced)
    so = ", so rewards fall" if costs else ""
    name = term("forced exploration", "Forced exploration")
    first, *others = forced
    taken = f"{plain(first.skill)} in {first.probability:.0%} of the steps{_where(first)}"
    if not others:
        return _said(name, f" until trial {first.until_trial:,}: {taken}{so}.")
    parts = [f"{taken} (until trial {first.until_trial:,})"]
    parts += [
        f"{plain(one.skill)} in {one.probability:.0%} of the others{_where(one)}"
        f" (until trial {one.until_trial:,})"
        for one in others
    ]
    return _said(name, f": {', '.join(parts)}{so}.")


def alone_in(snapshot: Snapshot) -> Alone | None:
    """The skill that learns alone at a moment, before the first trial; None where none does."""
    preset = snapshot.preset_spec
    return alone_at(snapshot.step, preset.schedule.pretrain, preset.learner.skills)


def _alone(alone: Alone, snapshot: Snapshot) -> Markup:
    return _said(
        "Before the first hunt each ",
        term("skill"),
        f" learns alone: {plain(alone.skill)} until step {alone.until_step:,}, of"
        f" {snapshot.preset_spec.schedule.pretrain * len(snapshot.preset_spec.learner.skills):,}.",
    )


def _taught(snapshot: Snapshot) -> Markup | str:
    """That a script chooses the skills, and until when."""
    until = snapshot.control.taught_until
    if until <= snapshot.trial:
        return ""
    taught = term("teaching", "Taught")
    return _said(taught, f" until trial {until:,}: a script shows it which skill to take.")


def _where(forced: Forced) -> str:
    """Where an exploration acts, if that is not everywhere."""
    if forced.value_at_most is None:
        return ""
    return f" where nothing else is worth more than {forced.value_at_most:g}"


def _held_still(snapshot: Snapshot) -> Markup | str:
    """All that is frozen or switched off by hand, and what is frozen for a skill that is new."""
    control = snapshot.control
    held = [
        word
        for word, is_held in [
            (_said("the ", term("selection")), control.selection_frozen),
            (_said("the ", term("skill", "skills")), control.skills_frozen),
        ]
        if is_held
    ]
    said: list[Markup] = []
    if held:
        so = ", so nothing is learned" if len(held) == 2 else ""
        said.append(_said(term("freeze", "Frozen"), " by hand: ", joined(held, " and "), f"{so}."))
    if snapshot.selection_frozen and not control.selection_frozen:
        said.append(_practised(snapshot))
    if not control.schedule_on and _has_skills(snapshot):
        said.append(_said("The ", term("schedule"), " is off: no skill joins by itself."))
    return joined(said, " ")


def _practised(snapshot: Snapshot) -> Markup:
    """Why nothing is learned of places while the newest skill is."""
    control = snapshot.control
    until = f"until trial {control.frozen_until:,}"
    frozen = _said("the ", term("selection"), " is ", term("freeze", "frozen"), f" {until}")
    if control.skills_frozen or not control.introductions:
        return _said("Besides, ", frozen, ", so nothing is learned.")
    if len(control.introductions) == 1:
        value = term("value", "worth")
        return _said(f"It is practised {until}; what places are ", value, " is learned after that.")
    newest = control.introductions[-1]
    by_rule = any(
        event.author == "trigger" and event.step == newest.step for event in control.history
    )
    how = "has joined by its rule, and is" if by_rule else "is new and"
    return _said(f"{named(newest.skill)} {how} practised first: ", frozen, ".")


def _spread(snapshot: Snapshot) -> Markup:
    """What value is doing, from where it rose lately, and what it looks like."""
    if has_rule(snapshot):
        return _agreed(snapshot)
    value = term("value", "Value")
    if not (snapshot.value > 0).any():
        return _said("No prey has been caught yet, so no place is of any ", term("value"), ".")
    world = snapshot.spec.world
    lately = front(world, snapshot.first_reach, snapshot.trial)
    shape = shape_of(world, snapshot.value)
    outside = lately.counterclockwise + lately.clockwise
    if outside + lately.inside < _STANDING_SHARE * snapshot.value.size:
        caught = f"{success_share(snapshot):.0%} of recent hunts end in capture"
        return _said(value, f" hardly spreads any more: {_STANDING[shape]}; {caught}.")
    if lately.inside > outside:
        return _said(value, " spreads inwards, into what the prey sees.")
    lean = lately.counterclockwise - lately.clockwise
    if shape == "filled":
        return _said(value, " spreads to the last places: nearly all round the prey is filled.")
    if shape == "ring":
        return _said(value, " spreads on round the prey; it has become a ring.")
    if shape == "open ring":
        return _said(value, " spreads on round the prey: a ring that is not closed yet.")
    if abs(lean) > _LEAN * outside and lately.beside > _ROUND * outside:
        way = "counter-clockwise" if lean > 0 else "clockwise"
        # One skill alone may widen its cone on one side; with others, that is how an arm begins.
        if shape in ("traces", "cone") and len(snapshot.present) == 1:
            return _said(value, f" spreads {way}, at the edge of the cone.")
        return _said(value, f" spreads {way}: an arm grows out of the cone.")
    if lately.beside > _LEAN * outside:
        return _said(value, " spreads to both sides round the prey, on its way to a ring.")
    if shape == "arm":
        return _said(value, " spreads from the cone behind the prey and from the arm beside it.")
    return _said(value, " spreads back from the prey as a cone: from there it sees nobody come.")


def _agreed(snapshot: Snapshot) -> Markup:
    """How often skills between which a rule selects are of one mind, and who has its way else."""
    known = np.broadcast_to((snapshot.skill_q != 0).any(axis=(0, -1)), snapshot.value.shape)
    if not known.any():
        return _said("No ", term("skill"), " has learned anything yet.")
    if len(snapshot.present) == 1:
        return _said(f"{success_share(snapshot):.0%} of recent hunts end in capture.")
    contested = minds(snapshot).any(axis=0) & known
    share = 1 - contested.sum() / known.sum()
    where = "nearly everywhere" if share >= _EVERYWHERE else f"in {share:.0%} of places"
    parts = [f"They agree {where}"]
    if contested.any():
        wins = np.maximum(snapshot.choice_q, 0)[contested].mean(axis=0)
        most = int(wins.argmax())
        name = plain(snapshot.spec.learner.skills[most])
        how_often = "" if wins[most] > _NEARLY_ALL else " mostly"
        parts.append(f"elsewhere {name}{how_often} has its way")
    caught = success_share(snapshot)
    if not math.isnan(caught):
        parts.append(f"{caught:.0%} of recent hunts end in capture")
    return _said(f"{'; '.join(parts)}.")


_STANDING: Final[Mapping[Shape, str]] = {
    "traces": "only a few places have any yet",
    "cone": "it is a cone behind the prey",
    "arm": "it is a cone behind the prey with an arm round it",
    "open ring": "it is a ring round the prey with a gap",
    "ring": "it is a ring round the prey",
    "filled": "nearly all round the prey is filled",
}
"""What value looks like when it stands."""


def _said(*parts: Markup | str) -> Markup:
    return joined(parts, "")


def how_far(behind: Behind) -> str:
    """How far a moment that is not now lies from the live run, in a few words."""
    # At one trial of two lines, which of them made more steps by then says nothing of when it is.
    if not behind.trials and (behind.branch or not behind.steps):
        return "level with the live run"
    apart, unit = (behind.trials, "trial") if behind.trials else (behind.steps, "step")
    return f"{counted(abs(apart), unit)} {'behind' if apart > 0 else 'ahead'}"


def _not_now(behind: Behind, trial: int) -> Markup:
    """Which moment it is that is shown, as a state that is seen first."""
    # Its name, and how far behind it is, stand with the readings and above the bar.
    where = term("branch", "Branch") if behind.branch else term("the past", "The past")
    return element("b", _said(where, f", trial {trial:,}."), class_="pounce-behind")


def said(status: Status) -> Markup:
    """What is going on in one sentence or a few short ones, as HTML with its terms marked.

    Of a moment that is not now it says so first, and nothing of how the live run stands.
    """
    snapshot = status.snapshot
    if status.behind is not None:
        parts = [_not_now(status.behind, snapshot.trial), *_of_moment(snapshot)]
        return joined([part for part in parts if part], " ")
    if status.error is not None:
        return _said(
            f"An error stopped the learner at trial {snapshot.trial:,}; what it has learned is"
            " kept."
        )
    if status.preparing:
        return _said("Getting ready: the learner is compiled, once on this machine; some seconds.")
    parts = _of_moment(snapshot)
    if status.finished:
        parts.insert(0, _said(f"The {snapshot.trial:,} ", term("trial", "trials"), " are over."))
    elif not status.playing:
        parts.insert(0, _said("Paused."))
    return joined([part for part in parts if part], " ")


def said_of(snapshot: Snapshot) -> Markup:
    """What a moment shows by itself, whoever runs it: nothing of a worker or of another line."""
    return joined([part for part in _of_moment(snapshot) if part], " ")


def _of_moment(snapshot: Snapshot) -> list[Markup | str]:
    """What a moment's tables and control say; some of it may be empty."""
    alone = alone_in(snapshot)
    if alone is not None:
        return [_alone(alone, snapshot)]
    parts = [_repertoire(snapshot), _taught(snapshot), _explored(snapshot), _held_still(snapshot)]
    if not snapshot.selection_frozen:
        parts.append(_spread(snapshot))
    return parts


def provenance(opened: Opened) -> str:
    """Which run of an experiment this is, and whether it came out as in the results."""
    recorded, found = opened.digest[:_DIGEST_SHOWN], opened.found[:_DIGEST_SHOWN]
    if opened.same is None:
        return f"Making {opened.name} again …"
    if opened.same:
        return f"This is {opened.name}, as it ended: digest {found}, as in the results."
    return (
        f"This is {opened.name}, made again, but its tables differ from the results (digest"
        f" {recorded} there, {found} here): another version of pounce made them."
    )
