"""The runs of a session, the requests made of them, and how the one that is shown stands.

One run goes on at a time, the one that is shown. Beside it one is kept that was set aside for it,
and stands as it was left: so whoever started again, or opened a run of an experiment, can go back.
"""

import math
import time
from dataclasses import dataclass

from app.live import snapshot
from app.live.held import Held, Opened
from app.live.opening import Opening, SlowStart
from app.live.places import Behind, LineSeen, Mark, Place
from app.live.requests import (
    AddMark,
    Begin,
    Branch,
    BringBack,
    DeleteLine,
    GoBack,
    GoOn,
    MakeLive,
    NameLine,
    OpenRun,
    Pause,
    PauseAtJoins,
    Play,
    RemoveMark,
    Request,
    RequestOfRun,
    RunTo,
    SetSpeed,
    SkipOpening,
    StartAgain,
    StepOnce,
    TrialOnce,
)
from app.live.snapshot import Snapshot
from app.live.worker import FULL_SPEED, Reply, Worker
from learners.commands import CommandError, SetSchedule
from learners.kernel.state import TRIAL_STEP
from learners.run import Run
from learners.spec import MAX_TRIALS, RunSpec

_CURVE_S = 0.4


_SAY_WHETHER_TO_PLAY = (Play, GoOn, Pause, StepOnce, TrialOnce, RunTo, OpenRun)
_END_THE_OPENING = (SkipOpening, SetSpeed, RunTo, StartAgain, OpenRun)


@dataclass(frozen=True)
class Status:
    """How the worker stands, and the moment it last published."""

    snapshot: Snapshot
    """Its ``generation`` is what the run that is shown is told from others by."""
    playing: bool
    finished: bool
    """The run has had the trials it was to have; it goes on if it is asked to (:class:`GoOn`)."""
    exhausted: bool
    """The run has had all the trials a run may have."""
    preparing: bool
    """The learner's code is being compiled, once on each machine."""
    speed: float
    """Steps per second that are set; slower while ``opening`` is there."""
    steps_per_s: float
    """Steps per second made, over the last second."""
    error: str | None
    """What stopped the worker; the state is kept."""
    answered: int
    """Requests answered so far: the ticket of the last one."""
    is_own: bool = True
    """Whether the run that is shown began here, and was not made again from results."""
    opened: Opened | None = None
    """The run of an experiment that is made again, or that stands as it ended."""
    aside: str | None = None
    """What was set aside for the run that is shown, in words; None if nothing was."""
    opening: Opening | None = None
    """The first hunts, while they are shown slowly and the speed rises after them."""
    lines: tuple[LineSeen, ...] = ()
    """The tree of the run that is shown: where that began, and what branched off since."""
    marks: tuple[Mark, ...] = ()
    """Moments of these lines that were given a line of text, in their order."""
    branched: tuple[tuple[int, Place], ...] = ()
    """Who gave a command at a moment of the past, and where the line begins that came of it; the
    newest last, and only some of them."""
    runs_to: int | None = None
    """Trial at whose start it is to stand still, on its way there at full speed."""
    pauses_at_joins: bool = False
    """Whether it stands still at each trial at which the schedule adds a skill."""
    journal: str | None = None
    """Why what is done cannot be written down; None while it is, or if nobody asked for it."""
    behind: Behind | None = None
    """What the moment that is shown is to the live run; None if it is that itself. A session shows
    nothing else: it is said by whoever shows somebody the past."""


