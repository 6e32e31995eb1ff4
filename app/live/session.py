"""The runs of a session, the requests made of them, and how the one that is shown stands.

One run goes on at a time, the live one. What branched off it at moments of its past is its family.
Beside that, one family is kept that was set aside for it, and stands as it was left: so whoever
started again, or opened a run of an experiment, can go back (:mod:`app.live.tree`).
"""

import math
import time

from app.live import snapshot
from app.live.branching import Begun, NameOf, plain_name
from app.live.excerpt import Excerpt, excerpt
from app.live.held import Held, Opened
from app.live.lines import Line, MadeAgain
from app.live.moments import Moments, moment_at
from app.live.opening import SlowStart
from app.live.past import Budget, Past
from app.live.places import Place
from app.live.race import Race
from app.live.racer import Entry
from app.live.records import Journal
from app.live.requests import (
    AddMark,
    Begin,
    Branch,
    BringBack,
    DeleteLine,
    EndRace,
    GoBack,
    GoOn,
    LeaveLesson,
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
    StartRace,
    StepOnce,
    TakeLesson,
    TakeUp,
    Tell,
    TrialOnce,
)
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.live.tree import FromMoments, Grown, Ready, Tree
from app.live.worker import FULL_SPEED, Reply, Worker
from learners.kernel.state import TRIAL_STEP
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.spec import RunSpec

_CURVE_S = 0.4


_SAY_WHETHER_TO_PLAY = (
    *(Play, GoOn, Pause, StepOnce, TrialOnce, RunTo, OpenRun, TakeUp, StartRace),
    TakeLesson,
)
_END_THE_OPENING = (SkipOpening, SetSpeed, RunTo, StartAgain, OpenRun, MakeLive, TakeUp, TakeLesson)


