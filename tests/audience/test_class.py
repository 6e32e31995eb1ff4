"""A class of a lab with a real port: thirty seats that answer, and can do nothing else."""

import contextlib
import gc
import logging
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from websockets.exceptions import ConnectionClosed

from app.audience.audience import Audience
from app.audience.poll import Ballot
from app.audience.room import Room
from app.audience.seats import SHAPES, Seat
from app.live.requests import Pause, Play
from app.picture.octants import OCTANTS
from app.player.classroom import Card, Question
from learners.kernel.state import digest
from learners.run import replay
from tests.support.audiences import Shown, hostile_texts
from tests.support.classes import Pupils, cookies_of
from tests.support.live import SEED
from tests.support.server import get_path

N_SEATS = 30
SOURCE = "127.0.0.77"
"""From where a class comes whose address must be in no log."""
CODE = "act347"
WAYS = ("this way round", "that way round", "no way at all")
WHICH = Question("way/1", "direction", "Which way?", tuple((way, way) for way in WAYS))
WHERE = Question("cone/2", "sectors", "Where?", tuple((octant, octant) for octant in OCTANTS))
WHEN = Question("ring/4", "moment", "When?", low=0, high=48_000)
CARD = Card("way/1", "Which way round?", 1, 7, "Which <b>way</b>?")
OUTCOME = {"run": WAYS[1], "twenty": {"n": 20, "counts": {WAYS[1]: 20}}}


class Taught(Shown):
    """A lab with a class, to which the test shows what a presenter sees."""

    def __init__(self, folder: Path, code: str | None = None, sessions: Path | None = None) -> None:
        super().__init__(folder, sessions=sessions)
        self.audience.close()
        self.audience = Audience(
            self.live.session.past_of, "127.0.0.1", 0, code=code, is_class=True
        )
        self.classes: list[Pupils] = []
        self.present()

    @property
    def room(self) -> Room:
        """The class."""
        assert self.audience.room is not None
        return self.audience.room

    def pupils(self, n: int = 1, **options: Any) -> Pupils:
        """So many more that look."""
        self.classes.append(Pupils(self.audience.watchers.port, n, **options))
        return self.classes[-1]

    def leave(self) -> None:
        """Have all pages be closed, and the class be forgotten."""
        while self.classes:
            self.classes.pop().close()
        self.room.end()
        self.present()

    def close(self) -> None:
        try:
            self.leave()
        finally:
            super().close()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Taught]:
    taught = Taught(tmp_path_factory.mktemp("lab"))
    yield taught
    taught.close()


@pytest.fixture
def taught(whole: Taught) -> Iterator[Taught]:
    yield whole
    whole.leave()


# --- Seats ----------------------------------------------------------------------------------------


def test_each_browser_has_a_seat_and_two_pages_of_one_have_the_same(taught: Taught) -> None:
    pupils = taught.pupils(N_SEATS)
    seats = [pupil.seat for pupil in pupils.all]
    assert sorted(seat["number"] for seat in seats if seat) == list(range(1, N_SEATS + 1))
    assert {seat["shape"] for seat in seats if seat} == set(SHAPES)
    again = taught.pupils(cookies=pupils.cookies[:3])
    assert [pupil.seat for pupil in again.all] == seats[:3]
    assert taught.room.state(None, False)["seats"] == taught.room.n_seats == N_SEATS


def test_who_comes_back_has_the_seat_and_the_answer_of_before(taught: Taught) -> None:
    pupils = taught.pupils(2)
    taught.room.ask(WHICH)
    pupils.answer(lambda n: WAYS[n])
    seats = [pupil.seat for pupil in pupils.all]
    pupils.close()
    taught.classes.clear()
    other = taught.pupils(1)
    back = taught.pupils(cookies=pupils.cookies)
    assert [pupil.seat for pupil in back.all] == seats
    assert [pupil.parts["seat"]["answer"] for pupil in back.all] == list(WAYS[:2])
    assert other.all[0].seat not in seats
    assert taught.room.state(WHICH.id, True)["answered"] == 2


