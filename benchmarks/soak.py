"""Whether memory stays as it is while people walk in the past: ``python -m benchmarks.soak``.

For some minutes a session learns, begins again and goes back, with a journal, while viewers drag
and jump through its past and paint what they see, and branches, names and marks come and go. Once a
minute the memory is printed, and a moment is compared with a run that is stopped there. The program
ends with 1 if checkpoints took more than they may, if the rest has grown by more than
``MOST_GROWN_MB`` since the first minute, if a moment was not exact, or if anything failed.
"""

import argparse
import gc
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from app.documents import presets
from app.live.kept import begun
from app.live.past import MOST_BYTES
from app.live.places import Place
from app.live.requests import (
    AddMark,
    Branch,
    BringBack,
    DeleteLine,
    GoBack,
    MakeLive,
    NameLine,
    Play,
    RemoveMark,
    Request,
    SetSpeed,
    StartAgain,
)
from app.live.session import Session
from app.live.worker import FULL_SPEED
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.util.machine import give_back_memory, resident_mb, share_among_threads
from learners.commands import Command, Explore, FreezeSelection, Introduce, SetParameter
from learners.kernel.state import digest
from learners.run import replay

VIEWERS = 3
SECONDS = 60.0
"""From one line that is printed to the next."""
MOST_GROWN_MB = 40.0
"""Beside checkpoints: logs of as many lines as there are just then, and what lies between things of
many sizes that come and go."""

_FRAME_S = 0.04
_LOOKS = tuple(Look(layer=layer) for layer in LAYERS)
_SPEEDS = (50_000.0, 1_000_000.0, FULL_SPEED)
_TRIALS = 100_000
_COMMANDS: tuple[Command, ...] = (
    Introduce("avoid", 300),
    Explore("approach", 2_000, 0.3),
    FreezeSelection(True),
    SetParameter("learner.epsilon", 0.2),
    SetParameter("world.vision_radius", 12.0),
    SetParameter("world.capture_reward", 50.0),
)


class Soak:
    """People at work, by chance."""

    def __init__(self, session: Session, seed: int) -> None:
        self.session = session
        self.faults: list[str] = []
        self._rng = np.random.default_rng(seed)
        self._at: list[Place | None] = [None] * VIEWERS
        self._deleted: list[int] = []

    def frame(self) -> None:
        """What all viewers do in one frame, and now and then something else."""
        for viewer in range(VIEWERS):
            self._look(viewer)
        if self._rng.random() < _FRAME_S:
            self.session.submit(self._anything())
        self._begin_again_at_the_end()

    def check(self) -> None:
        """Compare a moment of the live run with a run that is stopped there.

        Raises:
            RuntimeError: they differ.
        """
        snapshot = self.session.status.snapshot
        past = self.session.past_of(snapshot.generation)
        assert past is not None
        made = past.run_at(int(self._rng.integers(snapshot.step + 1)))
        assert made is not None
        again = replay(made.preset, made.seed, made.journal, made.step)
        if digest(made.state) != digest(again.state):
            raise RuntimeError(f"step {made.step:,} is not what a run stopped there is")

    def _look(self, viewer: int) -> None:
        status, moments = self.session.status, self.session.moments
        place, chance = self._at[viewer], self._rng.random()
        if (
            place is None
            or all(line.number != place.line for line in status.lines)
            or chance < 0.02
        ):
            lines = status.lines
            line = lines[int(self._rng.integers(len(lines)))]
            place = Place(line.number, int(self._rng.integers(line.until_step + 1)))
        elif chance < 0.03:
            # Back to what is live, and gone.
            moments.forget(viewer)
            self._at[viewer] = None
            return
        drawn = int(place.step + self._rng.normal(0, 30_000))
        self._at[viewer] = place = Place(place.line, max(drawn, 0))
        moments.want(viewer, place)
        found, fault = moments.found(viewer), moments.fault(viewer)
        if fault is not None and "not here" not in fault:
            self.faults.append(fault)
        if found is not None:
            look = _LOOKS[int(self._rng.integers(len(_LOOKS)))]
            LAYERS[look.layer].paint(found, look, Extras())

    def _anything(self) -> Request:
        """Something to ask for; whether it can be done is not looked at."""
        status = self.session.status
        lines, marks = status.lines, status.marks
        line = lines[int(self._rng.integers(len(lines)))]
        place = Place(line.number, int(self._rng.integers(line.until_step + 1)))
        branch = Branch(place, _COMMANDS[int(self._rng.integers(len(_COMMANDS)))])
        mark = AddMark(place, "something happened " * 4)
        makers: list[Callable[[], Request]] = [
            lambda: branch,
            lambda: branch,
            lambda: branch,
            lambda: self._delete(line.number),
            lambda: self._delete(line.number),
            lambda: BringBack(self._deleted.pop() if self._deleted else -1),
            lambda: NameLine(line.number, f"line {line.number}"),
            lambda: mark,
            lambda: RemoveMark(marks[0].number) if marks else mark,
            lambda: MakeLive(line.number),
            Play,
            lambda: SetSpeed(_SPEEDS[int(self._rng.integers(len(_SPEEDS)))]),
        ]
        return makers[int(self._rng.integers(len(makers)))]()

    def _delete(self, line: int) -> Request:
        self._deleted = [*self._deleted[-20:], line]
        return DeleteLine(line)

    def _begin_again_at_the_end(self) -> None:
        status = self.session.status
        if status.error is not None:
            self.faults.append(status.error)
        if status.finished and self._rng.random() < 0.02:
            snapshot = status.snapshot
            again = StartAgain(snapshot.preset_spec, "timed", snapshot.seed + 1)
            goes_back = status.aside is not None and self._rng.random() < 0.3
            self.session.submit(GoBack() if goes_back else again)
            self.session.submit(Play())
        elif not status.playing and not status.finished:
            self.session.submit(Play())


