"""A lesson in a session with browsers that are made up: what their frames are sent, and send."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import viser

from app.documents import lessons
from app.documents.lessons import Lesson
from app.live.places import Place
from app.live.requests import Request
from app.live.session import Session
from app.live.status import Status
from app.live.worker import FULL_SPEED
from app.page.lesson import messages
from app.page.lesson.desk import Desk
from app.page.lesson.panel import LessonPanel
from app.page.time.asks import Asks
from app.page.time.grounds import Grounds
from app.page.time.outlook import Outlook
from app.picture.look import Look
from tests.support.person import AtOnce

PATIENCE_S: Final = 60.0
"""How long to wait for what must happen; reaching it is a failure."""

SMALL: Final = """
title: A small one
minutes: 4
setup: {preset: timed, set: {world.size: 40}, seed: 3, start: 200, speed: 50000}
show: [play, speed, layer.value]
steps:
  - say: "The predator learns to **hunt**."
    id: first
    look: {layer: value, mark: behind, frame: turned}
    run: +50
  - ask: choice
    id: guess
    text: "Will it go on?"
    options: ["no", "yes"]
    confidence: true
    reveal: {measure: trial, above: 300, at: +100}
  - do: {command: introduce, skill: avoid}
    id: add
    text: "Let it learn to avoid."
    unlock: [add_skill, layer.reach, undo]
    check: {present: avoid, by: +200}
    hints: ["Look below the card.", "Press *Add avoid now*.", {do: true}]
  - see: {same_as: guess}
    id: seen
    text: "Has it?"
    run: +150
  - why: {inspect: behind, text: "Each place has its value from the next."}
  - free: {show: all}
    text: "Try it out."
texts:
  de:
    title: Eine kleine
    cards:
      - text: "Der Räuber lernt **jagen**."
      - {text: "Geht es weiter?", options: [nein, ja]}
      - {text: "Lass ihn ausweichen lernen.", hints: ["Sieh unter die Karte.", "Drücke."]}
      - text: "Hat er?"
      - text: "Jeder Ort hat seinen Wert vom nächsten."
      - text: "Probiere es aus."
