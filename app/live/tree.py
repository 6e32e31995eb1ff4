"""The families of runs that a session has, what is done to them, and what is written down of it.

Each change is judged, then written down if there is a journal, and then made: in the worker's
thread, which is the only one that changes anything here. What takes longer, to come to a moment of
the past, is done in the thread of moments; that has no other way back than to ask, like anybody
else, for what is to come of it.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Final, NamedTuple

from app.live.branching import Begun, Growth, NameOf, begin, run_at
from app.live.held import Opened
from app.live.lines import (
    Change,
    Family,
    Line,
    aside_after,
    families_of,
    known_of,
    one_line,
    root_line,
)
from app.live.moments import Moments
from app.live.past import Budget, Past
from app.live.places import LineSeen, Place
from app.live.records import (
    Began,
    Branched,
    BroughtBack,
    Deleted,
    Gave,
    Journal,
    NamedLine,
    Record,
    Stood,
    Unmarked,
    WentLive,
)
from app.live.requests import (
    AddMark,
    Branch,
    BringBack,
    DeleteLine,
    MakeLive,
    NameLine,
    RemoveMark,
    RequestOfLines,
    TakeLesson,
    TakeUp,
    Tell,
)
from app.live.story import LeftLesson, Stories, TookLesson, WentToCard, check
from app.live.worker import Reply
from learners.commands import Command, CommandError, SetSchedule
from learners.control import Control
from learners.kernel.state import digest
from learners.run import Run
from learners.schedule_spec import ScheduleSpec

_STOOD_S: Final = 1.0
"""How often it is written down how far a run that goes on is."""
_SOON_TRIALS: Final = 100
"""By which a branch is to have gone on until it is written down again what it came to."""
_MOST_NEWS: Final = 16
"""Of branches, that are told."""


class Grown(NamedTuple):
    """More of a branch is known."""


class Ready(NamedTuple):
    """A run of a line stands where that is to go on as the live one."""

    family: Family
    line: Line
    run: Run


FromMoments = Grown | Ready | Begun
"""What comes of what was made in the thread of moments."""


class Tree:
    """The family that is shown, with the live run, and the one that was set aside for it."""

    def __init__(
        self,
        submit: Callable[[FromMoments, Reply | None], Any],
        journal: Journal | None,
        name_of: NameOf,
        budget: Budget,
    ) -> None:
        """Prepare it; a family has to be begun or taken up before anything else.

        Args:
            submit: asks the worker to carry out what the thread of moments has made.
            journal: where what is done is written down.
            name_of: computes names of branches.
            budget: memory for checkpoints of all lines.
        """
        self.family: Family
        """The one that is shown."""
        self.aside: Family | None = None
        self.journal = journal
        self.moments = Moments(self.past_of, lambda line: self.family.preset)
        self.n_runs = 0
        """Runs that there were so far: the next one's number."""
        self.branched: tuple[tuple[int, Place], ...] = ()
        """Who gave a command in the past, and where the line begins that came of it."""
        self.lines: tuple[LineSeen, ...] = ()
        """As they are told; the same object until something has changed."""
        self.stories = Stories()
        """Lessons that were taken."""
        self._of_lessons: Mapping[str, Family] = {}
        """Of each lesson, by its name, the family of its run."""
        self._submit = submit
        self._name_of = name_of
        self._budget = budget
        self._growth = Growth(self.moments.do_meanwhile, lambda: submit(Grown(), None))
        self._stood: Stood | None = None
        self._stood_s = -math.inf
        self._digested: tuple[Run | None, int, Control | None, str] = (None, 0, None, "")
        """A run, its step, what held there, and the digest of its tables."""

    # What is there

    def past_of(self, number: int) -> Past | None:
        """The past of a line that is shown; None if it is not here any more. From any thread."""
        line = self.family.lines.get(number)
        return None if line is None else line.past

    def live_line(self, number: int | None = None) -> Line:
        """The line of a live run, by its number, or of the one that is shown.

        Raises:
            CommandError: it is not here.
        """
        return self._live_family(number).live

    def _live_family(self, number: int | None = None) -> Family:
        for family in (self.family, self.aside):
            if family is not None and number in (None, family.live.number):
                return family
        raise CommandError("the run that this was meant for is not here any more")

    def keep_up(self, now_s: float) -> None:
        """Let journal, branches and what is told of the lines be as the live run is."""
        family, held = self.family, self.family.held
        stands = not held.is_learning
        family.live.known = known_of(held.run, self._digest() if stands else "")
        if stands or now_s - self._stood_s >= _STOOD_S:
            self._stood_s = now_s
            self.note_stood(at_rest=stands)
        if stands:
            self._note_branches(_SOON_TRIALS)
        branches = [line for line in family.lines.values() if line.grows]
        self._growth.follow(branches, held.run.trial, stands)
        lines = tuple(
            line.seen(line is family.live, line.grows and self._growth.is_behind(line))
            for line in family.lines.values()
        )
        if lines != self.lines:
            self.lines = lines

    # What is done to the lines that are shown

    def give(self, line: Line, command: Command) -> None:
        """Carry out a command on a live run.

        Raises:
            CommandError: it cannot be carried out now.
        """
        assert line.held is not None
        run = line.held.run
        run.check(command)
        gave = Gave(line.number, run.step, command)
        self._note(gave)
        run.apply(command, replacing=True)
        self._live_family(line.number).note_given(gave)
        line.held.claim_no_more()

    def carry_out(self, request: RequestOfLines | Ready | Begun, reply: Reply | None) -> None:
        """Do what is asked of the lines, or begin to do it.

        Raises:
            CommandError: it cannot be done.
        """
        match request:
            case Branch():
                self._branch(request, reply)
            case Begun():
                self._add(request)
            case MakeLive():
                self._make_live(request, reply)
            case Ready():
                self._go_live(request.family, request.line, request.run)
            case NameLine(line=line, name=name):
                self._change(NamedLine(line, one_line(name)))
            case DeleteLine(line=line):
                self._change(Deleted(line))
            case BringBack(line=line):
                self._change(BroughtBack(line))
            case AddMark(place=place, text=text):
                self._change(self.family.mark(place, one_line(text)))
            case RemoveMark(number=number):
                self._change(Unmarked(number))

    def _branch(self, request: Branch, reply: Reply | None) -> None:
        family = self.family
        place = family.place(request.place)
        amends = family.amends(place)
        if not amends:
            family.check_room()
        self.moments.ask(
            lambda: begin(family, place, (request.command,), amends, self._name_of),
            lambda begun: self._submit(replace(begun, viewer=request.viewer), reply),
            reply or _no_matter,
        )

    def _add(self, begun: Begun) -> None:
        family, former = begun.family, begun.instead_of
        self._check_shown(family)
        is_still = family.line(begun.parent).past.is_still(begun.step, begun.before)
        if former is None:
            family.check_room()
        if not is_still or (former is not None and not family.amends(former.begins)):
            raise CommandError("more was done at that moment meanwhile; give the command again")
        line = begun.line(self.n_runs, self._budget)
        instead_of = None if former is None else former.number
        record = Branched(line.number, begun.parent, begun.step, begun.commands, instead_of)
        self._note(record)
        self.n_runs += 1
        family.note_given(record)
        family.add(line, instead_of)
        if begun.viewer is not None:
            self.branched = (*self.branched, (begun.viewer, line.begins))[-_MOST_NEWS:]

    def _make_live(self, request: MakeLive, reply: Reply | None) -> None:
        family, step = self.family, request.step
        line = family.check_going_live(request.line, step)
        if line.held is not None and step in (None, line.held.run.step):
            self._go_live(family, line, line.held.run)
            return
        line.is_leaving = True

        def ready() -> Ready:
            self._growth.leave(line)
            end = line.past.end_step
            return Ready(family, line, run_at(line.past, end if step is None else step))

        def failed(reason: str) -> None:
            line.is_leaving = False
            (reply or _no_matter)(reason)

        self.moments.ask(ready, lambda made: self._submit(made, failed), failed)

    def _go_live(self, family: Family, line: Line, run: Run) -> None:
        self._check_shown(family)
        family.check_going_live(line.number, run.step)
        self.note_stood()
        self._note(WentLive(line.number, run.step))
        family.go_live(line, run)
        line.is_leaving = False

    def _change(self, change: Change) -> None:
        self.family.check(change)
        self._note(change)
        self.family.do(change)

    def _check_shown(self, family: Family) -> None:
        if family is not self.family:
            raise CommandError("another run has come on the board meanwhile")

    # Families

    def begin(
        self,
        run: Run,
        preset: str,
        until_trial: int,
        playing: bool,
        opened: Opened | None = None,
        plan: ScheduleSpec | None = None,
    ) -> None:
        """Show a run that begins.

        Args:
            run: it, before its first step.
            preset: as shown.
            until_trial: where it stands still by itself.
            playing: whether it goes on at once.
            opened: the run of an experiment that is made again by it.
            plan: a schedule that takes the place of the preset's own.

        Raises:
            CommandError: the plan is not one that this run can have.
        """
        number = self.n_runs
        gave = None if plan is None else Gave(number, 0, SetSchedule(plan))
        if gave is not None:
            run.apply(gave.command)
        if number > 0:
            self.note_stood()
        self._note(Began(number, preset, run.preset, run.seed, is_own=opened is None))
        if gave is not None:
            self._note(gave)
        if number > 0:
            self._set_aside(for_opened=opened is not None)
        self.n_runs += 1
        root = root_line(number, run, preset, self._budget, until_trial, playing, opened)
        self.family = Family(root, is_own=opened is None)
        if gave is not None:
            self.family.note_given(gave)

    def go_back(self) -> None:
        """Show the family again that was set aside.

        Raises:
            CommandError: there is none.
        """
        family = self.aside
        if family is None:
            raise CommandError("no run was set aside")
        self._show(family)

    def _show(self, family: Family) -> None:
        """Show a family that was set aside, in the place of the one that is shown."""
        self.note_stood()
        self._note(WentLive(family.live.number, family.held.run.step))
        if family is self.aside:
            self.aside = None
        self._set_aside()
        self.family = family

    def take_up(self, request: TakeUp) -> None:
        """Show a session that was made again, and write down there what is done from here on.

        Raises:
            CommandError: its runs have numbers that others have had.
        """
        made = request.made_again
        families = [made.family, *([] if made.aside is None else [made.aside])]
        families += [other for other in made.of_lessons.values() if other not in families]
        numbers = [number for family in families for number in (*family.lines, *family.deleted)]
        if min(numbers) < self.n_runs:
            raise CommandError("that session cannot be taken up now; ask for it again")
        if self.n_runs > 0:
            self.close()
            self.family.drop()
        for family in families:
            family.is_resumed, family.is_shared = not request.is_shared, request.is_shared
        self.journal = request.journal
        self.family, self.aside, self.n_runs = made.family, made.aside, made.n_runs
        self.stories, self._of_lessons = made.stories, made.of_lessons

    def _set_aside(self, for_opened: bool = False) -> None:
        self.family.drop()
        self.aside = aside_after(self.family, self.aside, for_opened)

    # Lessons

    def take_lesson(self, request: TakeLesson) -> bool:
        """Have a lesson be on, with its run; returns whether that begins just now.

        Raises:
            CommandError: its run cannot be had.
        """
        story, family = self.stories.of(request.name), self._of_lessons.get(request.name)
        goes_on = story is not None and story.took.digest == request.digest
        is_anew = request.is_anew or not goes_on or family is None
        begins = is_anew or request.runs_anew
        before = None if story is None or begins else story.took
        took = TookLesson(
            run=self.n_runs if before is None else before.run,
            name=request.name,
            source=request.source,
            digest=request.digest,
            text=request.text,
            language=request.language,
            start=request.start if before is None else before.start,
            follows=request.follows if before is None else before.follows,
            is_anew=is_anew,
        )
        check(took)
        if family is None or begins:
            of = request.begin
            run = Run(of.spec, of.seed)
            self.begin(run, of.preset, of.spec.trials, playing=False, plan=of.schedule)
        elif family is not self.family:
            self._show(family)
        self._note(took)
        self.stories = self.stories.after(took)
        self._of_lessons = families_of(self.stories, {**self._of_lessons, took.name: self.family})
        return begins

    def leave_lesson(self) -> None:
        """Have no lesson be on."""
        if self.stories.on is not None:
            self._note(LeftLesson())
            self.stories = self.stories.after(LeftLesson())

    def tell(self, request: Tell) -> None:
        """Do something in the lesson that is on.

        Raises:
            CommandError: that lesson is not on, or it is too much to be written down.
        """
        story, act = self.stories.on, request.act
        if story is None or story.name != request.lesson:
            raise CommandError("that lesson is not on any more")
        if isinstance(act, WentToCard):
            held = self.family.held
            run = held.run
            act = replace(
                act,
                run=held.generation,
                step=run.step,
                trial=run.trial,
                events=len(run.control.history),
            )
        check(act)
        stories = self.stories.after(act)
        if stories != self.stories:
            self._note(act)
            self.stories = stories

    # What is written down

    def note_stood(self, at_rest: bool = True) -> None:
        """Write down how far the live run is, unless that is known."""
        if self.journal is None:
            return
        held = self.family.held
        run = held.run
        # Taken up later, it is no copy of another run any more.
        stood = Stood(held.generation, run.step, run.trial, self._digest(), held.own_end)
        if stood != self._stood:
            self._stood = stood
            self.journal.stood(stood, at_rest)

    def _note_branches(self, least_trials: int = 1) -> None:
        """Write down what branches came to, if they are so many trials beyond what is known."""
        for line in self.family.lines.values():
            known, noted = line.known, line.noted_trial
            # One that has been live stands where that was written down.
            if self.journal is None or line.held is not None or not known.digest:
                continue
            if noted is None or known.trial - noted >= least_trials:
                line.noted_trial = known.trial
                stood = Stood(line.number, known.step, known.trial, known.digest, known.trial)
                self.journal.stood(stood, at_rest=True)

    def close(self) -> None:
        """Write down where all lines are left; no more is written after that."""
        self.note_stood()
        self._note_branches()
        if self.journal is not None:
            self.journal.close()

    def _digest(self) -> str:
        """Digest of the live run's tables, made anew only if they can be others."""
        run = self.family.held.run
        known, step, control, found = self._digested
        if known is not run or step != run.step or control is not run.control:
            found = digest(run.state)
            self._digested = (run, run.step, run.control, found)
        return found

    def _note(self, record: Record) -> None:
        if self.journal is not None:
            self.journal.note(record)


def _no_matter(reason: str) -> None:
    """Nobody has to be told why something could not be done."""
