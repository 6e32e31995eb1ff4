"""Only skills that promise much where they are, beside what they ever promised (section 3.2).

Lin's rule, by a threshold on what skills predict: skill i may be selected in x where

    max_a Q_i(x, a) >= share * M_i

M_i being the largest value that max_a Q_i has had so far, in any state in which a skill was
selected while skills learned. If no skill is applicable, all are.

It takes for granted that a skill predicts more the nearer it is to its goal. Here it is the other
way round: local rewards are for progress, of which less is left near the goal. It is built all the
same, because that is what it teaches.
"""

import numpy as np

from learners.kernel import rows
from learners.kernel.forms import Forms, skill_row
from sim.bits import U, lowest
from sim.compiled import piece

_ZERO = U(0)
_ONE = U(1)
_BEST = U(rows.BEST)


def applicable_q(
    share: float | None, selection_q: np.ndarray, skill_q: np.ndarray, best_ever: np.ndarray
) -> np.ndarray:
    """Values of the selection, minus infinity where a skill is not applicable and another is.

    Args:
        share: see :func:`applicable_among`; None leaves all as it is.
        selection_q: ``(heading, distance, direction, option)``, minus infinity where not present.
        skill_q: ``(skill, distance, direction, move)``, or with headings before the distance.
        best_ever: ``(skill,) float32``.
    """
    if share is None:
        return selection_q
    promised = np.moveaxis(skill_q.max(axis=-1), 0, -1)
    fits = (promised >= np.float32(share) * best_ever) & np.isfinite(selection_q)
    return np.where(fits | ~fits.any(axis=-1, keepdims=True), selection_q, -np.float32(np.inf))


@piece
def applicable_among(
    share: np.float32 | None,
    forms: Forms | None,
    best_ever: np.ndarray,
    skill_table: np.ndarray,
    n_skill_states: np.uint64,
    skill_state: np.uint64,
    heading: np.uint64,
    present: np.uint64,
    allowed: np.uint64,
    is_learning: bool,
) -> np.uint64:
    """Those of the allowed skills that are applicable; all that are allowed if none is.

    Args:
        share: of what a skill ever promised; None if the rule is not used.
        forms: of the skills.
        best_ever: (skill,) float32, brought up to date.
        skill_table: rows of the skills.
        n_skill_states: rows of each.
        skill_state: what skills see.
        heading: of the prey.
        present: skills present, as bits.
        allowed: those that may be selected.
        is_learning: whether skills learn; if not, what they ever promised stays as it is.
    """
    if share is None:
        return allowed
    applicable = _ZERO
    left = present
    while left != _ZERO:
        skill = lowest(left)
        left &= left - _ONE
        promised = skill_table[
            skill_row(forms, n_skill_states, skill, skill_state, heading) + _BEST
        ]
        if is_learning and promised > best_ever[skill]:
            best_ever[skill] = promised
        if promised >= share * best_ever[skill]:
            applicable |= _ONE << skill
    applicable &= allowed
    return applicable if applicable != _ZERO else allowed
