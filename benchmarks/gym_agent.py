"""The world as a Gymnasium environment, and the agent that a tutorial would write for it.

Everything here is plain Python, one step at a time, and meant to be obvious: what one would
have without a compiled loop. It needs gymnasium and NumPy and nothing of this project.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

N_HEADINGS = 8
MOVES = [(dx, dy) for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
HEADINGS = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]

State = tuple[int, int, int]
"""What the predator senses: direction and ring of its own place around the prey, heading."""


class PredatorEnv(gym.Env[np.ndarray, np.int64]):
    """A predator stalks a prey that stands still and sees only forwards (section 4.1).

    Lengths are those of a grid of 120 x 120 cells and scale with ``size / 120``. An observation
    is ``[direction, ring, heading]``; ``info`` holds what skills are rewarded for:
    ``distance``, and after a step ``turn``, the change of the bearing from the prey.
    """

    metadata = {"render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        size: int = 120,
        n_directions: int = 24,
        n_distances: int = 18,
        ring_exponent: float = 1.5,
        vision_radius: float = 27.0,
        start_radius: tuple[float, float] = (10.0, 60.0),
        step_limit: int = 500,
        capture_reward: float = 100.0,
        flight_reward: float = -50.0,
    ) -> None:
        """Make an environment; see ``sim.spec.WorldSpec`` for the settings."""
        scale = size / 120
        self.size = size
        self.n_directions = n_directions
        self.vision_radius = vision_radius * scale
        self.start_radius = (start_radius[0] * scale, start_radius[1] * scale)
        self.step_limit = step_limit
        self.capture_reward = capture_reward
        self.flight_reward = flight_reward
        self.prey = (size // 2, size // 2)
        farthest = math.hypot(*self.prey)
        self.ring_edges = [
            farthest * (k / n_distances) ** ring_exponent for k in range(1, n_distances + 1)
        ]

        self.action_space = spaces.Discrete(len(MOVES))
        self.observation_space = spaces.MultiDiscrete([n_directions, n_distances, N_HEADINGS])
        self.position = self.prey
        self.heading = 0
        self.n_steps = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start a trial at a random place, before a prey that faces a random way."""
        super().reset(seed=seed)
        radius = self.np_random.uniform(*self.start_radius)
        angle = self.np_random.uniform(0, 2 * math.pi)
        self.position = self._clipped(
            math.floor(self.prey[0] + radius * math.cos(angle) + 0.5),
            math.floor(self.prey[1] + radius * math.sin(angle) + 0.5),
        )
        self.heading = int(self.np_random.integers(N_HEADINGS))
        self.n_steps = 0
        return self._observation(), {"distance": self._distance(self.position), "turn": 0.0}

    def step(self, action: np.int64) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Move the predator; capture and flight end a trial, the step limit cuts it off."""
        before = self.position
        dx, dy = MOVES[int(action)]
        self.position = self._clipped(before[0] + dx, before[1] + dy)
        self.n_steps += 1

        caught = self.position == self.prey
        closer = self._distance(self.position) < self._distance(before)
        noticed = closer and self._is_visible(before if caught else self.position)
        reward = 0.0
        if noticed:
            reward = self.flight_reward
        elif caught:
            reward = self.capture_reward
        terminated = noticed or caught
        truncated = not terminated and self.n_steps >= self.step_limit
        turn = 0.0 if caught else self._turn(before, self.position)
        info = {"distance": self._distance(self.position), "turn": turn}
        return self._observation(), reward, terminated, truncated, info

    def _clipped(self, x: int, y: int) -> tuple[int, int]:
        return min(max(x, 0), self.size - 1), min(max(y, 0), self.size - 1)

    def _offset(self, position: tuple[int, int]) -> tuple[int, int]:
        return position[0] - self.prey[0], position[1] - self.prey[1]

    def _distance(self, position: tuple[int, int]) -> float:
        return math.hypot(*self._offset(position))

    def _bearing(self, position: tuple[int, int]) -> float:
        dx, dy = self._offset(position)
        return math.atan2(dy, dx)

    def _turn(self, before: tuple[int, int], after: tuple[int, int]) -> float:
        turn = self._bearing(after) - self._bearing(before)
        return (turn + math.pi) % (2 * math.pi) - math.pi

    def _is_visible(self, position: tuple[int, int]) -> bool:
        dx, dy = self._offset(position)
        hx, hy = HEADINGS[self.heading]
        return dx * hx + dy * hy > 0 and dx * dx + dy * dy <= self.vision_radius**2

    def _observation(self) -> np.ndarray:
        sector = 2 * math.pi / self.n_directions
        direction = math.floor(self._bearing(self.position) / sector + 0.5) % self.n_directions
        distance = self._distance(self.position) * (1 - 1e-12)
        ring = next(k for k, edge in enumerate(self.ring_edges) if distance <= edge)
        return np.array([direction, ring, self.heading])


class QTable:
    """Action values by state, with epsilon-greedy choice and the update of Q-learning."""

    def __init__(
        self,
        n_actions: int,
        alpha: float,
        gamma: float,
        epsilon: float,
        initial_q: float,
        rng: np.random.Generator,
    ) -> None:
        """Make a table in which every value is ``initial_q``."""
        self.n_actions = n_actions
        self.alpha = alpha
        self.gamma = gamma
        self.epsilon = epsilon
        self.initial_q = initial_q
        self.rng = rng
        self.values: dict[tuple[int, ...], list[float]] = {}

    def row(self, state: tuple[int, ...]) -> list[float]:
        """The values of all actions in a state."""
        if state not in self.values:
            self.values[state] = [self.initial_q] * self.n_actions
        return self.values[state]

    def utility(self, state: tuple[int, ...], actions: Sequence[int]) -> float:
        """The largest value of some actions in a state."""
        row = self.row(state)
        return max(row[action] for action in actions)

    def choose(self, state: tuple[int, ...], actions: Sequence[int]) -> int:
        """Epsilon-greedy choice among some actions, ties broken at random."""
        if self.rng.random() < self.epsilon:
            return int(self.rng.choice(actions))
        row = self.row(state)
        best = max(row[action] for action in actions)
        return int(self.rng.choice([action for action in actions if row[action] == best]))

    def update(self, state: tuple[int, ...], action: int, target: float) -> None:
        """Move Q(s, a) towards a target."""
        row = self.row(state)
        row[action] += self.alpha * (target - row[action])


@dataclass(frozen=True)
class Skill:
    """A skill's local reward, as weights of three metrics of a move, and its timer."""

    gain: float
    """Weight of the ground gained towards the prey."""
    arc: float
    """Weight of the arc length around it, counter-clockwise."""
    inward: float
    """Weight of the ground given up towards it."""
    introduced_at: int = 0
    """Trial in which the skill joins."""
    freeze_trials: int = 0
    """Trials for which the selection does not learn then."""

    def reward(self, d_tm1: float, d_t: float, turn: float) -> float:
        """Local reward of a move from one distance to another (section 4.2.2)."""
        gain = d_tm1 - d_t
        return self.gain * gain + self.arc * turn * d_tm1 + self.inward * max(gain, 0.0)


