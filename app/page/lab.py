"""The live page: one session, many browsers, and the loop that draws.

Only this loop touches scene handles and widgets: it does what people asked for since it last looked
into the inbox, and draws the latest moment there is, of which it never queues any. Views belong to
a browser, learning to the session.
"""

import functools
import logging
import math
import threading
import time
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import viser

from app.documents.lessons import Lesson
from app.lessons.kept import default_folder
from app.live.places import Place
from app.live.requests import Begin, Pause, Play, Request, StartAgain
from app.live.session import Session
from app.live.shared import is_code
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.live.worker import Reply
from app.page.browser import Browser, Shared
from app.page.clock import clock_html
from app.page.confirm import confirm_for_all
from app.page.dress import dress
from app.page.ghost import GhostWatch
from app.page.greedy import GreedyWatch
from app.page.inbox import Inbox
from app.page.lesson.desk import Desk
from app.page.panels.controls import Controls
from app.page.panels.experiments import ExperimentsPanel
from app.page.panels.plan import PlanPanel
from app.page.panels.side_by_side import SideBySide
from app.page.presenting import Presenting
from app.page.scene.gallery import Exhibit, Gallery, Seen
from app.page.side.show import SideShow
from app.page.success import SuccessMaps
from app.page.time.bars import Bars
from app.page.time.grounds import PLAIN_PACE, Grounds
from app.page.time.panel import Deeds
from app.page.time.walk import WalkError
from app.picture.layer import Extras
from app.player.presented import Stand
from app.player.texts import Texts
from app.results.service import Service
from app.server.access import Access
from app.server.callbacks import RefusedError, guarded
from app.server.calls import Calls
from app.server.channels import Channels
from app.server.links import Links
from app.server.notices import tell
from app.server.origin import Authority
from app.server.pulse import Drawing, Pulse, send
from app.server.server import addresses_of, close_server, is_serving, open_server
from app.util.html import escaped
from app.util.machine import give_back_memory, share_among_threads
from learners import hunts
from learners.spec import RunSpec

log = logging.getLogger(__name__)

DEFAULT_SPEED = PLAIN_PACE
"""Steps per second: the cone shows within seconds, and avoid joins within a minute."""
_FRAME_S = 1 / 12
_ANSWER_S = 1 / 40
"""From one frame to the next for those who wait for an answer: a page that asks and asks takes the
others' time no more often."""
_LEAST_PAUSE = 2.0
"""From the beginning of a frame to that of the next, as a multiple of what it took to draw: where
there is much to draw there are fewer frames, and there is always time for clicks."""
_READINGS_S = 0.25
_READINGS_APART_S = 1 / 32
"""Pause between the readings of two browsers on average: many are told less often."""
_FAREWELL_S = 2.0
_TIDY_S = 10.0
"""How often memory is given back at most."""
_UNSEEN_S = 20.0
"""The learner waits for a page that never says that it has drawn the board no longer than this."""


