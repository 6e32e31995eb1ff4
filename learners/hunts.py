"""What a learner would do if it neither explored nor learned any more: hunts of pure greed.

Works on plain arrays, as a snapshot carries them, and changes nothing of a learner. From each state
the hunt takes an option of the largest value, and of that option's moves one of the largest value.
A learner that keeps its choices keeps them here as well.

Draws. Ties are broken at random, as the learner breaks them: a step takes one draw of 64 bits and
uses the same parts of it, the second 16 bits for the option and the last 16 for the move. A hunt's
stream is a function of the seed, its heading and its first cell, so that a single hunt goes the
way that it goes among all those of a map.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from learners.comparators.feudal import MOST_STEPS
from learners.kernel import rows
from learners.kernel.layout import by_main_state, by_sub_policy, regions_of
from learners.kernel.state import NO_OPTION, LearnerState, selection_q_of, skill_q_of
from learners.measures import Endings
from learners.policies.applicable import applicable_q
from learners.policies.greedy import Rule, choice_by, choices_of, rule_of
from learners.spec import RunSpec
from sim.bits import U, pick
from sim.compiled import loop, piece
from sim.geometry import N_MOVES, STAY
from sim.rng import GAMMA, mix
from sim.spec import N_HEADINGS
from sim.world import (
    CAPTURE,
    FLIGHT,
    ONGOING,
    READING_SHIFT,
    TIMEOUT,
    World,
    moved,
    outcome_of,
    skill_state_of,
    start_of_trial,
)

SLICE_STEPS = 2_000_000
"""Steps that one compiled call of a map makes at most, unless one hunt alone takes more."""

_ONE = U(1)
_S16 = U(16)
_S48 = U(48)
_LOW16 = U(0xFFFF)
_NOWHERE = U(0)
"""A cell of the frame, on which no hunt ever stands."""
_NO_OPTION = U(NO_OPTION)


class Kept(NamedTuple):
    """How long a hunt keeps to an option that it has taken, once it has."""

    group: np.ndarray
    """(reading,) uint32: as long as the selection's reading is of the same group..."""
    most: int
    """...and for at most so many steps."""


class Policy(NamedTuple):
    """What is greedy where, as sets of small numbers in the bits of a word."""

    moves: np.ndarray
    """(option, view, distance, direction) uint16: greedy moves of each option, by what skills see;
    of a primitive move, itself. Views are the headings if any option tells them apart, or one."""
    options: np.ndarray
    """(heading, distance, direction) uint16: greedy options of each state."""
    kept: Kept | None = None
    """None if an option is chosen anew in each step."""
    rule: Rule | None = None
    """The rule that chooses in each step from what may be chosen there; None if a table does."""


class Hunt(NamedTuple):
    """One greedy hunt."""

    cells: np.ndarray
    """(step + 1,) int64: the way, from the start to the cell of the last step."""
    options: np.ndarray
    """(step,) uint8: the option of each step."""
    moves: np.ndarray
    """(step,) uint8: the move of each step."""
    outcome: int
    """``CAPTURE``, ``FLIGHT`` or ``TIMEOUT``."""

    @property
    def steps(self) -> int:
        """How long it took."""
        return len(self.moves)


def greedy_moves(selection_q: np.ndarray, skill_q: np.ndarray, kept: Kept | None = None) -> Policy:
    """The greedy policy of a learner.

    Args:
        selection_q: ``(heading, distance, direction, option)``, minus infinity where not present.
        skill_q: ``(skill, distance, direction, move)``, a skill for each option, distance and
            direction as skills see them; ``(skill, heading, distance, direction, move)`` where one
            sees headings; no skill where the options are the primitive moves.
        kept: how long an option is kept, see :func:`kept_by`.

    Raises:
        ValueError: no option is present in some state.
    """
    present = np.isfinite(selection_q)
    if not present.any(axis=-1).all():
        raise ValueError("selection_q: no option is present in some state; allowed: at least one")
    shape = skill_q.shape[-3:-1]
    if len(skill_q):
        moves = _largest(skill_q).reshape(len(skill_q), -1, *shape)
    else:
        moves = _single_moves(shape)
    return Policy(moves, _largest(selection_q), kept)


