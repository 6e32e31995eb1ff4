"""Choices that are kept, skills that learn alone first, and a teacher: the reference with these.

As plain as ``tests.support.reference``, of which it is a variant. Section 3.2 has Lin's ideas, 5.2
that of extent.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from numpy import float32

from tests.support.reference import (
    WORD,
    Cell,
    Option,
    Outcome,
    Reading,
    SlowLearner,
    SlowSettings,
    SplitMix64,
    Step,
)

GAMMA = 0x9E3779B97F4A7C15
MAX_TRIALS = 2_000_000


class SlowHeld(NamedTuple):
    """For how long a choice is kept."""

    until_change: bool
    most: int
    once: bool = False
    """Whether what follows is discounted once for the choice, and not for each of its steps."""


ONE_STEP = SlowHeld(until_change=False, most=1)
"""As if choices were not kept."""


@dataclass(frozen=True)
class HeldSettings(SlowSettings):
    """Everything a run depends on but its seed."""

    held: SlowHeld = ONE_STEP
    taught: int = 0
    """Trials in which the script chooses."""
    alone: int = 0
    """Steps for which each skill learns by itself before the first trial."""
    applicable: float | None = None
    """Share of what a skill ever promised that it must promise to be selected."""


class HeldLearner(SlowLearner):
    """The learner whose choices are kept."""

    def __init__(self, settings: HeldSettings, seed: int) -> None:
        super().__init__(settings, seed)
        self.own = settings
        self.made = 0
        self.choice: Option | None = None
        """That is being kept."""
        self.rewards: list[float32] = []
        """Of its steps."""
        self.chosen_at: Cell = self.cell
        self.most_ever = dict.fromkeys(settings.skills, float32(settings.initial_q))
        # Trials start as if there were no pre-training: it has the numbers that no trial has.
        self.first_start: tuple[Cell, int] = self.cell, self.heading
        root = SplitMix64(seed)
        root.draw()
        self.other_starts = SplitMix64((root.draw() + 3 * MAX_TRIALS * GAMMA) & WORD)
        if self._lone() is not None:
            self.cell, self.heading = self.world.start(self.other_starts)

    def step(self) -> Step:
        """A step of a trial, or of a skill that learns by itself."""
        skill = self._lone()
        step = super().step() if skill is None else self._step_alone(skill)
        self.made += 1
        return step

    def _lone(self) -> str | None:
        """The first so many steps are the first skill's, the next the second's, and so on."""
        if self.made >= self.own.alone * len(self.own.skills):
            return None
        return self.own.skills[self.made // self.own.alone]

    def _step_alone(self, skill: str) -> Step:
        """The skill chooses the move and learns; the selection does neither, and no trial ends."""
        self._let_skills_join()
        before, heading = self.cell, self.heading
        draw = self.decisions.draw()
        values = self.skills[skill][self.world.reading(before)]
        move = self._epsilon_greedy(values, draw >> 32 & 0xFFFF, draw >> 48)
        after = self.world.moved(before, move)
        outcome = self.world.outcome(heading, before, after)
        self.trial_step += 1
        if outcome is None and self.trial_step == self.world.step_limit:
            outcome = "timeout"
        self.visits[self.world.state(heading, before), skill] += 1
        self._learn_skill(skill, move, before, after)
        self.cell = after
        if outcome is not None:
            self._place_anew()
            self.happened["alone and done"] += 1
        if (self.made + 1) % self.own.alone == 0:
            self._place_anew()
            if skill == self.own.skills[-1]:
                self.cell, self.heading = self.first_start
        return Step(skill, move, after, heading, outcome)

    def _place_anew(self) -> None:
        self.trial_step = 0
        self.cell, self.heading = self.world.start(self.other_starts)

    def _decide(self) -> tuple[Option, tuple[int, int]]:
        """The choice goes on if there is one; otherwise the script, episodes and the table."""
        option, others = self.choice, list[Option]()
        is_new = option is None
        if option is None:
            option = self._scripted()
        if option is None:
            option, others = self._asked_episodes()
        draw = self.decisions.draw()
        explore_option, which_option, explore_move, which_move = (
            draw >> shift & 0xFFFF for shift in (0, 16, 32, 48)
        )
        reading = self.world.reading(self.cell)
        if option is None:
            others = self._applicable(reading, others)
            row = self.selection[self.world.state(self.heading, self.cell)]
            values = {other: row[other] for other in others}
            option = self._epsilon_greedy(values, explore_option, which_option)
        if is_new:
            self.choice, self.rewards, self.chosen_at = option, [], self.cell
        self.happened["kept"] += not is_new
        if not isinstance(option, str):
            return option, option
        return option, self._epsilon_greedy(self.skills[option][reading], explore_move, which_move)

    def _scripted(self) -> str | None:
        """In front of the prey and near it avoid, behind it approach, and circle to get there."""
        if self.trial >= self.own.taught:
            return None
        to_the_side = self.world.bearing(self.cell) - self.heading * math.pi / 4
        b = abs(math.atan2(math.sin(to_the_side), math.cos(to_the_side)))
        radius = self.world.vision_radius * self.world.size / 120
        if b <= math.pi / 2 + 0.1 and self.world.distance(self.cell) <= radius + 1.5:
            skill = "avoid"
        elif b > math.pi / 2 + 0.35:
            skill = "approach"
        else:
            skill = "circle_clockwise"
        self.happened[f"taught to {skill}"] += 1
        if skill not in self.present:
            self.happened["taught what is not there"] += 1
            return None
        return skill

    def _applicable(self, reading: Reading, others: list[Option]) -> list[Option]:
        """Those whose best promise here is a share of the best that they ever made."""
        if self.own.applicable is None:
            return others
        fitting: list[Option] = []
        for skill in self.own.skills:
            if skill not in self.present:
                continue
            promise = max(self.skills[skill][reading].values())
            self.most_ever[skill] = max(self.most_ever[skill], promise)
            if promise >= float32(self.own.applicable) * self.most_ever[skill]:
                fitting.append(skill)
        left = [option for option in others if option in fitting]
        self.happened["not applicable"] += 0 < len(left) < len(others)
        self.happened["none applicable"] += not left
        return left or others

    def _learn_selection(
        self, option: Option, before: Cell, after: Cell, outcome: Outcome | None
    ) -> None:
        """At the end of a choice, from the sum of what its steps earned."""
        earned = {"capture": self.world.capture_reward, "flight": self.world.flight_reward}
        self.rewards.append(float32(earned.get(str(outcome), 0.0)))
        held, heading = self.own.held, self.heading
        state_t = self.world.state(heading, after)
        has_changed = state_t != self.world.state(heading, before)
        is_over = outcome is not None or len(self.rewards) == held.most
        if not is_over and not (held.until_change and has_changed):
            return
        gamma, discount, total = float32(self.settings.gamma), float32(1), float32(0)
        for reward in self.rewards:
            total = total + discount * reward
            discount = discount if held.once else discount * gamma
        discount = gamma if held.once else discount
        future = max(self.selection[state_t].values())
        if outcome in ("capture", "flight"):
            future = float32(0)
        self._note_end(outcome, has_changed)
        alpha = float32(self.settings.alpha)
        timers = [self.own.timer(skill) for skill in self.own.skills if skill in self.present]
        if any(timer.freezes(self.trial) for timer in timers):
            alpha = float32(0)
        values = self.selection[self.world.state(heading, self.chosen_at)]
        values[option] = values[option] + alpha * (total + discount * future - values[option])
        self.choice = None

    def _note_end(self, outcome: Outcome | None, has_changed: bool) -> None:
        took = len(self.rewards)
        self.happened["ended with the trial after several steps"] += (
            outcome is not None and took > 1
        )
        self.happened["ended by a change"] += has_changed and took < self.own.held.most
        self.happened["ended by its length"] += not has_changed and took == self.own.held.most
