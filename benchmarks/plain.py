"""The same learning as a plain compiled loop: what numba gives without the tricks with rows.

Tables of float64 that are scanned for their largest value at each step, tables by cell for what
the world would compute, a draw of random numbers for each decision, and no record of the run. It
learns the same task by the same rules as ``learners.kernel.loop``, not from the same draws.
"""

import math
from typing import NamedTuple

import numpy as np

from benchmarks.schedule import Phase, phases
from learners.spec import RunSpec
from sim import geometry
from sim.bits import U
from sim.compiled import loop, piece
from sim.rng import GAMMA, mix
from sim.spec import N_HEADINGS, WorldSpec


class Board(NamedTuple):
    """The world by cell; a cell is ``y * size + x``."""

    next_cell: np.ndarray
    """(cell, move) int64."""
    skill_state: np.ndarray
    """(cell,) int64."""
    distance: np.ndarray
    """(cell,) float64, in cells."""
    angle: np.ndarray
    """(cell,) float64, bearing from the prey in radians."""
    visible: np.ndarray
    """(heading, cell) bool."""
    size: int
    prey_cell: int
    n_skill_states: int
    start_nearest: float
    start_farthest: float
    step_limit: int
    capture_reward: float
    flight_reward: float


class Rules(NamedTuple):
    """What holds from one event of the schedule to the next."""

    options_are_moves: bool
    present: np.ndarray
    """(option,) bool."""
    allowed: np.ndarray
    """(option,) bool: those present; the loop's own while episodes run."""
    all_moves: np.ndarray
    """(move,) bool, all true."""
    alpha: float
    skill_alpha: float
    gamma: float
    epsilon: float
    episode_option: np.ndarray
    """(episode,) int64: options of the running exploration episodes, the newest first."""
    episode_chance: np.ndarray
    """(episode,) float64."""
    reward_weights: np.ndarray
    """(skill, metric) float64: gain, arc, inward."""


class Outcome(NamedTuple):
    """How much was done, and how the trials ended."""

    steps: int
    captures: int
    flights: int
    timeouts: int


def board(spec: WorldSpec) -> Board:
    """Tabulate a world."""
    size = spec.size
    dx, dy = geometry.offsets(spec)
    px, py = geometry.prey_xy(spec)
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    to_x = np.clip(x[..., None] + geometry.MOVES[:, 0], 0, size - 1)
    to_y = np.clip(y[..., None] + geometry.MOVES[:, 1], 0, size - 1)
    return Board(
        next_cell=(to_y * size + to_x).reshape(-1, geometry.N_MOVES),
        skill_state=geometry.readings(spec).ravel(),
        distance=np.hypot(dx, dy).ravel(),
        angle=np.arctan2(dy, dx).ravel(),
        visible=geometry.visible(spec).reshape(N_HEADINGS, -1),
        size=size,
        prey_cell=py * size + px,
        n_skill_states=spec.n_skill_states,
        start_nearest=spec.start_radius[0] * spec.scale,
        start_farthest=spec.start_radius[1] * spec.scale,
        step_limit=spec.step_limit,
        capture_reward=spec.capture_reward,
        flight_reward=spec.flight_reward,
    )


@piece
def uniform(stream):
    """A number from 0 to 1, the latter excluded."""
    stream[0] += GAMMA
    return float(mix(stream[0]) >> U(11)) * 2.0**-53


@piece
def below(stream, n):
    """A whole number from 0 to n - 1."""
    return int(uniform(stream) * n)


@piece
def largest(q, row):
    """max over a of Q(s, a)."""
    best = q[row, 0]
    for action in range(1, q.shape[1]):
        if q[row, action] > best:
            best = q[row, action]
    return best


@piece
def greedy(q, row, allowed, stream):
    """One of the best allowed actions, ties broken at random."""
    best = -np.inf
    chosen = 0
    ties = 0
    for action in range(q.shape[1]):
        if allowed[action]:
            if q[row, action] > best:
                best = q[row, action]
                chosen = action
                ties = 1
            elif q[row, action] == best:
                ties += 1
    if ties > 1:
        skip = below(stream, ties)
        for action in range(chosen, q.shape[1]):
            if allowed[action] and q[row, action] == best:
                if skip == 0:
                    return action
                skip -= 1
    return chosen


@piece
def epsilon_greedy(q, row, allowed, epsilon, stream):
    """The best allowed action, or with probability epsilon any of them."""
    if uniform(stream) >= epsilon:
        return greedy(q, row, allowed, stream)
    while True:
        action = below(stream, q.shape[1])
        if allowed[action]:
            return action


@piece
def imposed_option(episode_option, episode_chance, present, allowed, stream):
    """The option that an exploration episode imposes, or -1 and the options that are left."""
    left = 0
    for option in range(allowed.size):
        allowed[option] = present[option]
        left += present[option]
    for episode in range(episode_option.size):
        option = episode_option[episode]
        if uniform(stream) < episode_chance[episode]:
            return option
        allowed[option] = False
        left -= 1
    if left == 0:
        for option in range(allowed.size):
            allowed[option] = present[option]
    return -1