def policy_of(spec: RunSpec, state: LearnerState) -> Policy:
    """The greedy policy of a learner between two steps: the sets that its tables keep, copied.

    It is that of :func:`greedy_moves`, for a tenth of the time.
    """
    rule = rule_of(spec, state)
    if rule is not None:
        return policy_by(spec, rule)
    if spec.learner.applicable is not None:
        skill_q, share = skill_q_of(spec, state), spec.learner.applicable
        allowed_q = applicable_q(share, selection_q_of(spec, state), skill_q, state.best_ever)
        return greedy_moves(allowed_q, skill_q, kept_by(spec))
    of_skills = spec.world.of_skills
    shape = of_skills.n_distances, of_skills.n_directions
    options = by_main_state(spec, rows.greedy_sets(state.selection_words))
    if spec.learner.sub_policies:
        moves = by_sub_policy(spec, rows.greedy_sets(state.skill_words))
        moves = moves.reshape(len(moves), -1, *shape)
    else:
        moves = _single_moves(shape)
    return Policy(moves, options, kept_by(spec))


def policy_by(spec: RunSpec, rule: Rule) -> Policy:
    """The greedy policy of a learner whose skills are selected by a rule."""
    found = choices_of(spec, rule)
    return Policy(found.moves, found.options, None, rule)


def kept_by(spec: RunSpec) -> Kept | None:
    """How long a learner keeps to an option; None if it chooses anew in each step."""
    regions, held = regions_of(spec), spec.learner.held
    if regions is not None:
        return Kept(regions.of_reading, MOST_STEPS)
    if held is None:
        return None
    readings = np.arange(spec.world.n_readings, dtype=np.uint32)
    return Kept(readings if held.until == "change" else np.zeros_like(readings), held.most)


def _single_moves(shape: tuple[int, ...]) -> np.ndarray:
    """The greedy moves of options that are the primitive moves: of each, itself."""
    only_itself = (1 << np.arange(N_MOVES, dtype=np.uint16))[:, None, None, None]
    return np.broadcast_to(only_itself, (N_MOVES, 1, *shape)).copy()


def _largest(values: np.ndarray) -> np.ndarray:
    """Set of the actions with the largest value, ``(...) uint16`` from ``(..., action)``."""
    bit = (1 << np.arange(values.shape[-1])).astype(np.uint16)
    greedy = values == values.max(axis=-1, keepdims=True)
    return (greedy * bit).sum(axis=-1, dtype=np.uint16)


class _Rules(NamedTuple):
    """A policy as the loops go by it."""

    moves: np.ndarray
    """(option * view * skill state,) uint16."""
    options: np.ndarray
    """(heading * reading,) uint16."""
    n_views: np.uint64
    """A power of two, so that a heading's view is its lowest bits."""
    kept: Kept | None
    rule: Rule | None


def _rules(policy: Policy) -> _Rules:
    n_views = U(policy.moves.shape[1])
    return _Rules(policy.moves.ravel(), policy.options.ravel(), n_views, policy.kept, policy.rule)


@piece
def _taken(
    kept: Kept | None,
    best: np.uint64,
    reading: np.uint64,
    draw16: np.uint64,
    option: np.uint64,
    steps: int,
    group: np.uint64,
) -> tuple[np.uint64, np.uint64, int, np.uint64]:
    """The option of a step: the one that is kept, or one of the best.

    Args:
        kept: how long an option is kept.
        best: set of the best options.
        reading: of the selection.
        draw16: of the step.
        option: of the step before.
        steps: for which that one has been kept so far.
        group: in which it was taken.

    Returns:
        The option; the set it was picked from; for how many steps it has been kept with this one,
        0 where none is kept; and the group.
    """
    if kept is None:
        return pick(best, draw16), best, 0, group
    here = U(kept.group[reading])
    if steps != 0 and steps < kept.most and here == group:
        return option, _ONE << option, steps + 1, group
    return pick(best, draw16), best, 1, here


@piece
def stream_of(seed: np.uint64, heading: np.uint64, cell: np.uint64) -> np.uint64:
    """Counter from which the draws of a hunt are made."""
    return mix(seed + (cell * U(N_HEADINGS) + heading + _ONE) * GAMMA)


@loop
def stepped(
    world: World, cell: np.uint64, heading: np.uint64, move: np.uint64
) -> tuple[np.uint64, int]:
    """Cell after one move, and what the move ended in."""
    cell_t = moved(world.cell_word, world.clipped, world.move_step, cell, move)
    return cell_t, outcome_of(world, cell, cell_t, heading)


