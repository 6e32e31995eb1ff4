"""What a loop notes of a step and of a trial that ends, beside what it learns.

The loop of :mod:`learners.kernel.loop` has these lines of its own, spread so that no register is
kept for them across a step.
"""

import numpy as np

from learners.kernel.state import NOT_REACHED, TRAIL_LENGTH, TRIAL_REACHED, LearnerState
from sim.bits import U
from sim.compiled import piece

_TRAIL_MASK = U(TRAIL_LENGTH - 1)


@piece
def note_step(
    state: LearnerState,
    s_tm1: np.uint64,
    n_options: np.uint64,
    option: np.uint64,
    repertoire: np.uint8,
    step: int,
    cell_t: np.uint64,
) -> int:
    """Note a step from a main state to a cell; returns how many new states that makes: 0 or 1."""
    new_states = 0
    if state.seen[s_tm1] != repertoire:
        state.seen[s_tm1] = repertoire
        new_states = 1
    state.visits[s_tm1 * n_options + option] += np.uint32(1)
    state.trail[U(step) & _TRAIL_MASK] = np.uint32(cell_t)
    return new_states


@piece
def note_reach(state: LearnerState, s_tm1: np.uint64, trial: int) -> None:
    """Note that the value of a main state has risen above 0, unless it did so before."""
    if state.first_reach[s_tm1] == NOT_REACHED:
        state.first_reach[s_tm1] = trial
        state.tally[TRIAL_REACHED] += 1


@piece
def note_trial(
    state: LearnerState,
    trial: int,
    outcome: int,
    trial_step: int,
    new_states: int,
    switches: int,
    change: float,
    cell: np.uint64,
) -> None:
    """Write down a trial that has ended."""
    state.log_outcome[trial] = outcome
    state.log_steps[trial] = trial_step
    state.log_new_states[trial] = new_states
    state.log_reached[trial] = state.tally[TRIAL_REACHED]
    state.tally[TRIAL_REACHED] = 0
    state.log_switches[trial] = switches
    state.log_change[trial] = change
    state.log_cell[trial] = np.uint32(cell)
