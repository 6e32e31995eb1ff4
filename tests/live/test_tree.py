"""Branches, what is done to them, and what is written down: against runs made from the start."""

import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.live.branching import LEAST_TRIALS
from app.live.lines import MOST_BRANCHES, MOST_CHARACTERS, MOST_MARKS
from app.live.places import LineSeen, Place
from app.live.records import (
    Began,
    Branched,
    BroughtBack,
    Deleted,
    Gave,
    Marked,
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
    GoBack,
    MakeLive,
    NameLine,
    OpenRun,
    Pause,
    Play,
    RemoveMark,
    Request,
    RunTo,
    SetSpeed,
    SkipOpening,
    StartAgain,
    StepOnce,
)
from app.live.session import Session
from app.live.status import Status
from app.live.worker import FULL_SPEED
from learners.commands import Command, FreezeSelection, FreezeSkills, Introduce, SetParameter, Undo
from learners.kernel.state import digest
from learners.names import MAX_TRIALS
from learners.run import Run
from tests.support import lines as made_up
from tests.support.lines import SEED, SPEC

PATIENCE_S = 60.0
"""How long to wait for what must happen; reaching it is a failure."""
FREEZE = FreezeSelection(frozen=True)
SLOWER = SetParameter("learner.alpha", 0.2)
VIEWER = 3


class Kept:
    """A journal that keeps its records, and looks at each moment at which it gets one."""

    def __init__(self) -> None:
        self.records: list[Record] = []
        self.looked: list[Any] = []
        self.look: Callable[[], Any] = lambda: None
        self.fault: str | None = None

    def note(self, record: Record) -> None:
        self.looked.append(self.look())
        self.records.append(record)

    def stood(self, record: Stood, at_rest: bool = False) -> None:
        self.looked.append(at_rest)
        self.records.append(record)

    def close(self) -> None:
        pass


class Desk:
    """A session, paused at first, and what is asked of it."""

    def __init__(self, **options: Any) -> None:
        self.kept = Kept()
        self.session = Session(SPEC, "timed", SEED, FULL_SPEED, False, journal=self.kept, **options)
        self.session.start()

    def ask(self, *requests: Request) -> Status:
        """The status in which all these requests have been answered."""
        return self.told(requests)[0]

    def refusals(self, *requests: Request) -> list[str]:
        """Why they were not carried out, once they have been answered, and all before them."""
        return self.told(requests)[1]

    def told(self, requests: Sequence[Request]) -> tuple[Status, list[str]]:
        refusals: list[str] = []
        for request in requests:
            self.session.submit(request, refusals.append)
        done = threading.Event()
        # What was asked of the thread of moments comes back before what is asked of it after.
        self.session.wait_for(self._answers(self.session.submit(SkipOpening())), PATIENCE_S)
        self.session.moments.ask(lambda: None, lambda _: done.set())
        assert done.wait(PATIENCE_S)
        answers = self._answers(self.session.submit(SkipOpening()))
        return self.session.wait_for(answers, PATIENCE_S), refusals

    def at(self, trial: int, steps: int = 0) -> Status:
        """Learn to so many steps after the start of a trial, and stand still there."""
        if trial > self.session.status.snapshot.trial:
            self.ask(RunTo(trial))
            self.session.wait_for(lambda s: s.snapshot.trial >= trial and not s.playing, PATIENCE_S)
        return self.ask(*[StepOnce()] * steps)

    def branch(self, line: int, step: int, command: Command = FREEZE) -> LineSeen:
        """The line that comes of a command at a moment."""
        status, refusals = self.told([Branch(Place(line, step), command, VIEWER)])
        assert not refusals
        viewer, place = status.branched[-1]
        assert viewer == VIEWER
        return self.line(place.line)

    def rests(self) -> dict[int, LineSeen]:
        """The lines, once no branch grows any more."""
        status = self.session.wait_for(
            lambda s: not any(line.is_growing for line in s.lines), PATIENCE_S
        )
        return {line.number: line for line in status.lines}

    def line(self, number: int) -> LineSeen:
        """A line as it is told now."""
        return next(line for line in self.session.status.lines if line.number == number)

    def reference(self, line: int, step: int) -> Run:
        """A run from the start that was given all that was written down of a line."""
        return reference(self.kept.records, line, step)

    def check(self) -> None:
        """All lines are what a run from the start is that was given the same."""
        for line in self.rests().values():
            again = self.reference(line.number, line.until_step)
            assert (line.until_trial, line.digest) == (again.trial, digest(again.state))

    @staticmethod
    def _answers(ticket: int) -> Callable[[Status], bool]:
        return lambda status: status.answered >= ticket


