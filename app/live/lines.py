"""The tree of runs that began as one: its lines, the marks on them, and which of them is live.

What is done with it is the same whether somebody asks for it or a session is made again from what
was written down: each change is a record, which is judged first and then taken in.
"""

import unicodedata
from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from app.live.held import Held, Opened
from app.live.past import Budget, Past
from app.live.places import LineSeen, Mark, Place
from app.live.records import (
    Branched,
    BroughtBack,
    Deleted,
    Gave,
    Marked,
    NamedLine,
    Unmarked,
)
from app.live.story import Stories
from learners.commands import Command, CommandError
from learners.control import Control
from learners.kernel.state import digest
from learners.measures import recent_reward
from learners.run import Run

MOST_BRANCHES: Final = 8
"""Lines of a tree beside the one that is live, and branches of it that can be brought back."""
MOST_MARKS: Final = 100
MOST_CHARACTERS: Final = 80
"""Of a mark's text, and of a name."""

FIRST_RUN: Final = "first run"
"""What the line is called from which all others branched off."""

Change = NamedLine | Deleted | BroughtBack | Marked | Unmarked
"""What can be done to a tree but to grow it and to go on with another line of it."""


class Known(NamedTuple):
    """How far a line is known, and what it came to."""

    step: int
    trial: int
    reward: float
    """Mean per trial over the last trials; NaN before the first has ended."""
    digest: str = ""
    """Of its tables there; "" while it goes on."""


def known_of(run: Run, tables: str = "") -> Known:
    """What is known of a line whose run stands there; ``tables`` is their digest, if it rests."""
    return Known(run.step, run.trial, recent_reward(run.state), tables)


@dataclass(eq=False)
class Line:
    """A run of a tree, and where it branched off."""

    number: int
    past: Past
    known: Known
    """Set anew by whoever makes steps of it."""
    held: Held | None = None
    """The run itself once it has been live; the worker alone has to do with that."""
    parent: int | None = None
    """The line that it branched off; None for the one that began by itself."""
    fork_step: int = 0
    fork_trial: int = 0
    before: Control | None = None
    """What held where it branched off, before its commands."""
    commands: tuple[Command, ...] = ()
    """Given where it branched off."""
    plain_name: str = FIRST_RUN
    """Computed of its commands, whatever other lines are called."""
    computed_name: str = FIRST_RUN
    """The same, made unlike the names of the lines that were there when it began."""
    given_name: str = ""
    is_leaving: bool = False
    """Whether it is about to be live, and not to be made up to anywhere any more."""
    is_broken: bool = False
    """Whether it could not be made any farther."""
    noted_trial: int | None = None
    """In which trial it was when it was last written down what it came to."""

    @property
    def name(self) -> str:
        """What it is called."""
        return self.given_name or self.computed_name

    @property
    def begins(self) -> Place:
        """The moment at which it branched off, its commands given."""
        return Place(self.number, self.fork_step)

    @property
    def grows(self) -> bool:
        """Whether it is made up to where the live run is."""
        return self.held is None and not self.is_leaving

    def seen(self, is_live: bool, is_growing: bool) -> LineSeen:
        """What is told of it."""
        known = self.known
        return LineSeen(
            number=self.number,
            parent=self.parent,
            fork_step=self.fork_step,
            fork_trial=self.fork_trial,
            name=self.name,
            until_step=known.step,
            until_trial=known.trial,
            reward=known.reward,
            digest="" if is_growing else known.digest,
            is_live=is_live,
            is_growing=is_growing,
        )