class Session(Worker[Status]):
    """Runs, of which one is live and advances. Public methods may be called from any thread."""

    def __init__(
        self,
        spec: RunSpec,
        preset: str,
        seed: int,
        speed: float,
        playing: bool,
        opening: bool = False,
        *,
        journal: Journal | None = None,
        made_again: MadeAgain | None = None,
        name_of: NameOf = plain_name,
        budget: Budget | None = None,
    ) -> None:
        """Prepare the own run; :meth:`start` sets it going.

        With an ``opening`` its first hunts are slow enough to be seen; what is learned is the same.

        Args:
            spec: of the run to begin with.
            preset: what it is called.
            seed: its seed.
            speed: steps per second that are set.
            playing: whether it goes on at once.
            opening: whether its first hunts are slow.
            journal: where all that is done is written down; closed when the session ends.
            made_again: an earlier session, which is taken up instead of beginning a run; it stands
                still.
            name_of: computes names of branches.
            budget: memory for checkpoints, which that session shares if there is one.

        Raises:
            ValueError: the seed is not allowed.
        """
        super().__init__()
        self.budget = budget or Budget()
        """Memory that is shared by the checkpoints of all lines, and of a race."""
        self.race: Race | None = None
        """Runs that learn side by side; another object for each race."""
        self._tree = Tree(super().submit, journal, name_of, self.budget)
        if made_again is None:
            self._tree.begin(Run(spec, seed), preset, spec.trials, playing)
        else:
            self._tree.take_up(TakeUp(made_again, journal))
        self._speed = speed
        self._told_to_play = playing or made_again is not None
        """Whether somebody has said that the learner is to go on, or to stand still."""
        self._pauses_at_joins = False
        self._slow_start = SlowStart() if opening else None
        self._curve_at = -math.inf
        self._former: Snapshot | None = None
        self._status = self._take_status(-math.inf)

    # What others do

    def submit(self, request: Request, reply: Reply | None = None, run: int | None = None) -> int:
        """Ask for something, as :meth:`Worker.submit`; a run is meant by its generation.

        What is asked of the past takes longer than the others' answers: a branch is there once
        ``Status.branched`` or ``Status.lines`` tells of it.
        """
        return super().submit(request, reply, run)

    def stop(self) -> None:
        """End the worker and the thread of moments, and wait for them."""
        super().stop()
        self.moments.stop()
        self._end_race()
        if not self._thread.is_alive():
            self._tree.close()

    @property
    def moments(self) -> Moments:
        """Makes moments of the lines that are shown."""
        return self._tree.moments

    @property
    def n_runs(self) -> int:
        """Runs that it has had: the next one's number."""
        return self._tree.n_runs

    @property
    def is_kept(self) -> bool:
        """Whether what is done is written down."""
        return self._tree.journal is not None

    def past_of(self, line: int) -> Past | None:
        """The past of a line that is shown, by its number; None if it is not here any more."""
        return self._tree.past_of(line)

    def entry_of(self, line: int, name: str = "") -> Entry:
        """A line that is shown, as one that is to be in a race.

        Args:
            line: its number.
            name: what it is to be called there; if "", as the tree calls it.

        Raises:
            CommandError: there is no such line.
        """
        family = self._tree.family
        found = family.line(line)
        control = found.past.control
        return Entry(name or found.name, family.preset, found.past.seed, control.spec, line)

    def snapshot_at(self, place: Place) -> Snapshot:
        """A moment, made while the caller waits.

        Raises:
            CommandError: there is no such line.
        """
        family = self._tree.family
        made = moment_at(family.line(place.line).past, place, family.preset)
        assert made is not None
        return made

    def excerpt(self, line: int | None) -> Excerpt:
        """A line that is shown, or with None all of them, to be shared; the caller waits.

        Raises:
            CommandError: there is no such line.
            SessionError: it is too much for a file that others take.
        """
        return excerpt(self._tree.family, line)

    # What the worker advances

    def _held(self, run: int | None = None) -> Held:
        """A live run by its generation, or the one that is shown.

        Raises:
            CommandError: it is not here.
        """
        held = self._tree.live_line(run).held
        assert held is not None
        return held

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
            made = self._advance_slowly(self._slow_start, held, steps)
        else:
            hurried = held.hurries
            made = held.go_on(steps, self._pauses_at_joins)
            self._preparing = False
            if held.hurries != hurried:
                self._pace.restart()
        self._tree.family.live.past.note(held.run)
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

    # What is asked for

    def _carry_out(
        self, request: Request | FromMoments, run: int | None, reply: Reply | None = None
    ) -> None:
        if isinstance(request, _SAY_WHETHER_TO_PLAY):
            self._told_to_play = True
        if isinstance(request, _END_THE_OPENING):
            self._slow_start = None
        match request:
            case Grown():
                # The next status tells of it, and there is one for each answer.
                pass
            case SkipOpening():
                self._pace.restart()
            case SetSpeed(steps_per_s=speed):
                self._speed = speed
                self._pace.restart()
            case PauseAtJoins(on=on):
                self._pauses_at_joins = on
            case StartAgain():
                self._start_again(request)
            case OpenRun():
                self._open(request)
            case GoBack():
                self._tree.go_back()
                self._show()
            case TakeUp():
                self._tree.take_up(request)
                self._show()
            case TakeLesson():
                self._take_lesson(request)
            case LeaveLesson():
                self._tree.leave_lesson()
            case Tell():
                self._tree.tell(request)
            case StartRace():
                self._start_race(request)
            case EndRace():
                self._end_race()
            case (
                Branch()
                | MakeLive()
                | NameLine()
                | DeleteLine()
                | BringBack()
                | AddMark()
                | RemoveMark()
                | Begun()
                | Ready()
            ):
                live = self._tree.family.live
                self._tree.carry_out(request, reply)
                if self._tree.family.live is not live:
                    self._show()
            case _:
                self._carry_out_on(self._tree.live_line(run), request)

    def _carry_out_on(self, line: Line, request: RequestOfRun) -> None:
        held = line.held
        assert held is not None
        hurried = held.hurries
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
                self._tree.give(line, request)
        line.past.note(held.run)
        if held.hurries != hurried:
            self._pace.restart()

    def _play(self, held: Held) -> None:
        held.play()
        self._pace.restart()

    def _start_again(self, request: StartAgain) -> None:
        run = Run(request.spec, request.seed)
        goes_on = self._held().is_learning and not request.paused
        plan = request.schedule
        self._tree.begin(run, request.preset, request.spec.trials, goes_on, plan=plan)
        # One that is to stand still does so even if nobody has come yet.
        self._told_to_play = self._told_to_play or request.paused
        self._show()

    def _take_lesson(self, request: TakeLesson) -> None:
        self._held().pause()
        begins = self._tree.take_lesson(request)
        held = self._held()
        if begins and request.start > held.run.trial:
            held.run_to(request.start)
        self._speed = request.speed
        self._show()

    def _open(self, request: OpenRun) -> None:
        opened = Opened(request.name, request.step, request.digest, same=None)
        run = Run(request.spec, request.seed)
        # The step alone says where it ended: an experiment may run more trials than a preset has.
        self._tree.begin(run, request.preset, MAX_TRIALS, playing=True, opened=opened)
        self._show()

    def _start_race(self, request: StartRace) -> None:
        race = Race(
            request.entries, self.budget, self.past_of, request.speed, playing=request.playing
        )
        former, held = self.race, self._held()
        if held.is_learning:
            race.paused_live = held.run.trial
        elif former is not None and former.paused_live == held.run.trial:
            race.paused_live = former.paused_live
        held.pause()
        self._end_race()
        self.race = race
        race.start()

    def _end_race(self) -> None:
        race, self.race = self.race, None
        if race is not None:
            race.close()

    def _show(self) -> None:
        """Another run is live."""
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
        tree = self._tree
        tree.keep_up(now_s)
        if self.race is not None:
            self.race.heed()
        aside = tree.aside
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
            is_own=tree.family.is_own,
            is_resumed=tree.family.is_resumed,
            is_shared=tree.family.is_shared,
            opened=held.opened,
            aside=None if aside is None else f"{aside.preset}, trial {aside.held.run.trial:,}",
            opening=None if held.is_over else opening,
            lines=tree.lines,
            marks=tree.family.marks,
            branched=tree.branched,
            stories=tree.stories,
            runs_to=held.runs_to,
            pauses_at_joins=self._pauses_at_joins,
            journal=None if tree.journal is None else tree.journal.fault,
        )
