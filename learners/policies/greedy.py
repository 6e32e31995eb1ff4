"""What a rule of static selection chooses in each state, if nothing is explored.

Which skill moves may hang on which of its best moves a skill would make, so a rule has no sets of
best options that a hunt could pick from: it is asked anew in each step, with the step's draw. What
it *may* choose in a state is found by asking it with draws that break ties in every way.
"""

from typing import NamedTuple

import numpy as np

from learners.kernel import rows
from learners.kernel.forms import Forms, forms_of
from learners.kernel.state import NO_OPTION, LearnerState
from learners.policies.static import Static, static_choice, static_of
from learners.spec import RunSpec
from sim.bits import U, count
from sim.compiled import loop, piece
from sim.geometry import N_MOVES
from sim.spec import N_HEADINGS

_ZERO = U(0)
_ONE = U(1)
_S16 = U(16)
_S48 = U(48)
_TWO = U(2)
_RANGE = U(1 << 16)
_NOBODY = U(NO_OPTION)


class Rule(NamedTuple):
    """A rule of static selection, and all that it goes by; arrays are copies."""

    static: Static
    forms: Forms | None
    skills: np.ndarray
    skill_words: np.ndarray
    w_values: np.ndarray
    present: np.uint64
    n_readings: np.uint64


class Choices(NamedTuple):
    """What a rule chooses without exploring."""

    share: np.ndarray
    """(heading, distance, direction, option) float32: how often an option moves there; minus
    infinity where it is not present."""
    options: np.ndarray
    """(heading, distance, direction) uint16: set of the options that may move there."""
    moves: np.ndarray
    """(option, heading, distance, direction) uint16: set of the moves that are made then."""


def rule_of(spec: RunSpec, state: LearnerState) -> Rule | None:
    """The rule of a learner between two steps; None if its selection is learned."""
    static = static_of(spec.learner)
    if static is None:
        return None
    there = np.isfinite(rows.values(state.selection)[0])
    skills = rows.copy_table(state.skills)
    return Rule(
        static,
        forms_of(spec, skills_learn=False),
        skills,
        skills.view(np.uint32),
        state.w_values.copy(),
        U(sum(1 << option for option in np.flatnonzero(there).tolist())),
        U(spec.world.n_readings),
    )


@piece
def choice_by(
    rule: Rule | None,
    heading: np.uint64,
    reading: np.uint64,
    draw: np.uint64,
    option: np.uint64,
    move: np.uint64,
) -> tuple[np.uint64, np.uint64]:
    """Option and move by a rule; those that are given if there is none."""
    if rule is None:
        return option, move
    n_readings = rule.n_readings
    return static_choice(
        rule.static,
        rule.forms,
        rule.skills,
        rule.skill_words,
        rule.w_values,
        n_readings * U(N_HEADINGS),
        heading * n_readings + reading,
        n_readings,
        reading,
        heading,
        rule.present,
        _NOBODY,
        _ZERO,
        draw,
    )


@loop
def fill_choices(rule: Rule, n_options: np.uint64, wins: np.ndarray, moves: np.ndarray) -> None:
    """Ask a rule in each state as often as there are ways in which ties may break.

    Args:
        rule: the rule.
        n_options: skills that there are.
        wins: ``(state * option,) float32`` of zeros, filled with how often each was chosen.
        moves: ``(option * state,) uint16`` of zeros, filled with the sets of their moves.
    """
    n_states = rule.n_readings * U(N_HEADINGS)
    n_present = count(rule.present)
    of_each = np.float32(1.0 / (float(n_present) * N_MOVES))
    state = _ZERO
    while state < n_states:
        heading = state // rule.n_readings
        reading = state % rule.n_readings
        part = _ZERO
        while part < n_present * U(N_MOVES):
            # The middles of equal parts of the draw's range.
            skill16 = (_TWO * (part // U(N_MOVES)) + _ONE) * _RANGE // (_TWO * n_present)
            move16 = (_TWO * (part % U(N_MOVES)) + _ONE) * _RANGE // U(2 * N_MOVES)
            draw = (skill16 << _S16) | (move16 << _S48)
            option, move = choice_by(rule, heading, reading, draw, _NOBODY, _ZERO)
            wins[state * n_options + option] += of_each
            moves[option * n_states + state] |= np.uint16(_ONE << move)
            part += _ONE
        state += _ONE


def choices_of(spec: RunSpec, rule: Rule) -> Choices:
    """What a rule chooses in each state."""
    shape = N_HEADINGS, spec.world.n_distances, spec.world.n_directions
    n_options, n_states = len(spec.learner.skills), spec.world.n_states
    share = np.zeros(n_states * n_options, np.float32)
    moves = np.zeros(n_options * n_states, np.uint16)
    fill_choices(rule, U(n_options), share, moves)
    share, moves = share.reshape(*shape, n_options), moves.reshape(n_options, *shape)
    bits = (1 << np.arange(n_options)).astype(np.uint16)
    options = ((share > 0) * bits).sum(axis=-1, dtype=np.uint16)
    present = (int(rule.present) >> np.arange(n_options)) & 1
    return Choices(np.where(present, share, -np.float32(np.inf)), options, moves)
