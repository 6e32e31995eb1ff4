"""The live page: one session, many browsers, and the loop that draws.

Only this loop touches scene handles and sets widgets; it draws the latest moment there is and
never queues any. Views belong to a browser, learning to the session.
"""

import functools
import html
import logging
import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import viser

from app.documents.tree import PresetError
from app.explain.cell import moment_of, policy_of
from app.live.session import Begin, Request, Session, Status
from app.live.snapshot import Snapshot
from app.page.panels.controls import Controls
from app.page.panels.experiments import Experimenter
from app.page.panels.inspection import Inspector
from app.page.panels.readings import Readings, Texts, clock_html
from app.page.panels.results import ResultsPanel
from app.page.panels.schedule import Planner, PresetButtons, show_problems
from app.page.panels.steering import saved_state
from app.page.scene.board import FLAT_CAMERA, FLAT_TARGET
from app.page.scene.gallery import Gallery
from app.picture.layer import Extras, SuccessMap
from app.picture.look import Look
from app.results.service import Workbench
from app.server.access import Access
from app.server.callbacks import guarded
from app.server.calls import Calls
from app.server.notices import tell
from app.server.origin import Authority
from app.server.pulse import Drawing, Pulse, send
from app.server.server import addresses_of, close_server, is_serving, open_server
from app.server.stage import Stage
from app.util.background import Maker
from app.util.machine import give_back_memory, share_among_threads
from learners import hunts
from learners.spec import RunSpec

log = logging.getLogger(__name__)

DEFAULT_SPEED = 20_000.0
"""Steps per second: the cone shows within seconds, and avoid joins within a minute."""
_FRAME_S = 1 / 12
_LEAST_PAUSE = 2.0
"""From the beginning of a frame to that of the next, as a multiple of what it took to draw: where
there is much to draw there are fewer frames, and there is always time for clicks."""
_READINGS_S = 0.25
_READINGS_APART_S = 1 / 32
"""Pause between the readings of two browsers on average: many are told less often."""
_FAREWELL_S = 2.0
_TIDY_S = 10.0
"""How often memory is given back at most."""
_MAP_REST_S = 1.5
"""Pause between two success maps, so that the learner keeps its cores."""
_FOV_RADIANS = np.pi / 3
_PANEL_WIDTH = 330.0


def success_of(snapshot: Snapshot, wanted: Callable[[], bool]) -> SuccessMap | None:
    """How hunts end by where they start; None if it was no longer wanted."""
    try:
        outcomes = hunts.success_map(snapshot.world, policy_of(snapshot), snapshot.seed, wanted)
    except Exception:
        log.exception("no success map")
        raise
    return None if outcomes is None else SuccessMap(outcomes, snapshot.trial, snapshot.generation)


