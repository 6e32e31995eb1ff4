"""Skills that join by a rule, and exploration by context, once more as slowly and as plainly.

Follows ``tests.support.reference``: no code is shared with the project. What a rule watches is kept
as one list entry for each trial, and the mean over its last entries is taken anew before each.
"""

import math
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from numpy import float32

from tests.support.reference import (
    Cell,
    Option,
    Outcome,
    SlowEpisode,
    SlowLearner,
    SlowSettings,
    SlowTimer,
    State,
)

NEVER = 10**9


@dataclass(frozen=True)
class SlowContextEpisode(SlowEpisode):
    """An episode that acts only in states with V(s) <= ``value_at_most`` (section 5.2)."""

    value_at_most: float = math.inf


class SlowRule(NamedTuple):
    """The rule by which each skill joins that has no timer, in the order listed."""

    by: Literal["novelty", "reach", "change"]
    window: int
    below: float
    freeze: int
    """After each introduction."""
    duration: int
    """Of the exploration that begins with it, in trials."""
    probability: float
    value_at_most: float = math.inf


class Noted(NamedTuple):
    """What there is to say of a trial that has ended."""

    new_states: int
    reached: int
    change: float
    steps: int


class RuledLearner(SlowLearner):
    """A learner whose skills join by a rule, but for the first, which is there from the start.

    Attributes:
        joined: skills that joined by the rule, and the trials before which they did.
        notes: of each trial that has ended.
    """

    def __init__(self, settings: SlowSettings, rule: SlowRule, seed: int) -> None:
        first, *others = settings.skills
        timers = {first: SlowTimer(0, rule.freeze)}
        timers |= {skill: SlowTimer(NEVER) for skill in others}
        super().__init__(replace(settings, timers=timers), seed)
        self.rule = rule
        self.joined: list[tuple[str, int]] = []
        self.notes: list[Noted] = []
        self._seen: set[State] = set()
        self._ever_worth_something: set[State] = set()
        self._now = Noted(0, 0, 0.0, 0)

    def mean(self) -> float | None:
        """What the rule asks for before the running trial; None if it is too early to ask."""
        latest = max(timer.at for timer in self.settings.timers.values() if timer.at < NEVER)
        since = latest + self.rule.freeze
        if self.trial < since + self.rule.window:
            return None
        window = self.notes[self.trial - self.rule.window : self.trial]
        assert len(window) == self.rule.window
        if self.rule.by == "novelty":
            return sum(note.new_states for note in window) / len(window)
        if self.rule.by == "reach":
            return sum(note.reached for note in window) / len(window)
        return sum(note.change for note in window) / sum(note.steps for note in window)

    def _let_skills_join(self) -> None:
        waiting = [s for s in self.settings.skills if self.settings.timer(s).at == NEVER]
        if waiting and self.trial_step == 0:
            mean = self.mean()
            if mean is not None and mean < self.rule.below:
                self._join(waiting[0])
        former = list(self.present)
        super()._let_skills_join()
        if self.present != former:
            self._seen.clear()

    def _join(self, skill: str) -> None:
        """From here on it is as if its timer had said so."""
        rule = self.rule
        episode = SlowContextEpisode(
            skill, self.trial, rule.duration, rule.probability, rule.value_at_most
        )
        self.settings = replace(
            self.settings,
            timers={**self.settings.timers, skill: SlowTimer(self.trial, rule.freeze)},
            episodes=(*self.settings.episodes, episode),
        )
        self.joined.append((skill, self.trial))

    def _asked_episodes(self) -> tuple[str | None, list[Option]]:
        """While the newest skill is explored: in a step with V(s) <= v0, it is taken with the
        episode's probability, and otherwise the choice is among the others; V(s) is the maximum of
        Q(s, .) over the present ones of these. Where V(s) > v0 the choice is the ordinary one."""
        values = self.selection[self.world.state(self.heading, self.cell)]
        others = [option for option in self.settings.options if option in self.present]
        running = [episode for episode in self.settings.episodes if episode.runs(self.trial)]
        for episode in sorted(running, key=lambda episode: episode.first, reverse=True):
            worth = [value for option, value in values.items() if option != episode.skill]
            limit = episode.value_at_most if isinstance(episode, SlowContextEpisode) else math.inf
            if max(worth, default=-math.inf) > limit:
                self.happened["left to an ordinary choice"] += 1
                continue
            if self.decisions.draw() >> 32 < episode.probability * 2**32:
                self.happened["imposed"] += 1
                return episode.skill, others
            others.remove(episode.skill)
        if not others:
            others = [option for option in self.settings.options if option in self.present]
        return None, others

    def _learn_selection(
        self, option: Option, before: Cell, after: Cell, outcome: Outcome | None
    ) -> None:
        state = self.world.state(self.heading, before)
        values = self.selection[state]
        former = values[option]
        super()._learn_selection(option, before, after, outcome)
        is_new = state not in self._seen
        self._seen.add(state)
        is_reached = bool(values[option] > 0) and state not in self._ever_worth_something
        if is_reached:
            self._ever_worth_something.add(state)
        now = self._now
        self._now = Noted(
            now.new_states + is_new,
            now.reached + is_reached,
            now.change + abs(float(values[option] - former)),
            now.steps + 1,
        )
        if outcome is not None:
            self.notes.append(self._now._replace(change=float(float32(self._now.change))))
            self._now = Noted(0, 0, 0.0, 0)
