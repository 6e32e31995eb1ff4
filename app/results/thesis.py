"""The thesis's experiments: its worlds and learners, what is measured of them, and its findings."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from app.analysis import estimates
from app.analysis.estimates import PHASE_STEPS, PHASES, Contrast, average
from app.documents import presets
from app.experiments.record import Record
from app.results import spread
from app.results.findings import (
    CLOSE,
    FINAL,
    MORE,
    MUCH_MORE,
    Finding,
    Place,
    Term,
    ahead,
    term,
)
from app.results.read import Group, Log, Reader
from learners import measures

TABLE_WINDOWS = (*PHASES, FINAL)
"""Quantities that are tabulated for every learner in every world."""

_WINDOWS: Mapping[str, tuple[int, int]] = {
    **{name: (place * PHASE_STEPS, (place + 1) * PHASE_STEPS) for name, place in PHASES.items()},
    "0–1 M": (0, 1_000_000),
    "1–2 M": (1_000_000, 2_000_000),
}
"""Windows by name, each with the steps before which and with which it ends."""


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

Placed = Mapping[Place, Sequence[Record]]
"""Runs by where in the thesis's experiments they belong."""


def place_of(run: Record) -> Place | None:
    """Where in the thesis's experiments a run belongs, if it is one of them."""
    # Of runs that end once they have learned enough, the good ones are short: selected by outcome.
    shipped = presets.shipped_settings(run.preset_name)
    if run.origin.limited or run.preset_name not in LEARNER_TITLES or shipped is None:
        return None
    if any(run.settings.get(key) != shipped[key] for key in ("learner", "schedule", "trials")):
        return None
    world = dict(run.settings.get("world", {}))
    for name, (size, directions, distances) in WORLDS.items():
        changes = {"size": size, "n_directions": directions, "n_distances": distances}
        if world == {**shipped["world"], **changes}:
            return name, run.preset_name
    return None


def placed_of(groups: Iterable[Group]) -> dict[Place, list[Record]]:
    """Runs of the thesis's experiments among groups, each once."""
    found: dict[Place, list[Record]] = {}
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


def quantities_of(run: Record, log: Log) -> dict[str, float]:
    """What the findings speak of, by name; what the run did not get to is not there."""
    reward = log.reward
    ends = np.cumsum(log.steps, dtype=np.int64)
    found = {
        name: average(reward[(ends > first) & (ends <= last)])
        for name, (first, last) in _WINDOWS.items()
        if ends.size and ends[-1] >= last
    }
    if reward.size >= run.settings["trials"]:
        # It may have gone on until a horizon.
        found[FINAL] = average(reward[: run.settings["trials"]][-measures.FINAL_TRIALS :])
    for name, (first, last) in _phases(run.settings).items():
        if reward.size >= last > first:
            found[name] = average(reward[first:last])
    return found | spread.quantities_of(run.settings, log.pictures)


def _phases(settings: Mapping[str, Any]) -> dict[str, tuple[int, int]]:
    """Phases of the timed schedule by name, each with its first trial and the one after it."""
    joins = spread.joins(settings)
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


# --- Findings ------------------------------------------------------------------------------------


def _lead(learner: str, wide: str, narrow: str) -> tuple[Term, ...]:
    """How much timed's lead over a learner grows from one world to another."""
    return (
        Term(1, wide, "timed"),
        Term(-1, wide, learner),
        Term(-1, narrow, "timed"),
        Term(1, narrow, learner),
    )


_STANDARD = ("Standard world", "4.3.1")
_SIZE = ("Size", "4.3.2")
_RESOLUTION = ("Resolution", "4.3.3")
"""Topic and section."""
_OTHER_LEARNERS = {"standard_q": "standard Q", "hierarchical_3": "three skills from the start"}

_OUTPERFORMS = "Timed learning does significantly better than both others, and far sooner."
_TWO_SKILLS = "Two skills are learned very quickly, and level off below timed learning."
_DIPS = (
    "Timed learning dips significantly twice, while it explores the skill that has just come in,"
    " and recovers."
)
_MINIMAL = "In the small world the three full learners hardly differ."
_EARLY = "There standard Q is ahead of timed learning, at least early on."
_GROWS = (
    "Differences are much more pronounced in the larger worlds, and the advantage of timed learning"
    " grows significantly from the middle one to the large one."
)
_BREAKS = "Standard Q no longer performs acceptably when sensors are coarse."
_HURTS = "Three skills from the start get significantly worse as sensors get coarser."
_LEAVES = "Timed learning goes on performing fairly well with coarse sensors."

