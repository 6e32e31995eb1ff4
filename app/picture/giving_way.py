"""What a rule of static selection costs the skills between which it selects."""

import numpy as np

from app.live.snapshot import Snapshot
from app.picture.value_maps import own_least, own_most
from learners.kernel.state import weights_of
from sim.geometry import N_MOVES
from sim.spec import N_HEADINGS

_AXES = 5
"""Of tables of skills of which some see headings."""
W_LEARNING = "w_learning"
_NOTHING = 0.01
"""Less than this share of what is at stake for a skill is nothing that it would mind."""


def has_rule(snapshot: Snapshot) -> bool:
    """Whether a rule selects between skills, and no table."""
    return snapshot.spec.learner.selection != "learned"


def stakes(snapshot: Snapshot) -> np.ndarray:
    """What is at stake for each skill in one move at most, about, ``(skill,) float64``.

    Its weight times what it is punished with; or, if it has nothing to lose, twice what it earns by
    a move.
    """
    learner = snapshot.spec.learner
    each = [
        own_least(snapshot, skill) or 2 * own_most(snapshot, skill) * (1 - learner.gamma)
        for skill in range(len(learner.skills))
    ]
    return np.asarray(weights_of(learner) * np.array(each), np.float64)


def costs(snapshot: Snapshot) -> np.ndarray:
    """What it costs each skill that the rule's move is made, and not its own.

    ``(skill, heading, distance, direction) float64``: w_i (max_a Q_i - Q_i(x, a)), the mean over
    the ways in which ties may break; 0 of a skill that is not present.
    """
    choices, q = snapshot.choices, snapshot.skill_q
    if choices is None:
        raise ValueError("selection: no rule selects; allowed: a static selection")
    sees_headings = q.ndim == _AXES
    q = q if sees_headings else np.repeat(q[:, None], N_HEADINGS, axis=1)
    weights = weights_of(snapshot.spec.learner)[:, None, None, None, None]
    lost = weights * (q.max(axis=-1, keepdims=True) - q)
    found = np.zeros(lost.shape[:-1])
    for option in range(len(q)):
        share = choices.share[..., option]
        made = (choices.moves[option][..., None] >> np.arange(N_MOVES, dtype=np.uint16)) & 1
        each = (lost * made).sum(axis=-1) / np.maximum(made.sum(axis=-1), 1)
        found += np.where(np.isfinite(share), share, 0) * each
    there = [name in snapshot.present for name in snapshot.spec.learner.skills]
    return np.where(np.array(there)[:, None, None, None], found, 0.0)


def minds(snapshot: Snapshot) -> np.ndarray:
    """Which skills the rule's move costs something, ``(skill, heading, distance, direction)``."""
    least = np.maximum(_NOTHING * stakes(snapshot), 1e-9)
    return costs(snapshot) > least[:, None, None, None]


def learned_w(snapshot: Snapshot) -> np.ndarray | None:
    """W of each skill, ``(skill, heading, distance, direction) float32``, if W is learned."""
    rule = snapshot.rule
    if rule is None or not rule.w_values.size:
        return None
    return rule.w_values.reshape(len(snapshot.spec.learner.skills), *snapshot.value.shape)