"""


def small_lesson(text: str = SMALL, name: str = "small") -> Lesson:
    """A lesson in a small world, with a card of nearly each kind."""
    return lessons.parse(text, f"{name}.yaml")


class Frame:
    """The frame of a lesson, which keeps what it is sent."""

    def __init__(self) -> None:
        self.sent: dict[str, Any] = {}
        self.n_sent = 0
        self.opened: Callable[[], object] = lambda: None

    def enter(self, kind: Any, take: Any, opened: Callable[[], object], page: str = "") -> "Frame":
        self.opened = opened
        return self

    def frame_html(self, title: str) -> str:
        return "<iframe></iframe>"

    def send(self, kind: str, content: dict[str, Any]) -> None:
        assert kind == "lesson"
        self.sent = json.loads(json.dumps(content))
        self.n_sent += 1

    def leave(self) -> None:
        pass


class View:
    """How a made-up browser sees the board."""

    def __init__(self) -> None:
        self.look = Look(layer="success")

    def show(self, layer: str | None, frame: int | None) -> None:
        look = self.look
        self.look = look._replace(
            layer=layer or look.layer, frame=look.frame if frame is None else frame
        )


class Sitter:
    """One browser of a room."""

    def __init__(self, room: "Room", gui: viser.GuiApi, number: int) -> None:
        self.frame, self.view = Frame(), View()
        self.outlook = Outlook(number, room.session.moments)
        self.asks = Asks(self.outlook, room.submit, lambda act: room.later.append(act))
        self.done: list[str] = []
        """What was asked of other parts of the page."""
        self.on_board: Any = None
        self.on_bar: Any = None
        rooms: Any = SimpleNamespace(
            view=self.view,
            outlook=self.outlook,
            asks=self.asks,
            time=SimpleNamespace(ask=self._ask_bar, go_to=self._go_to),
            octants=SimpleNamespace(ask=self._ask_board),
            marked=SimpleNamespace(show=self._mark),
            inspection=SimpleNamespace(look_into=self._look_into),
            open_side=lambda: self.done.append("side"),
            watch=lambda: self.done.append("watch"),
            experiment=lambda name: self.done.append(f"experiment {name}"),
            presents=lambda: room.classroom is not None,
            classroom=room.classroom,
        )
        self.marked: str | None = None
        self.cell: tuple[int, int] | None = None
        client: Any = SimpleNamespace(gui=gui, client_id=number)
        channels: Any = self.frame
        inbox: Any = AtOnce()
        self.panel = LessonPanel(
            client, room.desk, rooms, channels, inbox, lambda: len(room.sitters), lambda: None
        )
        self._room = room

    def _ask_bar(self, asked: Any, answered: Any) -> None:
        self.on_bar, self.answered = asked, answered

    def _ask_board(self, asked: Any, toggled: Any) -> None:
        self.on_board, self.toggled = asked, toggled

    def _mark(self, region: str | None, *_: object) -> None:
        self.marked = region

    def _look_into(self, cell: tuple[int, int] | None) -> None:
        self.cell = cell

    def _go_to(self, place: Place) -> None:
        ground = self._room.grounds.of(self._room.status)
        self.outlook.walk.look(place.line, place.step, time.perf_counter(), ground)

    @property
    def state(self) -> dict[str, Any]:
        """What its frame was sent last."""
        return self.frame.sent

    @property
    def lesson(self) -> dict[str, Any]:
        """The lesson in it."""
        return self.state["lesson"]

    @property
    def card(self) -> dict[str, Any]:
        """The card that it shows."""
        return self.lesson["card"]

    def do(self, *many: Any) -> None:
        """Have its frame send messages, one after the other, and the lab answer each."""
        for message in many:
            self.panel.take(message)
            self._room.settle()

    def start(self, name: str = "small", language: str | None = None, again: bool = False) -> None:
        """Take a lesson, and wait until its first card has begun, or it is gone on with."""
        self.do(messages.Start(name, language, again))
        self._room.until(lambda: self.state["lesson"] is not None and self.card["busy"] is None)


class Room:
    """A session in whose lab there are a lesson and browsers."""

    def __init__(
        self,
        session: Session,
        gui: viser.GuiApi,
        own: Lesson | None = None,
        sitters: int = 1,
        folder: Path | None = None,
    ) -> None:
        """``folder`` is where what twenty runs answer is kept; by default it is not."""
        self.session = session
        self.grounds = Grounds(session)
        self.ticket = 0
        self.later: list[Callable[[], object]] = []
        service: Any = SimpleNamespace(standing=None)
        self.classroom: Any = None
        self.desk = Desk(session, service, self.submit, lambda: None, folder=folder)
        if own is not None:
            self.desk.library.offer(own)
        self.sitters: list[Sitter] = []
        for number in range(sitters):
            self.sitters.append(Sitter(self, gui, number + 1))
        self.show()

    @property
    def status(self) -> Status:
        """How the live run stands."""
        return self.session.status

    def submit(self, request: Request, refused: Any = None) -> None:
        """As the lab does it."""
        now = self.session.status.snapshot
        self.desk.doings.note_request(request, now.step)
        self.ticket = self.session.submit(request, refused, now.generation)

    def close(self) -> None:
        """End what runs beside the session, and that."""
        self.desk.stop()
        self.session.stop()

    def show(self) -> None:
        """Draw a frame."""
        while self.later:
            self.later.pop()()
        live, now_s = self.session.status, time.perf_counter()
        ground = self.grounds.of(live)
        self.desk.update(live, live.answered >= self.ticket)
        for sitter in self.sitters:
            sitter.asks.follow(live, ground, now_s)
            seen = sitter.outlook.status(live, now_s, ground)
            sitter.panel.update(seen, live, ground, sitter.view.look, now_s)

    def settle(self) -> None:
        """Wait until all that was asked for is answered, and has been shown."""
        self.session.wait_for(lambda status: status.answered >= self.ticket, PATIENCE_S)
        self.show()

    def until(self, condition: Callable[[], bool]) -> None:
        """Draw until something is so."""
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < deadline, self.sitters[0].state
            time.sleep(0.002)
            self.show()


def small_session(**more: Any) -> Session:
    """A session of another run than a lesson's, which stands still."""
    lesson = small_lesson()
    return Session(lesson.run_spec, "timed", 5, FULL_SPEED, False, **more)
