"""The thesis's experiments as places: its worlds, its learners, and what it holds them against."""

import json
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

from app.documents import presets
from app.experiments.record import Record
from app.results.findings import Place
from app.results.read import Group
from learners.spec import RunSpec

WORLDS: Mapping[str, Mapping[str, int]] = {
    "120": {},
    "60": {"size": 60},
    "150": {"size": 150},
    "16×11": {"n_directions": 16, "n_distances": 11},
    "8×6": {"n_directions": 8, "n_distances": 6},
    "16×11 selection": {
        "n_directions": 16,
        "n_distances": 11,
        "skill_n_directions": 24,
        "skill_n_distances": 18,
    },
    "8×6 selection": {
        "n_directions": 8,
        "n_distances": 6,
        "skill_n_directions": 24,
        "skill_n_distances": 18,
    },
}
"""By name: what is not as in the standard world. Of coarse sensors there are both readings of
section 4.3.3: those of selection and skills, or those of the selection alone."""
WORLD_TITLES: Mapping[str, str] = {
    "120": "grid 120 × 120, sensors 24 × 18",
    "60": "grid 60 × 60, sensors 24 × 18",
    "150": "grid 150 × 150, sensors 24 × 18",
    "16×11": "grid 120 × 120, sensors 16 × 11",
    "8×6": "grid 120 × 120, sensors 8 × 6",
    "16×11 selection": "grid 120 × 120, selection 16 × 11",
    "8×6 selection": "grid 120 × 120, selection 8 × 6",
}
FIGURES: Mapping[str, tuple[str, Sequence[str]]] = {
    "figure_4_1": ("Figure 4.1: performance in the standard environment", ("120",)),
    "figure_4_2": ("Figure 4.2: scaling with environment size", ("60", "120", "150")),
    "figure_4_3": ("Figure 4.3: scaling with state resolution", ("120", "16×11", "8×6")),
    "figure_4_3_selection": (
        "Figure 4.3 as well: scaling with the resolution of the selection alone",
        ("120", "16×11 selection", "8×6 selection"),
    ),
}
"""By name: title and worlds."""


class Learner(NamedTuple):
    """A learner of a place."""

    title: str
    preset: str
    changes: Mapping[str, Any] = {}
    """What is not as in the shipped preset, by dotted key."""


LEARNERS: Mapping[str, Learner] = {
    "timed": Learner("timed hierarchical Q, 3 skills", "timed"),
    "hierarchical_3": Learner("hierarchical Q, 3 skills", "hierarchical_3"),
    "standard_q": Learner("standard Q", "standard_q"),
    "hierarchical_2": Learner("hierarchical Q, 2 skills", "hierarchical_2"),
    "hierarchical_2, alpha 0.6": Learner(
        "hierarchical Q, 2 skills, its selection learning at 0.6",
        "hierarchical_2",
        {"learner.alpha": 0.6},
    ),
    "standard_q, hopeful": Learner(
        "standard Q that starts from hope and tries nothing at random",
        "standard_q",
        {
            "learner.alpha": 0.6,
            "learner.epsilon": 0.0,
            "learner.gamma": 0.99,
            "learner.initial_q": 50.0,
        },
    ),
    "timed, no freeze": Learner(
        "timed, without freeze",
        "timed",
        {
            "schedule.skills.approach.freeze": 0,
            "schedule.skills.circle_clockwise.freeze": 0,
            "schedule.skills.avoid.freeze": 0,
        },
    ),
    "timed, no episodes": Learner(
        "timed, without explorations", "timed", {"schedule.episodes": []}
    ),
    "timed, no timers": Learner(
        "timed, all skills from the start",
        "timed",
        {
            "schedule.skills": {},
            "schedule.episodes.0.at": 12_000,
            "schedule.episodes.1.at": 14_500,
        },
    ),
    "timed, joined together": Learner(
        "timed, circle and avoid introduced together and explored in turn",
        "timed",
        {
            "schedule.skills.avoid.at": 12_000,
            "schedule.episodes.0.at": 12_000,
            "schedule.episodes.1.at": 14_500,
        },
    ),
    "timed, all at once": Learner(
        "timed, all skills introduced at the start",
        "timed",
        {"schedule.skills.circle_clockwise.at": 0, "schedule.skills.avoid.at": 0},
    ),
    "timed, unsafe": Learner(
        "timed, without safe introduction", "timed", {"schedule.safe_introduction": False}
    ),
    "timed, avoid at 0.95": Learner(
        "timed, avoid explored as often as circle",
        "timed",
        {"schedule.episodes.1.probability": 0.95},
    ),
    "timed, early": Learner(
        "timed, skills at trials 1,500 and 3,000",
        "timed",
        {"schedule.skills.circle_clockwise.at": 1_500, "schedule.skills.avoid.at": 3_000},
    ),
    "timed, late": Learner(
        "timed, skills at trials 18,000 and 24,000",
        "timed",
        {"schedule.skills.circle_clockwise.at": 18_000, "schedule.skills.avoid.at": 24_000},
    ),
}
"""By name: the thesis's four, which are run in its worlds, and variants that some of its sentences
speak of, which the shipped experiments run in some of them."""
LEARNER_TITLES: Mapping[str, str] = {
    name: learner.title for name, learner in LEARNERS.items() if not learner.changes
}
"""Of the thesis's four."""