def main(words: Sequence[str] | None = None) -> int:
    """Print the memory once a minute; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args(words)
    share_among_threads()
    spec = presets.load("timed", [f"trials={_TRIALS}"])
    rest_mb: list[float] = []
    most_mb = 0.0
    with tempfile.TemporaryDirectory() as folder:
        journal = begun(Path(folder), "timed", asked.seed)
        session = Session(spec, "timed", asked.seed, FULL_SPEED, playing=True, journal=journal)
        session.start()
        soak = Soak(session, asked.seed)
        try:
            for minute in range(1, asked.minutes + 1):
                ends_s = time.perf_counter() + SECONDS
                while time.perf_counter() < ends_s:
                    started_s = time.perf_counter()
                    soak.frame()
                    time.sleep(max(_FRAME_S - (time.perf_counter() - started_s), 0.0))
                soak.check()
                gc.collect()
                give_back_memory()
                held_mb, checkpoints_mb = resident_mb(), session.budget.nbytes / 1e6
                rest_mb.append(held_mb - checkpoints_mb)
                most_mb = max(most_mb, checkpoints_mb)
                print(_stand(session, minute, held_mb, checkpoints_mb), flush=True)
                if soak.faults:
                    print(f"failed: {soak.faults[0]}", file=sys.stderr)
                    return 1
        finally:
            session.stop()
            journal.close()
    grown_mb = max(rest_mb) - rest_mb[0]
    print(
        f"beside checkpoints, grown by {grown_mb:.0f} MB since the first minute;"
        f" allowed: {MOST_GROWN_MB:.0f}"
    )
    return 0 if grown_mb <= MOST_GROWN_MB and most_mb <= MOST_BYTES / 1e6 else 1


def _stand(session: Session, minute: int, held_mb: float, checkpoints_mb: float) -> str:
    status = session.status
    return (
        f"minute {minute}: {held_mb:.0f} MB, of which {checkpoints_mb:.0f} are checkpoints (of"
        f" {MOST_BYTES / 1e6:.0f}); run {session.n_runs},"
        f" {len(status.lines)} lines, {len(status.marks)} marks, trial {status.snapshot.trial:,}"
    )


if __name__ == "__main__":
    sys.exit(main())
