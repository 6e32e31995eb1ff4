"""Sharing in the page: what is given to others, what comes from them, and what is said of it."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import viser

from app.explain.branches import name_of
from app.live.kept import begun, sessions_in
from app.live.places import Place
from app.live.records import Began, Gave, Stood
from app.live.requests import AddMark, Branch, Request, StartAgain, StepOnce, TrialOnce
from app.live.session import Session
from app.live.shared import is_code, read_link, read_shared
from app.live.status import Status
from app.live.worker import Reply
from app.live.written import read, whole
from app.page.arrival import Arrival
from app.page.panels.share import Share
from app.server.links import Links
from app.server.server import close_server, open_server
from learners.commands import FreezeSkills, SetParameter
from learners.kernel.state import digest
from learners.run import replay
from tests.support.journals import HEADER
from tests.support.person import AtOnce, Person
from tests.support.schedules import small_spec
from tests.support.sessions import settle

SPEC, SEED = small_spec(), 5
FREEZE, EPSILON = FreezeSkills(True), SetParameter("learner.epsilon", 0.3)
ENDED = replay(SPEC, SEED, [(300, FREEZE)], 900)
STOOD = Stood(0, 900, ENDED.trial, digest(ENDED.state), 500)
THEIRS = (Began(0, "theirs", SPEC, SEED), Gave(0, 300, FREEZE), STOOD)
THEIR_FILE = whole(HEADER, THEIRS).decode()
WHAT = f"theirs, seed 5; 1 command; up to trial {ENDED.trial}; written by pounce 1.2.3."


class Desk:
    """A session, and the widgets of one browser."""

    def __init__(self, gui: viser.GuiApi, folder: Path | None) -> None:
        self.n_viewers = 1
        journal = None if folder is None else begun(folder, "timed", 3)
        self.session = Session(SPEC, "timed", 3, 1.0, False, journal=journal, name_of=name_of)
        self.session.start()
        self.person = Person(gui)
        self.links = Links(is_code)
        client: Any = self.person
        work = AtOnce().work
        self.arrival = Arrival(
            client, self.session, self.submit, work, lambda: self.n_viewers, folder, self.links
        )
        self.share = Share(client, self.session, lambda _: self.session.status, work, self.arrival)

    def submit(self, request: Request, reply: Reply) -> None:
        self.session.submit(request, reply)

    def does(self, *requests: Request) -> Status:
        for request in requests:
            self.session.submit(request)
            settle(self.session)
        status = self.session.status
        self.share.update(status)
        return status


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = open_server(port=0)
    yield server
    close_server(server)


@pytest.fixture
def sit_down(server: viser.ViserServer, tmp_path: Path) -> Iterator[Callable[..., Desk]]:
    """Begins a session that is kept, or is not."""
    desks: list[Desk] = []

    def begin(kept: bool = True) -> Desk:
        desks.append(Desk(server.gui, tmp_path if kept else None))
        return desks[-1]

    yield begin
    for desk in desks:
        desk.session.stop()


@pytest.fixture
def desk(sit_down: Callable[..., Desk]) -> Desk:
    return sit_down()


# --- What is given -------------------------------------------------------------------------------


def test_what_is_shared_is_said_before_it_is(desk: Desk) -> None:
    assert desk.person.reads("What is shared: this run from its beginning to now")
    assert not desk.person.sees("All lines")
    desk.does(TrialOnce(), StepOnce(), Branch(Place(0, 1), EPSILON))
    assert desk.person.reads(
        "What is shared: first run, the line that you look at, from its beginning to its end, with"
        " its marks. Not in it: 1 other line."
    )
    desk.person.check("All lines")
    assert desk.person.reads("What is shared: all 2 lines, with names and marks.")


def test_a_file_has_the_line_or_all_of_them(desk: Desk) -> None:
    desk.does(TrialOnce(), FREEZE, Branch(Place(0, 1), EPSILON), AddMark(Place(0, 1), "a"))
    desk.person.click("Download session")
    ((name, data),) = desk.person.downloads.items()
    assert re.fullmatch(r"\d{4}-\d\d-\d\d-\d{6}-timed-seed3\.pounce", name)
    records = read_shared(Path(name), data).records
    assert [type(record).__name__ for record in records] == ["Began", "Gave", "Stood", "Marked"]
    assert desk.person.reads(f"{name}, {len(data) / 1000:.1f} kB: 1 line, up to trial 1.")
    desk.person.check("All lines")
    desk.person.click("Download session")
    more = read_shared(Path(name), [*desk.person.downloads.values()][-1]).records
    assert sum(isinstance(record, Stood) for record in more) == 2


def link_in(desk: Desk) -> str:
    found = re.search(r'href="s/([^"]*)"', desk.person.html)
    assert found is not None
    return found[1]


def test_a_link_has_the_same_in_it(desk: Desk) -> None:
    desk.does(TrialOnce(), FREEZE)
    desk.person.click("Copy link")
    desk.person.click("Download session")
    (data,) = desk.person.downloads.values()
    # What was said before is gone.
    assert "href" not in desk.person.html
    desk.person.click("Copy link")
    assert read_link(link_in(desk)).records == read_shared(Path("one"), data).records
    # Each is copied, even if it is the same as the one before.
    assert 'data-copy-link="2"' in desk.person.html


def test_what_is_too_much_is_said(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.live.shared.MOST_CHARACTERS", 100)
    desk.person.click("Copy link")
    assert desk.person.reads("There is no link to this: too much is in it for a link, ")
    monkeypatch.setattr("app.live.shared.MOST_BYTES", 1_000)
    desk.person.click("Copy link")
    assert desk.person.reads("This cannot be shared: ")
    assert desk.person.reads("timed-seed3.pounce: is too large; allowed: up to ")
    monkeypatch.setattr("app.live.excerpt.MOST_STEPS", 0)
    desk.does(StepOnce())
    desk.person.click("Download session")
    assert desk.person.reads("to make it again takes more than 0 steps; allowed: what has fewer.")
    assert desk.person.downloads == {}


# --- What comes ----------------------------------------------------------------------------------


def test_a_file_is_opened_as_a_session_of_its_own(desk: Desk, tmp_path: Path) -> None:
    before = desk.does(TrialOnce()).snapshot
    desk.person.upload("Open session", "C:\\dir\\theirs.pounce", THEIR_FILE)
    status = desk.does(StepOnce())
    assert (status.snapshot.step, status.snapshot.preset, status.snapshot.seed) == (
        901,
        "theirs",
        5,
    )
    assert (status.is_shared, status.is_resumed, status.journal) == (True, False, None)
    said = f"{WHAT} Digest as recorded: same."
    assert desk.person.told[-1] == said
    assert desk.person.reads(f"Opened: {said}")
    desk.does(FREEZE)
    desk.session.stop()
    # Both are kept, and theirs has what was done in it here.
    kept = {found.glance.header.preset: read(found.path) for found in sessions_in(tmp_path)}
    assert kept["theirs"].records[:3] == THEIRS
    assert Gave(0, 901, FREEZE) in kept["theirs"].records
    assert kept["timed"].records[-1] == replace(kept["timed"].records[-1], step=before.step)


def test_one_that_is_not_as_it_was_recorded_is_said_with_what_to_do(
    desk: Desk, tmp_path: Path
) -> None:
    wrong = whole(HEADER, (*THEIRS[:2], replace(STOOD, digest="ab" * 32)))
    desk.person.upload("Open session", "theirs.pounce", wrong.decode())
    assert desk.person.told[-1] == "Not as it was recorded."
    assert desk.person.reads("Digest as recorded: differs. Pounce ")
    assert desk.person.reads("to see what was recorded, open it with pounce 1.2.3.")
    desk.session.stop()
    # What is kept here is true here.
    (kept,) = [found for found in sessions_in(tmp_path) if found.glance.header.preset == "theirs"]
    assert read(kept.path).records[2] == STOOD


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("no session", "theirs.pounce: is no session of pounce; allowed: a file .pounce of a lab"),
        (
            THEIR_FILE.replace('"step":300', '"step":301'),
            "theirs.pounce: line 3 does not have the checksum",
        ),
        (whole(HEADER, THEIRS[1:]).decode(), "theirs.pounce: line 2: run "),
        (" " * (2**18 + 1), "theirs.pounce: is too large; allowed: up to 256 KiB"),
    ],
)
def test_what_cannot_be_opened_changes_nothing(desk: Desk, content: str, message: str) -> None:
    desk.person.upload("Open session", "theirs.pounce", content)
    assert desk.person.reads(message)
    assert desk.person.told[-1] == "Nothing has changed."
    assert desk.does(StepOnce()).snapshot.preset == "timed"


def test_names_of_files_are_shown_and_not_obeyed(desk: Desk) -> None:
    desk.person.upload("Open session", "../<b>\x1b[31m.pounce", "no session")
    assert "&lt;b&gt;" in desk.person.html
    assert "<b>" not in desk.person.html
    assert "\x1b" not in desk.person.html


def test_a_link_is_opened_at_once_only_where_nothing_was_done(desk: Desk) -> None:
    desk.person.click("Copy link")
    code = link_in(desk)
    desk.arrival.came(desk.links.keep(code))
    assert desk.does(TrialOnce()).is_shared
    desk.arrival.came(desk.links.keep(code))
    assert desk.person.reads("timed, seed 3; 0 commands; up to trial 0; written by pounce ")
    assert desk.person.reads(
        "It takes the place of the session on the board, which is kept, and can be resumed later."
    )
    assert desk.session.status.snapshot.trial == 1
    desk.person.click("Open")
    assert desk.does().snapshot.trial == 0


def test_a_ticket_that_is_none_is_nobodys_business(desk: Desk) -> None:
    desk.arrival.came("x" * 300)
    assert desk.person.told == []


def test_a_link_that_holds_no_session_is_said(desk: Desk) -> None:
    desk.arrival.came(desk.links.keep("AAAA"))
    assert desk.person.reads("the link: is not whole, or not one of pounce; allowed: all of it")


def test_others_are_asked_for_first(desk: Desk) -> None:
    desk.n_viewers = 3
    desk.person.upload("Open session", "theirs.pounce", THEIR_FILE)
    assert desk.person.reads("2 others look at the session on the board, which is kept, and can be")
    assert desk.does(StepOnce()).snapshot.preset == "timed"
    desk.person.click("Open for all")
    assert desk.does(StepOnce()).snapshot.preset == "theirs"


def test_what_would_be_lost_is_asked_for_first(sit_down: Callable[..., Desk]) -> None:
    desk = sit_down(kept=False)
    desk.does(TrialOnce())
    desk.person.upload("Open session", "theirs.pounce", THEIR_FILE)
    assert desk.person.reads("the session on the board, which is not kept.")
    desk.person.click("Open")
    assert desk.does(StepOnce()).snapshot.preset == "theirs"
    assert not desk.session.is_kept


def test_one_is_opened_at_a_time(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    waiting: list[Callable[[], object]] = []

    def work(_: object, make: Callable[[], Any], then: Callable[[Any], object]) -> None:
        waiting.append(lambda: then(make()))

    monkeypatch.setattr(desk.arrival, "_work", work)
    desk.arrival.open(lambda: read_shared(Path("a"), THEIR_FILE.encode()), is_sure=True)
    desk.arrival.open(lambda: read_shared(Path("b"), b""), is_sure=True)
    assert desk.person.reads("Another session is being opened; wait for that.")
    while waiting:
        waiting.pop(0)()
    assert desk.does(StepOnce()).snapshot.preset == "theirs"


def test_one_that_fails_leaves_room_for_another(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise MemoryError

    with monkeypatch.context() as failing:
        failing.setattr("app.page.arrival.made_again", fail)
        with pytest.raises(MemoryError):
            desk.arrival.open(partial(read_shared, Path("a"), THEIR_FILE.encode()), is_sure=True)
    desk.person.upload("Open session", "theirs.pounce", THEIR_FILE)
    assert desk.does(StepOnce()).snapshot.preset == "theirs"


def test_one_that_is_refused_by_the_session_is_said(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.does(TrialOnce(), StartAgain(SPEC, "timed", 4, paused=True))
    # As if so many runs had begun meanwhile.
    monkeypatch.setattr("app.page.taking_up._APART", -2)
    desk.person.upload("Open session", "theirs.pounce", THEIR_FILE)
    assert desk.person.reads("that session cannot be taken up now; ask for it again")
    assert desk.does(StepOnce()).snapshot.preset == "timed"
