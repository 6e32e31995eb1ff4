"""The thesis's experiments: its worlds and learners, and its findings as sums with a bound.

A finding is a weighted sum of quantities of runs, and holds where the whole interval of the sum
meets its condition.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np

from app import presets, statistics
from app.readout import Group, Log, Reader, RunRow
from app.statistics import Contrast, Estimate
from learners import measures
from learners.measures import FoldedValue
from sim import geometry
from sim.spec import WorldSpec

LEAST_SEEDS = 5
"""Runs below which no finding is decided."""
WIDE = 15.0
"""Reward per trial: a tenth of the range from flight to capture."""
REACHED = 0.5
"""Share of the states of a place with a value above 0, beyond which value has reached it."""
NOT_REACHED = 0.25
"""Share below which it has not."""
FINAL = "last 2,000 trials"
"""The quantity that is the mean reward in the end."""
TABLE_WINDOWS = ("0–0.5 M", "0.5–1 M", "1–1.5 M", "1.5–2 M", "3.5–4 M", FINAL)
"""Quantities that are tabulated for every learner in every world."""

_WINDOW_STEPS = 500_000


# --- Worlds and learners --------------------------------------------------------------------------

WORLDS: Mapping[str, tuple[int, int, int]] = {
    "120": (120, 24, 18),
    "60": (60, 24, 18),
    "150": (150, 24, 18),
    "16×11": (120, 16, 11),
    "8×6": (120, 8, 6),
}
"""By name: size of the grid, directions and distances of the sensors."""
WORLD_TITLES: Mapping[str, str] = {
    "120": "grid 120 × 120, sensors 24 × 18",
    "60": "grid 60 × 60, sensors 24 × 18",
    "150": "grid 150 × 150, sensors 24 × 18",
    "16×11": "grid 120 × 120, sensors 16 × 11",
    "8×6": "grid 120 × 120, sensors 8 × 6",
}
FIGURES: Mapping[str, tuple[str, Sequence[str]]] = {
    "figure_4_1": ("Figure 4.1: performance in the standard environment", ("120",)),
    "figure_4_2": ("Figure 4.2: scaling with environment size", ("60", "120", "150")),
    "figure_4_3": ("Figure 4.3: scaling with state resolution", ("120", "16×11", "8×6")),
}
"""By name: title and worlds."""
LEARNER_TITLES: Mapping[str, str] = {
    "timed": "timed hierarchical Q, 3 skills",
    "hierarchical_3": "hierarchical Q, 3 skills",
    "standard_q": "standard Q",
    "hierarchical_2": "hierarchical Q, 2 skills",
}

Place = tuple[str, str]
"""A world and a learner of the thesis."""
TIMED: Place = ("120", "timed")
"""The learner whose value is looked at as it spreads."""
Placed = Mapping[Place, Sequence[RunRow]]
"""Runs by where in the thesis's experiments they belong."""


@cache
def _shipped(preset: str) -> dict[str, Any]:
    return presets.load(preset).model_dump(mode="json")


def place_of(run: RunRow) -> Place | None:
    """Where in the thesis's experiments a run belongs, if it is one of them."""
    if run.preset not in LEARNER_TITLES:
        return None
    shipped = _shipped(run.preset)
    if any(run.settings.get(key) != shipped[key] for key in ("learner", "schedule", "trials")):
        return None
    world = dict(run.settings.get("world", {}))
    for name, (size, directions, distances) in WORLDS.items():
        changes = {"size": size, "n_directions": directions, "n_distances": distances}
        if world == {**shipped["world"], **changes}:
            return name, run.preset
    return None


def placed_of(groups: Iterable[Group]) -> dict[Place, list[RunRow]]:
    """Runs of the thesis's experiments among groups, each once."""
    found: dict[Place, list[RunRow]] = {}
    seen: set[tuple[Place, int]] = set()
    for group in groups:
        for run in group.runs:
            place = place_of(run)
            # The standard world is in all three experiments, with the same seeds.
            if place is not None and (place, run.seed) not in seen:
                seen.add((place, run.seed))
                found.setdefault(place, []).append(run)
    return found


# --- Quantities of a run -------------------------------------------------------------------------


