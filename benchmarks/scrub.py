"""What walking in the past gives, and what it costs: moments a second, and the learner's share.

Moments at random places of the first ten million steps are wished, made and painted one after the
other, while the learner goes on at full speed. Its rate meanwhile is compared with its rate without
all this, in turns in the same run, so that it does not count how far that is.

What it costs that there is a past at all, whether or not anybody looks at it:
``python -m benchmarks.scrub``.
"""

import statistics
import threading
import time
from collections.abc import Callable

import numpy as np

from app.documents import presets
from app.live.past import Budget, Past
from app.live.places import Place
from app.live.session import Session
from app.live.worker import FULL_SPEED
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.util.machine import share_among_threads
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.spec import RunSpec

STEPS = 10_000_000
"""Of the run, among which the moments lie."""
TURN_S = 0.2
"""For so long one scrubs, or does not: so short that no run comes to its end meanwhile."""
TURNS = 3
"""Of either kind in a repetition, each time in another run."""
PATIENCE_S = 60.0

_KEPT_STEPS = 20_000_000
_SLICE_STEPS = 200_000


def measure_scrub(
    spec: RunSpec, preset: str, repetitions: int, progress: Callable[[str], None]
) -> dict[str, float]:
    """What walking in the past gives and costs.

    Returns:
        ``{"moments_per_s", "p95_ms", "learner_share"}``: moments that were painted in a second; the
        milliseconds from a wish to its picture within which 95 % of them are there; the learner's
        rate as a share of that beside nobody who scrubs, the median.

    Raises:
        RuntimeError: the learner stopped, or a moment could not be made.
    """
    share_among_threads()
    endless = spec.model_copy(update={"trials": MAX_TRIALS})
    rng = np.random.default_rng(0)
    took_s: list[float] = []
    shares: list[float] = []
    for turn in range(TURNS * repetitions):
        progress(f"scrubbing: {turn + 1} of {TURNS * repetitions}")
        session = Session(endless, preset, turn, FULL_SPEED, playing=True)
        session.start()
        try:
            session.wait_for(lambda status: status.snapshot.step >= STEPS, PATIENCE_S)
            rates: dict[bool, float] = {}
            # Which comes first changes, since a learner's rate does with what it knows.
            for scrubs in (turn % 2 == 0, turn % 2 == 1):
                rates[scrubs] = _rate(session, rng, took_s if scrubs else None)
            shares.append(rates[True] / rates[False])
        finally:
            session.stop()
    return {
        "moments_per_s": round(len(took_s) / sum(took_s), 1),
        "p95_ms": round(1e3 * float(np.percentile(took_s, 95)), 1),
        "learner_share": round(statistics.median(shares), 3),
    }


def _rate(session: Session, rng: np.random.Generator, took_s: list[float] | None) -> float:
    """Steps that the learner makes in a second, while somebody scrubs or nobody does."""
    line = session.status.snapshot.generation
    past = session.past_of(line)
    assert past is not None
    first, started_s = past.end_step, time.perf_counter()
    # On a busy machine the learner may have to wait for its turn.
    while time.perf_counter() - started_s < TURN_S or past.end_step == first:
        if took_s is None:
            time.sleep(TURN_S)
        else:
            took_s.append(_look(session, Place(line, int(rng.integers(STEPS)))))
        status = session.status
        if status.finished or status.error is not None:
            raise RuntimeError(status.error or "the learner came to its end while it was measured")
    return (past.end_step - first) / (time.perf_counter() - started_s)


def _look(session: Session, place: Place) -> float:
    """Seconds from a wish to its picture."""
    found = threading.Event()
    session.moments.call_when_found(found.set)
    started_s = time.perf_counter()
    session.moments.want("scrub", place)
    found.wait(PATIENCE_S)
    made = session.moments.found("scrub")
    if made is None or made.step != place.step:
        raise RuntimeError(session.moments.fault("scrub") or "a moment was not made in time")
    LAYERS["value"].paint(made, Look(), Extras())
    return time.perf_counter() - started_s


def share_beside_keeping(spec: RunSpec, repetitions: int) -> float:
    """The learner's rate while its past is kept, as a share of its rate without: the median."""
    _rate_keeping(spec, keeps=True)
    shares: list[float] = []
    for _ in range(repetitions):
        before, kept, after = (_rate_keeping(spec, keeps) for keeps in (False, True, False))
        shares.append(2 * kept / (before + after))
    return statistics.median(shares)


def _rate_keeping(spec: RunSpec, keeps: bool) -> float:
    """Steps that the learner makes in a second of its thread's time."""
    run = Run(spec, 0)
    past = Past(run, Budget())
    started_s = time.thread_time()
    while run.step < _KEPT_STEPS:
        run.advance(_SLICE_STEPS, until_trial=MAX_TRIALS)
        if keeps:
            past.note(run)
    return run.step / (time.thread_time() - started_s)


if __name__ == "__main__":
    share = share_beside_keeping(presets.load("timed"), 9)
    print(f"while its past is kept, the learner keeps {share:.3f} of its rate")