def given_on(records: Sequence[Record], line: int) -> list[tuple[int, Command]]:
    """Commands by hand that a line has had, and their steps, by what was written down."""
    had: list[tuple[int, Command]] = []
    for place, record in enumerate(records):
        match record:
            case Gave(run=run, step=step, command=command) if run == line:
                had.append((step, command))
            case Branched(run=run, parent=parent, step=step, commands=commands) if run == line:
                before = given_on(records[:place], parent)
                had += [(at, command) for at, command in before if at <= step]
                had += [(step, command) for command in commands]
            case WentLive(run=run, step=step) if run == line and step is not None:
                had = [(at, command) for at, command in had if at <= step]
            case _:
                pass
    return had


def reference(records: Sequence[Record], line: int, step: int) -> Run:
    """A run from the start, given what a line was given."""
    root = line
    parents = {r.run: r.parent for r in records if isinstance(r, Branched)}
    while root in parents:
        root = parents[root]
    began = next(r for r in records if isinstance(r, Began) and r.run == root)
    run = Run(began.spec, began.seed)
    for at, command in given_on(records, line):
        if at > step:
            break
        run.advance(max_steps=at - run.step, until_trial=MAX_TRIALS)
        run.apply(command, replacing=True)
    run.advance(max_steps=step - run.step, until_trial=MAX_TRIALS)
    return run


@pytest.fixture
def desk() -> Iterator[Desk]:
    """A session of its own."""
    desk = Desk()
    yield desk
    desk.session.stop()


# Branches


def test_a_command_in_the_past_makes_a_branch_and_the_live_run_stays(desk: Desk) -> None:
    before = desk.at(80).snapshot
    branch = desk.branch(0, 700)
    assert (branch.parent, branch.fork_step, branch.is_live) == (0, 700, False)
    assert branch.fork_trial == desk.reference(0, 700).trial
    line = desk.rests()[branch.number]
    assert line.until_trial == branch.fork_trial + LEAST_TRIALS
    live = desk.line(0)
    assert (live.is_live, live.until_step, live.until_trial) == (True, before.step, before.trial)
    assert desk.session.status.snapshot.generation == 0
    assert live.digest == digest(desk.reference(0, before.step).state) != line.digest
    desk.check()


def test_branches_follow_the_live_run(desk: Desk) -> None:
    desk.at(20)
    branch = desk.branch(0, 100)
    desk.rests()
    desk.at(LEAST_TRIALS + 400)
    assert desk.rests()[branch.number].until_trial == LEAST_TRIALS + 400
    desk.at(LEAST_TRIALS + 401)
    assert desk.rests()[branch.number].until_trial == LEAST_TRIALS + 401
    desk.check()


