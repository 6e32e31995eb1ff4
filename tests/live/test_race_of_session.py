"""A session has a race beside its runs: the live run stands still for it, and nothing is kept."""

from collections.abc import Iterator

import pytest

from app.live.places import Place
from app.live.records import Began, Record, Stood
from app.live.requests import Begin, Branch, EndRace, Play, Request, StartAgain, StartRace
from app.live.session import Session
from app.live.status import Status
from app.live.worker import FULL_SPEED
from learners.commands import FreezeSelection
from learners.kernel.state import digest
from learners.run import replay
from tests.support.races import PATIENCE_S, SEED, alone, at_rest, entry, over, small, tables

FOUR = tuple(entry(name) for name in ("standard_q", "hierarchical_3", "timed", "hierarchical_2"))
LONG = small("timed", "trials=1000000")
BRISK = 100_000.0
"""A speed at which it is not over while the test's thread stands still for a second."""


class Notes:
    """A journal in memory."""

    fault = None

    def __init__(self) -> None:
        self.records: list[Record] = []

    def note(self, record: Record) -> None:
        """Keep it."""
        self.records.append(record)

    def stood(self, record: Stood, at_rest: bool = False) -> None:
        """Keep it."""
        self.records.append(record)

    def close(self) -> None:
        """Keep nothing more."""


@pytest.fixture
def notes() -> Notes:
    return Notes()


@pytest.fixture
def session(notes: Notes) -> Iterator[Session]:
    made = Session(LONG, "timed", SEED, BRISK, False, journal=notes)
    made.start()
    yield made
    made.stop()


def ask(session: Session, request: Request) -> tuple[Status, list[str]]:
    """How it stands once something has been answered, and what was refused."""
    said: list[str] = []
    ticket = session.submit(request, said.append)
    return session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S), said


def test_the_live_run_stands_still_for_a_race_and_is_as_it_was_left(session: Session) -> None:
    ask(session, Play())
    session.wait_for(lambda status: status.snapshot.step > 2_000, PATIENCE_S)
    stands, said = ask(session, StartRace(FOUR))
    assert not said
    assert not stands.playing
    race = session.race
    assert race is not None
    assert race.paused_live == stands.snapshot.trial
    end = over(race)
    assert list(end.digests) == [tables(alone(racer)) for racer in FOUR]
    assert session.status.snapshot.step == stands.snapshot.step
    left = replay(LONG, SEED, [], stands.snapshot.step)
    assert session.status.lines[0].digest == digest(left.state)
    after, _ = ask(session, EndRace())
    assert session.race is None
    assert race.is_gone
    assert not after.playing
    ask(session, Play())
    session.wait_for(lambda status: status.snapshot.step > stands.snapshot.step, PATIENCE_S)


def test_whoever_comes_first_does_not_set_the_live_run_going_beside_a_race(
    session: Session,
) -> None:
    ask(session, StartRace(FOUR, playing=False))
    assert not ask(session, Begin())[0].playing
    assert session.race is not None
    assert session.race.paused_live is None


def test_nothing_of_a_race_is_written_down(session: Session, notes: Notes) -> None:
    before = list(notes.records)
    assert isinstance(before[0], Began)
    ask(session, StartRace(FOUR))
    assert session.race is not None
    over(session.race)
    ask(session, EndRace())
    assert [
        record for record in notes.records[len(before) :] if not isinstance(record, Stood)
    ] == []
    # And the numbers of runs, by which a journal means them, are those of its own.
    assert session.n_runs == 1
    ask(session, StartAgain(LONG, "timed", SEED))
    assert Began(1, "timed", LONG, SEED) in notes.records


def test_a_race_that_cannot_be_leaves_all_as_it_is(session: Session) -> None:
    ask(session, StartRace(FOUR))
    race = session.race
    assert race is not None
    ask(session, Play())
    stands, said = ask(session, StartRace(FOUR[:1]))
    assert said == ["a race is of 2 to 4 runs, and not of 1"]
    assert stands.playing
    assert session.race is race
    assert not race.is_gone


def test_another_race_takes_the_place_of_one(session: Session) -> None:
    ask(session, StartRace(FOUR))
    first = session.race
    assert first is not None
    first.paused_live = 0
    ask(session, StartRace(FOUR[:2]))
    second = session.race
    assert second is not None
    assert second.paused_live == 0
    assert first.is_gone
    assert over(second).entries == FOUR[:2]
    # Boards that show one are told from those that showed the other.
    numbers = [one.generation for race in (first, second) for one in race.status.snapshots]
    assert len(set(numbers)) == len(numbers)
    assert max(numbers) < 0


def test_lines_of_the_tree_race_as_far_as_they_are_known(session: Session) -> None:
    ask(session, Play())
    session.wait_for(lambda status: status.snapshot.step > 3_000, PATIENCE_S)
    ask(session, StartRace((session.entry_of(0, "live"), FOUR[0])))
    stands = session.status.snapshot
    ask(session, Branch(Place(0, 1_000), FreezeSelection(True)))
    status = session.wait_for(
        lambda status: len(status.lines) == 2 and status.lines[1].digest != "", PATIENCE_S
    )
    branch = session.entry_of(1)
    assert branch.name == status.lines[1].name
    entries = (session.entry_of(0, "live"), branch, FOUR[0])
    assert entries[0].seed == SEED
    ask(session, StartRace(entries))
    race = session.race
    assert race is not None
    end = race.wait_for(lambda status: "" not in status.stands, PATIENCE_S)
    assert end.stands == ("known", "known", "finished")
    assert end.snapshots[0].step == stands.step
    assert at_rest(race).digests == (
        *(line.digest for line in status.lines),
        tables(alone(FOUR[0])),
    )
    # The live run goes on, and the race goes with it.
    ask(session, Play())
    race.wait_for(lambda status: status.snapshots[0].step > stands.step, PATIENCE_S)


def test_it_ends_with_its_session(notes: Notes) -> None:
    session = Session(LONG, "timed", SEED, FULL_SPEED, False, journal=notes)
    session.start()
    ask(session, StartRace(FOUR))
    race = session.race
    session.stop()
    assert race is not None
    assert race.is_gone
    assert session.race is None