FINDINGS: Sequence[Finding] = (
    *(
        ahead(
            *_STANDARD,
            _OUTPERFORMS,
            f"timed ends above {name} by a wide margin",
            term("120", "timed"),
            term("120", other),
            MUCH_MORE,
        )
        for other, name in _OTHER_LEARNERS.items()
    ),
    *(
        ahead(
            *_STANDARD,
            _OUTPERFORMS,
            f"timed learns a good deal faster than {name}: from 1.5 to 2 M steps",
            term("120", "timed", "1.5–2 M"),
            term("120", other, "1.5–2 M"),
            MUCH_MORE,
        )
        for other, name in _OTHER_LEARNERS.items()
    ),
    *(
        ahead(
            *_STANDARD,
            _TWO_SKILLS,
            f"two skills are very fast: ahead of {name} from 0.5 to 1 M steps",
            term("120", "hierarchical_2", "0.5–1 M"),
            term("120", other, "0.5–1 M"),
            MUCH_MORE,
        )
        for other, name in _OTHER_LEARNERS.items()
    ),
    ahead(
        *_STANDARD,
        _TWO_SKILLS,
        "two skills stop: they end close to where they are from 0.5 to 1 M steps",
        term("120", "hierarchical_2"),
        term("120", "hierarchical_2", "0.5–1 M"),
        CLOSE,
    ),
    ahead(
        *_STANDARD,
        _TWO_SKILLS,
        "two skills end below timed",
        term("120", "timed"),
        term("120", "hierarchical_2"),
    ),
    *(
        ahead(
            *_STANDARD,
            _DIPS,
            claim,
            term("120", "timed", larger),
            term("120", "timed", smaller),
            margin,
        )
        for claim, larger, smaller, margin in (
            (
                "timed dips significantly when circle comes in",
                "before circle",
                "circle explored",
                MUCH_MORE,
            ),
            ("timed recovers from circle", "circle mastered", "before circle", MORE),
            (
                "timed dips significantly when avoid comes in",
                "circle mastered",
                "avoid explored",
                MUCH_MORE,
            ),
            ("timed recovers from avoid", "avoid mastered", "avoid explored", MORE),
        )
    ),
    *spread.FINDINGS,
    *(
        ahead(
            *_SIZE,
            _MINIMAL,
            f"at 60 the full learners end close together: {claim}",
            term("60", larger),
            term("60", smaller),
            CLOSE,
        )
        for claim, larger, smaller in (
            ("standard Q and timed", "standard_q", "timed"),
            ("timed and three skills from the start", "timed", "hierarchical_3"),
            ("standard Q and three skills from the start", "standard_q", "hierarchical_3"),
        )
    ),
    *(
        ahead(
            *_SIZE,
            _EARLY,
            f"at 60 standard Q is ahead of timed early: from {window.replace('–', ' to ')} steps",
            term("60", "standard_q", window),
            term("60", "timed", window),
        )
        for window in ("0–1 M", "1–2 M")
    ),
    *(
        Finding(
            *_SIZE,
            _GROWS,
            f"timed's lead over {name} grows {how} from {narrow} to {wide}",
            _lead(other, wide, narrow),
            MUCH_MORE,
        )
        for narrow, wide, how in (("60", "120", "much"), ("120", "150", "significantly"))
        for other, name in _OTHER_LEARNERS.items()
    ),
    *(
        ahead(
            *_RESOLUTION,
            _BREAKS,
            f"lower resolution breaks standard Q: it ends lower by a wide margin at {world}",
            term("120", "standard_q"),
            term(world, "standard_q"),
            MUCH_MORE,
        )
        for world in ("16×11", "8×6")
    ),
    *(
        ahead(
            *_RESOLUTION,
            _HURTS,
            f"three skills from the start end significantly lower at {world}",
            term("120", "hierarchical_3"),
            term(world, "hierarchical_3"),
            MUCH_MORE,
        )
        for world in ("16×11", "8×6")
    ),
    *(
        ahead(
            *_RESOLUTION,
            _LEAVES,
            f"lower resolution leaves timed working: it ends close to 24×18 at {world}",
            term("120", "timed"),
            term(world, "timed"),
            CLOSE,
        )
        for world in ("16×11", "8×6")
    ),
    *(
        ahead(
            *_RESOLUTION,
            _LEAVES,
            f"timed ends above {name} by a wide margin at {world}",
            term(world, "timed"),
            term(world, other),
            MUCH_MORE,
        )
        for world in ("16×11", "8×6")
        for other, name in _OTHER_LEARNERS.items()
    ),
)


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
    return estimates.contrast(terms, rng)
