"""What the live page costs the learner: its rate with no browser, one and five, as ratios.

The browsers read every frame and draw nothing. Each rate is compared with that of a run of the
same length without a page, measured right before and after in the same process.
"""

import statistics
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from app.live.requests import Play, StartAgain
from app.live.session import Session
from app.live.worker import FULL_SPEED
from app.page.lab import Lab
from app.player.presented import Stand
from benchmarks.clients import clients
from learners.run import Run
from learners.spec import RunSpec

CLIENTS = (0, 1, 5)
SECONDS = 2.0
TRIALS = 400_000
"""Long enough that beginning again does not count."""
_CONNECT_S = 60.0


def rate_alone(spec: RunSpec, seed: int) -> float:
    """Steps per second of a run without a page, over its full number of trials."""
    run = Run(spec, seed)
    started = time.perf_counter()
    run.advance()
    return run.step / (time.perf_counter() - started)


def page_rate(session: Session, spec: RunSpec, preset: str, seed: int) -> float:
    """Steps per second of a session at full speed, over the full number of trials.

    The run begins again until ``SECONDS`` are over; the time from one run to the next counts.
    """
    steps = 0
    started = time.perf_counter()
    while time.perf_counter() - started < SECONDS:
        generation = session.status.snapshot.generation + 1
        session.submit(StartAgain(spec, preset, seed))
        session.submit(Play())
        done = session.wait_for(
            lambda status, wanted=generation: (
                status.finished and status.snapshot.generation == wanted
            ),
            timeout_s=60.0,
        )
        steps += done.snapshot.step
    return steps / (time.perf_counter() - started)


@contextmanager
def opened_lab(
    spec: RunSpec,
    preset: str,
    presets: Mapping[str, RunSpec],
    opens_stand: Callable[[Session], Stand | None] = lambda session: None,
) -> Iterator[tuple[Session, Lab]]:
    """A lab at full speed, with nobody looking yet; it may have a stand for an audience."""
    session = Session(spec, preset, 0, FULL_SPEED, playing=True)
    lab = Lab(session, presets, "127.0.0.1", 0, Path("results"), stand=opens_stand(session))
    session.start()
    drawing = threading.Thread(target=lab.serve, daemon=True)
    drawing.start()
    try:
        yield session, lab
    finally:
        lab.close()
        drawing.join()


@contextmanager
def clients_of(lab: Lab, n_clients: int) -> Iterator[subprocess.Popen[str]]:
    """The process of so many clients that read a lab's page, once all of them do.

    Raises:
        TimeoutError: they did not come in time.
    """
    before = len(lab.browsers)
    with clients("page_client", lab.server.get_port(), n_clients) as readers:
        wait_until(
            lambda: len(lab.browsers) == before + n_clients, f"{n_clients} clients did not connect"
        )
        yield readers
    wait_until(lambda: len(lab.browsers) == before, "clients that have left are still there")


def wait_until(condition: Callable[[], bool], complaint: str) -> None:
    """Wait until something holds.

    Raises:
        TimeoutError: it does not in time; with the complaint.
    """
    deadline = time.perf_counter() + _CONNECT_S
    while not condition():
        if time.perf_counter() > deadline:
            raise TimeoutError(complaint)
        time.sleep(0.05)


def compare_page(
    spec: RunSpec,
    preset: str,
    presets: Mapping[str, RunSpec],
    repetitions: int,
    progress: Callable[[str], None],
) -> dict[str, dict[str, float]]:
    """Ratio of the learner's rate beside a page to its rate alone, by number of clients.

    Returns:
        ``{"clients": {"0": ratio, "1": ratio, "5": ratio}}``, medians over the repetitions.
    """
    rate_alone(spec.model_copy(update={"trials": 10}), 0)
    spec = spec.model_copy(update={"trials": TRIALS})
    ratios: dict[str, float] = {}
    for n_clients in CLIENTS:
        with (
            opened_lab(spec, preset, presets) as (session, lab),
            clients_of(lab, n_clients),
        ):
            measured = []
            for repetition in range(repetitions):
                progress(f"{n_clients} clients: {repetition + 1} of {repetitions}")
                before = rate_alone(spec, 0)
                beside = page_rate(session, spec, preset, 0)
                after = rate_alone(spec, 0)
                measured.append(beside / ((before + after) / 2))
        ratios[str(n_clients)] = statistics.median(measured)
    return {"clients": ratios}