class Family:
    """The lines that began as one run. Changed by one thread; all others may look."""

    def __init__(self, root: Line, is_own: bool) -> None:
        """Begin with a run that is live, and that is ``is_own`` or made again from results."""
        assert root.held is not None
        self.preset = root.held.preset
        """Of the run from which all branched off, as shown."""
        self.is_own = is_own
        """Whether that began in its session, and was not made again from results."""
        self.is_resumed = False
        """Whether it was made again from what was kept of an earlier session."""
        self.is_shared = False
        """Whether it was made again from what somebody shared."""
        self.lines: dict[int, Line] = {root.number: root}
        self.deleted: dict[int, Line] = {}
        """Those that can be brought back."""
        self.live = root
        self.given: tuple[Gave | Branched, ...] = ()
        """All that was given by hand on these lines, in its order: what leads to them again."""
        self.marks: tuple[Mark, ...] = ()
        """On the lines that are there, by place."""
        self._marks: dict[int, Mark] = {}
        self._n_marks = 0

    @property
    def held(self) -> Held:
        """The live run."""
        assert self.live.held is not None
        return self.live.held

    @property
    def is_begun(self) -> bool:
        """Whether a step has been made, or something been done by hand."""
        return self.held.is_begun or len(self.lines) > 1

    def line(self, number: int) -> Line:
        """A line by its number.

        Raises:
            CommandError: it is not here.
        """
        line = self.lines.get(number)
        if line is None:
            raise CommandError("that line is not in the tree any more")
        return line

    def place(self, place: Place) -> Place:
        """The same moment on the line that it is of: a branch's beginning is its parent's.

        Raises:
            CommandError: there is no such moment.
        """
        line = self.line(place.line)
        if not 0 <= place.step <= line.past.end_step:
            raise CommandError(f"{line.name} is known up to step {line.past.end_step:,}")
        while line.parent is not None and place.step < line.fork_step:
            line = self.line(line.parent)
        return Place(line.number, place.step)

    def children(self, number: int) -> list[Line]:
        """Lines that branch off a line."""
        return [line for line in self.lines.values() if line.parent == number]

    def note_given(self, record: Gave | Branched) -> None:
        """Keep what is given by hand on one of its lines."""
        self.given = (*self.given, record)

    def _forget(self, line: int) -> None:
        self.given = tuple(record for record in self.given if record.run != line)

    # Branches

    def amends(self, place: Place) -> bool:
        """Whether what is given at a place is one more command of those that made its line.

        It is not if something hangs on that line, or if it would not begin now as it began: where
        the line that it left stands still at that moment, more may have been done there since.
        """
        line = self.line(place.line)
        return (
            line.parent is not None
            and line.before is not None
            and line.held is None
            and place.step == line.fork_step
            and self.line(line.parent).past.is_still(place.step, line.before)
            and not self.children(line.number)
            and all(mark.place.line != line.number for mark in self._marks.values())
        )

    def check_room(self) -> None:
        """Refuse one more line where there are as many as there may be.

        Raises:
            CommandError: there are.
        """
        if len(self.lines) > MOST_BRANCHES:
            raise CommandError(
                f"there are {MOST_BRANCHES} lines beside the live one, as many as there may be;"
                " delete one of them first"
            )

    def add(self, line: Line, instead_of: int | None = None) -> None:
        """Let a line branch off; the one whose place it takes is gone."""
        if instead_of is not None:
            former = self.lines.pop(instead_of)
            former.past.drop()
            self._forget(instead_of)
            line.given_name = former.given_name
        others = {other.name for other in self.lines.values()}
        line.computed_name = unlike(others, line.plain_name)
        self.lines[line.number] = line

    def check_going_live(self, number: int, step: int | None) -> Line:
        """The line that is to go on from a step, or from its end.

        Raises:
            CommandError: it cannot.
        """
        line = self.line(number)
        if line is self.live:
            raise CommandError(f"{line.name} is the live run")
        if step is None:
            return line
        if not line.fork_step <= step <= line.past.end_step:
            raise CommandError(
                f"{line.name} can go on from steps {line.fork_step:,} to {line.past.end_step:,}"
            )
        if line.held is not None and any(
            event.author == "hand" and event.step > step for event in line.held.run.control.history
        ):
            raise CommandError(
                f"what was done on {line.name} after that moment would be lost; a command that is"
                " given there makes a branch"
            )
        later = [child.name for child in self.children(number) if child.fork_step > step]
        if later:
            raise CommandError(
                f"{later[0]} begins on it after that moment; choose a later one, or delete it first"
            )
        return line

    def go_live(self, line: Line, run: Run) -> None:
        """Let a line be the live one, from where a run of it stands; the former stays as it is.

        It goes on by itself if that did.
        """
        former = self.held
        goes_on = former.is_learning
        former.pause()
        self.live.known = known_of(former.run, digest(former.run.state))
        if line.held is None:
            until_trial = max(former.until_trial, run.trial)
            line.held = Held(run, line.number, self.preset, until_trial, playing=False)
        line.held.run = run
        line.held.playing = goes_on and not line.held.is_over and line.held.error is None
        line.past.note(run)
        self.live = line

    # What else is done to it

    def check(self, change: Change) -> None:
        """Refuse a change that cannot be made.

        Raises:
            CommandError: it cannot; the message says why.
        """
        match change:
            case NamedLine(run=number, name=name):
                self.line(number)
                _check_text("a name", name)
            case Deleted(run=number):
                self._check_deletion(self.line(number))
            case BroughtBack(run=number):
                line = self.deleted.get(number)
                if line is None:
                    raise CommandError("that branch cannot be brought back any more")
                if line.parent not in self.lines:
                    raise CommandError("the line that it branched off is deleted, too")
                self.check_room()
            case Marked(run=number, step=step, text=text):
                self.place(Place(number, step))
                _check_text("the text of a mark", text)
                if not text:
                    raise CommandError("a mark needs a text")
                if len(self._marks) >= MOST_MARKS:
                    raise CommandError(
                        f"there are {MOST_MARKS} marks, as many as there may be; remove one first"
                    )
            case Unmarked(number=number):
                if number not in self._marks:
                    raise CommandError("that mark is not there any more")

    def do(self, change: Change) -> None:
        """Make a change that can be made."""
        match change:
            case NamedLine(run=number, name=name):
                self.lines[number].given_name = name
            case Deleted(run=number):
                line = self.lines.pop(number)
                line.past.drop()
                self.deleted[number] = line
                for oldest in [*self.deleted][:-MOST_BRANCHES]:
                    del self.deleted[oldest]
                    self._forget(oldest)
            case BroughtBack(run=number):
                self.lines[number] = self.deleted.pop(number)
            case Marked():
                place = Place(change.run, change.step)
                self._marks[change.number] = Mark(change.number, place, change.trial, change.text)
                self._n_marks = max(self._n_marks, change.number)
            case Unmarked(number=number):
                del self._marks[number]
        there = (mark for mark in self._marks.values() if mark.place.line in self.lines)
        self.marks = tuple(sorted(there, key=lambda mark: (mark.place.step, mark.number)))

    def mark(self, place: Place, text: str) -> Marked:
        """The record of a mark that is asked for.

        Raises:
            CommandError: there is no such moment.
        """
        line, step = self.place(place)
        trial = self.line(line).past.trial_of_step(step)
        return Marked(self._n_marks + 1, line, step, trial, text)

    def drop(self) -> None:
        """Give up the checkpoints of all lines: they are not looked at for now."""
        for line in (*self.lines.values(), *self.deleted.values()):
            line.past.drop()

    def _check_deletion(self, line: Line) -> None:
        if line is self.live:
            raise CommandError(f"{line.name} is live; make another line live first")
        children = self.children(line.number)
        if children:
            raise CommandError(f"{children[0].name} branches off {line.name}; delete it first")


