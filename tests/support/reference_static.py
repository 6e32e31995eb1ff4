"""Skills that differ, and static selection, once more: slow, plain, and of its own code.

As in ``tests.support.reference`` nothing is tabulated but what is learned, and each function states
the sentence of the definition that it follows.
"""

import math
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy import float32

from learners.spec import RunSpec
from tests.support import stepwise
from tests.support.reference import (
    MOVES,
    Cell,
    Move,
    Option,
    Outcome,
    SlowLearner,
    SlowSettings,
    State,
    local_reward,
)

Thing = TypeVar("Thing")


@dataclass(frozen=True)
class SlowSkill:
    """A skill that is not one of the thesis's four."""

    parts: dict[str, float] = field(default_factory=dict)
    """How much it earns of what each of the four does."""
    behind: float = 0.0
    flight: float = 0.0
    sees_heading: bool = False
    ends_with_trial: bool = False
    alpha: float | None = None


APPETITE = SlowSkill(behind=1.0, sees_heading=True, ends_with_trial=True, alpha=0.05)
FEAR = SlowSkill(flight=-50.0, sees_heading=True, ends_with_trial=True, alpha=0.05)


@dataclass(frozen=True)
class StaticSettings(SlowSettings):
    """With skills that differ, and a rule that selects."""

    own: dict[str, SlowSkill] = field(default_factory=dict)
    """Skills that are stated, by name; ``appetite`` and ``fear`` need not be."""
    rule: str = "learned"
    weights: dict[str, float] = field(default_factory=dict)

    def skill(self, name: str) -> SlowSkill:
        """What a skill is like."""
        known = {"appetite": APPETITE, "fear": FEAR} | self.own
        return known.get(name, SlowSkill(parts={name: 1.0}))


def spec_of(settings: StaticSettings) -> RunSpec:
    """The same run as a preset would state it."""
    plain = stepwise.spec_of(
        StaticSettings(
            **{
                name: getattr(settings, name)
                for name in SlowSettings.__dataclass_fields__
                if name not in ("skills", "timers", "episodes", "all_skills_learn")
            },
            skills=("approach",),
        )
    ).model_dump()
    plain["learner"] |= {
        "options": list(settings.skills),
        "skills_that_learn": "all" if settings.all_skills_learn else "chosen",
        "selection": settings.rule,
        "weights": settings.weights,
        "custom_skills": {
            name: skill.parts
            | {
                "behind": skill.behind,
                "flight": skill.flight,
                "sees": "prey_heading" if skill.sees_heading else None,
                "ends_with_trial": skill.ends_with_trial,
                "alpha": skill.alpha,
            }
            for name, skill in settings.own.items()
        },
    }
    plain["schedule"] |= {
        "skills": {skill: timer._asdict() for skill, timer in settings.timers.items()},
        "episodes": [
            {"skill": e.skill, "at": e.first, "duration": e.duration, "probability": e.probability}
            for e in settings.episodes
        ],
    }
    return RunSpec.model_validate(plain)


