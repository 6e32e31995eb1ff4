"""Static selection: the move comes from the skills' own tables, and no selection is learned.

After Humphrys (section 3.2), whose rules the thesis means in section 5.2. Each skill i that is
present has a table Q_i, a best move a_i in the state x, and a weight w_i:

====================== =======================================================================
rule                   who moves
====================== =======================================================================
best happiness         k = argmax_i w_i max_a Q_i(x, a)
worst unhappiness      the k that leaves the others the least unhappy: argmin_k max_{i != k} u_i(k)
negotiated unhappiness k at random, W = 0; while some i != k has u_i(k) > W, the one that has most
                       takes over: k = i, W = u_i(k) of the k before
collective             the move argmax_a sum_i w_i Q_i(x, a)
W-learning             k = argmax_i W_i(x); each i that loses learns what that costs it:
                       W_i += alpha (w_i (Q_i(x, a_i) - (r_i + gamma max Q_i(y, .))) - W_i)
====================== =======================================================================

u_i(k) = w_i (Q_i(x, a_i) - Q_i(x, a_k)) is what it costs i if k moves. All skills learn from each
move, whoever made it. With probability epsilon the move is any of the nine, and nobody's W changes.

Draws. Of the four parts of a step's draw, from the low end: whether the move is random; which of
the skills that are equal (of all, to begin a negotiation); nothing; which of the moves that are
equal, or of all nine.

A collective has no winner. Its step is put down to the skill that the move costs least; of several,
to the one that wants it most, w_i Q_i(x, a); of several, to the first.
"""

from typing import Final, NamedTuple

import numpy as np

from learners.kernel import rows
from learners.kernel.forms import Forms, skill_row
from learners.kernel.state import NO_OPTION, weights_of
from learners.learner_spec import LearnerSpec
from sim.bits import U, lowest, pick
from sim.compiled import piece

RULES: Final = (
    "best_happiness",
    "worst_unhappiness",
    "negotiated_unhappiness",
    "collective",
    "w_learning",
)
BEST_HAPPINESS, WORST_UNHAPPINESS, NEGOTIATED, COLLECTIVE, W_LEARNING = range(len(RULES))

_ZERO = U(0)
_ONE = U(1)
_S16 = U(16)
_S48 = U(48)
_LOW16 = U(0xFFFF)
_N_MOVES = U(9)
_BEST = U(rows.BEST)
_GREEDY = U(rows.GREEDY)
_NOTHING = np.float32(0)
_NO_SUMS = (_NOTHING,) * 9
_MOST = np.float32(np.inf)


Sums = tuple[np.float32, ...]
"""Of what each move is worth to several skills."""


class Static(NamedTuple):
    """How skills are selected without a table of the selection."""

    rule: int
    """Place in ``RULES``."""
    weights: np.ndarray
    """(skill,) float32: w_i."""


def static_of(learner: LearnerSpec) -> Static | None:
    """The rule by which a learner selects; None if it learns a table."""
    if learner.selection == "learned":
        return None
    return Static(RULES.index(learner.selection), weights_of(learner))


class Tables(NamedTuple):
    """What skills know of a state, for the rules to look at."""

    static: Static
    forms: Forms | None
    table: np.ndarray
    words: np.ndarray
    n_skill_states: np.uint64
    skill_state: np.uint64
    heading: np.uint64
    present: np.uint64
    move16: np.uint64
    """Part of the draw by which equal moves are told apart."""


@piece
def row_in(known: Tables, skill: np.uint64) -> np.uint64:
    """First word of a skill's row in the state."""
    return skill_row(known.forms, known.n_skill_states, skill, known.skill_state, known.heading)


@piece
def best_move(known: Tables, skill: np.uint64) -> np.uint64:
    """The move that a skill would make."""
    return pick(U(known.words[row_in(known, skill) + _GREEDY]), known.move16)


@piece
def happiness(known: Tables, skill: np.uint64) -> np.float32:
    """w_i max_a Q_i(x, a)."""
    return known.static.weights[skill] * known.table[row_in(known, skill) + _BEST]


@piece
def unhappiness(known: Tables, skill: np.uint64, move: np.uint64) -> np.float32:
    """w_i (Q_i(x, a_i) - Q_i(x, a)): what a move costs a skill."""
    row = row_in(known, skill)
    return known.static.weights[skill] * (known.table[row + _BEST] - known.table[row + move])