@dataclass(frozen=True)
class Exploration:
    """A biased exploration episode (section 3.3.4)."""

    skill: int
    start: int
    duration: int
    probability: float

    def runs_in(self, trial: int) -> bool:
        """Whether a trial is part of it."""
        return self.start <= trial < self.start + self.duration


class MoveAgent:
    """Q-learning whose options are the primitive moves."""

    def __init__(
        self, alpha: float, gamma: float, epsilon: float, initial_q: float, seed: int
    ) -> None:
        """Make an agent that knows nothing."""
        rng = np.random.default_rng(seed)
        self.table = QTable(len(MOVES), alpha, gamma, epsilon, initial_q, rng)
        self.actions = range(len(MOVES))

    def begin_trial(self, trial: int) -> None:
        """Nothing changes from one trial to the next."""

    def act(self, state: State) -> tuple[int, int]:
        """Option and move for a step: the same thing here."""
        move = self.table.choose(state, self.actions)
        return move, move

    def learn(
        self,
        state: State,
        option: int,
        move: int,
        reward: float,
        state_t: State,
        terminated: bool,
        before: Mapping[str, float],
        after: Mapping[str, float],
    ) -> None:
        """Learn from one step."""
        future = 0.0 if terminated else self.table.utility(state_t, self.actions)
        self.table.update(state, option, reward + self.table.gamma * future)


