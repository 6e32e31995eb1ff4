"""What people have done since a card was entered, as far as a lesson can ask for it."""

from collections.abc import Iterable
from typing import Final

import numpy as np

from app.documents.lesson_grammar import Opened
from app.explain.cell import sensed
from app.lessons.measures import Columns, Deeds, Done, Looked, Racing
from app.lessons.regions import masks
from app.lessons.words import Words
from app.live.race import Race
from app.live.requests import (
    AddMark,
    Branch,
    Play,
    Request,
    RunTo,
    StartAgain,
    StepOnce,
    TrialOnce,
)
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.results.service import Service
from sim.spec import WorldSpec
from sim.world import cell_at

_NAMES: Final[tuple[tuple[type[object], str], ...]] = (
    (StepOnce, "step"),
    (TrialOnce, "trial"),
    (Play, "play"),
    (RunTo, "run_to"),
    (AddMark, "mark"),
    (StartAgain, "start_again"),
    (Branch, "fork"),
)
"""What requests are called in lessons."""
_MOST: Final = 64
"""Of a card; more of them say nothing new."""


class Doings:
    """Of one card of one lesson. The render loop alone has to do with it."""

    def __init__(self, session: Session, service: Service) -> None:
        self._session, self._service = session, service
        self._done: tuple[Done, ...] = ()
        self._opened: tuple[Looked, ...] = ()
        self._race: tuple[Racing, ...] = ()
        self._raced: tuple[Race | None, int] = (None, -1)
        """A race, and how far it was when it was last looked at."""
        self._experiments: dict[str, dict[str, Columns]] = {}
        self._n_results = (-1, -1)
        self._former = (session.race, service.standing)
        """The race and the experiment that there were when the card was entered, as they stood."""
        self._made: Deeds | None = None

    def begin(self) -> None:
        """Another card is shown: nothing has been done on it."""
        self._done, self._opened, self._made = (), (), None
        self._former = (self._session.race, self._service.standing)

    def note_request(self, request: Request, step: int) -> None:
        """Something was asked for when so many steps were made."""
        name = next((name for kind, name in _NAMES if isinstance(request, kind)), None)
        if name is not None:
            self.note(name, step)

    def note(self, what: str, step: int) -> None:
        """Something was done."""
        if len(self._done) < _MOST and all(done.what != what for done in self._done):
            self._done, self._made = (*self._done, Done(what, step)), None

    def note_opened(self, opened: Iterable[Opened], step: int) -> None:
        """Something was opened."""
        known = {looked.opened for looked in self._opened}
        new = [Looked(one, step) for one in opened if one not in known]
        if new and len(self._opened) < _MOST:
            self._opened, self._made = (*self._opened, *new), None

    def experiment(self, words: Words) -> str | None:
        """How far an experiment is that is being run, in words; None if none is."""
        standing = self._service.standing
        if standing is None or not standing.running:
            return None
        progress = standing.progress
        if progress is None:
            return words.say("busy.experiment")
        return words.counted("busy.experiment_runs", progress.total, done=progress.done)

    def deeds(self) -> Deeds:
        """All of it, with the race and the experiment that there are; it is the same object until
        something is new."""
        self._look_at_race()
        self._look_at_results()
        if self._made is None:
            self._made = Deeds(
                self._done, self._opened, self._race, experiments=dict(self._experiments)
            )
        return self._made

    def _look_at_race(self) -> None:
        race = self._session.race
        stand = (race, -1 if race is None else race.status.step)
        if stand == self._raced:
            return
        self._raced, self._made = stand, None
        if race is not None and race is not self._former[0]:
            # The page with runs side by side asks the session by itself.
            self.note("race", self._session.status.snapshot.step)
        self._race = () if race is None else tuple(_racing(race))

    def _look_at_results(self) -> None:
        standing = self._service.standing
        if standing is None:
            return
        former = self._former[1]
        if former is None or standing.gatherer is not former.gatherer:
            # From wherever in the page it was begun.
            self.note("experiment", self._session.status.snapshot.step)
        runs = standing.gatherer.gathering().runs
        key = (id(standing.gatherer), len(runs))
        if key == self._n_results:
            return
        self._n_results, self._made = key, None
        found: dict[str, dict[str, list[float]]] = {}
        for _, record in runs:
            columns = found.setdefault(record.variant, {})
            for name, value in record.values.items():
                if np.isfinite(value):
                    columns.setdefault(name, []).append(value)
        self._experiments[standing.experiment.name] = dict(found)


def _racing(race: Race) -> Iterable[Racing]:
    status = race.status
    for place, entry in enumerate(status.entries):
        past, snapshot = race.past(place), status.snapshots[place]
        logs, trial = past.logs, min(snapshot.trial, past.end_trial)
        yield Racing(
            entry.name if entry.line is not None else entry.preset,
            logs.log_reward[:trial],
            np.cumsum(logs.log_steps[:trial], dtype=np.int64),
            snapshot.step,
            status.stands[place] in ("finished", "known", "gone"),
        )


def layer_opened(key: str) -> Opened:
    """That a layer is seen."""
    return Opened("layer", layer=key)


def opened_at(cell: tuple[int, int], snapshot: Snapshot, heading: int) -> list[Opened]:
    """What is opened where a cell of the board is looked into: every region that it lies in.

    Args:
        cell: its column and row.
        snapshot: the moment.
        heading: where the prey looks in the picture.
    """
    world: WorldSpec = snapshot.spec.world
    ring, direction = sensed(snapshot, cell_at(snapshot.world, *cell))
    turned = (direction - heading * world.n_directions // 8) % world.n_directions
    regions = masks(world)
    opened = [Opened("why")]
    return opened + [Opened("cell", region=name) for name in regions if regions[name][ring, turned]]
