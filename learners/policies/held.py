"""A choice that is kept for some steps and learned from once, at its end (sections 3.2 and 5.2).

Problem: a main state is many cells, so most steps lead from one to itself, and what is learned in
most of them is just that. Operator: a choice o made in main state s is kept for k steps, which earn
r_0 ... r_(k-1) and lead to s'; then

    Q(s, o) += alpha (sum of g^i r_i + g^k max Q(s', .) - Q(s, o))

where g is gamma; or, if what follows is discounted once for the choice, with 1 in the place of g^i
and gamma in that of g^k. After capture and flight the last term is 0; where the step limit ends the
trial it stays. Stopping rule: the choice ends when the main state has changed (unless choices are
of a fixed length), when it has been kept for ``most`` steps, and with the trial.
"""

from typing import NamedTuple

import numpy as np

from learners.kernel.state import (
    CHOICE_DISCOUNT,
    CHOICE_REWARD,
    CHOICE_STATE,
    CHOICE_STEPS,
    NO_OPTION,
)
from sim.bits import U
from sim.compiled import piece

_ZERO = U(0)
_ONE = U(1)
_NOTHING = np.float32(0)
_WHOLE = np.float32(1)


class Held(NamedTuple):
    """For how long a choice is kept."""

    until_change: bool
    """Whether it ends when the main state has changed."""
    most: int
    """Steps after which it ends."""
    once: bool
    """Whether what follows is discounted once for the choice, and not for each step."""


@piece
def kept_option(
    held: Held | None, choice: np.ndarray, previous: np.uint64, present: np.uint64
) -> np.uint64:
    """Option of the choice that goes on; ``NO_OPTION`` if one is to be made.

    A choice of an option that has left meanwhile is dropped, and nothing is learned from it.

    Args:
        held: for how long choices are kept; None for one step.
        choice: see ``LearnerState``.
        previous: option of the last step.
        present: options present, as bits.
    """
    if held is None:
        return U(NO_OPTION)
    if choice[CHOICE_STEPS] == 0 or present & (_ONE << previous) == _ZERO:
        return U(NO_OPTION)
    return previous


@piece
def begin_choice(held: Held | None, choice: np.ndarray, sums: np.ndarray, state: np.uint64) -> None:
    """Note that a choice is made in a main state."""
    if held is not None:
        choice[CHOICE_STATE] = state
        choice[CHOICE_STEPS] = 0
        sums[CHOICE_REWARD] = _NOTHING
        sums[CHOICE_DISCOUNT] = _WHOLE


@piece
def concluded(
    held: Held | None,
    choice: np.ndarray,
    sums: np.ndarray,
    state: np.uint64,
    reward: np.float32,
    future: np.float32,
    gamma: np.float32,
    has_changed: bool,
    has_ended: bool,
) -> tuple[bool, np.uint64, np.float32]:
    """Take a step into the choice that it is a part of.

    Args:
        held: for how long choices are kept; None for one step.
        choice: see ``LearnerState``.
        sums: of the choice, see ``LearnerState.choice_sums``.
        state: main state before the step.
        reward: of the step.
        future: utility of the state after it; 0 where nothing follows.
        gamma: discount.
        has_changed: whether the step led to another main state.
        has_ended: whether the trial ended with it.

    Returns:
        Whether the choice is over; the main state it was made in; the target of its value.
    """
    if held is None:
        return True, state, reward + gamma * future
    steps = choice[CHOICE_STEPS] + 1
    discount = sums[CHOICE_DISCOUNT]
    total = sums[CHOICE_REWARD] + discount * reward
    if not held.once:
        discount *= gamma
    is_over = has_ended or steps >= held.most or (held.until_change and has_changed)
    choice[CHOICE_STEPS] = 0 if is_over else steps
    sums[CHOICE_REWARD] = total
    sums[CHOICE_DISCOUNT] = discount
    if held.once:
        discount = gamma
    return is_over, U(choice[CHOICE_STATE]), total + discount * future
