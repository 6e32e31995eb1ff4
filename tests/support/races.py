"""Races in small worlds, whose learners are through in a moment."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from app.documents import presets
from app.live.past import Budget, Past
from app.live.race import Race, RaceStatus
from app.live.racer import Entry
from app.live.snapshot import Snapshot
from learners.kernel.state import digest
from learners.run import Run
from learners.spec import RunSpec

PATIENCE_S = 60.0
"""How long to wait for what must happen; reaching it is a failure."""
SEED = 7


def small(preset: str, *settings: str) -> RunSpec:
    """A preset in a small world, with few trials."""
    return presets.load(
        preset,
        [
            "world.size=30",
            "world.n_directions=16",
            "world.n_distances=6",
            "world.step_limit=60",
            "trials=60",
            *settings,
        ],
    )


def entry(name: str, seed: int = SEED, *settings: str) -> Entry:
    """A run of its own, called as its preset."""
    return Entry(name, name, seed, small(name, *settings))


@contextmanager
def racing(
    entries: Sequence[Entry],
    past_of: Callable[[int], Past | None] = lambda line: None,
    budget: Budget | None = None,
    playing: bool = False,
) -> Iterator[Race]:
    """A race whose thread has begun, and is ended after the test."""
    race = Race(entries, budget or Budget(), past_of, playing=playing)
    race.start()
    try:
        yield race
    finally:
        race.close()


def answered(race: Race, ticket: int) -> RaceStatus:
    """How it stands once something has been answered."""
    return race.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)


def at_rest(race: Race) -> RaceStatus:
    """How it stands once it does."""
    return race.wait_for(lambda status: bool(status.digests), PATIENCE_S)


def over(race: Race) -> RaceStatus:
    """How it stands once the trials of all are over, or it has stopped."""
    return race.wait_for(lambda status: status.finished or status.error is not None, PATIENCE_S)


def alone(entry: Entry, step: int | None = None) -> Run:
    """The same run by itself, at a step or at its end."""
    run = Run(entry.spec, entry.seed)
    run.advance(2**62 if step is None else step)
    return run


def tables(run: Run) -> str:
    """Digest of a run."""
    return digest(run.state)


def snapshots_at(race: Race, step: int) -> tuple[Snapshot, ...]:
    """All at one step, or at an earlier end, made while the caller waits."""
    made = race.moments.made(step)
    assert made is not None
    return made