@piece
def unhappiest(known: Tables, winner: np.uint64) -> tuple[np.uint64, np.float32]:
    """The skill that is left most unhappy if another moves, and how much; that one if none is."""
    worst = winner
    most = _NOTHING
    move = best_move(known, winner)
    others = known.present & ~(_ONE << winner)
    while others != _ZERO:
        skill = lowest(others)
        others &= others - _ONE
        cost = unhappiness(known, skill, move)
        if cost > most:
            most = cost
            worst = skill
    return worst, most


@piece
def with_the_best(
    best: tuple[np.uint64, np.float32], skill: np.uint64, value: np.float32
) -> tuple[np.uint64, np.float32]:
    """The skills of the largest value so far, and that value, with one skill more looked at."""
    members, top = best
    if value > top:
        return _ONE << skill, value
    if value == top:
        return members | (_ONE << skill), top
    return members, top


@piece
def happiest(known: Tables, skill16: np.uint64) -> np.uint64:
    """Best happiness."""
    best = (_ZERO, rows.NO_VALUE)
    asked = known.present
    while asked != _ZERO:
        skill = lowest(asked)
        asked &= asked - _ONE
        best = with_the_best(best, skill, happiness(known, skill))
    return pick(best[0], skill16)


@piece
def least_harmful(known: Tables, skill16: np.uint64) -> np.uint64:
    """Worst unhappiness."""
    least = _MOST
    members = _ZERO
    asked = known.present
    while asked != _ZERO:
        skill = lowest(asked)
        asked &= asked - _ONE
        _, cost = unhappiest(known, skill)
        if cost < least:
            least = cost
            members = _ONE << skill
        elif cost == least:
            members |= _ONE << skill
    return pick(members, skill16)


@piece
def negotiated(known: Tables, skill16: np.uint64) -> np.uint64:
    """Negotiated worst unhappiness; it ends, since each that takes over loses more."""
    winner = pick(known.present, skill16)
    stake = _NOTHING
    while True:
        skill, cost = unhappiest(known, winner)
        if not cost > stake:
            return winner
        winner = skill
        stake = cost


@piece
def with_wishes_of(sums: Sums, table: np.ndarray, row: np.uint64, weight: np.float32) -> Sums:
    """What nine moves are worth so far, and to one skill more."""
    # Written out, so that the compiler keeps the sums in registers.
    return (
        sums[0] + weight * table[row],
        sums[1] + weight * table[row + U(1)],
        sums[2] + weight * table[row + U(2)],
        sums[3] + weight * table[row + U(3)],
        sums[4] + weight * table[row + U(4)],
        sums[5] + weight * table[row + U(5)],
        sums[6] + weight * table[row + U(6)],
        sums[7] + weight * table[row + U(7)],
        sums[8] + weight * table[row + U(8)],
    )


@piece
def agreed_move(known: Tables) -> np.uint64:
    """The move that is worth most to all skills together; sums go from the first skill on."""
    sums = _NO_SUMS
    asked = known.present
    while asked != _ZERO:
        skill = lowest(asked)
        asked &= asked - _ONE
        weight = known.static.weights[skill]
        sums = with_wishes_of(sums, known.table, row_in(known, skill), weight)
    top = max(sums)
    members = _ZERO
    for move in range(len(sums)):
        if sums[move] == top:
            members |= _ONE << U(move)
    return pick(members, known.move16)


@piece
def put_down_to(known: Tables, move: np.uint64) -> np.uint64:
    """The skill that a move of all of them is put down to."""
    chosen = U(NO_OPTION)
    least = _MOST
    most = rows.NO_VALUE
    asked = known.present
    while asked != _ZERO:
        skill = lowest(asked)
        asked &= asked - _ONE
        cost = unhappiness(known, skill, move)
        wish = known.static.weights[skill] * known.table[row_in(known, skill) + move]
        if chosen == U(NO_OPTION) or cost < least or (cost == least and wish > most):
            chosen = skill
            least = cost
            most = wish
    return chosen