def test_a_branch_grows_by_so_many_steps_and_no_farther(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.live.branching.MOST_STEPS", 20_000)
    desk.at(40)
    branch = desk.branch(0, 300)
    line = desk.rests()[branch.number]
    assert line.until_step == 20_000
    assert line.digest == digest(desk.reference(branch.number, 20_000).state)


def test_what_goes_on_has_no_digest(desk: Desk) -> None:
    desk.ask(SetSpeed(50.0))
    desk.ask(Play())
    status = desk.session.wait_for(lambda s: s.playing and s.snapshot.step > 3, PATIENCE_S)
    assert status.lines[0].digest == ""
    assert desk.ask(Pause()).lines[0].digest != ""
    desk.check()


def test_a_branch_branches(desk: Desk) -> None:
    desk.at(60)
    first = desk.branch(0, 500)
    desk.rests()
    second = desk.branch(first.number, 2_000, SLOWER)
    assert (second.parent, second.fork_step) == (first.number, 2_000)
    third = desk.branch(second.number, 1_500, FreezeSkills(frozen=True))
    assert (third.parent, third.fork_step) == (first.number, 1_500), "before it began: its parent"
    desk.check()
    commands = [command for _, command in given_on(desk.kept.records, second.number)]
    assert commands == [FREEZE, SLOWER]


def test_what_cannot_be_done_there_is_told_and_makes_no_branch(desk: Desk) -> None:
    desk.at(30)
    end = desk.session.status.snapshot.step
    refused = {
        Branch(Place(0, 300), Introduce("approach", 5)): "approach has joined already",
        Branch(Place(0, end + 1), FREEZE): f"first run is known up to step {end:,}",
        Branch(Place(0, -1), FREEZE): f"first run is known up to step {end:,}",
        Branch(Place(9, 0), FREEZE): "that line is not in the tree any more",
        MakeLive(0): "first run is the live run",
        MakeLive(4): "that line is not in the tree any more",
        DeleteLine(0): "first run is live; make another line live first",
        BringBack(0): "that branch cannot be brought back any more",
        RemoveMark(1): "that mark is not there any more",
        AddMark(Place(0, 10), " \n "): "a mark needs a text",
        NameLine(0, "x" * (MOST_CHARACTERS + 1)): "a name has at most 80 characters",
    }
    for request, why in refused.items():
        assert desk.refusals(request) == [why]
    assert desk.rests().keys() == {0}
    assert not [r for r in desk.kept.records if not isinstance(r, Began | Stood)]


def test_there_are_so_many_branches_and_no_more(desk: Desk) -> None:
    desk.at(30)
    for step in range(MOST_BRANCHES):
        desk.branch(0, 10 * step)
    (why,) = desk.refusals(Branch(Place(0, 300), FREEZE))
    assert why.startswith("there are 8 lines beside the live one, as many as there may be; delete")
    newest = desk.session.status.lines[-1].number
    desk.ask(DeleteLine(newest))
    desk.branch(0, 300)
    assert "as many as there may be" in desk.refusals(BringBack(newest))[0]
    desk.check()


def test_many_that_are_asked_for_at_once_are_not_more_than_there_may_be(desk: Desk) -> None:
    desk.at(30)
    refusals = desk.refusals(*[Branch(Place(0, 10 * step), FREEZE) for step in range(20)])
    assert len(refusals) == 20 - MOST_BRANCHES
    assert len(desk.rests()) == 1 + MOST_BRANCHES


# Commands where a branch begins


def test_a_command_where_a_branch_begins_is_one_more_of_its_own(desk: Desk) -> None:
    desk.at(60)
    first = desk.branch(0, 500)
    desk.ask(NameLine(first.number, "mine"))
    second = desk.branch(first.number, 500, SLOWER)
    assert (second.parent, second.fork_step, second.name) == (0, 500, "mine")
    assert desk.rests().keys() == {0, second.number}
    assert [r for r in desk.kept.records if isinstance(r, Branched)][-1] == Branched(
        second.number, 0, 500, (FREEZE, SLOWER), instead_of=first.number
    )
    third = desk.branch(second.number, 500, FreezeSelection(frozen=False))
    history = desk.session.snapshot_at(Place(third.number, 500)).control.history
    assert [event.command for event in history if event.author == "hand"] == [SLOWER]
    desk.check()


def test_a_slider_that_is_shaken_where_it_was_set_before_is_written_down_once(desk: Desk) -> None:
    step = desk.at(30).snapshot.step
    desk.ask(SetParameter("learner.epsilon", 0.2))
    desk.at(40)
    line = 0
    for epsilon in (0.3, 0.4, 0.5):
        line = desk.branch(line, step, SetParameter("learner.epsilon", epsilon)).number
    *_, branched = [record for record in desk.kept.records if isinstance(record, Branched)]
    assert branched.commands == (SetParameter("learner.epsilon", 0.5),)
    desk.check()


def test_no_more_is_done_at_a_moment_than_can_be_written_down(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.live.branching.MOST_COMMANDS", 1)
    desk.at(60)
    first = desk.branch(0, 500)
    (refusal,) = desk.refusals(Branch(Place(first.number, 500), SLOWER))
    assert refusal == "1 things were done at that very moment, as many as may be; go a step on"
    assert desk.rests().keys() == {0, first.number}


def test_where_more_was_done_since_a_branch_stays_as_it_began(desk: Desk) -> None:
    step = desk.at(30).snapshot.step
    first = desk.branch(0, step)
    desk.ask(FreezeSkills(frozen=True))
    second = desk.branch(first.number, step, SLOWER)
    third = desk.branch(0, step, SLOWER)
    assert (second.parent, third.parent) == (first.number, 0)
    desk.check()


def test_what_is_done_while_a_branch_is_begun_is_told_to_whoever_began_it(desk: Desk) -> None:
    step = desk.at(30).snapshot.step
    begun, goes_on, refusals = threading.Event(), threading.Event(), list[str]()
    submit = desk.session._tree._submit

    def late(*made: Any) -> Any:
        begun.set()
        goes_on.wait(PATIENCE_S)
        return submit(*made)

    desk.session._tree._submit = late
    desk.session.submit(Branch(Place(0, step), FREEZE), refusals.append)
    assert begun.wait(PATIENCE_S)
    ticket = desk.session.submit(FreezeSkills(frozen=True))
    desk.session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    goes_on.set()
    desk.ask(Pause())
    assert refusals == ["more was done at that moment meanwhile; give the command again"]
    assert desk.rests().keys() == {0}


def test_a_hand_that_shakes_where_a_branch_begins_leaves_what_it_came_to(desk: Desk) -> None:
    desk.at(60)
    line = desk.branch(0, 500)
    for number in range(30):
        line = desk.branch(line.number, 500, SetParameter("learner.alpha", 0.1 + number / 100))
    last = desk.kept.records[-1]
    assert isinstance(last, Branched)
    assert last.commands == (FREEZE, SetParameter("learner.alpha", 0.1 + 29 / 100))
    desk.check()


def test_the_live_run_is_the_same_whatever_branches_off_it(desk: Desk) -> None:
    desk.ask(RunTo(30_000))
    for step in range(40):
        end = desk.session.status.snapshot.step
        desk.ask(Branch(Place(0, end * step // 40), SetParameter("learner.alpha", 0.2)))
        newest = desk.session.status.lines[-1]
        if not newest.is_live and step % 3:
            desk.ask(DeleteLine(newest.number))
    taken = desk.at(30_001).snapshot
    desk.check()
    alone = Run(SPEC, SEED)
    alone.advance(until_trial=taken.trial)
    assert desk.line(0).digest == digest(alone.state)


@pytest.mark.parametrize("what", ["branch", "mark", "was live"])
def test_where_something_hangs_on_it_a_branch_stays_and_another_begins(
    desk: Desk, what: str
) -> None:
    desk.at(60)
    first = desk.branch(0, 500)
    desk.rests()
    match what:
        case "branch":
            desk.branch(first.number, 600)
        case "mark":
            desk.ask(AddMark(Place(first.number, 510), "here"))
        case _:
            desk.ask(MakeLive(first.number, 500))
            desk.ask(MakeLive(0))
    second = desk.branch(first.number, 500, SLOWER)
    assert (second.parent, second.fork_step) == (first.number, 500)
    assert first.number in desk.rests()
    desk.check()


# Which is live


@pytest.mark.parametrize("beyond", [None, 0, 700])
def test_a_branch_that_is_made_live_learns_on_as_if_it_had_been_so_from_the_start(
    desk: Desk, beyond: int | None
) -> None:
    former = desk.at(60).snapshot
    number = desk.branch(0, 500).number
    branch = desk.rests()[number]
    step = None if beyond is None else 500 + beyond
    taken = desk.ask(MakeLive(branch.number, step)).snapshot
    assert taken.generation == branch.number
    assert taken.step == (branch.until_step if step is None else step)
    desk.ask(FreezeSelection(frozen=False))
    taken = desk.at(taken.trial + 50, steps=3).snapshot
    assert desk.refusals(Undo(99)) == ["nothing was done by hand under the number 99"]
    lines = desk.rests()
    assert (lines[0].is_live, lines[branch.number].is_live) == (False, True)
    assert (lines[0].until_step, lines[0].until_trial) == (former.step, former.trial)
    assert lines[branch.number].until_step == taken.step
    desk.check()
    # And back again: what was live first is as it was.
    assert desk.ask(MakeLive(0)).snapshot.step == former.step
    desk.at(70, steps=1)
    desk.check()


def test_the_run_that_comes_goes_on_if_the_one_that_leaves_did(desk: Desk) -> None:
    desk.at(40)
    branch = desk.branch(0, 500)
    assert not desk.ask(MakeLive(branch.number, 500)).playing
    desk.ask(SetSpeed(50.0))
    desk.session.submit(Play())
    desk.session.submit(MakeLive(0, 600))
    status = desk.session.wait_for(lambda s: s.snapshot.generation == 0, PATIENCE_S)
    assert status.playing


def test_what_begins_later_on_a_line_is_not_cut_off(desk: Desk) -> None:
    desk.at(40)
    first = desk.branch(0, 300)
    desk.rests()
    second = desk.branch(first.number, 700)
    (why,) = desk.refusals(MakeLive(first.number, 600))
    assert why.startswith(f"{second.name} begins on it after that moment")
    assert not desk.refusals(MakeLive(first.number, 700))
    (why,) = desk.refusals(MakeLive(second.number, 699))
    assert why.startswith(f"{second.name} can go on from steps 700 to ")
    desk.check()


def test_what_was_done_on_a_line_later_is_not_cut_off_either(desk: Desk) -> None:
    step = desk.at(30).snapshot.step
    desk.ask(FREEZE)
    end = desk.at(40).snapshot.step
    branch = desk.branch(0, 300)
    desk.ask(MakeLive(branch.number))
    (why,) = desk.refusals(MakeLive(0, step - 1))
    assert why.startswith("what was done on first run after that moment would be lost")
    assert not desk.refusals(MakeLive(0, step))
    assert desk.at(40).snapshot.step == end
    desk.check()


def test_a_line_that_could_not_be_made_live_still_grows(desk: Desk) -> None:
    desk.at(40)
    branch = desk.branch(0, 300)
    # By the time at which the run stands there, the branch is gone, or has come back.
    desk.told([MakeLive(branch.number, 310), DeleteLine(branch.number), BringBack(branch.number)])
    desk.rests()
    desk.check()


# What else is done to lines


def test_a_branch_that_is_brought_back_is_as_it_was(desk: Desk) -> None:
    desk.at(40)
    desk.branch(0, 300)
    first = [*desk.rests().values()][1]
    desk.ask(DeleteLine(first.number))
    assert desk.rests().keys() == {0}
    assert desk.session.past_of(first.number) is None
    desk.ask(BringBack(first.number))
    assert desk.rests()[first.number] == first
    desk.check()


def test_a_line_with_branches_of_its_own_is_not_deleted(desk: Desk) -> None:
    desk.at(40)
    first = desk.branch(0, 300)
    desk.rests()
    second = desk.branch(first.number, 400, SLOWER)
    (why,) = desk.refusals(DeleteLine(first.number))
    assert why == f"{second.name} branches off {first.name}; delete it first"
    assert not desk.refusals(DeleteLine(second.number), DeleteLine(first.number))
    (why,) = desk.refusals(BringBack(second.number))
    assert why == "the line that it branched off is deleted, too"
    assert not desk.refusals(BringBack(first.number), BringBack(second.number))
    desk.check()


def test_names_are_one_line_and_can_be_taken_back(desk: Desk) -> None:
    desk.at(40)
    first, second = desk.branch(0, 300), desk.branch(0, 310)
    assert (first.name, second.name) == ("branch", "branch (2)")
    desk.ask(NameLine(first.number, "  a\n<b>\x00name\u202e "), NameLine(0, "trunk"))
    assert (desk.line(first.number).name, desk.line(0).name) == ("a <b> name", "trunk")
    desk.ask(NameLine(first.number, ""))
    assert desk.line(first.number).name == "branch"
    named = [record for record in desk.kept.records if isinstance(record, NamedLine)]
    assert [record.name for record in named] == ["a <b> name", "trunk", ""]


def test_marks_lie_on_lines_that_are_there(desk: Desk) -> None:
    desk.at(40)
    first = desk.branch(0, 300)
    desk.rests()
    desk.ask(
        AddMark(Place(first.number, 1_000), "later"),
        AddMark(Place(first.number, 200), "before it began"),
        AddMark(Place(0, 100), "early"),
    )
    marks = desk.session.status.marks
    assert [(mark.place, mark.text) for mark in marks] == [
        (Place(0, 100), "early"),
        (Place(0, 200), "before it began"),
        (Place(first.number, 1_000), "later"),
    ]
    assert [mark.trial for mark in marks[:2]] == [desk.reference(0, s).trial for s in (100, 200)]
    desk.ask(DeleteLine(first.number))
    assert [mark.text for mark in desk.session.status.marks] == ["early", "before it began"]
    desk.ask(BringBack(first.number), RemoveMark(marks[0].number))
    assert [mark.text for mark in desk.session.status.marks] == ["before it began", "later"]


def test_there_are_so_many_marks_and_no_longer_ones(desk: Desk) -> None:
    desk.at(10)
    assert not desk.refusals(*[AddMark(Place(0, step), "x") for step in range(MOST_MARKS)])
    (why,) = desk.refusals(AddMark(Place(0, 0), "x"))
    assert why.startswith("there are 100 marks")
    (why,) = desk.refusals(AddMark(Place(0, 0), "x" * (MOST_CHARACTERS + 1)))
    assert why == "the text of a mark has at most 80 characters"


def test_lines_are_told_anew_only_if_something_has_changed(desk: Desk) -> None:
    desk.at(40)
    desk.branch(0, 300)
    desk.rests()
    lines = desk.ask(Pause()).lines
    assert desk.ask(SetSpeed(10.0), Pause()).lines is lines


# Families


def test_a_family_is_set_aside_and_comes_back_whole(desk: Desk) -> None:
    desk.at(60)
    branch = desk.branch(0, 500)
    desk.rests()
    desk.ask(MakeLive(branch.number, 900), AddMark(Place(branch.number, 600), "here"))
    before = desk.rests()
    marks = desk.session.status.marks
    status = desk.ask(StartAgain(SPEC, "timed", 9, paused=True))
    assert (len(status.lines), status.marks) == (1, ())
    assert desk.session.budget.nbytes == 0
    assert desk.refusals(Branch(Place(branch.number, 600), SLOWER)) == [
        "that line is not in the tree any more"
    ]
    desk.at(30)
    other = desk.branch(status.snapshot.generation, 100)
    status = desk.ask(GoBack())
    assert (desk.rests(), status.marks) == (before, marks)
    assert status.snapshot.generation == branch.number
    desk.check()
    assert desk.ask(GoBack()).snapshot.preset_spec == SPEC
    assert other.number in desk.rests()
    desk.check()


def test_branches_of_a_run_of_an_experiment_are_kept_where_nothing_else_is(desk: Desk) -> None:
    alone = Run(SPEC, 9)
    alone.advance(max_steps=2_000)
    desk.at(30)
    opened = OpenRun(SPEC, "timed", 9, alone.step, digest(alone.state), "figure: timed, seed 9")
    desk.ask(opened)
    status = desk.session.wait_for(lambda s: s.opened is not None and s.opened.same, PATIENCE_S)
    branch = desk.branch(status.snapshot.generation, 1_000)
    desk.rests()
    assert desk.ask(GoBack()).snapshot.generation == 0
    assert branch.number in {line.number for line in desk.ask(GoBack()).lines}
    # But not in the place of one's own run.
    desk.ask(StartAgain(SPEC, "timed", 3, paused=True))
    assert desk.ask(GoBack()).snapshot.generation == 0
    desk.check()


def test_a_branch_of_a_run_that_is_shown_no_more_is_refused(desk: Desk) -> None:
    desk.at(60)
    held_up = threading.Event()
    desk.session.moments.ask(lambda: held_up.wait(PATIENCE_S), lambda _: None)
    refusals: list[str] = []
    desk.session.submit(Branch(Place(0, 500), FREEZE), refusals.append)
    ticket = desk.session.submit(StartAgain(SPEC, "timed", 9))
    desk.session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    held_up.set()
    desk.ask(Pause())
    assert refusals == ["another run has come on the board meanwhile"]


# What is written down


def test_what_is_done_is_written_down_before_it_takes_effect(desk: Desk) -> None:
    desk.at(40)
    held = desk.session._held()
    desk.kept.look = lambda: (held.run.control, desk.session._tree.family.lines.copy())
    desk.kept.looked.clear()
    branch = desk.branch(0, 300)
    desk.rests()
    desk.ask(FREEZE, FREEZE, Introduce("approach", 2), DeleteLine(branch.number))
    desk.ask(BringBack(branch.number), MakeLive(branch.number))
    desk.ask(AddMark(Place(0, 10), "here"), RemoveMark(1), NameLine(0, "trunk"))
    first = desk.kept.records.index(
        next(record for record in desk.kept.records if isinstance(record, Branched))
    )
    noted = [
        (type(record), looked)
        for record, looked in zip(
            desk.kept.records[first:],
            desk.kept.looked[-len(desk.kept.records[first:]) :],
            strict=True,
        )
        if not isinstance(record, Stood)
    ]
    assert [kind for kind, _ in noted] == [
        Branched,
        Gave,
        Gave,
        Deleted,
        BroughtBack,
        WentLive,
        Marked,
        Unmarked,
        NamedLine,
    ]
    frozen = [control.selection_frozen for _, (control, _) in noted]
    there = [branch.number in lines for _, (_, lines) in noted]
    assert frozen[:3] == [False, False, True]
    assert there[:5] == [False, True, True, True, False]


def test_how_far_a_run_is_is_written_down_whenever_it_stops(desk: Desk) -> None:
    desk.at(40)
    desk.ask(StepOnce())
    stood = [record for record in desk.kept.records if isinstance(record, Stood)]
    for record in stood:
        again = reference(desk.kept.records, record.run, record.step)
        assert (record.trial, record.digest) == (again.trial, digest(again.state))
    step = desk.session.status.snapshot.step
    assert [record.step for record in stood[-2:]] == [step - 1, step]
    desk.ask(StartAgain(SPEC, "timed", 9))
    last, began = [r for r in desk.kept.records if isinstance(r, Stood | Began)][-3:-1]
    assert (last, began) == (stood[-1], Began(1, "timed", SPEC, 9))
    desk.ask(RunTo(20))
    desk.ask(Pause())
    desk.session.stop()
    assert desk.kept.records[-1].run == 1
    assert desk.kept.records[-1].step == desk.session._held().run.step


def test_what_branches_come_to_is_written_down_where_all_stands_still(desk: Desk) -> None:
    def noted() -> list[Stood]:
        records = [record for record in desk.kept.records if isinstance(record, Stood)]
        return [record for record in records if record.run == branch.number]

    desk.at(40)
    branch = desk.branch(0, 300)
    line = desk.rests()[branch.number]
    desk.ask()
    (only,) = noted()
    assert (only.step, only.trial, only.digest) == (line.until_step, line.until_trial, line.digest)
    # A little more of it is written down once the session is left.
    desk.at(LEAST_TRIALS + 41)
    line = desk.rests()[branch.number]
    assert (line.until_trial, noted()) == (LEAST_TRIALS + 41, [only])
    desk.session.stop()
    assert [record.digest for record in noted()] == [only.digest, line.digest]


def test_a_run_of_an_experiment_that_is_taken_up_on_the_way_ends_where_its_preset_does(
    desk: Desk,
) -> None:
    desk.ask(OpenRun(SPEC, "timed", 9, 10**12, "0" * 64, "figure: timed, seed 9"))
    desk.ask(StartAgain(SPEC, "timed", 3, paused=True))
    stood = [r for r in desk.kept.records if isinstance(r, Stood) and r.run == 1]
    assert [r.until_trial for r in stood] == [max(SPEC.trials, r.trial) for r in stood]
    assert stood


def test_what_is_wrong_with_a_journal_is_told(desk: Desk) -> None:
    desk.kept.fault = "the disk is full"
    assert desk.ask(StepOnce()).journal == "the disk is full"
    desk.kept.fault = None
    assert desk.ask(StepOnce()).journal is None


# Threads


@pytest.fixture
def endless_branches(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a branch grow for half a minute, so that it still does whenever somebody looks."""
    monkeypatch.setattr("app.live.branching.LEAST_TRIALS", MAX_TRIALS)
    monkeypatch.setattr("app.live.branching._SLICE_STEPS", 50)


@pytest.mark.usefixtures("endless_branches")
def test_it_stops_while_a_branch_grows(desk: Desk) -> None:
    desk.at(40)
    desk.branch(0, 300)
    grown = desk.session.wait_for(
        lambda s: s.lines[-1].until_trial > 5_000,
        PATIENCE_S,
    )
    assert grown.lines[-1].is_growing
    assert grown.lines[-1].digest == ""
    desk.session.stop()
    assert desk.session.is_gone


@pytest.mark.usefixtures("endless_branches")
def test_a_moment_is_made_while_a_branch_grows(desk: Desk) -> None:
    desk.at(40)
    branch = desk.branch(0, 300)
    # Of a branch that is not known so far, it would be where that ends.
    desk.session.wait_for(lambda status: status.lines[-1].until_step >= 400, PATIENCE_S)
    found = threading.Event()
    desk.session.moments.call_when_found(found.set)
    desk.session.moments.want("somebody", Place(branch.number, 400))
    assert found.wait(PATIENCE_S)
    made = desk.session.moments.found("somebody")
    assert made is not None
    assert (made.generation, made.step) == (branch.number, 400)
    assert desk.line(branch.number).is_growing


def test_the_past_can_be_acted_in_while_the_worker_is_deaf(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.at(40)
    branch = desk.branch(0, 300)
    desk.rests()
    compiled, compiling, advance = threading.Event(), threading.Event(), Run.advance

    def compile_first(run: Run, *limits: Any, **more: Any) -> int:
        if threading.current_thread().name == "learner":
            compiling.set()
            compiled.wait(PATIENCE_S)
        return advance(run, *limits, **more)

    monkeypatch.setattr(Run, "advance", compile_first)
    desk.session.submit(StepOnce())
    assert compiling.wait(PATIENCE_S)
    assert desk.session.snapshot_at(Place(branch.number, 900)).step == 900
    ticket = desk.session.submit(Branch(Place(branch.number, 900), SLOWER))
    compiled.set()
    desk.session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    desk.ask(Pause())
    assert len(desk.rests()) == 3
    desk.check()


def test_a_branch_that_cannot_be_made_farther_is_left_and_all_else_goes_on(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.at(40)
    advance = Run.advance

    def broken(run: Run, *limits: Any, **more: Any) -> int:
        if threading.current_thread().name == "moments" and run.control.selection_frozen:
            raise ValueError("the branch is broken")
        return advance(run, *limits, **more)

    monkeypatch.setattr(Run, "advance", broken)
    first, second = desk.branch(0, 300, FREEZE), desk.branch(0, 300, SLOWER)
    lines = desk.rests()
    assert lines[first.number].until_step == 300
    assert lines[second.number].until_trial == second.fork_trial + LEAST_TRIALS
    assert desk.at(50).error is None


# At random


moves = st.one_of(
    st.tuples(st.just("on"), st.integers(1, 30), st.sampled_from([0, 1, 5])),
    st.tuples(st.just("give"), made_up.commands, st.none()),
    st.tuples(st.just("branch"), st.integers(0, 9), st.tuples(st.floats(0, 1), made_up.commands)),
    st.tuples(st.just("branch"), st.integers(0, 9), st.tuples(st.floats(0, 1), made_up.commands)),
    st.tuples(st.just("amend"), st.integers(0, 9), made_up.commands),
    st.tuples(st.just("live"), st.integers(0, 9), st.none() | st.floats(0, 1)),
    st.tuples(st.just("delete"), st.integers(0, 9), st.none()),
    st.tuples(st.just("back"), st.integers(0, 9), st.none()),
    st.tuples(st.just("again"), st.none(), st.none()),
    st.tuples(st.just("go back"), st.none(), st.none()),
)


def done(desk: Desk, move: tuple[str, Any, Any]) -> None:
    """Do something; it may be refused."""
    what, which, how = move
    lines = [*desk.rests().values()]
    line = lines[(which if isinstance(which, int) else 0) % len(lines)]
    match what:
        case "on":
            desk.at(desk.session.status.snapshot.trial + which, steps=how)
        case "give":
            desk.ask(which)
        case "branch":
            desk.ask(Branch(Place(line.number, int(how[0] * line.until_step)), how[1]))
        case "amend":
            desk.ask(Branch(Place(line.number, line.fork_step), how))
        case "live":
            between = line.until_step - line.fork_step
            step = None if how is None else line.fork_step + int(how * between)
            desk.ask(MakeLive(line.number, step))
        case "delete":
            desk.ask(DeleteLine(line.number))
        case "back":
            desk.ask(BringBack(which))
        case "again":
            desk.ask(StartAgain(SPEC, "timed", which or 1, paused=True))
        case _:
            desk.ask(GoBack())


@settings(max_examples=25)
@given(st.lists(moves, max_size=14))
def test_whatever_is_done_all_lines_are_what_was_given_to_them(
    whole: list[tuple[str, Any, Any]],
) -> None:
    desk = Desk()
    try:
        for move in whole:
            done(desk, move)
            assert desk.session.status.error is None
        desk.check()
        live = desk.session.status.snapshot
        taken = desk.session.snapshot_at(Place(live.generation, live.step // 2))
        again = desk.reference(live.generation, taken.step)
        assert taken.control == again.control
    finally:
        desk.session.stop()
