"""Only skills that promise much where they are, beside what they ever promised (section 3.2).

Lin's rule, by a threshold on what skills predict: skill i may be selected in x where

    max_a Q_i(x, a) >= share * M_i

M_i being the largest value that max_a Q_i has had so far, in any state in which a skill was
selected. If no skill is applicable, all are.

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
        if promised > best_ever[skill]:
            best_ever[skill] = promised
        if promised >= share * best_ever[skill]:
            applicable |= _ONE << skill
    applicable &= allowed
    return applicable if applicable != _ZERO else allowed