@piece
def start_of_trial(size, nearest, farthest, stream):
    """A cell at a random distance and bearing."""
    radius = nearest + (farthest - nearest) * uniform(stream)
    angle = 2.0 * math.pi * uniform(stream)
    x = math.floor(size // 2 + radius * math.cos(angle) + 0.5)
    y = math.floor(size // 2 + radius * math.sin(angle) + 0.5)
    return min(max(y, 0), size - 1) * size + min(max(x, 0), size - 1)


@loop
def run_trials(board, rules, q, skill_q, stream, n_trials):
    """Learn for a number of trials by the same rules.

    Args:
        board: the world.
        rules: what holds in these trials.
        q: the selection table, ``(state, option) float64``; changed.
        skill_q: the skills' tables, ``(skill * n_skill_states + state, move) float64``; changed.
        stream: ``(1,) uint64``, the counter of random numbers; changed.
        n_trials: how many.

    Returns:
        Steps, captures, flights, time-outs.
    """
    next_cell, skill_states, n_states = board.next_cell, board.skill_state, board.n_skill_states
    distance, angle, visible = board.distance, board.angle, board.visible
    alpha, skill_alpha, gamma, epsilon = rules.alpha, rules.skill_alpha, rules.gamma, rules.epsilon
    present, weights = rules.present, rules.reward_weights
    episode_option, episode_chance = rules.episode_option, rules.episode_chance
    options_are_moves = rules.options_are_moves
    prey_cell = board.prey_cell
    allowed, all_moves = rules.allowed, rules.all_moves
    steps = 0
    captures = 0
    flights = 0
    for _ in range(n_trials):
        cell = start_of_trial(board.size, board.start_nearest, board.start_farthest, stream)
        heading = below(stream, N_HEADINGS)
        for _ in range(board.step_limit):
            state = heading * n_states + skill_states[cell]
            option = -1
            if episode_option.size > 0:
                option = imposed_option(episode_option, episode_chance, present, allowed, stream)
            if option < 0:
                option = epsilon_greedy(q, state, allowed, epsilon, stream)
            move = option
            skill_row = option * n_states + skill_states[cell]
            if not options_are_moves:
                move = epsilon_greedy(skill_q, skill_row, all_moves, epsilon, stream)

            cell_t = next_cell[cell, move]
            steps += 1
            on_prey = cell_t == prey_cell
            closer = distance[cell_t] < distance[cell]
            noticed = closer and visible[heading, cell if on_prey else cell_t]

            if noticed:
                target = board.flight_reward
            elif on_prey:
                target = board.capture_reward
            else:
                target = gamma * largest(q, heading * n_states + skill_states[cell_t])
            q[state, option] += alpha * (target - q[state, option])

            if not options_are_moves:
                gain = distance[cell] - distance[cell_t]
                turn = 0.0 if on_prey else angle[cell_t] - angle[cell]
                if turn > math.pi:
                    turn -= 2.0 * math.pi
                elif turn < -math.pi:
                    turn += 2.0 * math.pi
                r_t = (
                    weights[option, 0] * gain
                    + weights[option, 1] * turn * distance[cell]
                    + weights[option, 2] * max(gain, 0.0)
                )
                target = r_t + gamma * largest(skill_q, option * n_states + skill_states[cell_t])
                skill_q[skill_row, move] += skill_alpha * (target - skill_q[skill_row, move])

            cell = cell_t
            if noticed or on_prey:
                captures += not noticed
                flights += noticed
                break
    return steps, captures, flights, n_trials - captures - flights


class PlainRun:
    """A learner of a preset on the plain loop."""

    def __init__(self, spec: RunSpec) -> None:
        """Prepare the tables; nothing has been learned yet."""
        learner = spec.learner
        n_options = len(learner.skills) or geometry.N_MOVES
        n_skill_rows = max(len(learner.skills), 1) * spec.world.n_skill_states
        first = -np.inf if learner.skills else learner.initial_q
        self.spec = spec
        self.board = board(spec.world)
        self.q = np.full((spec.world.n_states, n_options), first)
        self.skill_q = np.full((n_skill_rows, geometry.N_MOVES), learner.initial_q)

    def run(self, seed: int) -> Outcome:
        """Learn for all trials of the preset."""
        stream = np.array([seed], np.uint64)
        total = np.zeros(4, np.int64)
        for phase in phases(self.spec):
            for option in phase.joining:
                self._join(option)
            n_trials = phase.until_trial - phase.first_trial
            total += run_trials(
                self.board, self._rules(phase), self.q, self.skill_q, stream, n_trials
            )
        return Outcome(*total.tolist())

    def _join(self, option: int) -> None:
        """Q(s, new) = min(initial, max over the present options of Q(s, .)); unsafe: initial."""
        utility = self.q.max(axis=1)
        initial = self.spec.learner.initial_q
        is_safe = self.spec.schedule.safe_introduction and not np.isneginf(utility).any()
        self.q[:, option] = np.minimum(initial, utility) if is_safe else initial

    def _rules(self, phase: Phase) -> Rules:
        learner = self.spec.learner
        present = np.zeros(self.q.shape[1], np.bool_)
        present[list(phase.present)] = True
        return Rules(
            options_are_moves=not learner.skills,
            present=present,
            allowed=present.copy(),
            all_moves=np.ones(geometry.N_MOVES, np.bool_),
            alpha=0.0 if phase.frozen else learner.alpha,
            skill_alpha=learner.skill_alpha,
            gamma=learner.gamma,
            epsilon=learner.epsilon,
            episode_option=np.array([e.option for e in phase.running], np.int64),
            episode_chance=np.array([e.probability for e in phase.running], np.float64),
            reward_weights=np.array([learner.reward_of(s)[:3] for s in learner.skills]).reshape(
                -1, 3
            ),
        )
