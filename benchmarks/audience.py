"""What an audience costs: the presenter's clicks, the learner's rate, and what each phone is sent.

The watchers read every frame and draw nothing, in a process of their own, and as a class they
answer; the presenter's page is in another, draws nothing either, and clicks. The learner's rate
beside them is compared with its rate beside the presenter alone, in turns in the same process.
"""

import functools
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
from app.player.classroom import Question
from benchmarks.audience_client import OPTIONS
from benchmarks.clients import clients
from benchmarks.load import clicks, percentile
from benchmarks.page import TRIALS, clients_of, opened_lab, page_rate, wait_until
from learners.names import MAX_TRIALS
from learners.spec import RunSpec

READ_S = 5.0
"""For so long at least it is counted what the watchers are sent."""
_TURN_S = 0.25
"""For so long they read at a time."""
_CONNECT_S = 60.0
QUESTION = Question("bench", "choice", "Which?", tuple((value, value) for value in OPTIONS))


def measure_audience(
    spec: RunSpec,
    preset: str,
    presets: Mapping[str, RunSpec],
    n_watchers: int,
    repetitions: int,
    progress: Callable[[str], None],
) -> dict[str, Any]:
    """What so many watchers cost.

    Returns:
        ``{"watchers": N, "click_ms": {"p50", "p95"}, "class_click_ms": {"p50", "p95"},
        "kB_per_s_each", "learner_share"}``: the milliseconds from a click of the presenter to its
        effect in their page, over all repetitions, while the learner learns at full speed; the same
        while each watcher has a seat and answers a question once a second; what each watcher is
        sent meanwhile while nobody clicks, in kB a second, the median; the learner's rate as a
        share of that with no watcher, the median.
    """
    spec = spec.model_copy(update={"trials": TRIALS})
    took_ms: list[float] = []
    class_ms: list[float] = []
    sent: list[float] = []
    shares: list[float] = []
    audiences: list[Audience] = []

    def opens_stand(session: Session) -> Audience:
        audiences.append(Audience(session.past_of, "127.0.0.1", 0, most=10_000, is_class=True))
        return audiences[-1]

    with (
        opened_lab(spec, preset, presets, opens_stand) as (session, lab),
        clients_of(lab, 1) as pages,
    ):
        (audience,) = audiences
        for repetition in range(repetitions):
            progress(f"no watchers: {repetition + 1} of {repetitions}")
            alone = page_rate(session, spec, preset, 0)
            progress(f"{n_watchers} watchers: {repetition + 1} of {repetitions}")
            with _watchers_of(audience, n_watchers) as readers:
                shares.append(page_rate(session, spec, preset, 0) / alone)
                sent.append(_kb_per_s_each(session, spec, preset, readers, n_watchers))
                took_ms += clicks(session, spec, preset, pages)
            progress(f"{n_watchers} who answer: {repetition + 1} of {repetitions}")
            with _answering(audience, n_watchers):
                class_ms += clicks(session, spec, preset, pages)
    took_ms.sort()
    class_ms.sort()
    return {
        "watchers": n_watchers,
        "click_ms": {"p50": percentile(took_ms, 50), "p95": percentile(took_ms, 95)},
        "class_click_ms": {"p50": percentile(class_ms, 50), "p95": percentile(class_ms, 95)},
        "kB_per_s_each": round(statistics.median(sent), 2),
        "learner_share": round(statistics.median(shares), 3),
    }


@contextmanager
def _answering(audience: Audience, n_seats: int) -> Iterator[None]:
    """A class of so many seats, each of which answers once a second."""
    room = audience.room
    assert room is not None
    room.ask(QUESTION)
    with _watchers_of(audience, n_seats, "class"):
        state = functools.partial(room.state, QUESTION.id, True)
        wait_until(lambda: state()["answered"] == n_seats, f"{n_seats} seats did not answer")
        yield
        if state()["answered"] != n_seats:
            raise RuntimeError("answers were lost")
    room.end()


@contextmanager
def _watchers_of(
    audience: Audience, n_watchers: int, *words: str
) -> Iterator[subprocess.Popen[str]]:
    """The process of so many watchers, once all of them look."""
    with clients("audience_client", audience.watchers.port, n_watchers, *words) as readers:
        wait_until(lambda: audience.n_watchers == n_watchers, f"{n_watchers} watchers did not come")
        yield readers
    wait_until(lambda: audience.n_watchers == 0, "watchers that have left are still there")


def _kb_per_s_each(
    session: Session,
    spec: RunSpec,
    preset: str,
    readers: subprocess.Popen[str],
    n_watchers: int,
) -> float:
    """What each is sent in the long run while the learner learns and nobody does anything."""
    # Who always explores has trials so long that the run does not come to its end meanwhile.
    learner = spec.learner.model_copy(update={"epsilon": 1.0})
    endless = spec.model_copy(update={"trials": MAX_TRIALS, "learner": learner})
    _sent(readers, 0.0, n_watchers)
    session.submit(StartAgain(endless, preset, 0))
    ticket = session.submit(Play())
    session.wait_for(lambda status: status.answered >= ticket, _CONNECT_S)
    # Of another run all is sent at once, which is made up for by silence.
    for is_silent in (False, True, False):
        wait_until(
            lambda silent=is_silent: (_sent(readers, _TURN_S, n_watchers) == 0) == silent,
            "watchers are sent nothing, or never rest",
        )
    n_bytes, began_s = 0, time.perf_counter()
    while not n_bytes or time.perf_counter() - began_s < READ_S:
        n_bytes += _sent(readers, _TURN_S, n_watchers)
        if session.status.finished:
            raise RuntimeError("the learner came to its end while it was measured")
    return n_bytes / 1_000 / (time.perf_counter() - began_s) / n_watchers


def _sent(readers: subprocess.Popen[str], seconds: float, n_watchers: int) -> int:
    """The bytes that came to all of them since they were asked last, up to so many seconds on."""
    assert readers.stdin is not None
    assert readers.stdout is not None
    readers.stdin.write(f"{seconds}\n")
    readers.stdin.flush()
    told = json.loads(readers.stdout.readline())
    if told["watchers"] != n_watchers:
        raise RuntimeError(f"{n_watchers - told['watchers']} watchers have gone")
    return told["bytes"]
