"""Watkins's Q(λ) and feudal Q once more, as slowly and as plainly as they can be written.

Like :mod:`tests.support.reference`, whose world they live in: no code is shared with the project,
tables are dictionaries, and each function states the sentence of the definition that it follows.
"""

from collections import Counter
from dataclasses import dataclass, field
from typing import NamedTuple

from numpy import float32

from tests.support.reference import (
    MOVES,
    Cell,
    Outcome,
    Reading,
    SlowSettings,
    SplitMix64,
    State,
    Step,
)

COMMANDS = ("counterclockwise", "clockwise", "inwards", "outwards", "search")
MOST_TRACES = 256
NOTHING = float32(0)


@dataclass
class TrialLog:
    """What is counted in a trial."""

    new_states: int = 0
    switches: int = 0
    change: float = 0.0


@dataclass
class Notes:
    """What a learner notes as it goes, beside what it learns."""

    visits: Counter[tuple[State, int]] = field(default_factory=Counter)
    first_reach: dict[State, int] = field(default_factory=dict)
    running: TrialLog = field(default_factory=TrialLog)
    ended: list[TrialLog] = field(default_factory=list)
    happened: Counter[str] = field(default_factory=Counter)


class Drawn(NamedTuple):
    """One draw of 64 bits as four of 16, from the low end."""

    explore_option: int
    which_option: int
    explore_move: int
    which_move: int