@pytest.mark.parametrize("cookie", ["", "pounce-{}-seat=0123456789abcdef", "x=1"])
def test_without_a_cookie_one_looks_and_does_not_answer(taught: Taught, cookie: str) -> None:
    port = taught.audience.watchers.port
    pupils = taught.pupils(cookies=[cookie.format(port)])
    (pupil,) = pupils.all
    assert pupil.seat is None
    taught.room.ask(WHICH)
    pupils.wait_for(lambda pupil: pupil.ballot is not None)
    pupils.send(lambda _: _answer(pupil.ballot, WAYS[0]))
    heard = taught.pupils()
    heard.answer(lambda _: WAYS[1])
    assert taught.room.state(WHICH.id, True)["answered"] == 1


def _answer(ballot: int | None, value: Any) -> str:
    return msgspec.json.encode({"do": "answer", "ballot": ballot, "value": value}).decode()


# --- A vote ---------------------------------------------------------------------------------------


def test_a_class_votes_votes_again_and_sees_what_came_out(taught: Taught) -> None:
    pupils = taught.pupils(N_SEATS)
    taught.present(card=CARD)
    pupils.wait_for(lambda pupil: pupil.parts["lesson"]["card"] == CARD._asdict())
    taught.room.ask(WHICH)
    pupils.answer(lambda n: WAYS[n % 3])
    assert taught.room.state(WHICH.id, True)["answered"] == N_SEATS
    # Whoever answers once more is counted once.
    pupils.send(lambda n: _answer(pupils.all[n].ballot, WAYS[0]) if n < 10 else None)
    pupils.until(lambda: all(p.parts["seat"]["answer"] == WAYS[0] for p in pupils.all[:10]))
    taught.room.vote_again()
    pupils.wait_for(lambda pupil: pupil.parts["lesson"]["ask"]["round"] == 2)
    pupils.wait_for(lambda pupil: pupil.parts["seat"]["answer"] is None)
    pupils.answer(lambda n: WAYS[1] if n else None)
    state = taught.room.state(WHICH.id, True)
    assert (state["answered"], state["seats"], state["hidden"]) == (N_SEATS - 1, N_SEATS, True)
    assert all(pupil.parts["lesson"]["reveal"] is None for pupil in pupils.all)
    taught.room.reveal()
    taught.room.come_out(WHICH.id, OUTCOME)
    pupils.wait_for(lambda pupil: pupil.parts["lesson"]["reveal"] is not None)
    (reveal,) = {msgspec.json.encode(pupil.parts["lesson"]["reveal"]) for pupil in pupils.all}
    told = msgspec.json.decode(reveal)
    assert told["before"] == {"n": 30, "counts": dict(zip(WAYS, (16, 7, 7), strict=True))}
    assert told["class"] == {"n": 29, "counts": dict(zip(WAYS, (0, 29, 0), strict=True))}
    assert {name: told[name] for name in OUTCOME} == OUTCOME
    assert taught.room.found(WHICH.id)["class"] == told["class"]


@pytest.mark.parametrize("n", [1, 4])
def test_of_fewer_than_five_nobody_is_shown_anything(taught: Taught, n: int) -> None:
    pupils = taught.pupils(n)
    taught.room.ask(WHERE)
    pupils.answer(lambda _: ["n", "w"])
    taught.room.reveal()
    taught.room.come_out(WHICH.id, OUTCOME)
    pupils.wait_for(lambda pupil: pupil.parts["lesson"]["reveal"] is not None)
    told_to_all = [pupil.parts["lesson"]["reveal"] for pupil in pupils.all]
    for told in (*told_to_all, taught.room.state(WHERE.id, True)):
        assert (told["class"], told["before"], told["few"]) == (None, None, True)


def test_what_is_asked_belongs_to_its_card(taught: Taught) -> None:
    pupils = taught.pupils(5)
    taught.present(card=CARD)
    taught.room.ask(WHICH)
    pupils.answer(lambda n: WAYS[0])
    taught.present(card=CARD._replace(id="way/2", at=2))
    pupils.wait_for(lambda pupil: pupil.parts["lesson"]["ask"] is None)
    taught.present(card=CARD._replace(id="way/3", at=3))
    taught.room.reveal()
    taught.room.come_out(WHICH.id, OUTCOME)
    nothing = {"run": None}
    pupils.wait_for(lambda pupil: (pupil.parts["lesson"]["reveal"] or nothing)["run"] is not None)
    pupils.wait_for(lambda pupil: pupil.parts["lesson"]["ask"] is not None)
    taught.present(card=CARD._replace(id="way/4", at=4))
    pupils.wait_for(lambda pupil: pupil.parts["lesson"]["reveal"] is None)