class SkillAgent:
    """Hierarchical Q-learning over skills, with timers and exploration episodes."""

    def __init__(
        self,
        skills: Sequence[Skill],
        explorations: Sequence[Exploration],
        safe_introduction: bool,
        alpha: float,
        skill_alpha: float,
        gamma: float,
        epsilon: float,
        initial_q: float,
        seed: int,
    ) -> None:
        """Make an agent that knows nothing; skills join when their timers say so.

        Explorations are given the oldest first.
        """
        self.rng = np.random.default_rng(seed)
        self.skills = skills
        self.explorations = explorations
        self.safe_introduction = safe_introduction
        self.selection = QTable(len(skills), alpha, gamma, epsilon, initial_q, self.rng)
        self.tables = [
            QTable(len(MOVES), skill_alpha, gamma, epsilon, initial_q, self.rng) for _ in skills
        ]
        self.present: list[int] = []
        self.frozen = False
        self.running: list[Exploration] = []

    def begin_trial(self, trial: int) -> None:
        """Let the timers of a trial act."""
        for option, skill in enumerate(self.skills):
            if skill.introduced_at == trial:
                self._join(option)
        self.frozen = any(
            skill.introduced_at <= trial < skill.introduced_at + skill.freeze_trials
            for skill in self.skills
        )
        newest_first = reversed(self.explorations)
        self.running = [episode for episode in newest_first if episode.runs_in(trial)]

    def act(self, state: State) -> tuple[int, int]:
        """Option and move for a step."""
        option = self._choose_option(state)
        return option, self.tables[option].choose(state[:2], range(len(MOVES)))

    def learn(
        self,
        state: State,
        option: int,
        move: int,
        reward: float,
        state_t: State,
        terminated: bool,
        before: Mapping[str, float],
        after: Mapping[str, float],
    ) -> None:
        """Learn from one step: the selection from its reward, the chosen skill from its own."""
        if not self.frozen:
            future = 0.0 if terminated else self.selection.utility(state_t, self.present)
            self.selection.update(state, option, reward + self.selection.gamma * future)
        table = self.tables[option]
        r_t = self.skills[option].reward(before["distance"], after["distance"], after["turn"])
        # A skill's task goes on when the trial ends.
        future = table.utility(state_t[:2], range(len(MOVES)))
        table.update(state[:2], move, r_t + table.gamma * future)

    def _choose_option(self, state: State) -> int:
        left = list(self.present)
        for episode in self.running:
            if self.rng.random() < episode.probability:
                return episode.skill
            if episode.skill in left:
                left.remove(episode.skill)
        return self.selection.choose(state, left or self.present)

    def _join(self, option: int) -> None:
        """Q(s, new) = min(initial, max over the present options of Q(s, .)); unsafe: initial."""
        if self.present and self.safe_introduction:
            for state, row in self.selection.values.items():
                utility = self.selection.utility(state, self.present)
                row[option] = min(self.selection.initial_q, utility)
        self.present.append(option)


Agent = MoveAgent | SkillAgent


def train(
    env: PredatorEnv, agent: Agent, max_trials: int, max_steps: int, seed: int
) -> tuple[int, int]:
    """Learn for a number of trials, or until a trial ends at or after a number of steps.

    Returns:
        Steps and trials.
    """
    steps = trials = 0
    env.reset(seed=seed)
    while trials < max_trials and steps < max_steps:
        agent.begin_trial(trials)
        observation, info = env.reset()
        state = to_state(observation)
        done = False
        while not done:
            option, move = agent.act(state)
            observation, reward, terminated, truncated, info_t = env.step(np.int64(move))
            state_t = to_state(observation)
            agent.learn(state, option, move, reward, state_t, terminated, info, info_t)
            state, info = state_t, info_t
            steps += 1
            done = terminated or truncated
        trials += 1
    return steps, trials


def to_state(observation: np.ndarray) -> State:
    """An observation as a key of a table."""
    direction, ring, heading = observation.tolist()
    return direction, ring, heading