class Browser:
    """What one connected browser is shown."""

    def __init__(self, lab: "Lab", client: viser.ClientHandle, status: Status) -> None:
        self.client = client
        self._lab = lab
        self.readings = Readings(client, status)
        self.pulse = Pulse(lab.server, client.client_id)
        self._look = self.readings.look
        self._stage: Stage | None = None
        self._seen = 0
        self._inspector = Inspector(client, self.readings.inspect_tab, wake=lab.wake)
        with self.readings.file_tab:
            PresetButtons(client, lab.session, lab.ask, lab.save_dir)
            save = client.gui.add_button("Save tables", icon=viser.Icon.DEVICE_FLOPPY)
            self._load_experiment = client.gui.add_upload_button(
                "Load experiment", icon=viser.Icon.FLASK, mime_type=".yaml,.yml"
            )
        self.results = ResultsPanel(client, lab.calls, lab.bench, lab.ask_for, lab.wake)
        self._load_experiment.on_upload(guarded(self._take_experiment))
        save.on_click(
            guarded(
                lambda _: client.send_file_download(
                    *saved_state(lab.snapshot), save_immediately=True
                )
            )
        )
        client.scene.on_click()(guarded(self._clicked))
        client.scene.on_click(modifier="shift")(guarded(self._clicked))
        self._read_at = 0.0

    def _clicked(self, event: viser.SceneClickEvent) -> None:
        board = self._lab.gallery.board(self._look)
        if board is None:
            return
        place = board.place_under(event.ray_origin, event.ray_direction)
        if place is not None:
            self._inspector.take_click(place, shift=event.modifier == "shift")

    def _take_experiment(self, event: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
        file = event.target.value
        try:
            name = self._lab.experimenter.take(file.content, file.name)
        except PresetError as error:
            title = "This experiment cannot be run; nothing has changed"
            show_problems(self.client, title, error, file)
            return
        body = f"{name} is chosen under Experiments."
        tell(self.client, "Loaded", body, auto_close_seconds=6.0)

    def frame(self, stage: Stage, look: Look) -> bytes | None:
        """What this browser has not been sent yet of what it wants to see; None if nothing is."""
        if stage is not self._stage:
            self._stage, self._look, self._seen = stage, look, 0
        frame, self._seen = stage.frame_since(self._seen), stage.now
        return frame

    def update(self, texts: Texts, clock: str, every_s: float, now_s: float) -> None:
        """Show a moment beside the board: what was asked for at once, the rest now and then."""
        success = texts.extras.success
        outcomes = None
        if success is not None and success.generation == texts.status.snapshot.generation:
            outcomes = success.outcomes
        self._inspector.update(texts.status.snapshot, texts.look, outcomes)
        self.results.update(now_s)
        if now_s - self._read_at >= every_s:
            self.readings.update(texts, clock)
            self._read_at = now_s


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
    ) -> None:
        """Open the page; with ``waits`` the learner begins when the first browser has come.

        It answers to ``names`` besides its addresses; without the ``token`` nobody comes in.

        Raises:
            OSError: the host is not an address of this machine, or no port is free.
        """
        share_among_threads()
        self.session = session
        self.save_dir = save_dir
        self.calls = Calls()
        self.bench = Workbench(results)
        self._waits = waits
        self._browsers: dict[int, Browser] = {}
        self._left_early: set[int] = set()
        """Browsers that went away before their welcome was over."""
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self._due_s = -math.inf
        """When the next frame is to be drawn, on the clock of ``time.perf_counter``."""
        self._closed = False
        self._has_garbage = False
        """Whether pages have left whose memory may be given back."""
        self._tidied_s = -math.inf
        self.failure: str | None = None
        """Why :meth:`serve` ended, if nobody asked it to."""
        self._at_rest = threading.Event()
        self._at_rest.set()
        self._drawing = Drawing()
        self._success: Maker[SuccessMap | None] = Maker(rest_s=_MAP_REST_S)
        # Compiled beforehand, or the first click on the board would have to wait for it.
        threading.Thread(
            target=hunts.prepare, args=(session.status.snapshot.world,), daemon=True
        ).start()
        self.access = None if token is None else Access(token)
        self.server = open_server(
            host,
            port,
            label="pounce",
            names=names,
            access=self.access,
            on_refused=self._tell,
            on_call=self.calls.take,
        )
        self.gallery = Gallery(self.server)
        self._dress_server()
        self._controls = Controls(self.server.gui, session, presets)
        with self._controls.tabs.add_tab("Experiments", icon=viser.Icon.FLASK):
            self.experimenter = Experimenter(
                self.server.gui, session, self.bench, self.ask, self._show_results
            )
        self._planner = Planner(self.server.gui, self.ask, session)
        self._tab_title = self.server.gui.add_html("")
        self._tab_preset = ""
        session.call_when_answered(self._wake.set)
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

    def ask(self, event: viser.GuiEvent, request: Request) -> int:
        """Enqueue a request of a browser; returns its ticket."""
        return self._controls.ask(event, request)

    def ask_for(self, client: viser.ClientHandle, request: Request) -> int:
        """Enqueue a request of a browser that no event of viser's tells of."""
        return self._controls.ask_for(client, request)

    def wake(self) -> None:
        """Draw at once, because somebody waits for an answer."""
        self._due_s = -math.inf
        self._wake.set()

    def serve(self) -> None:
        """Draw until :meth:`close` is called, or there is nothing left to draw from or for."""
        self._at_rest.clear()
        try:
            while not self._closed and self.failure is None:
                started, status = time.perf_counter(), self.session.status
                with self._drawing:
                    # What answers a click comes first, and does not wait for the next frame.
                    self._controls.update(status)
                    if started >= self._due_s:
                        self._due_s = math.inf
                        self._draw(status, started)
                        pause_s = max(_FRAME_S, _LEAST_PAUSE * (time.perf_counter() - started))
                        # Unless somebody has asked for one meanwhile.
                        self._due_s = min(self._due_s, started + pause_s)
                if self._has_garbage and started - self._tidied_s > _TIDY_S:
                    self._has_garbage, self._tidied_s = False, started
                    give_back_memory()
                self._name_tab(status.snapshot.preset)
                self._wake.wait(max(self._due_s - time.perf_counter(), 0.0))
                self._wake.clear()
                self.failure = self._missing_part()
        finally:
            self._at_rest.set()

    def end(self) -> None:
        """Let :meth:`serve` end after the frame it is at; may be called from a signal's handler."""
        self._closed = True

    def close(self) -> None:
        """End the page and the session."""
        self._closed = True
        self._wake.set()
        # Not while a frame is being sent over the connections that this takes away.
        self._at_rest.wait(timeout=_FAREWELL_S)
        self.bench.close()
        self.session.stop()
        self._success.stop()
        close_server(self.server)

    def _name_tab(self, preset: str) -> None:
        """Call the browser's tab after the preset; a script of the page's own reads this."""
        if preset != self._tab_preset:
            title = html.escape(f"{Path(preset).stem} \N{MIDDLE DOT} pounce")
            self._tab_title.content = f'<span hidden data-tab-title="{title}"></span>'
            self._tab_preset = preset

    def _missing_part(self) -> str | None:
        """Which thread is gone without which there is no lab."""
        if self._closed:
            return None
        if not is_serving(self.server):
            return "the page's server has ended"
        return "the learner has ended" if self.session.is_gone else None

    @property
    def n_viewers(self) -> int:
        """Browsers that are connected."""
        return len(self._browsers)

    def _dress_server(self) -> None:
        server = self.server
        server.scene.set_up_direction("+z")
        server.scene.configure_default_lights(enabled=False)
        server.scene.world_axes.visible = False
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(_PANEL_WIDTH)
        camera = server.initial_camera
        camera.up = (0.0, 1.0, 0.0)
        camera.look_at = FLAT_TARGET
        camera.position = FLAT_CAMERA
        camera.fov = _FOV_RADIANS

    def _welcome(self, client: viser.ClientHandle) -> None:
        browser = Browser(self, client, self.session.status)
        with self._lock:
            if client.client_id not in self._left_early:
                self._browsers[client.client_id] = browser
            else:
                browser.results.leave()
            self._left_early.discard(client.client_id)
            begins, self._waits = self._waits, False
        if begins:
            self.session.submit(Begin())

    def _forget(self, client: viser.ClientHandle) -> None:
        with self._lock:
            browser = self._browsers.pop(client.client_id, None)
            if browser is None:
                self._left_early.add(client.client_id)
        if browser is not None:
            browser.results.leave()
        self._has_garbage = True

    def _show_results(self, client: viser.ClientHandle) -> None:
        with self._lock:
            browser = self._browsers.get(client.client_id)
        if browser is not None:
            browser.results.open()

    def _tell(self, client_id: int, reason: str) -> None:
        with self._lock:
            browser = self._browsers.get(client_id)
        if browser is not None:
            tell(browser.client, "Not accepted", reason, color="red")

    def _draw(self, status: Status, now_s: float) -> None:
        with self._lock:
            browsers = list(self._browsers.values())
        self._planner.update(status)
        self.experimenter.update(status)
        success = self._success.found
        extras = Extras(success if isinstance(success, SuccessMap) else None)
        looks = {browser: browser.readings.look for browser in browsers}
        if any(look.layer == "success" for look in looks.values()):
            self._success.want(
                moment_of(status.snapshot),
                lambda: success_of(status.snapshot, lambda: not self._closed),
            )
        ready: dict[Look, list[Browser]] = {}
        for browser, look in looks.items():
            if browser.pulse.is_ready(now_s):
                ready.setdefault(look, []).append(browser)
        every_s = max(_READINGS_S, _READINGS_APART_S * len(browsers))
        frames = []
        for look, here in ready.items():
            exhibit = self.gallery.of(status, look)
            texts = exhibit.update(status, extras, len(browsers), now_s)
            for browser in here:
                frame = browser.frame(exhibit.stage, look)
                if frame is not None:
                    frames.append((browser.pulse, frame))
                reading = browser.pulse.reading(now_s, self._drawing.share)
                clock = clock_html(reading, status, len(browsers))
                browser.update(texts, clock, every_s, now_s)
        send(self.server, frames, now_s)
        self.gallery.keep(looks.values())