def test_who_looks_around_is_asked_as_well(taught: Taught) -> None:
    pupils = taught.pupils(2)
    pupils.send(lambda _: '{"do": "look", "dark": true, "layer": "visits"}')
    taught.room.ask(WHEN)
    pupils.answer(lambda n: 1_000 * n)
    assert taught.room.state(WHEN.id, True)["answered"] == 2


def test_who_looks_at_a_learner_of_their_own_is_asked_as_well(taught: Taught) -> None:
    pupils = taught.pupils(2)
    pupils.send(lambda _: '{"do": "own", "dark": true}')
    taught.room.ask(WHEN)
    pupils.answer(lambda n: 1_000 * n)
    assert taught.room.state(WHEN.id, True)["answered"] == 2


# --- That it can do nothing else ------------------------------------------------------------------


def answers() -> Iterator[str | bytes]:
    """Whatever may be tried as an answer."""
    values: tuple[Any, ...] = (
        *WAYS, "", "x" * 101, "<script>alert(1)</script>", "\x00", 0, 7, -1, 1.5, 10**30, -1e300,
        2**53, True, None, [], ["n"], ["n"] * 9, ["north"], [["n"]], [1], {}, {"n": 1},
    )  # fmt: skip
    for value in values:
        for ballot in (1, 2, 3, 0, -1, 2**60, "1", None):
            yield msgspec.json.encode({"do": "answer", "ballot": ballot, "value": value})
    yield '{"do": "answer", "ballot": 1}'
    yield '{"do": "answer", "ballot": 1, "value": "this way round", "seat": 3}'
    yield '{"do": "answer", "ballot": 1, "value": 1e999}'
    yield '{"do": "answer", "ballot": 1, "value": NaN}'
    for do in ("ask", "ask_class", "vote_again", "reveal_class", "end_class", "end", "reveal"):
        yield msgspec.json.encode({"do": do})
    chance = random.Random(3)
    whole = _answer(1, WAYS[0]).encode()
    for _ in range(60):
        place = chance.randrange(len(whole))
        yield whole[:place] + chance.randbytes(2) + whole[place + 2 :]


