"""Earlier sessions in the page: which are offered, and one that is taken up."""

import contextlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import viser

from app.live.branching import plain_name
from app.live.journal import Journal, is_in_use
from app.live.kept import begun
from app.live.made_again import made_again
from app.live.past import Budget
from app.live.records import Began, Branched, Gave, NamedLine, Stood
from app.live.requests import StepOnce, TakeUp, TrialOnce
from app.live.session import Session
from app.live.status import Status
from app.live.worker import Reply
from app.live.written import read, whole
from app.page.panels.earlier import Earlier
from app.server.server import close_server, open_server
from learners.commands import FreezeSkills, SetParameter
from learners.kernel.state import digest
from learners.run import replay
from tests.support.journals import HEADER
from tests.support.person import AtOnce, Person
from tests.support.schedules import small_spec

SPEC, SEED = small_spec(), 5
FREEZE, EPSILON = FreezeSkills(True), SetParameter("learner.epsilon", 0.3)
ENDED = replay(SPEC, SEED, [(300, FREEZE)], 900)
STOOD = Stood(0, 900, ENDED.trial, digest(ENDED.state), 500)
RECORDS = (
    Began(0, "mine", SPEC, SEED),
    Gave(0, 300, FREEZE),
    Branched(1, 0, 500, (EPSILON,)),
    NamedLine(1, "looser"),
    STOOD,
)
DONE = f"timed, my own, seed 5 · trial {ENDED.trial} · 2 commands"


class Desk:
    """A session that is kept, and the widgets of one browser."""

    def __init__(self, gui: viser.GuiApi, folder: Path) -> None:
        self.n_viewers = 1
        self.journal = begun(folder, "timed", 3)
        self.session = Session(SPEC, "timed", 3, 1.0, False, journal=self.journal)
        self.session.start()
        self.person = Person(gui)
        client: Any = self.person
        work = AtOnce().work
        Earlier(client, self.session, self.submit, work, lambda: self.n_viewers, folder)

    def submit(self, request: TakeUp, reply: Reply) -> None:
        self.session.submit(request, reply)

    def does(self, request: Any) -> Status:
        ticket = self.session.submit(request)
        return self.session.wait_for(lambda status: status.answered >= ticket, 60.0)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "a.pounce").write_bytes(whole(HEADER, RECORDS))
    (tmp_path / "empty.pounce").write_bytes(whole(HEADER, RECORDS[:1]))
    return tmp_path


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = open_server(port=0)
    yield server
    close_server(server)


@pytest.fixture
def desk(server: viser.ViserServer, folder: Path) -> Iterator[Desk]:
    desk = Desk(server.gui, folder)
    yield desk
    desk.session.stop()


def test_those_in_which_something_was_done_are_offered(desk: Desk, folder: Path) -> None:
    (offered,) = desk.person.options("Session")
    assert offered[20:] == f"· {DONE}"
    with contextlib.closing(Journal.going_on(read(folder / "a.pounce"))):
        desk.person.click("Look again")
        assert desk.person.options("Session") == ["none"]
        assert not desk.person.can_use("Resume")
    desk.person.click("Look again")
    assert desk.person.options("Session") == [offered]


@pytest.mark.parametrize("preset", ["a\n\x1b[31m", "b" * 5_000])
def test_a_file_whose_preset_has_no_name_is_not_offered(
    desk: Desk, folder: Path, preset: str
) -> None:
    (folder / "a.pounce").write_bytes(whole(replace(HEADER, preset=preset), RECORDS))
    desk.person.click("Look again")
    assert desk.person.options("Session") == ["none"]


def test_a_session_is_taken_up_and_the_one_before_is_kept(desk: Desk, folder: Path) -> None:
    desk.does(TrialOnce())
    mine = desk.journal.path
    desk.person.click("Resume")
    status = desk.does(StepOnce())
    assert (status.snapshot.step, status.snapshot.preset, status.snapshot.seed) == (901, "mine", 5)
    assert [line.name for line in status.lines] == ["first run", "looser"]
    assert (status.journal, status.is_resumed) == (None, True)
    # What was on the board is offered now, and the other is not.
    (offered,) = desk.person.options("Session")
    assert "· timed, seed 3 · trial 1 · 0 commands" in offered
    assert made_again(read(mine), Budget(), plain_name).made.family.held.run.trial == 1
    desk.does(FREEZE)
    desk.session.stop()
    assert read(folder / "a.pounce").records[: len(RECORDS)] == RECORDS
    assert Gave(0, 901, FREEZE) in read(folder / "a.pounce").records


def test_others_are_asked_for_first(desk: Desk) -> None:
    desk.n_viewers = 3
    desk.person.click("Resume")
    assert desk.does(StepOnce()).snapshot.preset == "timed"


def test_a_damaged_session_is_refused_with_what_could_be_saved(desk: Desk, folder: Path) -> None:
    path = folder / "a.pounce"
    data = bytearray(path.read_bytes())
    data[len(whole(HEADER, RECORDS[:3])) + 50] ^= 1
    path.write_bytes(data)
    desk.person.click("Resume")
    assert desk.person.reads(
        "a.pounce: line 5 does not have the checksum that it states; the 3 records before it are"
        " saved as a-saved.pounce"
    )
    assert str(folder) not in desk.person.html
    assert read(folder / "a-saved.pounce").records == RECORDS[:3]
    assert desk.does(StepOnce()).snapshot.preset == "timed"


def test_a_session_that_cannot_be_made_again_is_left_to_others(
    desk: Desk, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("app.page.panels.earlier.made_again", fail)
    with contextlib.suppress(MemoryError):
        desk.person.click("Resume")
    assert not is_in_use(folder / "a.pounce")


def test_tables_that_are_not_those_recorded_are_said(desk: Desk, folder: Path) -> None:
    wrong = Stood(0, 900, ENDED.trial, "ab" * 32, 500)
    (folder / "a.pounce").write_bytes(whole(HEADER, (*RECORDS[:-1], wrong)))
    desk.person.click("Resume")
    assert desk.person.reads("Not as it was recorded: first run. This pounce learns otherwise.")
