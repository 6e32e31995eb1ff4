"""Where two runs part: the first step that they do not make alike.

Two runs are the same at a moment if all tables, counters and draws are. What is counted there
never comes back, so runs that have parted stay apart, and the moment is found by halving: first
between checkpoints, where moments cost little, then step by step between two of them. Runs of one
preset and seed are known to be the same, without looking, up to the first command that only one of
them was given.
"""

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from app.live.past import Past
from learners.commands import Command, CommandError
from learners.control import Control
from learners.kernel.state import CELL, TRAIL_LENGTH, LearnerState, n_options_of
from learners.names import MAX_TRIALS
from learners.run import Run
from sim.geometry import MOVES
from sim.world import board_xy

_CLOSE_STEPS: Final = 20_000
"""So many are made rather than looking for a checkpoint nearer by: a millisecond."""


@dataclass(frozen=True)
class Did:
    """What one of two runs did where they parted."""

    skill: str | None
    """That it took in its next step; None if its options are moves, or it made no more steps."""
    move: int | None
    """By which it went in that step, at an edge by as much of it as there is room for; None if it
    made none."""
    given: tuple[Command, ...]
    """What was given there, by hand or by its schedule, and not to the other."""
    control: Control
    """What held in that step."""


@dataclass(frozen=True)
class Divergence:
    """The moment at which two runs part."""

    step: int
    """So many steps they made alike."""
    trial: int
    """The running one there."""
    from_start: bool
    """They were not the same before their first step."""
    did: tuple[Did, Did]
    """What each did there."""
    seeds: tuple[int, int]


def is_same(one: LearnerState, other: LearnerState) -> bool:
    """Whether two learners are the same at a moment; logs apart, which say how they came there."""
    return all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in LearnerState._fields
        if name not in ("selection", "skills") and not name.startswith("log_")
    )


def first_divergence(one: Past, other: Past, *, until: int | None = None) -> Divergence | None:
    """Where two runs part; None if they are the same as far as both are known.

    Takes some tenths of a second, and leaves the runs and their pasts as they are.

    Args:
        one: past of the first.
        other: past of the second.
        until: step beyond which it does not matter.

    Raises:
        CommandError: one of them went another way meanwhile.
    """
    ends = [one.end_step, other.end_step, *([] if until is None else [max(until, 0)])]
    last = min(ends)
    known = _known_same(one, other)
    if known >= last:
        return None
    before = _pair(one, other, known) if known >= 0 else None
    if _is_same_pair(_pair(one, other, last)):
        return None
    at, after = known, last
    while after - at > 1:
        middle = _middle(one, other, at, after)
        there = _pair(one, other, middle, before)
        if _is_same_pair(there):
            at, before = middle, there
        else:
            after = middle
    return _parted(one, other, before)


class _Pair(NamedTuple):
    one: Run
    other: Run


def _is_same_pair(pair: _Pair) -> bool:
    return is_same(pair.one.state, pair.other.state)


def _known_same(one: Past, other: Past) -> int:
    """A step up to which both must be the same by what they were given; -1 if there is none."""
    first, second = one.control, other.control
    if one.seed != other.seed or first.preset != second.preset:
        return -1
    given, also = _by_hand(first), _by_hand(second)
    n_same = 0
    while n_same < min(len(given), len(also)) and given[n_same] == also[n_same]:
        n_same += 1
    ahead = [events[n_same][0] for events in (given, also) if len(events) > n_same]
    return min(ahead) - 1 if ahead else min(one.end_step, other.end_step)


def _by_hand(control: Control) -> list[tuple[int, Command]]:
    return [(event.step, event.command) for event in control.history if event.author == "hand"]


def _pair(one: Past, other: Past, step: int, before: _Pair | None = None) -> _Pair:
    """Both at a step, made of them at a step before if that is near."""
    firsts = before or (None, None)
    return _Pair(_at(one, step, firsts[0]), _at(other, step, firsts[1]))


def _at(past: Past, step: int, before: Run | None) -> Run:
    if before is not None and step - before.step < _CLOSE_STEPS:
        run = before.copy()
        if not past.take_on(run, step):
            raise CommandError("one of them went another way meanwhile; ask again")
        return run
    run = past.run_at(step, quietly=True)
    assert run is not None
    if run.step != step:
        raise CommandError("one of them went another way meanwhile; ask again")
    return run


def _middle(one: Past, other: Past, at: int, after: int) -> int:
    """A step between two: in the middle or, if they are far apart, at a checkpoint near it."""
    middle, quarter = (at + after) // 2, (after - at) // 4
    if after - at < 2 * _CLOSE_STEPS:
        return middle
    near = [step for past in (one, other) for step in _around(past.kept, middle)]
    near = [step for step in near if abs(step - middle) < quarter]
    return min(near, key=lambda step: abs(step - middle), default=middle)


def _around(steps: Sequence[int], step: int) -> Sequence[int]:
    place = bisect_left(steps, step)
    return steps[max(place - 1, 0) : place + 1]


def _parted(one: Past, other: Past, before: _Pair | None) -> Divergence:
    """What they did after the last moment at which they were the same; None if there is none."""
    if before is None:
        begun = _Pair(_begun(one), _begun(other))
        from_start = not _is_same_pair(begun)
        step = 0
    else:
        from_start, step = False, before.one.step
        ahead = _Pair(before.one.copy(), before.other.copy())
        for run in ahead:
            run.advance(1, MAX_TRIALS)
        if _is_same_pair(ahead):
            # Not by a step, but by what was given after it.
            step += 1
            before = None
    there = before or _pair(one, other, step)
    next_one, next_other = _next(one, there.one), _next(other, there.other)
    given = _given(next_one or there.one, step), _given(next_other or there.other, step)
    did = (
        _did(there.one, next_one, [command for command in given[0] if command not in given[1]]),
        _did(there.other, next_other, [command for command in given[1] if command not in given[0]]),
    )
    return Divergence(step, there.one.trial, from_start, did, (one.seed, other.seed))


def _begun(past: Past) -> Run:
    return Run(past.control.preset, past.seed)


def _next(past: Past, run: Run) -> Run | None:
    """A run a step later; None if it makes none."""
    if past.end_step <= run.step:
        return None
    after = run.copy()
    after.advance(1, MAX_TRIALS)
    return after


def _given(run: Run, step: int) -> list[Command]:
    """What was given at a step, the last that a run made or the one before."""
    return [event.command for event in run.control.history if event.step == step]


def _did(run: Run, after: Run | None, commands: Sequence[Command]) -> Did:
    """What a run did in a step, and what only it was given before that."""
    given = tuple(commands)
    if after is None:
        return Did(None, None, given, run.control)
    skills = after.spec.learner.sub_policies
    # A step counts one visit; of one that ended a trial no more than that is known.
    taken = int(np.flatnonzero(after.state.visits != run.state.visits)[0])
    skill = skills[taken % n_options_of(after.spec)] if skills else None
    cell = int(after.state.trail[after.step % TRAIL_LENGTH])
    way = np.subtract(board_xy(run.world, cell), board_xy(run.world, int(run.state.place[CELL])))
    move = int(np.flatnonzero((way == MOVES).all(axis=1))[0])
    return Did(skill, move, given, after.control)
