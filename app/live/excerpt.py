"""What is shared of a session: one of its lines, or all of a tree, as a file of a session.

It holds what leads there, and neither what was deleted nor what came before or beside it. A line
alone is a run of its own, whatever it branched off: it is given, from its beginning on, all that it
and the lines before it were given.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from app import __version__
from app.live.branching import run_at
from app.live.kept import name_of_file
from app.live.lines import FIRST_RUN, MOST_CHARACTERS, Family, Line, one_line, unlike
from app.live.places import Mark, Place
from app.live.records import Began, Branched, Gave, Marked, NamedLine, Record, Stood, WentLive
from app.live.shared import MOST_STEPS, read_shared
from app.live.written import Header, SessionError, whole
from learners.kernel.state import digest
from learners.run import Run

_TRIES: Final = 20
"""At a tree that is given commands all the while."""


@dataclass(frozen=True)
class Excerpt:
    """A file to be shared."""

    file_name: str
    data: bytes
    n_lines: int
    trial: int
    """In which the line is, or the live one of its tree."""


def excerpt(family: Family, line: int | None) -> Excerpt:
    """A line as it is now, or with None all lines of its tree. From any thread.

    Raises:
        CommandError: there is no such line any more.
        SessionError: it is more than another lab would take.
    """
    records = tuple(_of_tree(family) if line is None else _of_line(family, family.line(line)))
    stood = [record for record in records if isinstance(record, Stood)]
    if sum(record.step for record in stood) > MOST_STEPS:
        raise SessionError(
            f"to make it again takes more than {MOST_STEPS:,} steps; allowed: what has fewer"
        )
    began = records[0]
    assert isinstance(began, Began)
    now = datetime.now(UTC)
    header = Header(__version__, began.preset, began.seed, now.isoformat(timespec="seconds"))
    data = whole(header, records)
    file_name = name_of_file(header, now)
    # What others would refuse is not to be sent to them.
    read_shared(Path(file_name), data)
    end_trial = (family.live if line is None else family.line(line)).past.end_trial
    return Excerpt(file_name, data, len(stood), end_trial)


def _of_line(family: Family, line: Line) -> Iterator[Record]:
    run = run_at(line.past, line.past.end_step)
    yield _began(family, run)
    for step, command in run.journal:
        yield Gave(0, step, command)
    yield _stood(0, run)
    if line.name != FIRST_RUN:
        yield NamedLine(0, _name(line.name))
    marks = [mark for mark in family.marks if _is_on(family, mark, line, run.step)]
    for number, mark in enumerate(marks, 1):
        yield Marked(number, 0, mark.place.step, mark.trial, mark.text)


def _of_tree(family: Family) -> Iterator[Record]:
    for _ in range(_TRIES):
        # What was given on a line is there before it is, and what comes meanwhile is left out.
        lines = list(family.lines.values())
        given = family.given
        runs = [run_at(line.past, line.past.end_step) for line in lines]
        if family.given is given:
            break
    else:
        raise SessionError("so much is done at once that there is no telling it; try again")
    live = next(line.number for line in lines if line.parent is None)
    there, numbers = {line.number: line for line in lines}, {live: 0}
    made_again = {live: there[live].computed_name}
    come = dict.fromkeys(there, 0)
    yield _began(family, runs[0])
    for record in given:
        if record.run not in there:
            continue
        on = record.parent if isinstance(record, Branched) else record.run
        if isinstance(record, Gave) and record.step < come[on]:
            # It went back behind a branch that was deleted then, and is there again.
            raise SessionError("one of its lines went back behind a branch; share each line alone")
        come[on] = max(come[on], record.step)
        if isinstance(record, Branched):
            numbers[record.run] = len(numbers)
            made_again[record.run] = unlike(made_again.values(), there[record.run].plain_name)
            yield replace(
                record, run=numbers[record.run], parent=numbers[record.parent], instead_of=None
            )
            continue
        if record.run != live:
            live = record.run
            yield WentLive(numbers[live])
        yield replace(record, run=numbers[record.run])
    for line, run in zip(lines, runs, strict=True):
        yield _stood(numbers[line.number], run)
        # A computed name depends on the lines that were there then, deleted ones among them.
        if line.given_name or line.name != made_again[line.number]:
            yield NamedLine(numbers[line.number], line.name)
    marks = [mark for mark in family.marks if mark.place.line in there]
    for number, mark in enumerate(marks, 1):
        place = mark.place
        yield Marked(number, numbers[place.line], place.step, mark.trial, mark.text)
    if family.live.number in there and family.live.number != live:
        yield WentLive(numbers[family.live.number])


def _began(family: Family, run: Run) -> Began:
    return Began(0, family.preset, run.preset, run.seed)


def _stood(number: int, run: Run) -> Stood:
    return Stood(number, run.step, run.trial, digest(run.state), max(run.trial, run.spec.trials))


def _is_on(family: Family, mark: Mark, line: Line, end_step: int) -> bool:
    """Whether a mark is on the way that leads to where a line is."""
    place = mark.place
    return place.step <= end_step and family.place(Place(line.number, place.step)) == place


def _name(text: str) -> str:
    """What a line that has become the first one is called."""
    return one_line(text)[:MOST_CHARACTERS].rstrip()