class StaticLearner(SlowLearner):
    """One learner whose skills may differ, and whose selection may be a rule.

    Attributes:
        views: what each skill knows of each main state; one that sees no heading has the same
            table for all of them.
        w: W of each skill in each main state.
    """

    settings: StaticSettings

    def __init__(self, settings: StaticSettings, seed: int) -> None:
        super().__init__(settings, seed)
        initial = float32(settings.initial_q)
        self.views: dict[str, dict[State, dict[Move, float32]]] = {}
        for name in settings.skills:
            tables: dict[State, dict[Move, float32]] = {}
            for heading in range(8):
                for reading, values in self.skills[name].items():
                    own = dict.fromkeys(MOVES, initial)
                    tables[heading, *reading] = own if settings.skill(name).sees_heading else values
            self.views[name] = tables
        self.w = {name: dict.fromkeys(self.selection, float32(0)) for name in settings.skills}
        self.reached: dict[State, int] = {}
        self._explored = False

    def _seen(self, cell: Cell) -> State:
        return self.heading, *self.world.reading(cell)

    def _decide(self) -> tuple[Option, Move]:
        """By the skills' own tables; or, if the selection is learned, as ever."""
        imposed, others = self._asked_episodes()
        draw = self.decisions.draw()
        first, second, third, fourth = (draw >> shift & 0xFFFF for shift in (0, 16, 32, 48))
        names = [name for name in self.settings.skills if name in others]
        if self.settings.rule != "learned":
            explores = first < round(self.settings.epsilon * 2**16)
            name, move = self.selected(imposed, names, second, fourth)
            if explores:
                self.happened["random move"] += 1
                move = _one_of(MOVES, fourth)
            self._explored = explores
            return name, move
        values = self.selection[self.world.state(self.heading, self.cell)]
        option = imposed
        if option is None:
            option = self._epsilon_greedy({o: values[o] for o in others}, first, second)
        moves = self.views[str(option)][self._seen(self.cell)]
        return option, self._epsilon_greedy(moves, third, fourth)

    def selected(
        self, imposed: str | None, names: list[str], which_skill: int, which_move: int
    ) -> tuple[str, Move]:
        """The rules of section 3.2, by Humphrys."""
        known = {name: self.views[name][self._seen(self.cell)] for name in names}
        weight = {name: float32(self.settings.weights.get(name, 1.0)) for name in names}
        if imposed is not None:
            return imposed, _one_of_best(self.views[imposed][self._seen(self.cell)], which_move)
        wanted = {name: _one_of_best(known[name], which_move) for name in names}

        def lost(name: str, move: Move) -> float32:
            return weight[name] * (max(known[name].values()) - known[name][move])

        rule = self.settings.rule
        if rule == "best_happiness":
            # argmax_i w_i max_a Q_i(x, a)
            winner = _one_of_best(
                {name: weight[name] * max(known[name].values()) for name in names}, which_skill
            )
            return winner, wanted[winner]
        if rule == "worst_unhappiness":
            # argmin_k max_{i != k} w_i (Q_i(x, a_i) - Q_i(x, a_k))
            costs = {
                k: max((lost(i, wanted[k]) for i in names if i != k), default=float32(0))
                for k in names
            }
            winner = _one_of_best({k: -cost for k, cost in costs.items()}, which_skill)
            return winner, wanted[winner]
        if rule == "negotiated_unhappiness":
            winner, stake = _one_of(names, which_skill), float32(0)
            while True:
                losers = {i: lost(i, wanted[winner]) for i in names if i != winner}
                if not losers or max(losers.values()) <= stake:
                    return winner, wanted[winner]
                self.happened["taken over"] += 1
                stake = max(losers.values())
                winner = next(i for i in losers if losers[i] == stake)
        if rule == "collective":
            # argmax_a sum_i w_i Q_i(x, a)
            together: dict[Move, float32] = {}
            for move in MOVES:
                together[move] = float32(0)
                for name in names:
                    together[move] = together[move] + weight[name] * known[name][move]
            move = _one_of_best(together, which_move)
            self.happened["nobody's own best move"] += all(lost(n, move) > 0 for n in names)
            winner = min(names, key=lambda n: (lost(n, move), -(weight[n] * known[n][move])))
            return winner, move
        # argmax_i W_i(x)
        state = self.world.state(self.heading, self.cell)
        winner = _one_of_best({name: self.w[name][state] for name in names}, which_skill)
        return winner, wanted[winner]

    def _learn_selection(
        self, option: Option, before: Cell, after: Cell, outcome: Outcome | None
    ) -> None:
        """There is no selection to learn where a rule selects."""
        self._option, self._outcome = option, outcome
        if self.settings.rule == "learned":
            super()._learn_selection(option, before, after, outcome)

    def _learn_skill(self, skill: str, move: Move, before: Cell, after: Cell) -> None:
        """From its own reward, at its own rate; a task that ends with the trial ends there."""
        like = self.settings.skill(skill)
        table = self.views[skill]
        values, following = table[self._seen(before)], table[self._seen(after)]
        reward = self._earned(like, before, after)
        target = reward + float32(self.settings.gamma) * max(following.values())
        if like.ends_with_trial and self._outcome in ("capture", "flight"):
            target = reward
        if self.settings.rule == "w_learning" and skill != self._option and not self._explored:
            # W_i += alpha (w_i (Q_i(x, a_i) - (r_i + gamma max Q_i(y, .))) - W_i)
            state = self.world.state(self.heading, before)
            weight = float32(self.settings.weights.get(skill, 1.0))
            w, alpha = self.w[skill][state], float32(self.settings.alpha)
            if any(self.settings.timer(name).freezes(self.trial) for name in self.settings.skills):
                # What a selection learns, it does not learn while it is frozen.
                alpha = float32(0)
                self.happened["frozen"] += 1
            self.w[skill][state] = w + alpha * (weight * (max(values.values()) - target) - w)
            self.happened["W learned"] += 1
        rate = self.settings.skill_alpha if like.alpha is None else like.alpha
        values[move] = values[move] + float32(rate) * (target - values[move])

    def _earned(self, like: SlowSkill, before: Cell, after: Cell) -> float32:
        """Weighted rewards of the four; ground gained behind the prey; flight."""
        world, penalty = self.world, self.settings.spiral_penalty
        total = float32(0)
        for name, share in like.parts.items():
            total = total + float32(share) * local_reward(world, name, before, after, penalty)
        relative = world.bearing(before) - self.heading * math.pi / 4
        is_behind = abs(math.remainder(relative, 2 * math.pi)) > math.radians(105)
        if is_behind:
            gained = float32(world.distance(before)) - float32(world.distance(after))
            total = total + float32(like.behind) * gained
            self.happened["gained behind"] += bool(like.behind and gained > 0)
        if self._outcome == "flight":
            total = total + float32(like.flight)
        return float32(total > 0) if self.settings.binary_rewards else total

    def _note(self, before: Cell, move: Move, after: Cell, outcome: Outcome | None) -> None:
        super()._note(before, move, after, outcome)
        state = self.world.state(self.heading, before)
        if self.settings.rule != "learned" and state not in self.reached:
            wishes = [self._wish(str(name), state) for name in self.present]
            if max(wishes) > 0:
                self.reached[state] = self.trial

    def _wish(self, name: str, state: State) -> float32:
        weight = float32(self.settings.weights.get(name, 1.0))
        return weight * max(self.views[name][state].values())

    def wishes(self) -> np.ndarray:
        """``(heading, distance, direction, option) float32``: w_i max_a Q_i, NaN where absent."""
        names = self.settings.skills
        shape = 8, self.world.n_distances, self.world.n_directions, len(names)
        found = np.full(shape, np.nan, np.float32)
        for number, name in enumerate(names):
            if name in self.present:
                for state in self.selection:
                    found[*state, number] = self._wish(name, state)
        return found

    def skill_q(self) -> np.ndarray:
        """``(skill, heading, distance, direction, move) float32``."""
        names, world = self.settings.skills, self.world
        shape = len(names), 8, world.n_skill_rings, world.n_skill_sectors, len(MOVES)
        found = np.full(shape, np.nan, np.float32)
        for number, name in enumerate(names):
            for state, values in self.views[name].items():
                found[number, *state] = [values[move] for move in MOVES]
        return found


def _one_of_best(values: dict[Thing, float32], which16: int) -> Thing:
    best = max(values.values())
    return _one_of([thing for thing, value in values.items() if value == best], which16)


def _one_of(things: list[Thing], which16: int) -> Thing:
    return things[which16 * len(things) // 2**16]
