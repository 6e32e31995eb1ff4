"""A session from its records: every line, name and mark, and the live run where it stood.

Records are taken in their order into families of runs (:mod:`app.live.lines`), as the session took
what was asked of it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from app.live.branching import NameOf, begin, run_at
from app.live.lines import Family, Line, MadeAgain, aside_after, families_of, known_of, root_line
from app.live.past import Budget, Past
from app.live.places import Place
from app.live.records import (
    Began,
    Branched,
    BroughtBack,
    Deleted,
    Gave,
    Journal,
    Marked,
    NamedLine,
    Record,
    Stood,
    Unmarked,
    WentLive,
)
from app.live.story import Stories, TookLesson
from app.live.written import DamagedError, Written
from learners.commands import Command, CommandError, SetParameter, Undo
from learners.kernel.state import digest
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.spec import RunSpec

_SLICE: Final = 200_000
"""Steps between two moments at which it can be broken off."""
_COPY: Final = 20_000
"""Steps that take about as long as to come to a moment at which there is a checkpoint."""
_CELL: Final = 5
"""Steps that take about as long as to compile a cell of a world."""
_EVENT: Final = 300
"""Steps that take about as long as to play an event of a history again."""

OnStep = Callable[[float], object]
"""Told now and then which share of the records has been taken."""


@dataclass(frozen=True)
class Remade:
    """A session that was made again."""

    made: MadeAgain
    differ: tuple[str, ...]
    """Names of the lines whose tables are not those that were written down."""
    n_compared: int
    """Lines of which it was written down how they stood."""
    records: tuple[Record, ...]
    """The same session as it is here: how each line stands, as it was made."""


def made_again(
    written: Written,
    budget: Budget,
    name_of: NameOf,
    first_number: int = 0,
    on_step: OnStep | None = None,
    most_steps: int | None = None,
) -> Remade:
    """Make a session again; its live run stands still, where it was last written down to be.

    Args:
        written: what was read of it.
        budget: memory for checkpoints of its lines.
        name_of: computes names of branches.
        first_number: of its runs; those of its file begin with 0.
        on_step: told now and then how far it is.
        most_steps: that may be made for it, about; None for as many as it takes.

    Raises:
        DamagedError: its records do not go together, or it takes more.
    """
    making = _Making(written.records, budget, name_of, first_number, on_step, most_steps)
    for place, record in enumerate(written.records):
        try:
            making.take(place, renumbered(record, first_number))
        except ValueError as error:
            # Refused commands are such, and so are seeds and settings that no run can have.
            saved = replace(written, records=written.records[:place])
            raise DamagedError(f"{written.path}: line {place + 2}: {error}", saved) from error
    return making.remade(written)


def renumbered(record: Record, by: int) -> Record:
    """A record about the runs that have a number higher by so much."""
    names = ("run", "parent", "instead_of")
    numbers = {name: getattr(record, name, None) for name in names}
    return replace(
        record, **{name: number + by for name, number in numbers.items() if number is not None}
    )


class Renumbered:
    """The journal of a session whose runs have higher numbers than in its file."""

    def __init__(self, journal: Journal, by: int) -> None:
        self._journal = journal
        self._by = by

    @property
    def fault(self) -> str | None:
        """As :attr:`Journal.fault`."""
        return self._journal.fault

    def note(self, record: Record) -> None:
        """As :meth:`Journal.note`."""
        self._journal.note(renumbered(record, -self._by))

    def stood(self, record: Stood, at_rest: bool = False) -> None:
        """As :meth:`Journal.stood`."""
        self._journal.stood(replace(record, run=record.run - self._by), at_rest)

    def close(self) -> None:
        """As :meth:`Journal.close`."""
        self._journal.close()


class _Making:
    def __init__(
        self,
        records: Sequence[Record],
        budget: Budget,
        name_of: NameOf,
        first_number: int,
        on_step: OnStep | None,
        most_steps: int | None,
    ) -> None:
        self._records = records
        self._first_number = first_number
        self._budget = budget
        self._name_of = name_of
        self._on_step = on_step
        self._n_records = len(records)
        self._most_steps = most_steps
        self._n_steps = 0
        """Made so far, or as long as something took that is no step."""
        self._place = 0
        self._last = {
            record.run + first_number: place
            for place, record in enumerate(records)
            if isinstance(record, Stood)
        }
        """Where in the records each line was written down last, which is where it is compared."""
        self._n_runs = first_number
        self._family: Family | None = None
        self._aside: Family | None = None
        self._stories = Stories()
        self._of_lessons: dict[str, Family] = {}
        self._differ: list[Line] = []
        self._stood: dict[int, Stood] = {}
        """How lines stand here, by the place in the records where that was written down."""

    def remade(self, written: Written) -> Remade:
        """What came of all records.

        Raises:
            DamagedError: no run has begun.
        """
        if self._family is None:
            raise DamagedError(f"{written.path}: no run has begun in it", None)
        self._family.held.pause()
        run = self._family.held.run
        self._family.live.known = known_of(run, digest(run.state))
        made = MadeAgain(self._family, self._aside, self._n_runs, self._stories, self._of_lessons)
        records = tuple(
            self._stood.get(place, record)
            for place, record in enumerate(self._records)
            if place in self._stood or not isinstance(record, Stood)
        )
        differ = tuple(line.name for line in self._differ)
        return Remade(made, differ, len(self._stood), records)

    def take(self, place: int, record: Record) -> None:
        """Take one record in.

        Raises:
            CommandError: it does not go with those before.
        """
        self._place = place
        match record:
            case Began():
                self._begin(record)
            case Branched():
                self._branch(record)
            case Gave(run=number, step=step, command=command):
                family = self._live_family(number)
                line = family.live
                run = self._know(line, step)
                if run.step != step:
                    raise CommandError(f"{line.name} is past step {step:,}")
                self._count_command(run, command)
                run.apply(command, replacing=True)
                line.past.note(run)
                family.note_given(record)
            case Stood():
                self._stand(record)
            case WentLive():
                self._go_live(record)
            case NamedLine() | Deleted() | BroughtBack() | Marked() | Unmarked():
                family = self._shown()
                if isinstance(record, Marked):
                    self._know(family.line(record.run), record.step)
                family.check(record)
                family.do(record)
            case TookLesson():
                self._take_lesson(record)
            case _:
                self._stories = self._stories.after(record)

    def _take_lesson(self, record: TookLesson) -> None:
        self._stories = self._stories.after(record)
        families = {**self._of_lessons, record.name: self._shown()}
        self._of_lessons = families_of(self._stories, families)

    def _shown(self) -> Family:
        if self._family is None:
            raise CommandError("no run has begun")
        return self._family

    def _live_family(self, number: int) -> Family:
        for family in (self._family, self._aside):
            if family is not None and family.live.number == number:
                return family
        raise CommandError(f"run {number} is not live")

    def _next(self, number: int) -> None:
        """Take in the number of another run."""
        if number < self._n_runs:
            raise CommandError(f"there has been a run {number}")
        self._n_runs = number + 1

    # Families

    def _begin(self, record: Began) -> None:
        self._next(record.run)
        self._count_world(record.spec)
        run = Run(record.spec, record.seed)
        root = root_line(record.run, run, record.preset, self._budget, record.spec.trials)
        self._set_aside(for_opened=not record.is_own)
        self._family = Family(root, record.is_own)

    def _set_aside(self, for_opened: bool = False) -> None:
        family = self._family
        if family is None:
            return
        family.held.pause()
        family.drop()
        self._aside = aside_after(family, self._aside, for_opened)

    # Lines

    def _branch(self, record: Branched) -> None:
        family, step = self._shown(), record.step
        self._next(record.run)
        self._know(family.line(record.parent), step)
        if record.instead_of is None:
            family.check_room()
        else:
            family.line(record.instead_of)
        place = Place(record.parent, step)
        parent = family.line(record.parent)
        self._count_way(parent, step)
        for command in record.commands:
            self._count_command(parent.past, command)
        begun = begin(family, place, record.commands, False, self._name_of)
        family.note_given(record)
        family.add(begun.line(record.run, self._budget), record.instead_of)

    def _stand(self, record: Stood) -> None:
        family = self._shown()
        line = family.lines.get(record.run)
        if line is None and self._aside is not None:
            line = self._aside.lines.get(record.run)
        if line is None or (line.held is None and self._place != self._last[record.run]):
            # A branch that is not there any more, or of which more is known later.
            return
        run = self._know(line, record.step)
        if line.held is not None:
            line.held.until_trial = record.until_trial
        if self._place == self._last[record.run]:
            if run.step > record.step:
                run = self._run_at(line, record.step)
            found = digest(run.state)
            stood = replace(record, trial=run.trial, digest=found)
            self._stood[self._place] = replace(stood, run=stood.run - self._first_number)
            if (found, run.trial) != (record.digest, record.trial):
                self._differ.append(line)
            if line.held is None and line.known.step == run.step:
                # Where a branch rests it is not made again for its digest.
                line.known = line.known._replace(digest=found)

    def _go_live(self, record: WentLive) -> None:
        family = self._shown()
        others = [*self._of_lessons.values(), *([] if self._aside is None else [self._aside])]
        other = next((other for other in others if other.live.number == record.run), None)
        if record.run in family.lines:
            line, step = family.lines[record.run], record.step
            if step is not None:
                self._know(line, step)
            family.check_going_live(line.number, step)
            if line.held is not None and step in (None, line.held.run.step):
                run = line.held.run
            else:
                run = self._run_at(line, line.past.end_step if step is None else step)
            family.go_live(line, run)
        elif other is not None:
            if other is self._aside:
                self._aside = None
            self._set_aside()
            self._family = other
        else:
            raise CommandError(f"there is no run {record.run} to go on with")

    def _know(self, line: Line, step: int) -> Run:
        """Have a line known up to a step at least; returns its run, as far as it is."""
        if line.held is not None:
            self._advance(line, line.held.run, step)
            line.known = known_of(line.held.run)
            return line.held.run
        run = self._run_at(line, line.past.end_step)
        if run.step < step:
            self._advance(line, run, step)
            line.known = known_of(run)
        return run

    def _advance(self, line: Line, run: Run, step: int) -> None:
        while run.step < step:
            if self._on_step is not None:
                self._on_step(self._place / self._n_records)
            most = min(step - run.step, _SLICE)
            self._count(most)
            if run.advance(max_steps=most, until_trial=MAX_TRIALS) == 0:
                raise CommandError(f"{line.name} ends before step {step:,}")
            line.past.note(run)

    # What it takes

    def _run_at(self, line: Line, step: int) -> Run:
        self._count_way(line, step)
        return run_at(line.past, step)

    def _count_way(self, line: Line, step: int) -> None:
        """Count what it takes to come to a moment of a line that is known."""
        before = max((kept for kept in line.past.kept if kept <= step), default=0)
        self._count(_COPY + line.past.end_trial + max(step - before, 0))

    def _count_command(self, of: Run | Past, command: Command) -> None:
        match command:
            case SetParameter(key=key) if key.startswith("world."):
                self._count_world(of.control.spec)
            case Undo():
                # All of it is played again without one.
                self._count(_EVENT * len(of.control.history))
            case _:
                pass

    def _count_world(self, spec: RunSpec) -> None:
        self._count(_CELL * spec.world.size**2)

    def _count(self, n_steps: int) -> None:
        """Count what is about to be made.

        Raises:
            CommandError: it is more than may be.
        """
        self._n_steps += n_steps
        if self._most_steps is not None and self._n_steps > self._most_steps:
            raise CommandError(
                f"to come so far takes more than {self._most_steps:,} steps, as many as may be"
            )
