"""The world and the learner once more, as slowly and as plainly as they can be written.

Ground truth for the compiled loop. Nothing is tabulated, nothing is remembered from one step to
the next that is not a part of the definition, and no code is shared with the project: distances,
angles and sensor readings are worked out anew at each step, tables are dictionaries, the best
action is found by looking at all of them. Each function states the sentence of the definition
that it follows; "section" is a section of the thesis.

Two things are not part of the definition and are agreed on, so that results can be compared
exactly: how a random draw is split into decisions, and that values are stored with 32 bits
(``float32`` rounds here in the same places).
"""

import functools
import math
from collections import Counter
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeVar

from numpy import float32

Cell = tuple[int, int]
"""Column and row, ``(x, y)``: x to the east, y to the north."""

Reading = tuple[int, int]
"""What a skill sees: ``(ring, direction)``."""

State = tuple[int, int, int]
"""What the selection sees: ``(heading, ring, direction)``."""

Move = tuple[int, int]
Option = Move | str
Outcome = Literal["capture", "flight", "timeout"]
Action = TypeVar("Action", Option, Move)

MOVES: list[Move] = [(dx, dy) for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
"""The 8 neighbours and staying, in the order of their numbers."""

SKILL_NAMES = ("approach", "avoid", "circle_clockwise", "circle_counterclockwise")

WORD = 2**64 - 1


class SplitMix64:
    """The generator of Steele, Lea and Flood (2014), as published."""

    def __init__(self, state: int) -> None:
        self.state = state

    def draw(self) -> int:
        """The next 64 random bits."""
        self.state = (self.state + 0x9E3779B97F4A7C15) & WORD
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & WORD
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & WORD
        return z ^ (z >> 31)

    def uniform(self) -> float:
        """A number in [0, 1), from the upper 53 bits of a draw."""
        return (self.draw() >> 11) * 2.0**-53


@dataclass(frozen=True)
class SlowWorld:
    """Section 4.1. Lengths are those of a grid of 120 x 120 and scale with ``size / 120``."""

    size: int = 120
    n_directions: int = 24
    n_distances: int = 18
    vision_radius: int = 27
    start_radius: tuple[int, int] = (10, 60)
    step_limit: int = 500
    capture_reward: float = 100.0
    flight_reward: float = -50.0
    skill_n_directions: int | None = None
    """Sectors and rings that skills tell apart; those of the selection unless given."""
    skill_n_distances: int | None = None
    twice_ring_exponent: int = 3
    """Rings' outer edges are d_max * (k / n)^e; that 2 e is whole keeps the comparison exact."""

    @functools.cached_property
    def prey(self) -> Cell:
        """Fixed at cell ``(size // 2, size // 2)``."""
        return self.size // 2, self.size // 2

    def offset(self, cell: Cell) -> tuple[int, int]:
        """Where a cell is, as seen from the prey."""
        return cell[0] - self.prey[0], cell[1] - self.prey[1]

    def distance_squared(self, cell: Cell) -> int:
        """Squared distance from the prey, which is a whole number."""
        dx, dy = self.offset(cell)
        return dx * dx + dy * dy

    def distance(self, cell: Cell) -> float:
        """Distance from the prey in cells."""
        return math.sqrt(self.distance_squared(cell))

    def bearing(self, cell: Cell) -> float:
        """Angle of a cell as seen from the prey, in radians, counter-clockwise from east."""
        dx, dy = self.offset(cell)
        return math.atan2(dy, dx)

    def direction(self, cell: Cell, n: int) -> int:
        """One of n equal sectors, the first centred on east."""
        sectors_turned = self.bearing(cell) / (2 * math.pi) * n
        return math.floor(sectors_turned + 0.5) % n

    def ring(self, cell: Cell, n: int) -> int:
        """One of n rings, whose outer edges are d_max * (k / n)^e.

        d <= d_max * (k / n)^e is asked as d^2 * n^2e <= d_max^2 * k^2e, which is exact.
        """
        power = self.twice_ring_exponent
        corners = [(x, y) for x in (0, self.size - 1) for y in (0, self.size - 1)]
        farthest_squared = max(self.distance_squared(corner) for corner in corners)
        k = 1
        while self.distance_squared(cell) * n**power > farthest_squared * k**power:
            k += 1
        return k - 1

    def reading(self, cell: Cell) -> Reading:
        """What a skill sees from a cell (section 4.3.3)."""
        return _sensed(self, cell, self.n_skill_rings, self.n_skill_sectors)

    @property
    def n_skill_rings(self) -> int:
        """Rings that skills tell apart."""
        return self.skill_n_distances or self.n_distances

    @property
    def n_skill_sectors(self) -> int:
        """Sectors that skills tell apart."""
        return self.skill_n_directions or self.n_directions

    def state(self, heading: int, cell: Cell) -> State:
        """What the selection sees from a cell."""
        return heading, *_sensed(self, cell, self.n_distances, self.n_directions)

    def visible(self, heading: int, cell: Cell) -> bool:
        """Half-disc: offset . heading > 0 and distance <= 27 (scaled)."""
        dx, dy = self.offset(cell)
        # cos and sin of multiples of 45 degrees, rounded, are the whole-numbered vector that
        # points the same way.
        ahead_x = round(math.cos(heading * math.pi / 4))
        ahead_y = round(math.sin(heading * math.pi / 4))
        is_ahead = dx * ahead_x + dy * ahead_y > 0
        is_near = self.distance_squared(cell) * 120**2 <= (self.vision_radius * self.size) ** 2
        return is_ahead and is_near

    def moved(self, cell: Cell, move: Move) -> Cell:
        """A move off the grid is clipped at the edge, each coordinate on its own."""
        x = min(max(cell[0] + move[0], 0), self.size - 1)
        y = min(max(cell[1] + move[1], 0), self.size - 1)
        return x, y

    def noticed(self, heading: int, before: Cell, after: Cell) -> bool:
        """The move brought the predator strictly closer, and it stands in the visual field after.

        A move onto the prey's own cell is judged from the cell it came from.
        """
        closer = self.distance_squared(after) < self.distance_squared(before)
        judged = before if after == self.prey else after
        return closer and self.visible(heading, judged)

    def outcome(self, heading: int, before: Cell, after: Cell) -> Outcome | None:
        """Flight: noticed. Capture: on the prey's cell and not noticed."""
        if self.noticed(heading, before, after):
            return "flight"
        if after == self.prey:
            return "capture"
        return None

    def start(self, starts: SplitMix64) -> tuple[Cell, int]:
        """Radius uniform in [10, 60], angle uniform, nearest cell; the heading drawn afresh.

        A radius of half the grid can end one cell outside it; the start is then clipped, like
        a move.
        """
        nearest, farthest = (length * self.size / 120 for length in self.start_radius)
        radius = nearest + (farthest - nearest) * starts.uniform()
        angle = 2 * math.pi * starts.uniform()
        heading = starts.draw() * 8 // 2**64
        x = math.floor(self.prey[0] + radius * math.cos(angle) + 0.5)
        y = math.floor(self.prey[1] + radius * math.sin(angle) + 0.5)
        return self.moved((x, y), (0, 0)), heading


@functools.cache
def _sensed(world: SlowWorld, cell: Cell, n_rings: int, n_sectors: int) -> Reading:
    """Worked out once for each cell: learners come by each of them some hundred times."""
    return world.ring(cell, n_rings), world.direction(cell, n_sectors)


def local_reward(
    world: SlowWorld, skill: str, before: Cell, after: Cell, spiral_penalty: float = 0.2
) -> float32:
    """Section 4.2.2: what a skill earns for a move from distance d0 to d1 that turns by dtheta.

    A circle is charged for a share of the ground that it gives up towards the prey.
    """
    d0, d1 = float32(world.distance(before)), float32(world.distance(after))
    if skill == "approach":
        return d0 - d1
    if skill == "avoid":
        return d1 - d0
    inward = max(d0 - d1, float32(0))
    if skill == "circle_clockwise":
        return -turned(world, before, after) * d0 - float32(spiral_penalty) * inward
    if skill == "circle_counterclockwise":
        return turned(world, before, after) * d0 - float32(spiral_penalty) * inward
    raise ValueError(f"skill: {skill} is not known; allowed: {', '.join(SKILL_NAMES)}")


def turned(world: SlowWorld, before: Cell, after: Cell) -> float32:
    """Dtheta: counter-clockwise positive, wrapped to +-pi; 0 at the prey's cell."""
    if after == world.prey:
        return float32(0)
    turn = float32(world.bearing(after)) - float32(world.bearing(before))
    if turn > math.pi:
        turn -= float32(2 * math.pi)
    if turn < -math.pi:
        turn += float32(2 * math.pi)
    return turn


@dataclass(frozen=True)
class SlowEpisode:
    """A biased exploration episode (section 3.3.4), from trial ``first`` on."""

    skill: str
    first: int
    duration: int
    probability: float

    def runs(self, trial: int) -> bool:
        """Whether it is going on in a trial."""
        return self.first <= trial < self.first + self.duration


class SlowTimer(NamedTuple):
    """A skill timer (section 3.3.4): when the skill joins, and the freeze after it, in trials."""

    at: int = 0
    freeze: int = 0

    def freezes(self, trial: int) -> bool:
        """Whether the freeze that follows the introduction is going on in a trial."""
        return self.at <= trial < self.at + self.freeze


@dataclass(frozen=True)
class SlowSettings:
    """Everything a run depends on but its seed."""

    world: SlowWorld
    skills: tuple[str, ...] = ()
    """Skills to select from; if there are none, the options are the nine moves."""
    alpha: float = 0.1
    skill_alpha: float = 0.6
    gamma: float = 0.9
    epsilon: float = 0.1
    initial_q: float = 0.0
    timers: dict[str, SlowTimer] = field(default_factory=dict)
    """A skill without a timer is there from the first trial."""
    episodes: tuple[SlowEpisode, ...] = ()
    spiral_penalty: float = 0.2
    binary_rewards: bool = False
    """Whether a local reward is 1 for a move that earned anything, and 0 for any other."""
    all_skills_learn: bool = False
    """Whether each skill that is present learns from every move, whichever made it."""
    safe_introduction: bool = True
    """Whether a skill that joins leaves the utility of every state as it is."""

    @property
    def options(self) -> list[Option]:
        """All options in the order of their numbers."""
        return list(self.skills) or list(MOVES)

    def timer(self, skill: str) -> SlowTimer:
        """When a skill joins and what it freezes."""
        return self.timers.get(skill, SlowTimer())


class Step(NamedTuple):
    """What happened in one step."""

    option: Option
    move: Move
    cell: Cell
    """Where the predator stood after the move, before a new trial placed it elsewhere."""
    heading: int
    outcome: Outcome | None


class SlowLearner:
    """One learner: a selection table over options; an option is a move, or a skill.

    Attributes:
        selection: selection table, Q(s, option) by state.
        skills: a table for each skill, Q(s, move) by reading.
        visits: how often an option was taken in a state.
        happened: how often the events happened that a test may want to be sure of.
    """

    def __init__(self, settings: SlowSettings, seed: int) -> None:
        self.settings = settings
        self.world = settings.world
        seeds = SplitMix64(seed)
        self.decisions = SplitMix64(seeds.draw())
        self.starts = SplitMix64(seeds.draw())
        self.trial = 0
        self.trial_step = 0
        self.cell, self.heading = self.world.start(self.starts)
        self.present: list[Option] = [] if settings.skills else list(MOVES)
        readings = [
            (ring, direction)
            for ring in range(self.world.n_distances)
            for direction in range(self.world.n_directions)
        ]
        skill_readings = [
            (ring, direction)
            for ring in range(self.world.n_skill_rings)
            for direction in range(self.world.n_skill_sectors)
        ]
        initial_q = float32(settings.initial_q)
        self.selection: dict[State, dict[Option, float32]] = {
            (heading, *reading): dict.fromkeys(self.present, initial_q)
            for heading in range(8)
            for reading in readings
        }
        self.skills: dict[str, dict[Reading, dict[Move, float32]]] = {
            skill: {reading: dict.fromkeys(MOVES, initial_q) for reading in skill_readings}
            for skill in settings.skills
        }
        self.visits: Counter[tuple[State, Option]] = Counter()
        self.happened: Counter[str] = Counter()

    def step(self) -> Step:
        """Choose an option, let it choose a move, make the move, learn at both levels."""
        if self.trial_step == 0:
            self._let_skills_join()
        before, heading = self.cell, self.heading
        option, move = self._decide()
        after = self.world.moved(before, move)
        outcome = self.world.outcome(heading, before, after)
        self.trial_step += 1
        if outcome is None and self.trial_step == self.world.step_limit:
            outcome = "timeout"
        self.visits[self.world.state(heading, before), option] += 1
        self._learn_selection(option, before, after, outcome)
        for skill in self.settings.skills:
            if skill == option or (self.settings.all_skills_learn and skill in self.present):
                self.happened["learned from another's move"] += skill != option
                self._learn_skill(skill, move, before, after)
        self._note(before, move, after, outcome)
        self.cell = after
        if outcome is not None:
            self.trial += 1
            self.trial_step = 0
            self.cell, self.heading = self.world.start(self.starts)
        return Step(option, move, after, heading, outcome)

    def _let_skills_join(self) -> None:
        """On joining, Q(s, new) = min(initial, max over present options of Q(s, .)) for every s.

        If the introduction is not to be safe, Q(s, new) = initial.
        """
        for skill in self.settings.skills:
            if skill in self.present or self.settings.timer(skill).at != self.trial:
                continue
            for values in self.selection.values():
                initial = float32(self.settings.initial_q)
                utility = max(values.values(), default=initial)
                joined = min(initial, utility) if self.settings.safe_introduction else initial
                values[skill] = joined
                self.happened["joined below the initial value"] += bool(joined < initial)
                self.happened["raised a utility by joining"] += bool(joined > utility)
            self.present.append(skill)

    def _decide(self) -> tuple[Option, Move]:
        """Both choices of a step.

        Each episode that runs takes a draw of its own until one of them takes the step. Then
        one draw serves all choices, 16 bits each, from the low end: whether to explore among the
        options, which option, whether to explore among the moves, which move.
        """
        imposed, others = self._asked_episodes()
        draw = self.decisions.draw()
        explore_option, which_option, explore_move, which_move = (
            draw >> shift & 0xFFFF for shift in (0, 16, 32, 48)
        )
        state = self.world.state(self.heading, self.cell)
        option = imposed
        if option is None:
            values = {option: self.selection[state][option] for option in others}
            self.happened["best option left out"] += bool(
                max(values.values()) < max(self.selection[state].values())
                and len(set(values.values())) > 1
            )
            option = self._epsilon_greedy(values, explore_option, which_option)
        if not isinstance(option, str):
            return option, option
        values = self.skills[option][self.world.reading(self.cell)]
        return option, self._epsilon_greedy(values, explore_move, which_move)

    def _asked_episodes(self) -> tuple[str | None, list[Option]]:
        """During an episode each step takes its skill with its probability.

        Otherwise the ordinary choice is made among the other options. Where episodes overlap,
        the newest is asked first. If no other option is left, the choice is among all of them.

        Returns:
            The skill that an episode imposes, if one does; the options for the ordinary choice.
        """
        others = [option for option in self.settings.options if option in self.present]
        running = [episode for episode in self.settings.episodes if episode.runs(self.trial)]
        for episode in sorted(running, key=lambda episode: episode.first, reverse=True):
            if self.decisions.draw() >> 32 < episode.probability * 2**32:
                self.happened["imposed"] += 1
                return episode.skill, others
            others.remove(episode.skill)
        self.happened["passed over by two episodes"] += len(running) >= 2
        if not others:
            self.happened["no other option"] += 1
            others = [option for option in self.settings.options if option in self.present]
        return None, others

    def _epsilon_greedy(
        self, values: dict[Action, float32], explore16: int, which16: int
    ) -> Action:
        """Any action with probability epsilon, otherwise a best one; ties broken at random."""
        best = max(values.values())
        candidates = [action for action, value in values.items() if value == best]
        # Probabilities of exploring are whole numbers of 1 / 65,536.
        if explore16 < round(self.settings.epsilon * 2**16):
            candidates = list(values)
        return candidates[which16 * len(candidates) // 2**16]

    def _learn_selection(
        self, option: Option, before: Cell, after: Cell, outcome: Outcome | None
    ) -> None:
        """Equation 3.5 with the global reward.

        Nothing follows capture and flight; the last step before the limit still bootstraps.
        During a freeze alpha is 0.
        """
        values = self.selection[self.world.state(self.heading, before)]
        future = max(self.selection[self.world.state(self.heading, after)].values())
        reward = float32(0)
        if outcome == "capture":
            reward, future = float32(self.world.capture_reward), float32(0)
        if outcome == "flight":
            reward, future = float32(self.world.flight_reward), float32(0)
        alpha = float32(self.settings.alpha)
        if any(self.settings.timer(skill).freezes(self.trial) for skill in self.present):
            self.happened["frozen"] += 1
            alpha = float32(0)
        target = reward + float32(self.settings.gamma) * future
        values[option] = values[option] + alpha * (target - values[option])

    def _learn_skill(self, skill: str, move: Move, before: Cell, after: Cell) -> None:
        """Only the chosen skill learns, or each that is present, from its own local reward.

        Skills treat their task as continuing: they bootstrap across the end of a trial.
        """
        values = self.skills[skill][self.world.reading(before)]
        future = max(self.skills[skill][self.world.reading(after)].values())
        penalty = self.settings.spiral_penalty
        reward = local_reward(self.world, skill, before, after, penalty)
        if self.settings.binary_rewards:
            reward = float32(reward > 0)
        target = reward + float32(self.settings.gamma) * future
        values[move] = values[move] + float32(self.settings.skill_alpha) * (target - values[move])

    def _note(self, before: Cell, move: Move, after: Cell, outcome: Outcome | None) -> None:
        self.happened["clipped"] += after != (before[0] + move[0], before[1] + move[1])
        self.happened["flight on the prey's cell"] += (
            outcome == "flight" and after == self.world.prey
        )
        if outcome is not None:
            self.happened[outcome] += 1
