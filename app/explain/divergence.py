"""Where two runs part, in words: up to which step they were the same, and what each did there."""

from typing import Final

from app.explain.branches import differences
from app.explain.commands import command_in_words
from app.live.divergence import Did, Divergence
from app.words.numbers import counted
from app.words.plain import MOVE_NAMES, joined_by_and, plain
from learners.control import Control
from learners.names import COMMANDS
from sim.geometry import STAY

_MOST_SAID: Final = 2
"""Things that are otherwise; the others are left out."""


def same_in_words(step: int, trial: int) -> str:
    """That two runs are the same as far as both are known: up to a step, in a trial."""
    return f"The same as far as both are known: until step {step:,} (trial {trial:,})."


def divergence_in_words(found: Divergence, one: str = "A", other: str = "B") -> str:
    """Where two runs part, as plain sentences.

    "The same until step 412,344 (trial 12,907): A took approach, B circle clockwise."

    Args:
        found: the moment.
        one: what the first run is called.
        other: what the second is called.
    """
    names = one, other
    if found.from_start:
        return (
            f"Different from the start: {_at_start(found, names)}. {_first(found, names)}".strip()
        )
    until = f"The same until step {found.step:,} (trial {found.trial:,})"
    given = [
        f"{joined_by_and([command_in_words(command) for command in did.given])} in {name} alone"
        for name, did in zip(names, found.did, strict=True)
        if did.given
    ]
    took = _took(found, names)
    if given:
        return f"{until}; there {', '.join(given)}." + (f" Then {took}." if took else "")
    why = _why(found, other)
    return f"{until}: {took}.{why}"


def _took(found: Divergence, names: tuple[str, str]) -> str:
    """What they did in their next steps; "" if not both made one."""
    one, other = found.did
    if one.move is None or other.move is None:
        return ""
    if one.skill != other.skill:
        return f"{names[0]} {_choice(one)}, {names[1]} {_choice(other, after=one)}"
    both = f"both took {plain(one.skill)}" if one.skill is not None else ""
    if one.move != other.move:
        went = f"{names[0]} {_went(one)}, {names[1]} {_went(other, after=one)}"
        return f"{both}; {went}" if both else went
    return f"{both or f'both {_went(one)}'}, and learned otherwise from it"


def _choice(did: Did, after: Did | None = None) -> str:
    if did.skill is None:
        return _went(did)
    is_said = after is not None and after.skill is not None
    return plain(did.skill) if is_said else f"took {plain(did.skill)}"


def _went(did: Did, after: Did | None = None) -> str:
    assert did.move is not None
    if did.move == STAY:
        return "stayed"
    is_said = after is not None and after.move != STAY
    return MOVE_NAMES[did.move] if is_said else f"went {MOVE_NAMES[did.move]}"


def _why(found: Divergence, other: str) -> str:
    """What is otherwise in the second run, if anything that was set is."""
    first, second = (did.control for did in found.did)
    said = differences(first, second, found.trial)[:_MOST_SAID]
    return f" In {other} {joined_by_and(said)}." if said else ""


def _at_start(found: Divergence, names: tuple[str, str]) -> str:
    one, other = (did.control for did in found.did)
    if one.preset.world != other.preset.world:
        return "their worlds are not the same"
    if found.seeds[0] != found.seeds[1]:
        seeds = " and ".join(
            f"{name} has seed {seed}" for name, seed in zip(names, found.seeds, strict=True)
        )
        return f"{seeds}, so their trials start elsewhere"
    return ", ".join(
        f"{name} {_repertoire(control)}" for name, control in zip(names, (one, other), strict=True)
    )


def _repertoire(control: Control) -> str:
    """What it begins with."""
    skills = control.spec.learner.skills
    if not skills:
        is_manager = control.spec.learner.options == COMMANDS
        return f"chooses among the {'five commands' if is_manager else 'nine moves'}"
    present = joined_by_and([plain(skill) for skill in control.present])
    more = len(skills) - len(control.present)
    later = f" ({counted(more, 'skill')} more later)" if more else ""
    return (
        f"begins with {present}{later}"
        if present
        else f"begins with none of its {counted(len(skills), 'skill')}"
    )


def _first(found: Divergence, names: tuple[str, str]) -> str:
    took = _took(found, names)
    return f"In the first step {took}." if took else ""
