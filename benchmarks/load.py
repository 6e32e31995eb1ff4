"""What many pages cost: how soon a click shows, what the learner keeps, and the memory it takes.

The pages read every frame and draw nothing, in a process of their own. The learner's rate beside
them is compared with its rate beside one page, in turns in the same process; clicks are made while
it learns at full speed.
"""

import json
import statistics
import subprocess
from collections.abc import Callable, Mapping
from typing import Any

from app.live.requests import StartAgain
from app.live.session import Session
from app.util.machine import resident_mb
from benchmarks.page import TRIALS, clients_of, opened_lab, page_rate
from learners.names import MAX_TRIALS
from learners.spec import RunSpec

ROUNDS, CLICKS = 4, 6
"""Rounds in each repetition, and clicks in each round."""
PATIENCE_S = 60.0


def measure_load(
    spec: RunSpec,
    preset: str,
    presets: Mapping[str, RunSpec],
    n_pages: int,
    repetitions: int,
    progress: Callable[[str], None],
) -> dict[str, Any]:
    """What so many reading pages cost.

    Returns:
        ``{"pages": N, "click_ms": {"p50", "p95", "max"}, "learner_share", "rss_mb"}``: the
        milliseconds from a click to its effect in the page that clicks, over all repetitions; the
        learner's rate as a share of that beside one page, the median; the most memory that the lab
        held, in MB.
    """
    spec = spec.model_copy(update={"trials": TRIALS})
    took_ms: list[float] = []
    shares = []
    most_mb = 0.0
    with opened_lab(spec, preset, presets) as (session, lab):
        for repetition in range(repetitions):
            rates = []
            for n in (1, n_pages):
                progress(f"{n} pages: {repetition + 1} of {repetitions}")
                with clients_of(lab, n) as readers:
                    rates.append(page_rate(session, spec, preset, 0))
                    if n == n_pages:
                        # Before the clicks, whose runs have logs for more trials than any preset.
                        most_mb = max(most_mb, resident_mb())
                        took_ms += clicks(session, spec, preset, readers)
            shares.append(rates[1] / rates[0])
    took_ms.sort()
    return {
        "pages": n_pages,
        "click_ms": {
            "p50": percentile(took_ms, 50),
            "p95": percentile(took_ms, 95),
            "max": took_ms[-1],
        },
        "learner_share": round(statistics.median(shares), 3),
        "rss_mb": round(most_mb, 1),
    }


def clicks(
    session: Session, spec: RunSpec, preset: str, readers: subprocess.Popen[str]
) -> list[float]:
    """Milliseconds that clicks took while the learner learns at full speed."""
    assert readers.stdin is not None
    assert readers.stdout is not None
    endless = spec.model_copy(update={"trials": MAX_TRIALS})
    took_ms: list[float] = []
    for _ in range(ROUNDS):
        # It stands still until the first click, and does not come to its end before the last.
        ticket = session.submit(StartAgain(endless, preset, 0, paused=True))
        session.wait_for(lambda status, wanted=ticket: status.answered >= wanted, PATIENCE_S)
        readers.stdin.write(f"{CLICKS}\n")
        readers.stdin.flush()
        answer = readers.stdout.readline()
        if not answer:
            raise RuntimeError("the pages ended before they had clicked")
        took_ms += json.loads(answer)
    return took_ms


def percentile(ordered: list[float], share: int) -> float:
    """The value that so many of a hundred do not exceed."""
    return ordered[min(-(-share * len(ordered) // 100), len(ordered)) - 1]
