"""How values are learned: one step of Q-learning, and of a skill, which goes on for ever."""

import numpy as np

from learners.kernel import rows
from sim.bits import U
from sim.compiled import piece

_BEST = U(rows.BEST)


@piece
def backup(
    table: np.ndarray,
    words: np.ndarray,
    row: np.uint64,
    action: np.uint64,
    target: np.float32,
    alpha: np.float32,
) -> np.float32:
    """Move Q(s, a) towards a target by the learning rate (equation 3.5); returns the change."""
    q_tm1 = table[row + action]
    q_t = q_tm1 + alpha * (target - q_tm1)
    rows.write(table, words, row, action, q_t)
    return q_t - q_tm1


@piece
def learn_skill(
    table: np.ndarray,
    words: np.ndarray,
    row: np.uint64,
    row_t: np.uint64,
    move: np.uint64,
    r_t: np.float32,
    gamma: np.float32,
    alpha: np.float32,
) -> None:
    """Let a skill learn from one move; its task goes on when the trial ends (section 4.2.2)."""
    target = np.float32(r_t + gamma * table[row_t + _BEST])
    backup(table, words, row, move, target, alpha)
