"""One learner, the thread that runs it, the requests made of it, and its latest snapshot.

Only the worker thread touches the learner. Everybody else enqueues a request and reads the
latest snapshot, of which there is one at a time and never a queue.
"""

import logging
import math
import queue
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

from app.live import snapshot
from app.live.snapshot import Snapshot
from learners.commands import Command, CommandError
from learners.kernel.state import digest
from learners.run import Run
from learners.spec import MAX_TRIALS, RunSpec

log = logging.getLogger(__name__)

FULL_SPEED = math.inf
"""A speed in steps per second: as fast as it goes."""

MOST_WAITING = 1_000
"""Requests that may wait while the worker is deaf."""

_SLICE_S = 0.005
"""How long the learner may keep the worker from its requests."""
_PUBLISH_S = 1 / 15
_TICK_S = 1 / 60
"""How often learning at a set speed is worth waking up for."""
_CURVE_S = 0.4
_MAX_DEBT_S = 0.1
"""Learning that is owed after a stall is forgiven beyond this, so that speed never bursts."""
_RATE_WINDOW_S = 1.0
_FAREWELL_S = 2.0


@dataclass(frozen=True)
class Begin:
    """Play, unless somebody has said by then whether the learner is to go on or to stand still."""


@dataclass(frozen=True)
class Play:
    """Learn on; past the preset's last trial, for as many trials again."""


@dataclass(frozen=True)
class Pause:
    """Stand still."""


@dataclass(frozen=True)
class StepOnce:
    """Pause, and make one step."""


@dataclass(frozen=True)
class TrialOnce:
    """Pause, and go to the start of the next trial."""


@dataclass(frozen=True)
class SetSpeed:
    """Aim at so many steps per second."""

    steps_per_s: float


@dataclass(frozen=True)
class StartAgain:
    """Throw the run away and begin another, playing unless the last one was paused by hand."""

    spec: RunSpec
    preset: str
    seed: int


@dataclass(frozen=True)
class OpenRun:
    """Make a run of an experiment again, up to where it ended, and pause there."""

    spec: RunSpec
    preset: str
    """As shown."""
    seed: int
    step: int
    """Where it ended."""
    digest: str
    """Of its tables there."""
    name: str
    """What it is called: "figure_4_1: timed, seed 3"."""


@dataclass(frozen=True)
class GoBack:
    """Take up the run again that was set aside when a run of an experiment was opened."""


Request = (
    Begin | Play | Pause | StepOnce | TrialOnce | SetSpeed | StartAgain | OpenRun | GoBack | Command
)
Reply = Callable[[str], None]
"""Told why a request could not be carried out."""

_SAY_WHETHER_TO_PLAY = (Play, Pause, StepOnce, TrialOnce, OpenRun)


@dataclass(frozen=True)
class Opened:
    """A run of an experiment, made again."""

    name: str
    step: int
    """Where it ended."""
    digest: str
    """Of its tables there, as the results have it."""
    same: bool | None
    """Whether the tables made here have that digest; None while they are being made."""
    found: str = ""
    """The digest of the tables made here, once they are."""


@dataclass(frozen=True)
class Status:
    """How the worker stands, and the moment it last published."""

    snapshot: Snapshot
    playing: bool
    finished: bool
    """The run has had the trials it was to have; playing on asks for as many again."""
    exhausted: bool
    """The run has had all the trials a run may have."""
    preparing: bool
    """The learner's code is being compiled, once on each machine."""
    speed: float
    """Steps per second aimed at."""
    steps_per_s: float
    """Steps per second made, over the last second."""
    error: str | None
    """What stopped the worker; the state is kept."""
    answered: int
    """Requests answered so far: the ticket of the last one."""
    opened: Opened | None = None
    """The run of an experiment that is made again, or that stands as it ended."""
    aside: str | None = None
    """What was set aside for it, in words; None if there is nothing to go back to."""


@dataclass(frozen=True)
class _Aside:
    """A run as it stood when another was opened."""

    run: Run
    preset: str
    until_trial: int
    playing: bool
    error: str | None


@dataclass(frozen=True)
class _Envelope:
    request: Request
    reply: Reply | None
    ticket: int