class SlowComparator:
    """What both have in common: the world, the trials, how they draw, what they note."""

    def __init__(self, settings: SlowSettings, seed: int) -> None:
        self.settings, self.world = settings, settings.world
        seeds = SplitMix64(seed)
        self.decisions, self.starts = SplitMix64(seeds.draw()), SplitMix64(seeds.draw())
        self.trial = self.trial_step = 0
        self.cell, self.heading = self.world.start(self.starts)
        self.previous: int | None = None
        self.notes = Notes()

    @property
    def states(self) -> list[State]:
        """All main states."""
        rings, sectors = range(self.world.n_distances), range(self.world.n_directions)
        return [(h, ring, sector) for h in range(8) for ring in rings for sector in sectors]

    @property
    def readings(self) -> list[Reading]:
        """All that a skill tells apart."""
        rings, sectors = range(self.world.n_skill_rings), range(self.world.n_skill_sectors)
        return [(ring, sector) for ring in rings for sector in sectors]

    def drawn(self) -> Drawn:
        """The draw of a step."""
        draw = self.decisions.draw()
        return Drawn(*(draw >> shift & 0xFFFF for shift in (0, 16, 32, 48)))

    def epsilon_greedy(self, values: list[float32], explore16: int, which16: int) -> int:
        """Any action with probability epsilon, otherwise a best one; ties broken at random."""
        best = max(values)
        candidates = [action for action, value in enumerate(values) if value == best]
        if explore16 < round(self.settings.epsilon * 2**16):
            candidates = list(range(len(values)))
        return candidates[which16 * len(candidates) // 2**16]

    def reward_of(self, outcome: Outcome | None) -> float32:
        """The reward of the world."""
        rewards = {"capture": self.world.capture_reward, "flight": self.world.flight_reward}
        return float32(rewards.get(outcome or "", 0))

    def outcome_of(self, before: Cell, after: Cell) -> Outcome | None:
        """Counts the step; a trial is cut off after so many."""
        outcome = self.world.outcome(self.heading, before, after)
        self.trial_step += 1
        if outcome is None and self.trial_step == self.world.step_limit:
            return "timeout"
        return outcome

    def note_step(self, state: State, option: int) -> None:
        """A main state is new until it was visited, whatever was taken there."""
        if not any((state, other) in self.notes.visits for other in range(9)):
            self.notes.running.new_states += 1
        self.notes.visits[state, option] += 1
        self.notes.running.switches += option != self.previous
        self.previous = option

    def note_end(self, outcome: Outcome | None) -> None:
        """A trial that has ended gives way to the next."""
        if outcome is None:
            return
        self.notes.happened[outcome] += 1
        self.notes.ended.append(self.notes.running)
        self.notes.running = TrialLog()
        self.trial += 1
        self.trial_step = 0
        self.previous = None
        self.cell, self.heading = self.world.start(self.starts)


class SlowWatkins(SlowComparator):
    """Q(λ) as Watkins has it, with replacing traces."""

    def __init__(self, settings: SlowSettings, trace_decay: float, seed: int) -> None:
        super().__init__(settings, seed)
        self.trace_decay = trace_decay
        self.q = {state: [float32(settings.initial_q)] * 9 for state in self.states}
        self.traces: dict[tuple[State, int], float32] = {}
        """How much each of the last moves has to do with what comes, the oldest first."""

    def step(self) -> Step:
        """Choose a move, make it, and let the last moves learn from what comes of it."""
        before, heading = self.cell, self.heading
        state, drawn = self.world.state(heading, before), self.drawn()
        move = self.epsilon_greedy(self.q[state], drawn.explore_option, drawn.which_option)
        after = self.world.moved(before, MOVES[move])
        outcome = self.outcome_of(before, after)
        self.note_step(state, move)
        self._fade(state, move)
        self._learn(state, move, self.world.state(heading, after), outcome)
        self.cell = after
        if outcome is not None:
            self.traces = {}
        self.note_end(outcome)
        return Step(MOVES[move], MOVES[move], after, heading, outcome)

    def _fade(self, state: State, move: int) -> None:
        """Traces are multiplied by gamma lambda, and dropped below 0.001, or after exploring.

        That of the move that is made is 1, even if it was made before.
        """
        happened = self.notes.happened
        if self.q[state][move] < max(self.q[state]):
            happened["cut by exploring"] += len(self.traces) > 1
            self.traces = {}
        if len(self.traces) == MOST_TRACES:
            happened["forgot the oldest"] += 1
            del self.traces[next(iter(self.traces))]
        happened["made again"] += (state, move) in self.traces
        decay = float32(self.settings.gamma) * float32(self.trace_decay)
        faded = {place: e * decay for place, e in self.traces.items() if place != (state, move)}
        self.traces = {place: e for place, e in faded.items() if e >= float32(0.001)}
        happened["too small"] += len(self.traces) < len(faded)
        self.traces[state, move] = float32(1)

    def _learn(self, state: State, move: int, state_t: State, outcome: Outcome | None) -> None:
        """Each trace learns from the error of the newest, by as much as it is worth."""
        future = NOTHING if outcome in ("capture", "flight") else max(self.q[state_t])
        target = self.reward_of(outcome) + float32(self.settings.gamma) * future
        error = float32(self.settings.alpha) * (target - self.q[state][move])
        for (place, action), e in self.traces.items():
            values = self.q[place]
            before, utility = values[action], max(values)
            values[action] = before + error * e
            self.notes.running.change += float(abs(values[action] - before))
            if utility <= 0 < max(values):
                self.notes.first_reach.setdefault(place, self.trial)
            self.notes.happened["learned through a trace"] += (place, action) != (state, move) and (
                values[action] != before
            )


class Region(NamedTuple):
    """A block of rings and sectors."""

    ring: int
    sector: int


class SlowFeudal(SlowComparator):
    """A manager that commands, and five that obey."""

    def __init__(self, settings: SlowSettings, region: int, seed: int) -> None:
        super().__init__(settings, seed)
        self.side = region
        first = float32(settings.initial_q)
        self.manager = {
            (heading, self.region((heading, ring, sector))): [first] * 5
            for heading, ring, sector in self.states
        }
        self.crossers = {
            command: {reading: [first] * 9 for reading in self.readings} for command in COMMANDS[:4]
        }
        self.searcher = {
            (heading, *reading): [first] * 9 for heading in range(8) for reading in self.readings
        }
        self.held: tuple[int, Region] | None = None
        """The command, and the region in which it was given."""
        self.held_steps = 0

    def region(self, state: State) -> Region:
        """Blocks of so many rings and sectors, counted from the first of each."""
        _, ring, sector = state
        return Region(ring // self.side, sector // self.side)

    def crossed(self, command: str, before: Region, after: Region) -> bool:
        """Whether a command was fulfilled; by the shorter way round the prey."""
        if command == "inwards":
            return after.ring < before.ring
        if command == "outwards":
            return after.ring > before.ring
        n_sectors = -(-self.world.n_directions // self.side)
        turned = (after.sector - before.sector) % n_sectors
        if command == "counterclockwise":
            return 0 < turned <= n_sectors / 2
        if command == "clockwise":
            return turned >= n_sectors / 2
        return False

    def sub_policy(self, command: str, heading: int, cell: Cell) -> list[float32]:
        """What the one that obeys a command knows here; the search sees the prey's heading."""
        reading = self.world.reading(cell)
        if command == "search":
            return self.searcher[heading, *reading]
        return self.crossers[command][reading]

    def step(self) -> Step:
        """Give a command unless one holds, make the move of the one that obeys, and learn."""
        before, heading = self.cell, self.heading
        state, drawn = self.world.state(heading, before), self.drawn()
        if self.held is None:
            here = self.region(state)
            values = self.manager[heading, here]
            command = self.epsilon_greedy(values, drawn.explore_option, drawn.which_option)
            self.held, self.held_steps = (command, here), 0
        command, given_in = self.held
        obeying = self.sub_policy(COMMANDS[command], heading, before)
        move = self.epsilon_greedy(obeying, drawn.explore_move, drawn.which_move)
        after = self.world.moved(before, MOVES[move])
        outcome = self.outcome_of(before, after)
        self.note_step(state, command)
        self.held_steps += 1
        arrived = self.region(self.world.state(heading, after))
        if outcome is not None or arrived != given_in or self.held_steps == 50:
            self._learn_manager(command, given_in, arrived, outcome)
            self.held = None
        self._learn_to_obey(before, move, after, given_in, arrived, outcome)
        self.cell = after
        self.note_end(outcome)
        return Step(COMMANDS[command], MOVES[move], after, heading, outcome)

    def _learn_manager(
        self, command: int, given_in: Region, arrived: Region, outcome: Outcome | None
    ) -> None:
        """Discounted once a command; nothing follows a capture or a flight."""
        values, happened = self.manager[self.heading, given_in], self.notes.happened
        over = outcome in ("capture", "flight")
        future = NOTHING if over else max(self.manager[self.heading, arrived])
        target = self.reward_of(outcome) + float32(self.settings.gamma) * future
        before, utility = values[command], max(values)
        values[command] = before + float32(self.settings.alpha) * (target - before)
        self.notes.running.change += float(abs(values[command] - before))
        if utility <= 0 < max(values):
            for state in self.states:
                if state[0] == self.heading and self.region(state) == given_in:
                    self.notes.first_reach.setdefault(state, self.trial)
        happened["given up after 50 steps"] += outcome is None and arrived == given_in
        happened["held for several steps"] += self.held_steps > 1
        happened["crossed as commanded"] += self.crossed(COMMANDS[command], given_in, arrived)

    def _learn_to_obey(
        self,
        before: Cell,
        move: int,
        after: Cell,
        given_in: Region,
        arrived: Region,
        outcome: Outcome | None,
    ) -> None:
        """All five learn from each move; nothing follows where the region changes or all is over.

        What crosses is rewarded with 1 for the commanded crossing, the search with a hundredth of
        the reward of the world.
        """
        over = arrived != given_in or outcome in ("capture", "flight")
        for command in COMMANDS:
            values = self.sub_policy(command, self.heading, before)
            reward = float32(self.crossed(command, given_in, arrived))
            if command == "search":
                reward = self.reward_of(outcome) * float32(0.01)
            target = reward
            if not over:
                future = max(self.sub_policy(command, self.heading, after))
                target = reward + float32(self.settings.gamma) * future
            rate = float32(self.settings.skill_alpha)
            values[move] = values[move] + rate * (target - values[move])
        both = sum(self.crossed(command, given_in, arrived) for command in COMMANDS) == 2
        self.notes.happened["two crossings at once"] += both