@piece
def strongest(
    known: Tables, w_values: np.ndarray, n_states: np.uint64, state: np.uint64, skill16: np.uint64
) -> np.uint64:
    """W-learning: the skill with the largest W in a state of the selection."""
    best = (_ZERO, rows.NO_VALUE)
    asked = known.present
    while asked != _ZERO:
        skill = lowest(asked)
        asked &= asked - _ONE
        best = with_the_best(best, skill, w_values[skill * n_states + state])
    return pick(best[0], skill16)


@piece
def winner_and_move(
    known: Tables,
    w_values: np.ndarray,
    n_states: np.uint64,
    state: np.uint64,
    imposed: np.uint64,
    skill16: np.uint64,
) -> tuple[np.uint64, np.uint64]:
    """The skill that a rule selects, unless one is imposed, and the move without exploring."""
    rule = known.static.rule
    if imposed != U(NO_OPTION):
        return imposed, best_move(known, imposed)
    if rule == COLLECTIVE:
        move = agreed_move(known)
        return put_down_to(known, move), move
    if rule == BEST_HAPPINESS:
        winner = happiest(known, skill16)
    elif rule == WORST_UNHAPPINESS:
        winner = least_harmful(known, skill16)
    elif rule == NEGOTIATED:
        winner = negotiated(known, skill16)
    else:
        winner = strongest(known, w_values, n_states, state, skill16)
    return winner, best_move(known, winner)


@piece
def static_choice(
    static: Static | None,
    forms: Forms | None,
    table: np.ndarray,
    words: np.ndarray,
    w_values: np.ndarray,
    n_states: np.uint64,
    state: np.uint64,
    n_skill_states: np.uint64,
    skill_state: np.uint64,
    heading: np.uint64,
    present: np.uint64,
    imposed: np.uint64,
    epsilon16: np.uint64,
    draw: np.uint64,
) -> tuple[np.uint64, np.uint64]:
    """Skill and move of a step.

    Args:
        static: the rule.
        forms: of the skills.
        table: the skills' rows.
        words: the same memory seen as uint32.
        w_values: ``(skill * main state,) float32``, of W-learning.
        n_states: main states.
        state: the main state.
        n_skill_states: of a skill that sees no heading.
        skill_state: what skills see.
        heading: of the prey.
        present: skills present, as bits.
        imposed: the skill that an exploration episode imposes, or ``NO_OPTION``.
        epsilon16: chance of a random move, in units of 2**-16.
        draw: of the step.
    """
    # Told by the type, so that the compiler leaves out what is not asked for.
    if static is None:
        return imposed, _ZERO
    move16 = draw >> _S48
    known = Tables(
        static, forms, table, words, n_skill_states, skill_state, heading, present, move16
    )
    skill16 = (draw >> _S16) & _LOW16
    winner, move = winner_and_move(known, w_values, n_states, state, imposed, skill16)
    if draw & _LOW16 < epsilon16:
        move = (move16 * _N_MOVES) >> _S16
    return winner, move


@piece
def learn_w(
    static: Static | None,
    w_values: np.ndarray,
    place: np.uint64,
    skill: np.uint64,
    expected: np.float32,
    target: np.float32,
    alpha: np.float32,
) -> np.float32:
    """W-learning of a skill that did not move: what that cost it; returns the change of W.

    Args:
        static: the rule.
        w_values: ``(skill * main state,) float32``.
        place: of the skill's W in the state.
        skill: that lost.
        expected: Q_i(x, a_i), what its own move would have come to.
        target: r_i + gamma max Q_i(y, .), what the other's came to.
        alpha: learning rate.
    """
    if static is None or static.rule != W_LEARNING:
        return _NOTHING
    w_tm1 = w_values[place]
    w_t = w_tm1 + alpha * (static.weights[skill] * (expected - target) - w_tm1)
    w_values[place] = w_t
    return w_t - w_tm1


@piece
def is_wanted(
    static: Static | None,
    forms: Forms | None,
    table: np.ndarray,
    words: np.ndarray,
    n_skill_states: np.uint64,
    skill_state: np.uint64,
    heading: np.uint64,
    present: np.uint64,
) -> bool:
    """Whether some skill's weighted value of a state is above 0."""
    if static is None:
        return False
    known = Tables(
        static, forms, table, words, n_skill_states, skill_state, heading, present, _ZERO
    )
    asked = present
    while asked != _ZERO:
        skill = lowest(asked)
        asked &= asked - _ONE
        if happiness(known, skill) > _NOTHING:
            return True
    return False
