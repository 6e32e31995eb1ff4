"""What a class costs in which each has a learner of their own: how soon a tap is answered.

The phones read every frame and draw nothing, in a process of their own; each has its learner learn
at the fastest level, and taps. The presenter's learner learns at full speed meanwhile; its rate is
compared with that while nobody looks, in turns in the same process.
"""

import json
import statistics
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from app.audience.audience import Audience
from app.live.requests import Play, StartAgain
from app.live.session import Session
from benchmarks.clients import clients
from benchmarks.load import percentile
from benchmarks.page import TRIALS, clients_of, opened_lab, page_rate, wait_until
from learners.names import MAX_TRIALS
from learners.spec import RunSpec

READ_S = 10.0
"""For so long they tap."""
TAPS_PER_S = 0.5
"""Of each."""
_CONNECT_S = 60.0


def measure_own(
    spec: RunSpec,
    preset: str,
    presets: Mapping[str, RunSpec],
    n_seats: int,
    repetitions: int,
    progress: Callable[[str], None],
) -> dict[str, Any]:
    """What so many own learners cost, and how they fare.

    Returns:
        ``{"seats": N, "tap_ms": {"p50", "p95"}, "steps_per_s_each", "learner_share"}``: the
        milliseconds from a tap to what came of it at the page, over all repetitions, while all of
        them and the presenter's learner learn; the steps a second of each that is to make 100,000,
        the median; the presenter's rate as a share of that with nobody, the median.
    """
    spec = spec.model_copy(update={"trials": TRIALS})
    took_ms: list[float] = []
    steps_per_s: list[float] = []
    shares: list[float] = []
    audiences: list[Audience] = []

    def opens_stand(session: Session) -> Audience:
        audiences.append(Audience(session.past_of, "127.0.0.1", 0, most=10_000, has_own=True))
        return audiences[-1]

    with (
        opened_lab(spec, preset, presets, opens_stand) as (session, lab),
        clients_of(lab, 1),
    ):
        (audience,) = audiences
        for repetition in range(repetitions):
            progress(f"no seats: {repetition + 1} of {repetitions}")
            alone = page_rate(session, spec, preset, 0)
            progress(f"{n_seats} seats: {repetition + 1} of {repetitions}")
            with _phones_of(audience, n_seats) as phones:
                shares.append(page_rate(session, spec, preset, 0) / alone)
                taps, each = _tapped(session, spec, preset, audience, phones)
                took_ms += taps
                steps_per_s.append(each)
    took_ms.sort()
    return {
        "seats": n_seats,
        "tap_ms": {"p50": percentile(took_ms, 50), "p95": percentile(took_ms, 95)},
        "steps_per_s_each": round(statistics.median(steps_per_s)),
        "learner_share": round(statistics.median(shares), 3),
    }


@contextmanager
def _phones_of(audience: Audience, n_seats: int) -> Iterator[subprocess.Popen[str]]:
    """The process of so many phones, once each has a learner that learns."""

    def learning() -> int:
        return 0 if audience.own is None else audience.own.playing

    with clients("own_client", audience.watchers.port, n_seats) as phones:
        wait_until(lambda: learning() == n_seats, f"{n_seats} phones did not come")
        yield phones
    wait_until(lambda: audience.n_watchers == 0, "phones that have left are still there")
    # Their learners are no burden to what is measured next.
    assert audience.seats is not None
    audience.seats.forget()
    wait_until(
        lambda: audience.own is not None and audience.own.learners == 0, "learners are still there"
    )


def _tapped(
    session: Session,
    spec: RunSpec,
    preset: str,
    audience: Audience,
    phones: subprocess.Popen[str],
) -> tuple[list[float], float]:
    """Milliseconds that taps took while all learn, and the steps a second of each meanwhile."""
    assert audience.owners is not None
    endless = spec.model_copy(update={"trials": MAX_TRIALS})
    session.submit(StartAgain(endless, preset, 0))
    ticket = session.submit(Play())
    session.wait_for(lambda status: status.answered >= ticket, _CONNECT_S)
    # As the presenter has begun something else, so have they.
    wait_until(lambda: audience.own is not None and not audience.own.playing, "they go on")

    def told(line: str) -> dict[str, Any]:
        assert phones.stdin is not None
        assert phones.stdout is not None
        phones.stdin.write(f"{line}\n")
        phones.stdin.flush()
        answer = phones.stdout.readline()
        if not answer:
            raise RuntimeError("the phones ended before they had tapped")
        return json.loads(answer)

    told("begin")
    before, began_s = audience.owners.steps_made, time.perf_counter()
    taps = told(f"{READ_S} {TAPS_PER_S}")
    made, took_s = audience.owners.steps_made - before, time.perf_counter() - began_s
    return taps["took_ms"], made / took_s / taps["seats"]
