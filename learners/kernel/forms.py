"""Skills that differ: in what they see, what they earn, how their task ends, how fast they learn.

Skills of the thesis see no heading, go on when the trial ends, and learn at one rate; where all of
a learner's skills are like that, there are no forms, and the loop is the one without them.
"""

from typing import NamedTuple

import numpy as np

from learners.kernel import rows
from learners.kernel.layout import first_rows
from learners.kernel.updates import backup
from learners.skill_spec import SkillWeights
from learners.skills import local_reward, wrapped
from learners.spec import RunSpec
from sim.bits import U
from sim.compiled import piece

_ROW_SHIFT = U(4)
_BEST = U(rows.BEST)
_ZERO = U(0)
_ONE = U(1)
_NOTHING = np.float32(0)
_EARNED = np.float32(1)
_EIGHTH = np.float32(np.pi / 4)
BEHIND = np.float32(np.radians(105))
"""The prey's back begins so far from where it looks, in radians."""


class Forms(NamedTuple):
    """What each skill is like."""

    first_row: np.ndarray
    """(skill,) uint64: where its table begins."""
    per_heading: np.ndarray
    """(skill,) uint64: rows that it has for each heading of the prey; 0 if it sees none."""
    behind: np.ndarray
    """(skill,) float32: what a cell gained behind the prey earns it."""
    flight: np.ndarray
    """(skill,) float32: what putting the prey to flight earns it."""
    ends: np.uint64
    """Skills whose task ends with the trial, as bits."""
    alpha: np.ndarray
    """(skill,) float32: learning rate of each; 0 while skills are frozen."""


def forms_of(spec: RunSpec, *, skills_learn: bool) -> Forms | None:
    """What the skills of a run are like; None if they are all like the thesis's.

    A static selection always has them: it asks for all skills' values, whatever they are like.
    """
    learner, names = spec.learner, spec.learner.skills
    skills = [learner.skill_of(name) for name in names]
    if learner.selection == "learned" and not any(_is_of_its_own(skill) for skill in skills):
        return None
    rates = [learner.skill_alpha if skill.alpha is None else skill.alpha for skill in skills]
    n_rows = spec.world.n_skill_states
    return Forms(
        first_row=first_rows(spec)[:-1],
        per_heading=np.array([0 if skill.sees is None else n_rows for skill in skills], np.uint64),
        behind=np.array([skill.behind for skill in skills], np.float32),
        flight=np.array([skill.flight for skill in skills], np.float32),
        ends=U(sum(skill.ends_with_trial << number for number, skill in enumerate(skills))),
        alpha=np.array(rates if skills_learn else [0.0] * len(skills), np.float32),
    )


def _is_of_its_own(skill: SkillWeights) -> bool:
    plain = SkillWeights()
    return any(
        getattr(skill, name) != getattr(plain, name)
        for name in ("behind", "flight", "sees", "ends_with_trial", "alpha")
    )


@piece
def skill_row(
    forms: Forms | None,
    n_skill_states: np.uint64,
    skill: np.uint64,
    skill_state: np.uint64,
    heading: np.uint64,
) -> np.uint64:
    """First word of a skill's row, by what skills see."""
    # Told by the type, so that the compiler leaves out what is not asked for.
    if forms is None:
        return (skill * n_skill_states + skill_state) << _ROW_SHIFT
    of_heading = heading * forms.per_heading[skill]
    return (forms.first_row[skill] + of_heading + skill_state) << _ROW_SHIFT


@piece
def is_behind(angle: np.float32, heading: np.uint64) -> bool:
    """Whether a bearing from the prey is more than 105 degrees from where the prey looks."""
    return bool(abs(wrapped(np.float32(angle - np.float32(heading) * _EIGHTH))) > BEHIND)


@piece
def earned(
    forms: Forms | None,
    weights: np.ndarray,
    binary: bool | None,
    skill: np.uint64,
    d_tm1: np.float32,
    d_t: np.float32,
    turn: np.float32,
    was_behind: bool,
    fled: bool,
) -> np.float32:
    """Local reward of a move, see :func:`learners.skills.local_reward`, of any form of skill.

    Args:
        forms: of the skills.
        weights: of the three metrics.
        binary: whether it is only told that the sum is above 0, by a reward of 1; None if not.
        skill: whose reward.
        d_tm1: distance before the move, in cells.
        d_t: distance after it.
        turn: of the bearing, in radians.
        was_behind: whether the move began behind the prey.
        fled: whether it put the prey to flight.
    """
    if forms is None:
        return local_reward(weights, binary, skill, d_tm1, d_t, turn)
    total = local_reward(weights, None, skill, d_tm1, d_t, turn)
    if was_behind:
        total += forms.behind[skill] * (d_tm1 - d_t)
    if fled:
        total += forms.flight[skill]
    if binary is None:
        return total
    return _EARNED if total > _NOTHING else _NOTHING


@piece
def target_of(
    forms: Forms | None,
    table: np.ndarray,
    skill: np.uint64,
    row_t: np.uint64,
    r_t: np.float32,
    gamma: np.float32,
    is_over: bool,
) -> np.float32:
    """What a move came to: r + gamma max Q(s', .), or r where the task ended with it."""
    if forms is None:
        return np.float32(r_t + gamma * table[row_t + _BEST])
    if is_over and (forms.ends >> skill) & _ONE != _ZERO:
        return r_t
    return np.float32(r_t + gamma * table[row_t + _BEST])


@piece
def learn_by_form(
    forms: Forms | None,
    table: np.ndarray,
    words: np.ndarray,
    skill: np.uint64,
    row: np.uint64,
    move: np.uint64,
    target: np.float32,
) -> None:
    """Let a skill learn from one move, at its own rate (section 4.2.2)."""
    if forms is not None:
        backup(table, words, row, move, target, forms.alpha[skill])