@loop
def follow(
    world: World,
    rules: _Rules,
    cell: np.uint64,
    heading: np.uint64,
    counter: np.uint64,
    max_steps: int,
    way: np.ndarray,
    ways_options: np.ndarray,
    ways_moves: np.ndarray,
) -> tuple[int, int]:
    """Hunt from a cell, and note down as much of the way as there is room for.

    Args:
        world: the world.
        rules: of the policy.
        cell: where the hunt starts.
        heading: of the prey.
        counter: of the hunt's draws.
        max_steps: step limit.
        way: ``(step,) int64``, filled with the cell after each step.
        ways_options: ``(step,) uint8``, filled with the option of each step.
        ways_moves: ``(step,) uint8``, filled with the move of each step.

    Returns:
        The outcome and the number of steps.
    """
    room = way.size
    base = heading * world.n_readings
    view = heading & (rules.n_views - _ONE)
    landmark = _NOWHERE
    landmark_option = _NO_OPTION
    landmark_kept = 0
    option = _NO_OPTION
    kept = 0
    group = _NOWHERE
    for step in range(max_steps):
        reading = U(world.cell_word[cell]) >> READING_SHIFT
        skill_state = skill_state_of(world.skill_states, cell, reading)
        counter += GAMMA
        draw = mix(counter)
        option, best_options, kept, group = _taken(
            rules.kept,
            U(rules.options[base + reading]),
            reading,
            (draw >> _S16) & _LOW16,
            option,
            kept,
            group,
        )
        option, move = choice_by(rules.rule, heading, reading, draw, option, _ONE)
        seen = (option * rules.n_views + view) * world.n_skill_states + skill_state
        best_moves = U(rules.moves[seen])
        if rules.rule is None:
            move = pick(best_moves, draw >> _S48)
        cell_t = moved(world.cell_word, world.clipped, world.move_step, cell, move)
        outcome = outcome_of(world, cell, cell_t, heading)
        cell = cell_t
        if step < room:
            way[step] = cell
            ways_options[step] = option
            ways_moves[step] = move
        if outcome != ONGOING:
            return outcome, step + 1
        # Where no tie was broken since the landmark, to be there again is to go round for ever; if
        # options are kept, with the same one, kept for as long.
        if (best_options & (best_options - _ONE)) | (best_moves & (best_moves - _ONE)):
            landmark = _NOWHERE
        elif (
            cell == landmark
            and step >= room
            and kept == landmark_kept
            and (kept == 0 or option == landmark_option)
        ):
            break
        if step & (step + 1) == 0:
            landmark = cell
            landmark_option = option
            landmark_kept = kept
    return TIMEOUT, max_steps


@piece
def ending_from(
    world: World,
    rules: _Rules,
    cell: np.uint64,
    heading: np.uint64,
    seed: np.uint64,
    no_way: np.ndarray,
    no_options: np.ndarray,
) -> int:
    """What a hunt comes to whose way is not asked for; the ``no_`` arrays are empty."""
    outcome, _ = follow(
        world,
        rules,
        cell,
        heading,
        stream_of(seed, heading, cell),
        world.step_limit,
        no_way,
        no_options,
        no_options,
    )
    return outcome


