"""What to do next: an option, imposed or selected, and of a skill one of its moves.

Each choice uses its own part of the step's draw, see ``learners.kernel.loop``.
"""

import numpy as np

from learners.kernel import rows
from learners.kernel.state import NO_OPTION
from sim.bits import U, pick
from sim.compiled import piece
from sim.rng import GAMMA, mix

_ZERO = U(0)
_ONE = U(1)
_S16 = U(16)
_S32 = U(32)
_S48 = U(48)
_LOW16 = U(0xFFFF)
_N_MOVES = U(9)
_GREEDY = U(rows.GREEDY)


@piece
def imposed_option(
    present: np.uint64,
    n_episodes: int,
    episode_option: np.ndarray,
    episode_chance: np.ndarray,
    episode_value_at_most: np.ndarray | None,
    table: np.ndarray,
    words: np.ndarray,
    row: np.uint64,
    counter: np.uint64,
) -> tuple[np.uint64, np.uint64, np.uint64]:
    """Option that a running exploration episode imposes on this step (section 3.3.4).

    An episode may act by context (section 5.2): only where V(s), the largest Q(s, o) of the present
    options but its own, is at most a value. Elsewhere it takes no draw, and its option may be
    chosen like any other.

    Returns:
        The option or ``NO_OPTION``; the options left for the ordinary choice; the counter of
        decisions after the draws this took.
    """
    left = present
    for episode in range(n_episodes):
        option = episode_option[episode]
        if (
            episode_value_at_most is not None
            and rows.best_without(table, words, row, option) > episode_value_at_most[episode]
        ):
            continue
        counter += GAMMA
        if mix(counter) >> _S32 < episode_chance[episode]:
            return option, left, counter
        left &= ~(_ONE << option)
    if left == _ZERO:
        left = present
    return U(NO_OPTION), left, counter


@piece
def selected_option(
    table: np.ndarray,
    words: np.ndarray,
    row: np.uint64,
    allowed: np.uint64,
    epsilon16: np.uint64,
    draw: np.uint64,
) -> np.uint64:
    """Selection policy: epsilon-greedy among the allowed options (section 4.2.1)."""
    index16 = (draw >> _S16) & _LOW16
    if draw & _LOW16 < epsilon16:
        return pick(allowed, index16)
    return pick(rows.greedy_among(table, words, row, allowed), index16)


@piece
def skill_move(
    words: np.ndarray, row: np.uint64, epsilon16: np.uint64, draw: np.uint64
) -> np.uint64:
    """A skill's policy: epsilon-greedy among the nine moves (section 4.2.2)."""
    index16 = draw >> _S48
    if (draw >> _S32) & _LOW16 < epsilon16:
        return (index16 * _N_MOVES) >> _S16
    return pick(U(words[row + _GREEDY]), index16)
