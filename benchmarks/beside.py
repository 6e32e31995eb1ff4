"""What experiments cost the live learner: ``python -m benchmarks.beside [WORKERS]``.

The learner runs at full speed, alone and beside an experiment in the same process, in turns; the
ratio of the two rates is printed, and how fast the experiment went. Alone on the machine, please.
"""

import statistics
import sys
import tempfile
import time
from pathlib import Path

from app.documents import experiments, presets
from app.experiments.runner import Progress
from app.live.requests import StartAgain
from app.live.session import Session
from app.live.worker import FULL_SPEED
from app.results.service import Service
from learners.names import MAX_TRIALS
from learners.spec import RunSpec

ROUNDS = 5
MEASURED_S = 2.0
WARM_UP_S = 0.5
PATIENCE_S = 60.0


def rate_of(session: Session, spec: RunSpec) -> float:
    """Steps per second of a learner that begins anew."""
    ticket = session.submit(StartAgain(spec, "timed", 1))
    session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    time.sleep(WARM_UP_S)
    step, began = session.status.snapshot.step, time.perf_counter()
    time.sleep(MEASURED_S)
    session.wait_for(lambda status: status.snapshot.step > step, PATIENCE_S)
    return (session.status.snapshot.step - step) / (time.perf_counter() - began)


def progress_of(service: Service) -> Progress:
    """How far an experiment is, as soon as it is known.

    Raises:
        TimeoutError: it has not begun in time.
    """
    ends = time.perf_counter() + PATIENCE_S
    while time.perf_counter() < ends:
        standing = service.standing
        if standing is not None and standing.progress is not None:
            return standing.progress
        time.sleep(0.01)
    raise TimeoutError("the experiment did not begin in time")


def main(workers: int) -> None:
    """Measure in turns, and print the median of the ratios."""
    spec = presets.load("timed", [f"trials={MAX_TRIALS}"])
    session = Session(spec, "timed", 1, FULL_SPEED, playing=True)
    session.start()
    session.wait_for(lambda status: status.snapshot.step > 0, PATIENCE_S)
    ratios: list[float] = []
    rates: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(ROUNDS):
            alone = rate_of(session, spec)
            service = Service(Path(folder, str(number)))
            service.start(experiments.load("figure_4_1", 1_000), workers)
            # Beside one that has not begun there is nothing to measure.
            progress_of(service)
            ratios.append(rate_of(session, spec) / alone)
            rates.append(progress_of(service).steps_per_s)
            service.close()
    session.stop()
    print(
        f"{workers} at a time: the learner keeps {statistics.median(ratios):.2f} of its rate"
        f" ({min(ratios):.2f} to {max(ratios):.2f}), the experiment makes"
        f" {statistics.median(rates) / 1e6:.0f} M steps/s"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