@loop
def follow_each(
    world: World,
    rules: _Rules,
    heading: np.uint64,
    seed: np.uint64,
    first: int,
    last: int,
    outcomes: np.ndarray,
    no_way: np.ndarray,
    no_options: np.ndarray,
) -> None:
    """Hunt from the cells ``first`` to ``last - 1`` of the board, row by row.

    Fills their places in ``outcomes``, ``(y * x,) int8``. The ``no_`` arrays are empty.
    """
    for place in range(first, last):
        cell = U(place // world.size + 1) * world.width + U(place % world.size + 1)
        outcomes[place] = ending_from(world, rules, cell, heading, seed, no_way, no_options)


@loop
def count_endings(
    world: World,
    rules: _Rules,
    starts: np.uint64,
    n_hunts: int,
    no_way: np.ndarray,
    no_options: np.ndarray,
    counts: np.ndarray,
) -> None:
    """Endings of hunts that start as the first trials of a stream of starts would.

    They are added to ``counts``, ``(outcome,) int64``. The ``no_`` arrays are empty.
    """
    for number in range(n_hunts):
        cell, heading = start_of_trial(world, starts, number)
        outcome = ending_from(world, rules, cell, heading, U(number), no_way, no_options)
        counts[outcome] += 1


def hunt(
    world: World,
    policy: Policy,
    cell: int,
    heading: int,
    seed: int = 0,
    max_steps: int | None = None,
    counter: np.uint64 | None = None,
) -> Hunt:
    """One hunt with its way; ``max_steps`` is the world's step limit unless given.

    With the ``counter`` of a learner's draws as a trial begins, and not with that of the seed, it
    is the trial that the learner would have if it neither explored nor learned.
    """
    limit = world.step_limit if max_steps is None else max_steps
    way = np.empty(limit, np.int64)
    options, moves = np.empty(limit, np.uint8), np.empty(limit, np.uint8)
    start, facing = U(cell), U(heading)
    outcome, steps = follow(
        world,
        _rules(policy),
        start,
        facing,
        U(stream_of(U(seed), facing, start) if counter is None else counter),
        limit,
        way,
        options,
        moves,
    )
    cells = np.concatenate([[cell], way[:steps]])
    return Hunt(cells, options[:steps].copy(), moves[:steps].copy(), int(outcome))


def endings(world: World, policy: Policy, starts: np.uint64, n_hunts: int) -> Endings:
    """How hunts end that start as the first trials of a stream of starts would.

    Each breaks its ties by a seed of its own, its number.
    """
    no_way, no_options = np.empty(0, np.int64), np.empty(0, np.uint8)
    counts = np.zeros(TIMEOUT + 1, np.int64)
    count_endings(world, _rules(policy), starts, n_hunts, no_way, no_options, counts)
    return Endings(int(counts[CAPTURE]), int(counts[FLIGHT]), int(counts[TIMEOUT]))


def success_map(
    world: World, policy: Policy, seed: int = 0, wanted: Callable[[], bool] = lambda: True
) -> np.ndarray | None:
    """How one hunt from each cell ends, for each heading of the prey.

    It is worked out in slices of a few hundredths of a second, between which ``wanted`` is asked.

    Returns:
        ``(heading, y, x) int8`` of ``CAPTURE``, ``FLIGHT`` and ``TIMEOUT``; None if it was no
        longer wanted.
    """
    n_cells = world.size * world.size
    per_slice = max(SLICE_STEPS // max(world.step_limit, 1), 1)
    outcomes = np.zeros((N_HEADINGS, n_cells), np.int8)
    rules = _rules(policy)
    no_way, no_options = np.empty(0, np.int64), np.empty(0, np.uint8)
    for heading in range(N_HEADINGS):
        for first in range(0, n_cells, per_slice):
            if not wanted():
                return None
            follow_each(
                world,
                rules,
                U(heading),
                U(seed),
                first,
                min(first + per_slice, n_cells),
                outcomes[heading],
                no_way,
                no_options,
            )
    return outcomes.reshape(N_HEADINGS, world.size, world.size)


def ring_of_starts(world: World, radius: float, n: int = 16) -> np.ndarray:
    """Cells all round the prey, from the east counter-clockwise, ``(n,) int64``.

    Args:
        world: the world.
        radius: in cells; what lies off the grid is moved to its edge.
        n: how many.
    """
    angle = 2 * math.pi * np.arange(n) / n
    middle, last = world.size // 2, world.size - 1
    x = np.clip(np.floor(middle + radius * np.cos(angle) + 0.5), 0, last).astype(np.int64)
    y = np.clip(np.floor(middle + radius * np.sin(angle) + 0.5), 0, last).astype(np.int64)
    return (y + 1) * int(world.width) + x + 1


def prepare(world: World) -> None:
    """Compile what hunts take, or load what was compiled before, ahead of the first one."""
    anything = np.zeros((N_HEADINGS, 1, int(world.n_readings), N_MOVES))
    policy = greedy_moves(anything, np.zeros((0, 1, int(world.n_skill_states), N_MOVES)))
    success_map(world._replace(step_limit=0), policy)
    hunt(world, policy, int(world.prey_cell), 0, max_steps=1)
    endings(world, policy, U(0), n_hunts=1)
    stepped(world, world.prey_cell, U(0), U(STAY))