class Session:
    """A live run. All public methods may be called from any thread."""

    def __init__(self, spec: RunSpec, preset: str, seed: int, speed: float, playing: bool) -> None:
        """Prepare the run; :meth:`start` sets it going.

        Raises:
            ValueError: the seed is not allowed.
        """
        self._requests: queue.SimpleQueue[_Envelope | None] = queue.SimpleQueue()
        self._newest_ticket = 0
        self._answered = 0
        self._thread = threading.Thread(target=self._work, name="learner", daemon=True)
        self._published = threading.Condition()
        self._submitting = threading.Lock()
        self._run = Run(spec, seed)
        self._preset = preset
        self._generation = 0
        self._until_trial = spec.trials
        self._speed = speed
        self._playing = playing
        self._told_to_play = playing
        """Whether somebody has said that the learner is to go on, or to stand still."""
        self._preparing = True
        self._error: str | None = None
        self._opened: Opened | None = None
        self._aside: _Aside | None = None
        self._stopping = False
        self._slice_steps = 1_000
        self._paced_from = time.perf_counter()
        self._owed = 0.0
        self._made_at: deque[tuple[float, int]] = deque()
        self._published_at = -math.inf
        self._curve_at = -math.inf
        self._former: Snapshot | None = None
        self._on_answer: Callable[[], object] = lambda: None
        self._told = 0
        self._status = self._take_status()

    @property
    def status(self) -> Status:
        """The latest published moment."""
        return self._status

    def call_when_answered(self, callback: Callable[[], object]) -> None:
        """Have this called, in the worker's thread, when a status tells of answered requests."""
        self._on_answer = callback

    def start(self) -> None:
        """Begin to work."""
        self._thread.start()

    @property
    def is_gone(self) -> bool:
        """Whether the worker has ended, be it that it was told to."""
        return self._thread.ident is not None and not self._thread.is_alive()

    def stop(self) -> None:
        """End the worker and wait for it, unless it is deaf because it compiles."""
        self._requests.put(None)
        self._thread.join(timeout=_FAREWELL_S)

    def submit(self, request: Request, reply: Reply | None = None) -> int:
        """Ask for something; it is done before the next slice of learning.

        Where too much is asked for already, because the learner's code is being compiled, it is
        refused.

        Returns:
            A ticket; the request has been answered once ``status.answered`` has reached it.
        """
        envelope = None
        with self._submitting:
            if self._requests.qsize() < MOST_WAITING:
                self._newest_ticket += 1
                envelope = _Envelope(request, reply, self._newest_ticket)
                self._requests.put(envelope)
            ticket = self._newest_ticket
        if envelope is None and reply is not None:
            reply(f"{MOST_WAITING:,} requests wait for the learner; ask again once it is ready")
        return ticket

    def wait_for(self, condition: Callable[[Status], bool], timeout_s: float) -> Status:
        """The first published status that meets a condition.

        Raises:
            TimeoutError: none did in time.
        """
        with self._published:
            if not self._published.wait_for(lambda: condition(self._status), timeout_s):
                raise TimeoutError("the session did not get there in time")
            return self._status

    def _work(self) -> None:
        while not self._stopping:
            try:
                self._answer_requests(self._pause_s())
                if self._is_learning() and not self._stopping:
                    self._learn()
            except Exception as error:
                # Whatever went wrong, the page must say so and the state must be kept.
                log.exception("the learner stopped")
                self._error = f"{type(error).__name__}: {error}"
                self._playing = False
                if self._is_made_again():
                    self._claim_no_more()
                self._publish()

    def _is_learning(self) -> bool:
        return self._playing and self._error is None and self._run.trial < self._until_trial

    def _is_made_again(self) -> bool:
        return self._opened is not None and self._opened.same is None

    def _aim(self) -> float:
        """Steps per second to make now: the set speed is for watching, not for catching up."""
        return FULL_SPEED if self._is_made_again() else self._speed

    def _pause_s(self) -> float | None:
        """How long to wait for a request before it is time to learn; None is for ever."""
        if not self._is_learning():
            return None
        if self._aim() == FULL_SPEED:
            return 0.0
        self._accrue()
        return max((self._quantum() - self._owed) / self._speed, 0.0)

    def _quantum(self) -> float:
        """Steps worth waking up for at the present speed."""
        return max(self._speed * _TICK_S, 1.0)

    def _accrue(self) -> None:
        now = time.perf_counter()
        limit = max(self._speed * _MAX_DEBT_S, 1.0)
        self._owed = min(self._owed + (now - self._paced_from) * self._speed, limit)
        self._paced_from = now

    def _answer_requests(self, wait_s: float | None) -> None:
        try:
            envelope = self._requests.get(block=wait_s != 0.0, timeout=wait_s)
            while True:
                if envelope is None:
                    self._stopping = True
                    return
                self._answer(envelope)
                envelope = self._requests.get_nowait()
        except queue.Empty:
            return
        finally:
            if not self._is_learning():
                self._publish()

    def _answer(self, envelope: _Envelope) -> None:
        log.debug("asked for %s", envelope.request)
        try:
            self._carry_out(envelope.request)
        except CommandError as error:
            self._reply(envelope, str(error))
        finally:
            self._answered = envelope.ticket
            self._published_at = -math.inf

    def _reply(self, envelope: _Envelope, reason: str) -> None:
        if envelope.reply is None:
            return
        try:
            envelope.reply(reason)
        except Exception:
            # Whoever asked may be gone; that is no reason for the learner to stop.
            log.exception("a refusal could not be told")

    def _carry_out(self, request: Request) -> None:
        if isinstance(request, _SAY_WHETHER_TO_PLAY):
            self._told_to_play = True
        match request:
            case Begin():
                if not self._told_to_play:
                    self._play()
            case Play():
                self._play()
            case Pause():
                self._playing = False
                if self._is_made_again():
                    self._claim_no_more()
            case StepOnce():
                self._check_not_over()
                self._playing = False
                self._advance(max_steps=1)
                self._claim_no_more()
            case TrialOnce():
                self._check_not_over()
                self._playing = False
                self._advance(until_trial=self._run.trial + 1)
                self._claim_no_more()
            case SetSpeed(steps_per_s=speed):
                self._speed = speed
                self._restart_pace()
            case StartAgain():
                self._start_again(request)
            case OpenRun():
                self._open(request)
            case GoBack():
                self._go_back()
            case _:
                self._run.apply(request, replacing=True)
                self._claim_no_more()

    def _check_not_over(self) -> None:
        if self._run.trial >= self._until_trial:
            raise CommandError(f"the {self._until_trial:,} trials are over; play to go on")

    def _play(self) -> None:
        if self._error is not None:
            raise CommandError(f"the learner has stopped: {self._error}")
        if self._run.trial >= MAX_TRIALS:
            raise CommandError(f"a run ends after {MAX_TRIALS:,} trials")
        if self._run.trial >= self._until_trial:
            self._until_trial = min(self._until_trial + self._run.spec.trials, MAX_TRIALS)
        self._playing = True
        self._restart_pace()

    def _start_again(self, request: StartAgain) -> None:
        was_over = self._run.trial >= self._until_trial or self._error is not None
        # A run that was made again paused by itself, wherever in its trials it ended.
        goes_on = self._playing or was_over or self._opened is not None
        self._begin(request)
        self._playing = goes_on
        self._aside = None

    def _begin(self, request: StartAgain | OpenRun) -> None:
        self._run = Run(request.spec, request.seed)
        self._preset = request.preset
        self._generation += 1
        self._until_trial = request.spec.trials
        self._opened = None
        self._error = None
        self._curve_at = -math.inf
        self._restart_pace()

    def _open(self, request: OpenRun) -> None:
        # Of several that are opened one after the other, the lesson that came before is kept.
        aside = self._aside or _Aside(
            self._run, self._preset, self._until_trial, self._playing, self._error
        )
        self._begin(request)
        self._aside = aside
        self._opened = Opened(request.name, request.step, request.digest, same=None)
        # The step alone says where it ended: an experiment may run more trials than a preset has.
        self._until_trial = MAX_TRIALS
        self._playing = True

    def _go_back(self) -> None:
        aside = self._aside
        if aside is None:
            raise CommandError("no run was set aside")
        self._run, self._preset = aside.run, aside.preset
        self._until_trial, self._playing, self._error = (
            aside.until_trial,
            aside.playing,
            aside.error,
        )
        self._aside = self._opened = None
        self._generation += 1
        self._curve_at = -math.inf
        self._restart_pace()

    def _compare_at_end(self, opened: Opened) -> None:
        """If the run is where it ended, or can go no further, stand still and compare."""
        if self._run.step < opened.step and self._run.trial < self._until_trial:
            return
        found = digest(self._run.state)
        self._playing = False
        self._claim_no_more()
        self._opened = replace(opened, same=found == opened.digest, found=found)

    def _claim_no_more(self) -> None:
        """From here on it is a run like any other, with the trials it was to have."""
        if self._is_made_again():
            self._until_trial = max(self._run.spec.trials, self._run.trial)
            self._playing = self._playing and self._run.trial < self._until_trial
            self._restart_pace()
        self._opened = None

    def _restart_pace(self) -> None:
        self._paced_from = time.perf_counter()
        self._owed = 0.0
        self._made_at.clear()

    def _learn(self) -> None:
        if self._preparing:
            # The first call compiles, or loads what was compiled before.
            self._publish()
            self._go_on(1)
            self._restart_pace()
            if not self._is_learning():
                self._publish()
            return
        # The time that the worker itself needed: it also waits while others draw.
        started = time.thread_time()
        steps = self._slice_steps
        if self._aim() != FULL_SPEED:
            self._accrue()
            steps = min(int(self._owed), steps)
            self._owed -= steps
        if steps > 0:
            made = self._go_on(steps)
            self._fit_slice(made, time.thread_time() - started)
        if time.perf_counter() - self._published_at >= _PUBLISH_S or not self._is_learning():
            self._publish()

    def _go_on(self, steps: int) -> int:
        """Learn, but not past the step up to which a run is made again."""
        opened = self._opened
        if opened is None or opened.same is not None:
            self._opened = None
            return self._advance(max_steps=steps)
        made = self._advance(max_steps=min(steps, opened.step - self._run.step))
        self._compare_at_end(opened)
        return made

    def _advance(self, max_steps: int = 2**62, until_trial: int | None = None) -> int:
        if self._error is not None:
            raise CommandError(f"the learner has stopped: {self._error}")
        limit = self._until_trial if until_trial is None else until_trial
        made = self._run.advance(max_steps=max_steps, until_trial=limit)
        self._preparing = False
        self._made_at.append((time.perf_counter(), self._run.step))
        if self._run.trial >= self._until_trial:
            self._playing = False
        return made

    def _fit_slice(self, made: int, took_s: float) -> None:
        """Let a slice take about as long as the worker may be deaf."""
        if made == self._slice_steps and took_s > 0:
            wanted = made * _SLICE_S / took_s
            self._slice_steps = int(min(max(wanted, self._slice_steps / 2, 1), made * 2))

    def _steps_per_s(self) -> float:
        if not self._is_learning():
            return 0.0
        horizon = time.perf_counter() - _RATE_WINDOW_S
        while len(self._made_at) > 2 and self._made_at[1][0] < horizon:
            self._made_at.popleft()
        if len(self._made_at) < 2:
            return 0.0
        (first_s, first), (last_s, last) = self._made_at[0], self._made_at[-1]
        return (last - first) / (last_s - first_s) if last_s > first_s else 0.0

    def _take_status(self) -> Status:
        now = time.perf_counter()
        new_curve = now - self._curve_at >= _CURVE_S or not self._is_learning()
        if new_curve:
            self._curve_at = now
        former = self._former
        if former is not None and former.generation != self._generation:
            former = None
        self._former = snapshot.take(self._run, self._preset, self._generation, former, new_curve)
        return Status(
            snapshot=self._former,
            playing=self._playing,
            finished=self._run.trial >= self._until_trial,
            exhausted=self._run.trial >= MAX_TRIALS,
            preparing=self._preparing and self._playing,
            speed=self._speed,
            steps_per_s=self._steps_per_s(),
            error=self._error,
            answered=self._answered,
            opened=self._opened,
            aside=self._aside_in_words(),
        )

    def _aside_in_words(self) -> str | None:
        if self._aside is None:
            return None
        return f"{self._aside.preset}, trial {self._aside.run.trial:,}"

    def _publish(self) -> None:
        with self._published:
            self._status = self._take_status()
            self._published_at = time.perf_counter()
            self._published.notify_all()
        if self._told != self._answered:
            self._told = self._answered
            self._on_answer()
