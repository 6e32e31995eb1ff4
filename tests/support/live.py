"""A lab in this process: a session with its page, which tests ask what is true."""

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from app.audience.audience import Audience
from app.documents import experiments, presets
from app.documents.experiments import Experiment
from app.explain.branches import name_of
from app.live import snapshot
from app.live.kept import begun
from app.live.places import Place
from app.live.requests import Request, RunTo, SetSpeed, StartAgain
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.lab import Lab
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import ALL, Look
from app.picture.multiples import all_headings
from app.results.service import Standing
from learners.commands import Command
from learners.run import replay
from learners.spec import RunSpec
from tests.support.person import Person

PATIENCE_S = 60.0
"""How long to wait for what must happen; reaching it is a failure."""
SEED = 3
FOUR = ("timed", "hierarchical_2", "hierarchical_3", "standard_q")
"""Presets that are offered."""

SMALL = """
description: Two learners in a small world.
presets: [timed, standard_q]
set: {world.size: 30}
trials: 600
seeds: 5
"""


def preset_of(name: str = "timed", *settings: str) -> RunSpec:
    """A shipped preset in a small world."""
    return presets.load(name, ["world.size=40", *settings])


def small_experiment(text: str = SMALL, n_seeds: int | None = None) -> Experiment:
    """An experiment that is called small."""
    return experiments.parse(text, "small.yaml", None, n_seeds)


def until(is_so: Callable[[], bool]) -> None:
    """Wait until something is so of which nobody is told."""
    deadline = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < deadline
        time.sleep(0.005)


class LiveLab:
    """A session with its page, served by this process; paused until somebody plays."""

    dpr = 0.5
    """Pixels of the board's picture for each of the screen, in either direction.

    A cell has some ten of the screen, so these are enough to be sure of its colour; and drawing,
    which is done in software, takes about half as long as for all of them.
    """

    def __init__(
        self,
        spec: RunSpec,
        speed: float,
        results: Path,
        opening: bool = False,
        sessions: Path | None = None,
        audience: bool = False,
        classroom: bool = False,
        own: bool = False,
    ) -> None:
        """With an ``opening`` the learner begins as people see it, with slow hunts once a page is
        there. With a folder of ``sessions`` this one is kept there. With an ``audience`` there is a
        port for those who only look, with a ``classroom`` one for those who answer as well, and
        with ``own`` for those who have learners of their own.
        """
        self.results = results
        """Folder below which experiments leave their results; made when it is needed."""
        # What compiled functions take to be there is not waited for with everything else.
        replay(spec, SEED, [], 1)
        offered = {name: preset_of(name) for name in FOUR}
        journal = None if sessions is None else begun(sessions, "timed", SEED)
        self.session = Session(
            spec, "timed", SEED, speed, False, opening, journal=journal, name_of=name_of
        )
        known = {**offered, "timed": spec}
        self.audience: Audience | None = None
        if audience or classroom or own:
            self.audience = Audience(
                self.session.past_of, "127.0.0.1", 0, is_class=classroom, has_own=own
            )
        self.lab = Lab(
            self.session,
            known,
            "127.0.0.1",
            0,
            results,
            waits=opening,
            sessions=sessions,
            stand=self.audience,
        )
        self.gone = threading.Event()
        """Set when a page has left."""
        self.lab.server.on_client_disconnect(lambda _: self.gone.set())
        self._drawing = threading.Thread(target=self.lab.serve, name="drawing")
        self.session.start()
        self._drawing.start()

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"{self.lab.url}/?fixedDpr={self.dpr:g}"

    def ask(self, *requests: Request) -> Status:
        """The status in which all these requests have been answered, and all before them."""
        harmless = SetSpeed(self.session.status.speed)
        ticket = max(self.session.submit(request) for request in requests or [harmless])
        return self.wait_for(lambda status: status.answered >= ticket)

    def begin(self, preset: str, *settings: str, speed: float, results: Path) -> None:
        """Another run from its beginning, in which nothing was done; paused."""
        again = StartAgain(preset_of(preset, *settings), preset, SEED, paused=True)
        self.ask(SetSpeed(speed), again)
        self.results = self.lab.service.root = results

    def go_to_trial(self, trial: int) -> Status:
        """Learn, and stand still at the start of a trial."""
        status = self.session.status
        if status.snapshot.trial >= trial:
            return status
        self.ask(RunTo(trial))
        return self.wait_for(lambda status: status.snapshot.trial >= trial and not status.playing)

    def wait_for(self, condition: Callable[[Status], bool]) -> Status:
        """The first status that meets a condition."""
        return self.session.wait_for(condition, PATIENCE_S)

    def place_of(self, trial: int) -> Place:
        """The beginning of a trial of the live run."""
        line = self.session.status.snapshot.generation
        past = self.session.past_of(line)
        assert past is not None
        return Place(line, past.step_of_trial(trial))

    def colours(
        self,
        look: Look | None = None,
        moment: Snapshot | None = None,
        extras: Extras = Extras(),  # noqa: B008  (it never changes)
    ) -> np.ndarray:
        """Colours of all cells as a page of that look must have them, ``(y * x, 3) uint8``.

        It looks at what is live, unless a moment is given.
        """
        look = look or Look()
        shown, layer = moment or self.session.status.snapshot, LAYERS[look.layer]
        if look.frame == ALL:
            return all_headings(shown, look, layer, extras).colours
        return layer.paint(shown, look, extras).colours

    def stopped_at(self, step: int, *journal: tuple[int, Command]) -> Snapshot:
        """What the run would be if it had been stopped at a step, made apart from the lab."""
        now = self.session.status.snapshot
        run = replay(now.preset_spec, now.seed, list(journal), step)
        return snapshot.take(run, now.preset, now.generation)

    def look_of(self, browser: int = 0) -> Look:
        """How the browser that came first, second, ... wants to see the board."""
        return self.lab.browsers[browser].look

    def widget(self, label: str) -> Any:
        """What all browsers share, by its label, as the server has it."""
        return Person(self.lab.server.gui).widget(label)

    def expect_value(self, label: str, value: object) -> None:
        """Wait until a widget that all browsers share holds a value."""
        until(lambda: self.widget(label).value == value)

    def run_to_end(self, experiment: Experiment) -> Standing:
        """Run an experiment, and wait until it is over."""
        self.lab.service.start(experiment, workers=2)
        return self.at_end()

    def at_end(self) -> Standing:
        """How an experiment stands once it is over."""
        self.lab.service.wait(PATIENCE_S)
        standing = self.lab.service.standing
        assert standing is not None
        assert not standing.running
        return standing

    def close(self) -> None:
        """End the page and the session."""
        self.lab.close()
        self._drawing.join()
