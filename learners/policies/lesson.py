"""What skills learn from a move where they differ, or where a static selection asks all of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from learners.kernel import rows
from learners.kernel.forms import earned, is_behind, learn_by_form, skill_row, target_of
from learners.kernel.state import NOT_REACHED, LearnerState
from learners.policies.static import is_wanted, learn_w
from sim.bits import U, lowest
from sim.compiled import piece
from sim.spec import N_HEADINGS
from sim.world import CAPTURE, FLIGHT, World

if TYPE_CHECKING:
    from learners.kernel.loop import Settings

_ZERO = U(0)
_ONE = U(1)
_BEST = U(rows.BEST)


@piece
def learn_from(
    world: World,
    state: LearnerState,
    settings: Settings,
    option: np.uint64,
    move: np.uint64,
    explored: bool,
    heading: np.uint64,
    cell: np.uint64,
    cell_t: np.uint64,
    skill_state: np.uint64,
    skill_state_t: np.uint64,
    turn: np.float32,
    outcome: int,
) -> float:
    """Let the skills that learn do so from one move, the first of them first.

    Args:
        world: the world.
        state: of the learner; its tables change.
        settings: of the loop.
        option: the skill that moved.
        move: its move.
        explored: whether that was a random one.
        heading: of the prey.
        cell: where the move began.
        cell_t: where it led.
        skill_state: what skills saw there.
        skill_state_t: what they see now.
        turn: of the bearing, in radians.
        outcome: of the move.

    Returns:
        Sum of the changes of W, without their signs.
    """
    forms = settings.forms
    static = settings.static
    n_skill_states = world.n_skill_states
    learning = _ONE << option if settings.all_skills_learn is None else settings.present
    was_behind = is_behind(world.angle[cell], heading)
    is_over = outcome in (FLIGHT, CAPTURE)
    change = 0.0
    while learning != _ZERO:
        skill = lowest(learning)
        learning &= learning - _ONE
        r_t = earned(
            forms,
            settings.reward_weights,
            settings.rewards_are_binary,
            skill,
            world.distance[cell],
            world.distance[cell_t],
            turn,
            was_behind,
            outcome == FLIGHT,
        )
        row = skill_row(forms, n_skill_states, skill, skill_state, heading)
        row_t = skill_row(forms, n_skill_states, skill, skill_state_t, heading)
        target = target_of(forms, state.skills, skill, row_t, r_t, settings.gamma, is_over)
        if static is not None and skill != option and not explored:
            place = (skill * U(N_HEADINGS) + heading) * world.n_readings + skill_state
            expected = state.skills[row + _BEST]
            lost = learn_w(static, state.w_values, place, skill, expected, target, settings.alpha)
            change += float(abs(lost))
        learn_by_form(forms, state.skills, state.skill_words, skill, row, move, target)
    return change


@piece
def note_wish(
    world: World,
    state: LearnerState,
    settings: Settings,
    heading: np.uint64,
    skill_state: np.uint64,
    trial: int,
) -> int:
    """Note the trial in which some skill's weighted value of a state first is above 0.

    Returns:
        How many states that makes: 0 or 1.
    """
    place = heading * world.n_readings + skill_state
    if state.first_reach[place] == NOT_REACHED and is_wanted(
        settings.static,
        settings.forms,
        state.skills,
        state.skill_words,
        world.n_skill_states,
        skill_state,
        heading,
        settings.present,
    ):
        state.first_reach[place] = trial
        return 1
    return 0