def aside_after(family: Family, aside: Family | None, for_opened: bool = False) -> Family | None:
    """What is kept once another family takes the place of one, in which one had been kept so far.

    That family, unless nothing has been done in it yet, or it is of an experiment, whose results
    make it again: of several that are opened one after the other, the lesson that came before is
    kept. Where there is none, branches of such a run are worth keeping, too; and so is a family in
    which nothing has been done, ``for_opened`` runs of an experiment: from these one goes back.
    """
    if family.is_own:
        is_all_there_is = for_opened and aside is None
        return family if family.is_begun or is_all_there_is else aside
    return family if aside is None and len(family.lines) > 1 else aside


def families_of(stories: Stories, families: Mapping[str, Family]) -> dict[str, Family]:
    """Of the families that lessons had, by name, those of the lessons that are kept."""
    names = (story.name for story in stories.kept)
    return {name: families[name] for name in names if name in families}


def root_line(
    number: int,
    run: Run,
    preset: str,
    budget: Budget,
    until_trial: int,
    playing: bool = False,
    opened: Opened | None = None,
) -> Line:
    """A line that begins by itself, and is live."""
    held = Held(run, number, preset, until_trial, playing, opened=opened)
    return Line(number, Past(run, budget), known_of(run), held)


@dataclass(frozen=True)
class MadeAgain:
    """The trees of a session, made again from what was written down of it."""

    family: Family
    """With the run that was live."""
    aside: Family | None
    """What was set aside for it."""
    n_runs: int
    """Runs that the session had: the next one's number."""
    stories: Stories = Stories()  # noqa: RUF009  (it never changes)
    """Lessons that were taken, and how they stand."""
    of_lessons: Mapping[str, Family] = field(default_factory=dict[str, Family])
    """Of each lesson, by its name, the family of its run."""


def unlike(others: Container[str], name: str) -> str:
    """The name that a branch has in a tree in which others may have it."""
    more, found = 2, name
    while found in others:
        found = f"{name} ({more})"
        more += 1
    return found


def one_line(text: str) -> str:
    """A line of text as it is kept: characters that can be read, and single spaces."""
    printable = "".join(
        " " if unicodedata.category(character)[0] in "CZ" else character for character in text
    )
    return " ".join(printable.split())


def _check_text(what: str, text: str) -> None:
    if len(text) > MOST_CHARACTERS:
        raise CommandError(f"{what} has at most {MOST_CHARACTERS} characters")
    if text != one_line(text):
        raise CommandError(f"{what} is one line of characters that can be read")