def test_whatever_a_class_sends_the_learner_is_as_if_it_had_sent_nothing(tmp_path: Path) -> None:
    taught = Taught(tmp_path)
    try:
        status = taught.live.ask(Play())
        before = (status.speed, len(status.lines), status.marks)
        question = WHICH
        taught.room.ask(question)
        messages = [
            text.decode("latin-1") if isinstance(text, bytes) else text
            for text in (*answers(), *hostile_texts())
        ]
        # So many of one page are read at once; what it answers then is read when all else has been.
        each = 15
        hostile = taught.pupils(-(-len(messages) // each))
        for turn in range(each):
            hostile.send(lambda n, turn=turn: dict(enumerate(messages[turn::each])).get(n))
        hostile.answer(lambda n: WAYS[2])
        everybody = taught.pupils(N_SEATS)
        everybody.answer(lambda n: WAYS[n % 3])
        # Neither is the vote another one than the presenter has made it.
        state = taught.room.state(question.id, True)
        assert everybody.all[0].parts["lesson"]["ask"]["id"] == question.id
        assert (state["round"], state["asking"]) == (1, True)
        assert state["answered"] == N_SEATS + len(hostile.all)
        after = taught.live.ask(Pause())
        assert (after.speed, len(after.lines), after.marks) == before
        assert after.error is None
        snapshot = after.snapshot
        assert all(event.author == "schedule" for event in snapshot.control.history)
        alone = replay(snapshot.preset_spec, SEED, [], snapshot.step)
        past = taught.live.session.past_of(snapshot.generation)
        assert past is not None
        made = past.run_at(snapshot.step)
        assert made is not None
        assert digest(made.state) == digest(alone.state)
    finally:
        taught.close()


# --- That nothing is known of anybody -------------------------------------------------------------


def test_when_it_ends_everything_of_it_is_forgotten(taught: Taught) -> None:
    pupils = taught.pupils(8)
    tickets = list(pupils.cookies)
    taught.room.ask(WHICH)
    pupils.answer(lambda n: WAYS[n % 3])
    taught.room.vote_again()
    # What answers the ballot of before is not taken any more.
    pupils.wait_for(lambda pupil: pupil.parts["lesson"]["ask"]["round"] == 2)
    pupils.wait_for(lambda pupil: pupil.parts["seat"]["answer"] is None)
    pupils.answer(lambda n: WAYS[1])
    taught.room.reveal()
    taught.room.come_out(WHICH.id, OUTCOME)
    pupils.wait_for(lambda pupil: pupil.parts["lesson"]["reveal"] is not None)
    taught.room.end()
    pupils.wait_for(
        lambda pupil: pupil.parts["seat"] == {"kind": "seat", "seat": None, "answer": None}
    )
    pupils.wait_for(lambda pupil: pupil.parts["lesson"]["ask"] is None)
    assert taught.room.state(WHICH.id, True)["answered"] == taught.room.n_seats == 0
    assert taught.room.seats.all == ()
    for watcher in taught.audience.watchers.all:
        assert watcher.seat is None
        kept = b"".join(part for part in watcher.seen.values() if isinstance(part, bytes))
        assert not any(way.encode() in kept for way in WAYS)
    # Nothing in this program has an answer any more, nor what could tell seats from each other.
    gc.collect()
    assert [one for one in gc.get_objects() if type(one) is Ballot] == []
    seats = [one for one in gc.get_objects() if type(one) is Seat]
    assert {(seat.number, seat.shape, seat.is_taken) for seat in seats} <= {(0, "", False)}
    # Their cookies are nobody's; with a new one they are somebody else.
    pupils.close()
    taught.classes.clear()
    assert [pupil.seat for pupil in taught.pupils(cookies=tickets).all] == [None] * 8
    answer = get_path(taught.audience.watchers.port, "/", {"Cookie": tickets[0]})
    assert "-seat=" in (answer.headers["Set-Cookie"] or "")


def test_no_log_and_no_journal_says_who_they_are(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    sessions = tmp_path / "sessions"
    taught = Taught(tmp_path, CODE, sessions)
    taught.live.ask()
    (journal,) = sessions.iterdir()
    written = journal.read_bytes()
    port = taught.audience.watchers.port
    try:
        for guess in ("wrong1", "wrong2", "wrong3"):
            assert cookies_of(port, guess, SOURCE) == ""
        pupils = taught.pupils(6, code=CODE, source=SOURCE)
        tickets = [part for cookie in pupils.cookies for part in cookie.split("=")]
        taught.room.ask(WHICH)
        pupils.answer(lambda n: WAYS[n % 3])
        pupils.send(lambda n: f'{{"do": "i am {SOURCE}", "{SOURCE}": {n}}}')
        # One sends too much at once, one goes without a word, one answers too late.
        with contextlib.suppress(ConnectionClosed, OSError):
            pupils.send(lambda n: "x" * 2_000 if n == 0 else None)
        taught.room.reveal()
        pupils.send(lambda n: _answer(1, WAYS[0]) if n else None)
        pupils.wait_for(
            lambda pupil: pupil is pupils.all[0] or pupil.parts["lesson"]["reveal"] is not None
        )
        taught.room.end()
        taught.live.ask()
        assert journal.read_bytes() == written
    finally:
        taught.close()
    # What the test's own pages log is theirs.
    said = [r for r in caplog.records if not r.name.startswith(("websockets.client", "asyncio"))]
    text = "\n".join(f"{record.name} {record.getMessage()} {record.exc_text}" for record in said)
    assert "wrong code" in text
    for secret in (SOURCE, "wrong1", "i am", *WAYS, *(t for t in tickets if len(t) > 12)):
        assert secret not in text
