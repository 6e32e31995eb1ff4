"""The lines of a session as rows above the lanes: each below the one that it branched off."""

from collections.abc import Iterable, Iterator, Sequence

from app.live.places import LineSeen, Mark


def in_rows(lines: Iterable[LineSeen]) -> tuple[LineSeen, ...]:
    """Lines in the order of their rows: each is followed by those that branched off it.

    Of these the one that branched off last comes first, so that no stroke to one crosses another.
    A line whose parent is not there begins a tree of its own.
    """
    ordered = sorted(lines, key=lambda line: (-line.fork_step, line.number))
    numbers = {line.number for line in ordered}
    below: dict[int | None, list[LineSeen]] = {}
    for line in ordered:
        below.setdefault(line.parent if line.parent in numbers else None, []).append(line)

    def rows(parent: int | None) -> Iterator[LineSeen]:
        for line in below.get(parent, ()):
            yield line
            yield from rows(line.number)

    return tuple(rows(None))


def marks_on(line: int, lines: Iterable[LineSeen], marks: Sequence[Mark]) -> tuple[Mark, ...]:
    """The marks that lie on a line, or on those it came from, before it branched off them."""
    until = known_until(line, lines)
    return tuple(mark for mark in marks if mark.place.step <= until.get(mark.place.line, -1))


def known_until(number: int, lines: Iterable[LineSeen]) -> dict[int, float]:
    """Up to which step each of the lines that a line is made of belongs to it, itself first."""
    by_number = {line.number: line for line in lines}
    until: dict[int, float] = {number: float("inf")}
    line = by_number.get(number)
    while line is not None and line.parent is not None and line.parent not in until:
        # Of a parent that branched off later than its child nothing is the child's.
        until[line.parent] = min(line.fork_step, *until.values())
        line = by_number.get(line.parent)
    return until
