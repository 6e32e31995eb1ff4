"""A run at one of its moments, without its logs.

Logs only grow: what is in them of a trial that has ended stays, so all moments of a run can share
those of its newest one, and only the tables, a few hundred kilobytes, are copied.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from learners.control import Control
from learners.kernel.state import STEP, TRIAL, LearnerState, copy_state
from learners.timers import Timer


class Logs(NamedTuple):
    """The logs of a run, each ``(trial,)``, see :class:`learners.kernel.state.LearnerState`.

    What is in them from the running trial on means nothing.
    """

    log_outcome: np.ndarray
    log_reward: np.ndarray
    log_steps: np.ndarray
    log_new_states: np.ndarray
    log_reached: np.ndarray
    log_switches: np.ndarray
    log_change: np.ndarray
    log_cell: np.ndarray


@dataclass(frozen=True)
class Checkpoint:
    """All that a run is at a moment but its logs; made and used by :class:`learners.run.Run`."""

    seed: int
    control: Control
    since: Control
    timers: tuple[Timer, ...]
    state: LearnerState
    """Its logs are empty."""

    @property
    def step(self) -> int:
        """Steps made by then."""
        return int(self.state.tally[STEP])

    @property
    def trial(self) -> int:
        """The running trial; so many have ended."""
        return int(self.state.tally[TRIAL])

    @property
    def nbytes(self) -> int:
        """Memory that is its own: its arrays, and its list of events."""
        own = {id(array.base if array.base is not None else array): array for array in self.state}
        return sum(array.nbytes for array in own.values()) + 8 * len(self.control.history)


def logs_of(state: LearnerState) -> Logs:
    """The logs themselves, not copied."""
    return Logs(*(getattr(state, name) for name in Logs._fields))


def without_logs(state: LearnerState) -> LearnerState:
    """An independent copy that has no logs."""
    empty = {name: log[:0] for name, log in logs_of(state)._asdict().items()}
    return copy_state(state._replace(**empty))


def with_logs(state: LearnerState, logs: Logs, room: int) -> LearnerState:
    """An independent copy that has logs of its own, the same up to the running trial.

    Args:
        state: of a checkpoint.
        logs: of the same run, at this moment or later.
        room: trials that the logs are to hold; at least those that have ended.
    """
    done = int(state.tally[TRIAL])
    copied: dict[str, np.ndarray] = {}
    for name, log in logs._asdict().items():
        # Zeros are pages that cost nothing until they are written to.
        copied[name] = np.zeros(max(room, done), log.dtype)
        copied[name][:done] = log[:done]
    return copy_state(state)._replace(**copied)