def quantities_of(run: RunRow, log: Log) -> dict[str, float]:
    """What the findings speak of, by name; what the run did not get to is not there."""
    reward, steps, pictures = log
    ends = np.cumsum(steps, dtype=np.int64)
    found = {
        name: _mean(reward[(ends > first) & (ends <= last)])
        for name, (first, last) in _windows().items()
        if ends[-1] >= last
    }
    if reward.size == run.settings["trials"]:
        found[FINAL] = _mean(reward[-measures.FINAL_TRIALS :])
    for name, (first, last) in _phases(run.settings).items():
        if reward.size >= last > first:
            found[name] = _mean(reward[first:last])
    # The regions that are measured are made of the standard world's states.
    if pictures is not None and pictures.share.shape[1:] == _SHAPE:
        for name, trial in moments_of(run.settings).items():
            value = pictures.at(trial)
            if value is not None:
                found |= {key: of(value) for key, (at, of) in _SPREAD.items() if at == name}
    return found


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if values.size else math.nan


@cache
def _windows() -> dict[str, tuple[int, int]]:
    """Windows by name, each with the steps before which and with which it ends."""
    half = {
        f"{k / 2:g}–{(k + 1) / 2:g} M": (k * _WINDOW_STEPS, (k + 1) * _WINDOW_STEPS)
        for k in (0, 1, 2, 3, 7)
    }
    return {**half, "0–1 M": (0, 1_000_000), "1–2 M": (1_000_000, 2_000_000)}


def _phases(settings: Mapping[str, Any]) -> dict[str, tuple[int, int]]:
    """Phases of the timed schedule by name, each with its first trial and the one after it."""
    joins = _joins(settings)
    length = {e["skill"]: e["duration"] for e in settings.get("schedule", {}).get("episodes", ())}
    if joins is None or not {"circle_clockwise", "avoid"} <= set(length):
        return {}
    circle, avoid = joins
    circled, avoided = circle + length["circle_clockwise"], avoid + length["avoid"]
    return {
        "before circle": (max(circle - 2_000, 0), circle),
        "circle explored": (circle, circled),
        "circle mastered": (circled, avoid),
        "avoid explored": (avoid, avoided),
        "avoid mastered": (avoided, avoided + 3_500),
    }


def _joins(settings: Mapping[str, Any]) -> tuple[int, int] | None:
    """Trials at which circle and avoid come in, if they do after the start and in this order."""
    starts = {
        skill: timer["at"]
        for skill, timer in settings.get("schedule", {}).get("skills", {}).items()
    }
    circle, avoid = starts.get("circle_clockwise", 0), starts.get("avoid", 0)
    return (circle, avoid) if 0 < circle < avoid else None


# --- How far value has spread --------------------------------------------------------------------


