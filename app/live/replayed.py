"""A session made again from what was written down of it, by runs alone, and compared with it.

Records are taken in their order. Each line of the session is a run of its own, which is given the
commands that its line was given; wherever it was written down how a line stood, the tables made
here must be those that were there.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Final

from app.live.branching import NameOf, plain_name
from app.live.lines import FIRST_RUN, unlike
from app.live.records import (
    Began,
    Branched,
    BroughtBack,
    Deleted,
    Gave,
    NamedLine,
    Record,
    Stood,
    WentLive,
)
from learners.commands import Command, CommandError
from learners.kernel.state import digest
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.spec import RunSpec

_SLICE: Final = 500_000
"""Steps between two moments at which it can be broken off."""

OnStep = Callable[[int, int], object]
"""Told now and then which line is made, and up to which step."""


class ReplayError(Exception):
    """Records that do not go together; the message says which record, and why."""


@dataclass(frozen=True)
class Given:
    """A command, and the step of its line before which it was given."""

    step: int
    command: Command


@dataclass(frozen=True)
class Difference:
    """Where a line was found not to be what was written down of it."""

    same_step: int
    """Where it still was, or where the line began."""
    stood: Stood
    """Where it was no more, as written down."""
    step: int
    trial: int
    digest: str
    """As made here."""
    given: tuple[Given, ...]
    """In between: the difference came with one of these, or with what is learned without any."""


@dataclass
class LineMade:
    """A line of the session, made again as far as was written down of it."""

    number: int
    spec: RunSpec
    seed: int
    preset: str
    run: Run
    parent: int | None = None
    fork_step: int = 0
    computed_name: str = FIRST_RUN
    given_name: str = ""
    is_there: bool = True
    """Whether it was in its tree in the end, and not deleted."""
    given: list[Given] = field(default_factory=list[Given])
    """Commands by hand, those of the lines that it branched off among them."""
    n_stands: int = 0
    """How often it was compared."""
    same_step: int = 0
    """The last step at which it was what was written down."""
    n_same: int = 0
    """Commands given by then."""
    difference: Difference | None = None
    """The first, if there is one."""

    @property
    def name(self) -> str:
        """What it was called in its tree."""
        return self.given_name or self.computed_name

    @property
    def digest(self) -> str:
        """Of the tables as they are where it was made up to."""
        return digest(self.run.state)

    @property
    def is_same(self) -> bool | None:
        """Whether it is what was written down; None if nothing was."""
        return self.difference is None if self.n_stands else None


@dataclass
class Replayed:
    """All lines of a session, made again."""

    lines: dict[int, LineMade] = field(default_factory=dict[int, LineMade])
    live: int | None = None
    """The line that was live in the end."""

    @property
    def is_same(self) -> bool:
        """Whether no line differs from what was written down of it."""
        return all(line.difference is None for line in self.lines.values())


def replayed(
    records: Iterable[Record],
    until_step: int | None = None,
    on_step: OnStep | None = None,
    name_of: NameOf = plain_name,
) -> Replayed:
    """Make the lines of a session again, each no farther than to a step if there is one.

    Raises:
        ReplayError: the records do not go together.
    """
    replayer = _Replayer(until_step, on_step, name_of)
    for place, record in enumerate(records, 1):
        try:
            replayer.take(record)
        except CommandError as error:
            raise ReplayError(f"record {place}: the command is refused now: {error}") from error
        except ValueError as error:
            raise ReplayError(f"record {place} does not go with those before: {error}") from error
    return replayer.made


class _Replayer:
    def __init__(self, until_step: int | None, on_step: OnStep | None, name_of: NameOf) -> None:
        self.made = Replayed()
        self._name_of = name_of
        self._until = until_step
        self._on_step = on_step

    def take(self, record: Record) -> None:
        """Take one record in.

        Raises:
            ValueError: it does not go with those before.
        """
        match record:
            case Began(run=number, spec=spec, seed=seed, preset=preset):
                self._add(LineMade(number, spec, seed, preset, Run(spec, seed)))
                self.made.live = number
            case Branched():
                self._branch(record)
            case Gave(run=number, step=step) | Stood(run=number, step=step) if self._is_later(step):
                self._go_so_far(number)
            case Gave(run=number, step=step, command=command):
                line = self._line(number)
                self._go(line, step)
                self._give(line, Given(step, command))
            case Stood():
                self._compare(self._line(record.run), record)
            case WentLive(run=number, step=step):
                self.made.live = number
                if self._until is None or number in self.made.lines:
                    self._go_live(self._line(number), step)
            case NamedLine(run=number, name=name) if number in self.made.lines:
                self.made.lines[number].given_name = name
            case Deleted(run=number) | BroughtBack(run=number) if number in self.made.lines:
                self.made.lines[number].is_there = isinstance(record, BroughtBack)
            case _:
                # Marks change no line, and neither does what befell one that is not made.
                pass

    def _is_later(self, step: int) -> bool:
        return self._until is not None and step > self._until

    def _go_so_far(self, number: int) -> None:
        """Make a line up to the step that is asked for; more of it is written down."""
        line = self.made.lines.get(number)
        # One that begins later than is asked for has not been made.
        if line is not None and self._until is not None:
            self._go(line, self._until)

    def _line(self, number: int) -> LineMade:
        line = self.made.lines.get(number)
        if line is None:
            raise ValueError(f"there is no line {number}")
        return line

    def _add(self, line: LineMade) -> None:
        if line.number in self.made.lines:
            raise ValueError(f"there is a line {line.number} already")
        self.made.lines[line.number] = line

    def _branch(self, record: Branched) -> None:
        if self._is_later(record.step):
            self._go_so_far(record.parent)
            return
        parent = self._line(record.parent)
        run = self._made_up_to(parent, record.step)
        before = run.control
        line = LineMade(
            record.run,
            parent.spec,
            parent.seed,
            parent.preset,
            run,
            parent.number,
            record.step,
            given=[given for given in parent.given if given.step <= record.step],
            same_step=record.step,
        )
        former = self.made.lines.get(-1 if record.instead_of is None else record.instead_of)
        if former is not None:
            former.is_there, line.given_name = False, former.given_name
        line.n_same = len(line.given)
        for command in record.commands:
            self._give(line, Given(record.step, command))
        name = self._name_of(before, run.trial, record.commands)
        line.computed_name = unlike(self._names_beside(line), name)
        self._add(line)

    def _root(self, line: LineMade) -> LineMade:
        while line.parent is not None:
            line = self.made.lines[line.parent]
        return line

    def _names_beside(self, branch: LineMade) -> set[str]:
        """Names of the lines that are in its tree."""
        root = self._root(branch)
        there = [line for line in self.made.lines.values() if line.is_there]
        return {line.name for line in there if self._root(line) is root}

    def _go_live(self, line: LineMade, step: int | None) -> None:
        if step is None:
            return
        if self._is_later(step):
            self._go_so_far(line.number)
            return
        if step < line.run.step:
            line.run = self._made_up_to(line, step)
            line.given = [given for given in line.given if given.step <= step]
            line.same_step = min(line.same_step, step)
            line.n_same = min(line.n_same, len(line.given))
        self._go(line, step)

    def _made_up_to(self, line: LineMade, step: int) -> Run:
        """Another run that stands at a step of a line, all done that was given by then."""
        twin = LineMade(line.number, line.spec, line.seed, line.preset, Run(line.spec, line.seed))
        for given in line.given:
            if given.step <= step:
                self._go(twin, given.step)
                self._give(twin, given)
        self._go(twin, step)
        return twin.run

    def _give(self, line: LineMade, given: Given) -> None:
        # As a session gives it, by which the numbers of events agree that are undone later.
        line.run.apply(given.command, replacing=True)
        line.given.append(given)

    def _go(self, line: LineMade, step: int) -> None:
        """Make a line up to a step."""
        if step < line.run.step:
            raise ValueError(f"line {line.number} is past step {step:,}")
        while line.run.step < step:
            if self._on_step is not None:
                self._on_step(line.number, line.run.step)
            most = min(step - line.run.step, _SLICE)
            if line.run.advance(max_steps=most, until_trial=MAX_TRIALS) == 0:
                raise ValueError(f"line {line.number} ends before step {step:,}")

    def _compare(self, line: LineMade, stood: Stood) -> None:
        self._go(line, stood.step)
        line.n_stands += 1
        if line.difference is not None:
            return
        found = line.digest
        if (found, line.run.trial) == (stood.digest, stood.trial):
            line.same_step, line.n_same = stood.step, len(line.given)
            return
        between = tuple(line.given[line.n_same :])
        line.difference = Difference(
            line.same_step, stood, line.run.step, line.run.trial, found, between
        )