Placed = Mapping[Place, Sequence[Record]]
"""Runs by where in the thesis's experiments they belong."""

_IDENTITY = ("world", "learner", "schedule", "trials")
"""Settings by which a run belongs to a place."""


def title_of(place: Place) -> str:
    """A place in words."""
    world, learner = place
    return f"{LEARNERS[learner].title}, {WORLD_TITLES[world]}"


def settings_of(place: Place) -> Mapping[str, Any]:
    """All settings of the runs of a place, as JSON has them."""
    world, name = place
    learner = LEARNERS[name]
    found = presets.load(learner.preset).model_dump(mode="json")
    found["world"] |= WORLDS[world]
    for key, value in learner.changes.items():
        *path, last = (int(part) if part.isdecimal() else part for part in key.split("."))
        part: Any = found
        for step in path:
            part = part[step]
        part[last] = value
    return RunSpec.model_validate(found).model_dump(mode="json")


def place_of(run: Record) -> Place | None:
    """Where in the thesis's experiments a run belongs, if it is one of them.

    What it was planned for beyond its trials makes no difference, nor which seed it has.
    """
    # Of runs that end once they have learned enough, the good ones are short: selected by outcome.
    if run.origin.limited:
        return None
    return _places().get(_identity(run.settings))


@cache
def _places() -> Mapping[str, Place]:
    """Places by the identity of their settings."""
    every = [(world, learner) for learner in LEARNERS for world in WORLDS]
    return {_identity(settings_of(place)): place for place in every}


def _identity(settings: Mapping[str, Any]) -> str:
    return json.dumps([settings.get(key) for key in _IDENTITY], sort_keys=True)


def placed_of(groups: Iterable[Group]) -> dict[Place, list[Record]]:
    """Runs of the thesis's experiments among groups, each once.

    Where experiments differ in the horizon that they state, a place has the runs of those with the
    longest: to take of all runs those that happen to be long enough would be to choose by outcome.
    """
    found: dict[Place, list[Record]] = {}
    for group in groups:
        for run in group.runs:
            place = place_of(run)
            if place is not None:
                found.setdefault(place, []).append(run)
    return {place: _planned_longest(runs) for place, runs in found.items()}


def _planned_longest(runs: Sequence[Record]) -> list[Record]:
    longest = max(run.origin.horizon or 0 for run in runs)
    planned = [run for run in runs if (run.origin.horizon or 0) == longest]
    # The standard world is in all three experiments, with the same seeds.
    by_seed: dict[int, Record] = {}
    for run in planned:
        by_seed.setdefault(run.seed, run)
    return list(by_seed.values())