class Session(Worker[Status]):
    """Runs, of which one is shown and advances. Public methods may be called from any thread."""

    def __init__(
        self,
        spec: RunSpec,
        preset: str,
        seed: int,
        speed: float,
        playing: bool,
        opening: bool = False,
    ) -> None:
        """Prepare the own run; :meth:`start` sets it going.

        With an ``opening`` its first hunts are slow enough to be seen; what is learned is the same.

        Raises:
            ValueError: the seed is not allowed.
        """
        super().__init__()
        self._n_runs = 0
        """That it has had so far."""
        self._shown = Held(Run(spec, seed), self._next(), preset, spec.trials, playing)
        self._aside: Held | None = None
        self._speed = speed
        self._told_to_play = playing
        """Whether somebody has said that the learner is to go on, or to stand still."""
        self._pauses_at_joins = False
        self._slow_start = SlowStart() if opening else None
        self._curve_at = -math.inf
        self._former: Snapshot | None = None
        self._status = self._take_status(-math.inf)

    def submit(self, request: Request, reply: Reply | None = None, run: int | None = None) -> int:
        """Ask for something, as :meth:`Worker.submit`; a run is meant by its generation."""
        return super().submit(request, reply, run)

    def _held(self, run: int | None = None) -> Held:
        """A run by its generation, or the one that is shown.

        Raises:
            CommandError: it is not here.
        """
        for held in (self._shown, self._aside):
            if held is not None and run in (None, held.generation):
                return held
        raise CommandError("the run that this was meant for is not here any more")

    def _aim(self) -> float | None:
        held = self._held()
        if not held.is_learning:
            return None
        if held.hurries:
            return FULL_SPEED
        if self._slow_start is not None:
            return self._slow_start.speed(held.run, self._speed, time.perf_counter())
        return self._speed

    def _advance(self, steps: int) -> int:
        held = self._held()
        if self._slow_start is not None:
            return self._advance_slowly(self._slow_start, held, steps)
        hurried = held.hurries
        made = held.go_on(steps, self._pauses_at_joins)
        self._preparing = False
        if held.hurries != hurried:
            self._pace.restart()
        return made

    def _advance_slowly(self, slow: SlowStart, held: Held, steps: int) -> int:
        trial, most = held.run.trial, None if self._preparing else slow.most_steps(held.run)
        made = held.go_on(steps if most is None else min(steps, most), self._pauses_at_joins)
        self._preparing = False
        if slow.is_over(held.run, time.perf_counter()):
            self._slow_start = None
            self._pace.restart()
        elif held.run.trial != trial and slow.most_steps(held.run) is not None:
            # What it came to is to be seen at once, for as long as it rests there.
            self._published_at = -math.inf
            self._pace.restart()
        return made

    def _break_off(self, error: str) -> None:
        held = self._held()
        held.error = error
        held.pause()

    def _carry_out(self, request: Request, run: int | None) -> None:
        if isinstance(request, _SAY_WHETHER_TO_PLAY):
            self._told_to_play = True
        if isinstance(request, _END_THE_OPENING):
            self._slow_start = None
        match request:
            case SkipOpening():
                self._pace.restart()
            case SetSpeed(steps_per_s=speed):
                self._speed = speed
                self._pace.restart()
            case PauseAtJoins(on=on):
                self._pauses_at_joins = on
            case (
                Branch()
                | MakeLive()
                | NameLine()
                | DeleteLine()
                | BringBack()
                | AddMark()
                | RemoveMark()
            ):
                raise CommandError("branches cannot be made yet")
            case StartAgain():
                self._start_again(request)
            case OpenRun():
                self._open(request)
            case GoBack():
                self._go_back()
            case _:
                held = self._held(run)
                hurried = held.hurries
                self._carry_out_on(held, request)
                if held.hurries != hurried:
                    self._pace.restart()

    def _carry_out_on(self, held: Held, request: RequestOfRun) -> None:
        match request:
            case Begin():
                if not self._told_to_play:
                    self._play(held)
            case Play():
                self._play(held)
            case GoOn():
                held.take_more_trials()
                self._play(held)
            case RunTo(trial=trial):
                held.run_to(trial)
            case Pause():
                held.pause()
            case StepOnce():
                held.step_by_hand(max_steps=1)
                self._preparing = False
            case TrialOnce():
                held.step_by_hand(trials=1)
                self._preparing = False
            case _:
                held.run.apply(request, replacing=True)
                held.claim_no_more()

    def _play(self, held: Held) -> None:
        held.play()
        self._pace.restart()

    def _start_again(self, request: StartAgain) -> None:
        run = Run(request.spec, request.seed)
        if request.schedule is not None:
            run.apply(SetSchedule(request.schedule))
        goes_on = self._shown.is_learning and not request.paused
        # One that is to stand still does so even if nobody has come yet.
        self._told_to_play = self._told_to_play or request.paused
        self._set_aside()
        self._show(Held(run, self._next(), request.preset, request.spec.trials, goes_on))

    def _open(self, request: OpenRun) -> None:
        opened = Opened(request.name, request.step, request.digest, same=None)
        # The step alone says where it ended: an experiment may run more trials than a preset has.
        run = Run(request.spec, request.seed)
        held = Held(run, self._next(), request.preset, MAX_TRIALS, playing=True, opened=opened)
        self._set_aside(even_if_new=self._aside is None)
        self._show(held)

    def _set_aside(self, even_if_new: bool = False) -> None:
        """Keep the run that is shown, in the place of the one that was kept before.

        Unless nothing has been done in it yet, or it is of an experiment, whose results make it
        again: of several that are opened one after the other, the lesson that came before is kept.
        """
        if self._shown.is_own and (self._shown.is_begun or even_if_new):
            self._aside = self._shown

    def _go_back(self) -> None:
        if self._aside is None:
            raise CommandError("no run was set aside")
        held, self._aside = self._aside, None
        self._set_aside()
        self._show(held)

    def _next(self) -> int:
        """The number of another run."""
        self._n_runs += 1
        return self._n_runs - 1

    def _show(self, held: Held) -> None:
        self._shown = held
        self._curve_at = -math.inf
        self._pace.restart()

    def _take_status(self, now_s: float) -> Status:
        held = self._held()
        opening = None if self._slow_start is None else self._slow_start.stand(held.run)
        at_start = held.run.state.tally[TRIAL_STEP] == 0
        rests = not held.is_learning or (opening is not None and at_start)
        new_curve = now_s - self._curve_at >= _CURVE_S or rests
        if new_curve:
            self._curve_at = now_s
        former = self._former
        if former is not None and former.generation != held.generation:
            former = None
        self._former = snapshot.take(held.run, held.preset, held.generation, former, new_curve)
        aside = self._aside
        return Status(
            snapshot=self._former,
            playing=held.playing,
            finished=held.is_over,
            exhausted=held.run.trial >= MAX_TRIALS,
            preparing=self._preparing and held.playing,
            speed=self._speed,
            steps_per_s=self._pace.rate() if held.is_learning else 0.0,
            error=held.error,
            answered=self._answered,
            is_own=held.is_own,
            opened=held.opened,
            aside=None if aside is None else f"{aside.preset}, trial {aside.run.trial:,}",
            opening=None if held.is_over else opening,
            runs_to=held.runs_to,
            pauses_at_joins=self._pauses_at_joins,
        )
