"""Runs that belong to a place of the thesis's experiments, made up."""

from pathlib import Path

from app.experiments.record import Origin, Record
from app.metrics import NAMES
from app.results import thesis
from app.results.findings import Place

ORIGIN = Origin(Path(), NAMES, limited=False, stop=None)


def run_of(place: Place, seed: int = 0, steps: int = 6_000_000) -> Record:
    """A run of a place."""
    return Record(
        key=f"{place}-{seed}",
        variant="",
        preset=thesis.LEARNERS[place[1]].preset,
        overrides={},
        settings=thesis.settings_of(place),
        seed=seed,
        error="",
        version="1",
        digest="",
        seconds=1.0,
        ended_at="",
        values={"steps": steps, "trials": 50_000},
        arrays="",
        origin=ORIGIN,
    )