class Lab:
    """A session with its page."""

    def __init__(
        self,
        session: Session,
        presets: Mapping[str, RunSpec],
        host: str,
        port: int,
        results: Path,
        save_dir: Path | None = None,
        waits: bool = False,
        names: Sequence[Authority] = (),
        token: str | None = None,
        sessions: Path | None = None,
        stand: Stand | None = None,
        lesson: Lesson | None = None,
    ) -> None:
        """Open the page; with ``waits`` the learner begins when a browser has drawn the board.

        It answers to ``names`` besides its addresses; without the ``token`` nobody comes in. Those
        who do can take up an earlier one of the ``sessions``. Of lessons there is a ``lesson`` of
        one's own beside the shipped ones.

        Raises:
            OSError: the host is not an address of this machine, or no port is free.
        """
        share_among_threads()
        self.session = session
        self.service = Service(results)
        self._waits = waits
        self._begins_s = math.inf
        """When it begins even if nobody has said that there is something to see."""
        self._browsers: dict[int, Browser] = {}
        self._ticket = 0
        """Of the last request that was made here."""
        self._wake = threading.Event()
        self.inbox = Inbox(self._wake.set)
        self._due_s = -math.inf
        """When the next frame is to be drawn, on the clock of ``time.perf_counter``."""
        self._frame_s = -math.inf
        """When the last one was begun, be it for a few."""
        self._moved_s = math.inf
        """When the next one is to be drawn for those alone that look at the past."""
        self._rests_until_s = -math.inf
        """After the last one: until then there is time for clicks."""
        self._closed = False
        self._has_garbage = False
        """Whether pages have left whose memory may be given back."""
        self._tidied_s = -math.inf
        self.failure: str | None = None
        """Why :meth:`serve` ended, if nobody asked it to."""
        self._at_rest = threading.Event()
        self._at_rest.set()
        self._drawing = Drawing()
        self._success = SuccessMaps()
        self._greedy = GreedyWatch()
        self._ghosts = GhostWatch()
        self._grounds = Grounds(session)
        self._bars = Bars(self._grounds, session.moments, self._greedy, self._ghosts)
        # Compiled beforehand, or the first click on the board would have to wait for it.
        threading.Thread(
            target=hunts.prepare, args=(session.status.snapshot.world,), daemon=True
        ).start()
        self._side = SideShow(session)
        calls, channels, links = Calls(), Channels(), Links(is_code)
        self.access = None if token is None else Access(token)
        self.server = open_server(
            host,
            port,
            label="pounce",
            names=names,
            access=self.access,
            on_refused=lambda page, reason: self.inbox.put(partial(self._tell, page, reason)),
            on_call=calls.take,
            workers=self.inbox,
            channels=channels,
            links=links,
        )
        self.gallery = Gallery(self.server)
        self._presenting = Presenting(stand, self.server)
        self._desk = Desk(session, self.service, self._submit, self.wake, lesson, default_folder())
        dress(self.server)
        gui = self.server.gui
        self._controls = Controls(gui, presets, self.ask, self.status_of, session.status)
        with self._controls.run_tab:
            self._runs = SideBySide(gui, self._open_side)
        with self._controls.tabs.add_tab("Plan", icon=viser.Icon.TIMELINE):
            self._plan = PlanPanel(gui, self.ask, self.status_of, session.status)
        with self._controls.tabs.add_tab("Experiments", icon=viser.Icon.FLASK):
            self.experiments = ExperimentsPanel(
                gui, session, self.service, self.ask, self.inbox.work, self._show_results
            )
        self._shared = Shared(
            server=self.server,
            session=session,
            calls=calls,
            channels=channels,
            links=links,
            bars=self._bars,
            deeds=Deeds(self._plan.choose, self._test),
            service=self.service,
            inbox=self.inbox,
            ask=self.ask,
            status_of=self.status_of,
            submit=self._submit,
            wake=self.wake,
            drawn=self._begin,
            take_experiment=self.experiments.take,
            offer_preset=self._controls.offer_preset,
            save_dir=save_dir,
            sessions=sessions,
            n_viewers=lambda: len(self._browsers),
            side=self._side,
            presets=lambda: self._controls.presets,
            presenting=self._presenting,
            desk=self._desk,
        )
        self._for_script = self.server.gui.add_html("")
        self._said: tuple[str, bool] | None = None
        """What the page's script has been told last."""
        session.call_when_answered(self._wake.set)
        session.moments.call_when_found(lambda: self.inbox.put(self._found))
        self.server.on_client_connect(guarded(self._welcome))
        self.server.on_client_disconnect(guarded(self._forget))

    @functools.cached_property
    def urls(self) -> tuple[str, ...]:
        """Addresses to open, that on this machine first; with the token if one is wanted."""
        question = "" if self.access is None else f"/{self.access.question()}"
        return tuple(f"{address}{question}" for address in addresses_of(self.server))

    @property
    def url(self) -> str:
        """Address to open on this machine."""
        return self.urls[0]

    @property
    def snapshot(self) -> Snapshot:
        """The latest moment."""
        return self.session.status.snapshot

    def status_of(self, client: viser.ClientHandle) -> Status:
        """What is true for a browser now: how the run stands at the moment that it looks at."""
        live = self.session.status
        browser = self._browsers.get(client.client_id)
        if browser is None:
            return live
        return browser.outlook.status(live, time.perf_counter(), self._grounds.of(live))

    def ask(self, client: viser.ClientHandle, request: Request) -> None:
        """Do what a browser asks for at the moment that it looks at (:mod:`app.page.time.asks`).

        What the session is asked means the run that is live. The browser is told if it cannot be
        carried out, and asked first where it would take away the run that others are looking at.

        Raises:
            RefusedError: it cannot be done there.
        """

        def refused(reason: str) -> None:
            tell(client, "That cannot be done now", reason, auto_close_seconds=6)

        n_others = len(self._browsers) - 1
        if isinstance(request, StartAgain) and n_others > 0:
            confirm_for_all(
                client,
                n_others,
                "Start again",
                "this run. It is set aside, and can be taken up again.",
                lambda: self._submit(request, refused),
            )
            return
        browser = self._browsers.get(client.client_id)
        if browser is None:
            self._submit(request, refused)
            return
        live, now_s = self.session.status, time.perf_counter()
        ground = self._grounds.of(live)
        status = browser.outlook.status(live, now_s, ground)
        try:
            browser.asks.take(request, refused, status, ground, now_s)
        except WalkError as error:
            raise RefusedError(str(error)) from error
        self.wake()

    def _submit(self, request: Request, refused: Reply | None = None) -> None:
        now = self.session.status.snapshot
        self._desk.doings.note_request(request, now.step)
        self._ticket = self.session.submit(request, refused, now.generation)

    def wake(self) -> None:
        """Draw at once, because somebody waits for an answer."""
        self._due_s = min(self._due_s, self._frame_s + _ANSWER_S)
        self._wake.set()

    def serve(self) -> None:
        """Draw until :meth:`close` is called, or there is nothing left to draw from or for."""
        self._at_rest.clear()
        try:
            while not self._closed and self.failure is None:
                self.inbox.drain()
                self._controls.settle(time.monotonic())
                started, status = time.perf_counter(), self.session.status
                with self._drawing:
                    seen = self._look(status, started)
                    # What answers a click comes first, and does not wait for the next frame.
                    if self._is_true(status):
                        elsewhere = sum(other.behind is not None for other in seen.values())
                        self._controls.update(
                            self._shared_by(seen, status), elsewhere if len(seen) > 1 else 0
                        )
                    if started >= min(self._due_s, self._moved_s):
                        self._draw_due(status, seen, started)
                if started >= self._begins_s:
                    self._begin()
                if self._has_garbage and started - self._tidied_s > _TIDY_S:
                    self._has_garbage, self._tidied_s = False, started
                    give_back_memory()
                self._tell_script(status)
                due_s = min(self._due_s, self._moved_s)
                self._wake.wait(max(due_s - time.perf_counter(), 0.0))
                self._wake.clear()
                self.failure = self._missing_part()
        finally:
            self._at_rest.set()

    def _draw_due(self, status: Status, seen: Mapping[Browser, Status], started: float) -> None:
        """Draw a frame for all, if that is due, or for those whose moment has come."""
        is_for_all = started >= self._due_s
        self._moved_s, self._frame_s = math.inf, started
        if is_for_all:
            self._due_s = math.inf
        self._draw(status, seen, started, is_for_all)
        pause_s = _LEAST_PAUSE * (time.perf_counter() - started)
        self._rests_until_s = started + pause_s
        if is_for_all:
            # Unless somebody has asked for one meanwhile.
            self._due_s = min(self._due_s, started + max(_FRAME_S, pause_s))

    def _found(self) -> None:
        """Draw soon for those who look at the past: a moment that somebody wants is there."""
        self._moved_s = max(self._rests_until_s, self._frame_s + _ANSWER_S)

    def _look(self, live: Status, now_s: float) -> dict[Browser, Status]:
        """What is true for each browser now."""
        ground = self._grounds.of(live)
        seen: dict[Browser, Status] = {}
        for browser in self.browsers:
            browser.asks.follow(live, ground, now_s)
            seen[browser] = browser.outlook.status(live, now_s, ground)
            wish = browser.outlook.walk.hold(live.playing)
            if wish is not None and not live.finished:
                self._submit(Pause() if wish == "pause" else Play())
        return seen

    def _shared_by(self, seen: Mapping[Browser, Status], live: Status) -> Status:
        """What panels show that all browsers share: what the only one looks at, or what is live."""
        return next(iter(seen.values())) if len(seen) == 1 else live

    def end(self) -> None:
        """Let :meth:`serve` end after the frame it is at; may be called from a signal's handler."""
        self._closed = True

    def close(self) -> None:
        """End the page and the session."""
        self._closed = True
        self._wake.set()
        # Not while a frame is being sent over the connections that this takes away.
        self._at_rest.wait(timeout=_FAREWELL_S)
        self.service.close()
        self._side.stop()
        self.session.stop()
        self._success.stop()
        self._greedy.stop()
        self._ghosts.stop()
        self._desk.stop()
        self._presenting.close()
        close_server(self.server)

    def _is_true(self, status: Status) -> bool:
        """Whether a moment knows of all that was asked for; widgets show nothing older."""
        return status.answered >= self._ticket

    def _tell_script(self, status: Status) -> None:
        """Tell the page's script what to call the browser's tab, and whether the learner learns."""
        said = (status.snapshot.preset, status.playing)
        if said != self._said:
            title = escaped(f"{Path(said[0]).stem} \N{MIDDLE DOT} pounce")
            playing = "yes" if status.playing else "no"
            self._for_script.content = (
                f'<span hidden data-tab-title="{title}" data-playing="{playing}"></span>'
            )
            self._said = said

    def _missing_part(self) -> str | None:
        """Which thread is gone without which there is no lab."""
        if self._closed:
            return None
        if not is_serving(self.server):
            return "the page's server has ended"
        return "the learner has ended" if self.session.is_gone else None

    @property
    def browsers(self) -> tuple[Browser, ...]:
        """Those that are connected, in the order in which they came."""
        return tuple(self._browsers.values())

    def _welcome(self, client: viser.ClientHandle) -> None:
        # It may have gone away before its turn came.
        if client.client_id in self.server.get_clients():
            self._browsers[client.client_id] = Browser(self._shared, client)
            self._presenting.come(client.client_id)
        if self._waits:
            self._begins_s = min(self._begins_s, time.perf_counter() + _UNSEEN_S)

    def _begin(self) -> None:
        """Somebody sees the board, so there is something to see from the first trial on."""
        self._begins_s = math.inf
        if self._waits:
            self._waits = False
            self.session.submit(Begin())

    def _forget(self, client: viser.ClientHandle) -> None:
        browser = self._browsers.pop(client.client_id, None)
        if browser is not None:
            walk = browser.outlook.walk
            walk.go_live()
            if walk.hold(self.session.status.playing) == "play":
                self._submit(Play())
            browser.leave()
            self._presenting.go(client.client_id, time.perf_counter())
        self._has_garbage = True

    def _open_side(self, client: viser.ClientHandle, four: bool) -> None:
        browser = self._browsers.get(client.client_id)
        if browser is not None:
            browser.side.open(four)

    def _show_results(self, client: viser.ClientHandle) -> None:
        browser = self._browsers.get(client.client_id)
        if browser is not None:
            browser.results.open()

    def _test(self, client: viser.ClientHandle, line: int) -> None:
        """Run what a line does over many seeds, and show what comes of it."""
        past = self.session.past_of(line)
        if past is None:
            raise RefusedError("that line is not there any more")
        if not self.inbox.is_free_for(client.client_id):
            # A frame's messages are not counted as those of viser's page are.
            raise RefusedError("much is being made for this browser already; wait for that")
        end = Place(line, past.end_step)
        names = [other.name for other in self.session.status.lines if other.number == line]
        self.inbox.work(
            client,
            lambda: self.session.snapshot_at(end),
            lambda snapshot: self.experiments.test(client, snapshot, "".join(names)),
        )

    def _tell(self, client_id: int, reason: str) -> None:
        browser = self._browsers.get(client_id)
        if browser is not None:
            tell(browser.client, "Not accepted", reason, color="red")

    def _draw(
        self, live: Status, seen: Mapping[Browser, Status], now_s: float, is_for_all: bool
    ) -> None:
        """Draw a frame, for all browsers or for those alone that look at the past."""
        if is_for_all:
            self._greedy.follow(live)
            self._ghosts.follow(live)
            if self._is_true(live):
                self._plan.update(self._shared_by(seen, live))
            self._desk.update(live, self._is_true(live))
            self._bars.tidy(now_s)
            self._runs.update(self.session.race)
            self.experiments.update(live, len(seen))
        n_viewers = len(seen)
        every_s = max(_READINGS_S, _READINGS_APART_S * n_viewers)
        ground, is_answered = self._grounds.of(live), self._is_true(live)
        frames: list[tuple[Pulse, bytes]] = []
        drawn: dict[Seen, tuple[Exhibit, Texts]] = {}
        wanted = {browser: browser.seen(status) for browser, status in seen.items()}
        for browser, status in seen.items():
            if not (is_for_all or status.behind):
                continue
            browser.lesson.update(status, live, ground, browser.look, now_s)
            browser.time.update(status, live, ground, self._plan.chosen, is_answered, now_s)
            if not browser.pulse.is_ready(now_s):
                continue
            which = wanted[browser]
            if which not in drawn:
                exhibit = self.gallery.of(status, which)
                extras = self._extras(browser, status)
                greedy = self._greedy.until(status.snapshot, live.lines)
                drawn[which] = exhibit, exhibit.update(status, extras, greedy, n_viewers, now_s)
            exhibit, texts = drawn[which]
            frame = browser.frame(exhibit)
            if frame is not None:
                frames.append((browser.pulse, frame))
            reading = browser.pulse.reading(now_s, self._drawing.share)
            clock = clock_html(reading, status, n_viewers)
            browser.update(status, texts, clock, every_s, now_s)
        send(self.server, frames, now_s)
        self._presenting.show(seen, live, self._extras, self._grounds.events_of, now_s)
        self._success.keep(wanted.values())
        self.gallery.keep(wanted.values())

    def _extras(self, browser: Browser, status: Status) -> Extras:
        """What layers show besides the moment of a status."""
        success = self._success.of(browser.seen(status), status.snapshot)
        return Extras(success=success, since=browser.outlook.since)
