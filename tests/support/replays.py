"""Sessions that are played back: a small run, and one with branches, names and marks."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from app.explain.branches import name_of
from app.live.made_again import made_again
from app.live.past import Budget
from app.live.records import Began, Branched, Gave, Marked, NamedLine, Record
from app.live.written import Header, Written
from app.player import images, replay_page
from app.player.reel import Recorded, recorded_family, recorded_run
from learners.commands import Explore, FreezeSkills, SetParameter
from learners.spec import RunSpec
from tests.support.schedules import small_spec

SEED = 5
HEADER = Header("1.2.3", "timed", SEED, "2026-11-29T15:00:00+00:00")
HOSTILE = "</script><script nonce=x>alert(1)</script><b onclick='x'>"
"""What somebody may call a line, or write at a moment."""


@contextmanager
def fewer_moments() -> Iterator[None]:
    """Replay pages and films with so few moments as are enough to play them, and to thin them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(replay_page, "MOST_MOMENTS", 40)
        patch.setattr(images, "FILM_MOMENTS", 40)
        yield


def branchy_records(spec: RunSpec, steps: int, n_branches: int = 3) -> tuple[Record, ...]:
    """A session whose live line is long, and that has branches with branches of their own."""
    records: list[Record] = [
        Began(0, "timed", spec, SEED),
        Gave(0, steps // 3, FreezeSkills(True)),
        Gave(0, steps, FreezeSkills(False)),
    ]
    for number in range(1, n_branches + 1):
        parent = number // 2 if number > 2 else 0
        at = steps * number // (n_branches + 2)
        command = SetParameter("learner.epsilon", round(0.3 / number, 3))
        commands = (command, Explore("approach", 40, 0.5))
        records.append(Branched(number, parent, at, commands))
        records.append(Marked(number, number, at + steps // 4, 0, f"mark {number}"))
    records.append(NamedLine(1, HOSTILE[:80]))
    records.append(Marked(n_branches + 1, 0, steps // 2, 0, HOSTILE[:80]))
    return tuple(records)


def recorded(records: tuple[Record, ...]) -> Recorded:
    """A session made again from its records."""
    written = Written(Path("a.pounce"), HEADER, records, False, 0, "")
    return recorded_family(made_again(written, Budget(), name_of).made.family)


def small_recorded() -> Recorded:
    """A run of a small world to which nothing was done."""
    return recorded_run(small_spec(), "timed", SEED)


def small_branchy() -> Recorded:
    """A small session with three branches."""
    return recorded(branchy_records(small_spec(), 6_000))