def moments_of(settings: Mapping[str, Any]) -> dict[str, int]:
    """Moments of the timed schedule at which value is looked at, with the trials they precede."""
    joins = _joins(settings)
    if joins is None:
        return {}
    circle, avoid = joins
    trials = settings["trials"]
    return {"approach only": circle, "circling": avoid, "half way": trials // 2, "the end": trials}


def averaged(values: Sequence[FoldedValue]) -> FoldedValue:
    """Mean over runs: of the shares, and of the distances over all headings that have one."""
    share = np.stack([value.share for value in values]).astype(np.float64)
    distance = np.stack([value.distance for value in values]).astype(np.float64)
    weight = np.where(np.isfinite(distance), share, 0)
    total = (weight * np.nan_to_num(distance)).sum(axis=0)
    count = weight.sum(axis=0)
    mean = np.divide(total, count, out=np.full(total.shape, np.nan), where=count > 0)
    return FoldedValue(mean, share.mean(axis=0))


class Region(NamedTuple):
    """States at some distances from the prey and in some directions, in the standard world."""

    rings: slice
    directions: Sequence[int]
    """Of 24, counter-clockwise from straight ahead of the prey, 15 degrees each."""

    def of(self, values: np.ndarray) -> np.ndarray:
        """Its part of a map ``(ring, direction)``."""
        return values[self.rings][:, list(self.directions)]

    @property
    def cells(self) -> str:
        """Its distances in words."""
        first, last = self.rings.start, self.rings.stop
        return f"{_EDGES[first - 1]:.0f} to {_EDGES[last - 1]:.0f} cells"


_SHAPE = (WorldSpec().n_distances, WorldSpec().n_directions)
_EDGES = geometry.ring_edges(WorldSpec())
_RING = slice(10, 14)
_BEHIND = tuple(range(7, 18))
_FRONT = (*range(19, 24), *range(6))
RIGHT_FLANK = Region(_RING, (17, 18))
LEFT_FLANK = Region(_RING, (6, 7))
AHEAD_RIGHT = Region(_RING, (20, 21, 22, 23))
INNER_RIGHT = Region(slice(9, 11), AHEAD_RIGHT.directions)
"""Just outside of the visual field."""
SEEN = Region(slice(1, 8), _FRONT)
"""In the visual field."""
NEAR_BEHIND = Region(slice(3, 6), (12,))
FAR_BEHIND = Region(slice(9, 12), (12,))


def _reach(region: Region) -> Callable[[FoldedValue], float]:
    """Share of the states of a region with a value above 0."""
    return lambda value: _mean(region.of(value.share))


def _steps(region: Region) -> Callable[[FoldedValue], float]:
    """Mean equivalent distance to capture in a region, in steps; NaN where none has a value."""

    def mean(value: FoldedValue) -> float:
        found = region.of(value.distance)
        return _mean(found[np.isfinite(found)])

    return mean


def _behind(value: FoldedValue) -> float:
    """Share that lies behind the prey of all states with a value above 0; NaN where none has."""
    total = float(value.share.sum())
    return float(value.share[:, list(_BEHIND)].sum()) / total if total else math.nan


def _thinnest(value: FoldedValue) -> float:
    """Share of states with a value above 0 in the direction of the ring that has fewest."""
    return float(value.share[_RING].mean(axis=0).min())


_SPREAD: Mapping[str, tuple[str, Callable[[FoldedValue], float]]] = {
    "behind, approach only": ("approach only", _behind),
    "near behind, approach only": ("approach only", _steps(NEAR_BEHIND)),
    "far behind, approach only": ("approach only", _steps(FAR_BEHIND)),
    "right flank, approach only": ("approach only", _reach(RIGHT_FLANK)),
    "seen, approach only": ("approach only", _reach(SEEN)),
    "right flank, circling": ("circling", _reach(RIGHT_FLANK)),
    "left flank, circling": ("circling", _reach(LEFT_FLANK)),
    "ahead to the right, circling": ("circling", _reach(AHEAD_RIGHT)),
    "ahead to the right, half way": ("half way", _reach(AHEAD_RIGHT)),
    "inner right, half way": ("half way", _reach(INNER_RIGHT)),
    "thinnest, half way": ("half way", _thinnest),
    "thinnest, the end": ("the end", _thinnest),
    "inner right, the end": ("the end", _reach(INNER_RIGHT)),
    "seen, the end": ("the end", _reach(SEEN)),
}
"""By name of the quantity: the moment it is of, and how it is measured."""


# --- Findings ------------------------------------------------------------------------------------


class Term(NamedTuple):
    """A quantity with a weight."""

    weight: float
    world: str
    learner: str
    quantity: str = FINAL


class Unit(NamedTuple):
    """What a quantity is measured in, and how it is written."""

    suffix: str
    """What follows a number in words."""
    form: str
    """How a number is formatted."""


REWARD = Unit("", ".1f")
"""Mean reward per trial."""
SHARE = Unit(" of the states", ".2f")
STEPS = Unit(" steps", ".1f")

Condition = Literal["above", "below", "within"]
"""Where a sum is to lie: above or below the bound, or between the bound and its negative."""


class Finding(NamedTuple):
    """A statement of the thesis as a sum of quantities and a bound."""

    topic: str
    claim: str
    terms: Sequence[Term]
    bound: float
    condition: Condition = "above"
    unit: Unit = REWARD

    @property
    def wanted(self) -> str:
        """The condition in words."""
        shown = f"{self.bound:g}{self.unit.suffix}"
        return f"between ±{shown}" if self.condition == "within" else f"{self.condition} {shown}"


def _ahead(
    topic: str,
    claim: str,
    larger: Term,
    smaller: Term,
    bound: float = 0,
    condition: Condition = "above",
    unit: Unit = REWARD,
) -> Finding:
    terms = (larger, smaller._replace(weight=-1))
    return Finding(topic, claim, terms, bound, condition, unit)


def _at(world: str, learner: str, quantity: str = FINAL) -> Term:
    return Term(1, world, learner, quantity)


def _lead(learner: str, wide: str, narrow: str) -> tuple[Term, ...]:
    """How much timed's lead over a learner grows from one world to another."""
    return (
        Term(1, wide, "timed"),
        Term(-1, wide, learner),
        Term(-1, narrow, "timed"),
        Term(1, narrow, learner),
    )


_STANDARD, _SIZE, _RESOLUTION = "Standard world (4.3.1)", "Size (4.3.2)", "Resolution (4.3.3)"
_SPREADING = "Spread of value (4.3.1)"
_OTHER_LEARNERS = {"standard_q": "standard Q", "hierarchical_3": "three skills from the start"}


def _value(claim: str, quantity: str, condition: Condition, bound: float) -> Finding:
    """On the share of states with a value, at one moment."""
    return Finding(_SPREADING, claim, (_at(*TIMED, quantity),), bound, condition, SHARE)


def _more(claim: str, larger: str, smaller: str, bound: float, unit: Unit = SHARE) -> Finding:
    """On values in two places or at two moments."""
    terms = _at(*TIMED, larger), _at(*TIMED, smaller)
    return _ahead(_SPREADING, claim, *terms, bound, unit=unit)


_VALUE_FINDINGS = (
    _value(
        "with approach only, value is a cone: most of the states that have one lie behind the prey",
        "behind, approach only",
        "above",
        0.9,
    ),
    _more(
        f"the cone falls off: straight behind, capture is farther from {FAR_BEHIND.cells} away"
        f" than from {NEAR_BEHIND.cells}",
        "far behind, approach only",
        "near behind, approach only",
        25,
        STEPS,
    ),
    _value(
        f"with approach only, value has not reached the right flank, {RIGHT_FLANK.cells} away",
        "right flank, approach only",
        "below",
        NOT_REACHED,
    ),
    _value(
        "circling takes value to the right flank by the time avoid comes in",
        "right flank, circling",
        "above",
        REACHED,
    ),
    _more(
        "circling spreads it counter-clockwise: there is more on the right flank than on the left",
        "right flank, circling",
        "left flank, circling",
        0.25,
    ),
    _value(
        "the ring goes no further before avoid: ahead to the right it is not there",
        "ahead to the right, circling",
        "below",
        NOT_REACHED,
    ),
    _value(
        "with avoid the ring goes on: half way it is there ahead to the right",
        "ahead to the right, half way",
        "above",
        REACHED,
    ),
    _value(
        "half way the ring is open: there is a sector of it that value has not reached",
        "thinnest, half way",
        "below",
        NOT_REACHED,
    ),
    _value(
        "in the end the ring is closed: there is no sector of it that value has not reached",
        "thinnest, the end",
        "above",
        NOT_REACHED,
    ),
    _more(
        f"value spreads inwards: ahead to the right, {INNER_RIGHT.cells} away, there is more in"
        " the end than half way",
        "inner right, the end",
        "inner right, half way",
        0.25,
    ),
    _more(
        "value spreads into the visual field: there is more in the end than with approach only",
        "seen, the end",
        "seen, approach only",
        0,
    ),
)

FINDINGS: Sequence[Finding] = (
    *(
        _ahead(
            _STANDARD,
            f"timed ends above {name} by a wide margin",
            _at("120", "timed"),
            _at("120", other),
            WIDE,
        )
        for other, name in _OTHER_LEARNERS.items()
    ),
    *(
        _ahead(
            _STANDARD,
            f"timed learns a good deal faster than {name}: from 1.5 to 2 M steps",
            _at("120", "timed", "1.5–2 M"),
            _at("120", other, "1.5–2 M"),
            WIDE,
        )
        for other, name in _OTHER_LEARNERS.items()
    ),
    *(
        _ahead(
            _STANDARD,
            f"two skills are fast: ahead of {name} from 0.5 to 1 M steps",
            _at("120", "hierarchical_2", "0.5–1 M"),
            _at("120", other, "0.5–1 M"),
            WIDE,
        )
        for other, name in _OTHER_LEARNERS.items()
    ),
    _ahead(
        _STANDARD,
        "two skills stop: they end close to where they are from 0.5 to 1 M steps",
        _at("120", "hierarchical_2"),
        _at("120", "hierarchical_2", "0.5–1 M"),
        WIDE,
        condition="within",
    ),
    _ahead(
        _STANDARD,
        "two skills stop low: they end below timed",
        _at("120", "timed"),
        _at("120", "hierarchical_2"),
        WIDE,
    ),
    *(
        _ahead(_STANDARD, claim, _at("120", "timed", larger), _at("120", "timed", smaller))
        for claim, larger, smaller in (
            ("timed dips when circle comes in", "before circle", "circle explored"),
            ("timed recovers from circle", "circle mastered", "before circle"),
            ("timed dips when avoid comes in", "circle mastered", "avoid explored"),
            ("timed recovers from avoid", "avoid mastered", "avoid explored"),
        )
    ),
    *_VALUE_FINDINGS,
    *(
        _ahead(
            _SIZE,
            f"at 60 the full learners end close together: {claim}",
            _at("60", larger),
            _at("60", smaller),
            WIDE,
            condition="within",
        )
        for claim, larger, smaller in (
            ("standard Q and timed", "standard_q", "timed"),
            ("timed and three skills from the start", "timed", "hierarchical_3"),
            ("standard Q and three skills from the start", "standard_q", "hierarchical_3"),
        )
    ),
    *(
        _ahead(
            _SIZE,
            f"at 60 standard Q is ahead of timed early: from {window.replace('–', ' to ')} steps",
            _at("60", "standard_q", window),
            _at("60", "timed", window),
        )
        for window in ("0–1 M", "1–2 M")
    ),
    *(
        Finding(
            _SIZE,
            f"timed's lead over {name} grows from {narrow} to {wide}",
            _lead(other, wide, narrow),
            0,
        )
        for narrow, wide in (("60", "120"), ("120", "150"))
        for other, name in _OTHER_LEARNERS.items()
    ),
    *(
        _ahead(
            _RESOLUTION,
            f"lower resolution breaks standard Q: it ends lower by a wide margin at {world}",
            _at("120", "standard_q"),
            _at(world, "standard_q"),
            WIDE,
        )
        for world in ("16×11", "8×6")
    ),
    *(
        _ahead(
            _RESOLUTION,
            f"lower resolution hurts three skills from the start: they end lower at {world}",
            _at("120", "hierarchical_3"),
            _at(world, "hierarchical_3"),
        )
        for world in ("16×11", "8×6")
    ),
    *(
        _ahead(
            _RESOLUTION,
            f"lower resolution leaves timed working: it ends close to 24×18 at {world}",
            _at("120", "timed"),
            _at(world, "timed"),
            WIDE,
            condition="within",
        )
        for world in ("16×11", "8×6")
    ),
    *(
        _ahead(
            _RESOLUTION,
            f"timed ends above {name} by a wide margin at {world}",
            _at(world, "timed"),
            _at(world, other),
            WIDE,
        )
        for world in ("16×11", "8×6")
        for other, name in _OTHER_LEARNERS.items()
    ),
)

HOLDS, FAILS, UNDECIDED = "holds", "does not hold", "undecided"


def verdict(finding: Finding, effect: Estimate) -> str:
    """Whether an effect bears a finding out: only where the whole interval says the same."""
    if effect.n < LEAST_SEEDS:
        return UNDECIDED
    low, high, bound = effect.low, effect.high, finding.bound
    if finding.condition == "within":
        holds, fails = -bound < low and high < bound, low > bound or high < -bound
    elif finding.condition == "below":
        holds, fails = high < bound, low > bound
    else:
        holds, fails = low > bound, high < bound
    return HOLDS if holds else FAILS if fails else UNDECIDED


def effect_of(
    finding: Finding, reader: Reader, placed: Placed, rng: np.random.Generator
) -> Contrast | None:
    """The sum that a finding speaks of; None where a part of it was not run."""
    terms = []
    for weight, world, learner, quantity in finding.terms:
        traces = reader.traces(placed.get((world, learner), ()))
        values = {t.seed: t.quantities[quantity] for t in traces if quantity in t.quantities}
        if not values:
            return None
        terms.append((weight, values))
    return statistics.contrast(terms, rng)
