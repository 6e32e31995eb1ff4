"""The live page: one session, many browsers, and the loop that draws.

Only this loop touches scene handles and sets widgets; it draws the latest moment there is and
never queues any.
"""

import logging
import sys
import threading
import time
import webbrowser
from collections.abc import Mapping

import numpy as np
import viser

from app import pictures
from app.board import BoardView, Look
from app.controls import Controls
from app.door import close_server, guarded, open_server
from app.readings import Readings
from app.session import Session, Status
from app.snapshot import Snapshot
from learners.spec import RunSpec

log = logging.getLogger(__name__)

DEFAULT_SPEED = 20_000.0
"""Steps per second: the cone shows within seconds, and avoid joins within a minute."""
_FRAME_S = 1 / 12
_READINGS_S = 0.25
_CAMERA_HEIGHT = 11.6
_FOV_RADIANS = np.pi / 3


class Browser:
    """What one connected browser is shown."""

    def __init__(self, client: viser.ClientHandle, status: Status) -> None:
        self.client = client
        self._readings = Readings(client, status)
        self._board = BoardView(client.scene, status.snapshot, self._readings.look)
        self._read_at = 0.0

    @property
    def look(self) -> Look:
        """How this browser wants to see the board."""
        return self._readings.look

    def update(self, status: Status, colours: np.ndarray, look: Look, now_s: float) -> None:
        """Show a moment."""
        with self.client.atomic():
            self._board.look_like(look)
            self._board.update(status.snapshot, colours, now_s)
        if now_s - self._read_at >= _READINGS_S or not status.playing:
            self._readings.update(status)
            self._read_at = now_s


def board_colours(snapshot: Snapshot, look: Look) -> np.ndarray:
    """Colour of each cell, ``(y * x, 3) uint8``."""
    spec = snapshot.spec
    known = pictures.folded(snapshot.value, spec.world.capture_reward, spec.learner.gamma)
    per_state = pictures.state_colours(
        known, look.scale, spec.world.capture_reward, -spec.world.flight_reward, look.theme
    )
    return pictures.on_board(per_state, spec.world).reshape(-1, 3)


class Lab:
    """A session with its page."""

    def __init__(
        self, session: Session, presets: Mapping[str, RunSpec], host: str, port: int
    ) -> None:
        """Open the page.

        Raises:
            OSError: the host is not an address of this machine, or no port is free.
        """
        self._session = session
        self._browsers: dict[int, Browser] = {}
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self.server = open_server(host, port, label="pounce", on_refused=self._tell)
        self._dress_server()
        self._controls = Controls(self.server.gui, session, presets)
        self.server.on_client_connect(guarded(self._welcome))
        self.server.on_client_disconnect(guarded(self._forget))

    @property
    def url(self) -> str:
        """Address to open."""
        host = self.server.get_host()
        shown = "127.0.0.1" if host in ("0.0.0.0", "::") else host
        return f"http://{shown}:{self.server.get_port()}"

    def serve(self) -> None:
        """Draw until :meth:`close` is called."""
        while not self._stop.is_set():
            started = time.perf_counter()
            self._draw(self._session.status, started)
            self._stop.wait(max(_FRAME_S - (time.perf_counter() - started), 0.005))

    def close(self) -> None:
        """End the page and the session."""
        self._stop.set()
        self._session.stop()
        close_server(self.server)

    def _dress_server(self) -> None:
        server = self.server
        server.scene.set_up_direction("+z")
        server.scene.configure_default_lights(enabled=False)
        server.scene.world_axes.visible = False
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(330.0)
        camera = server.initial_camera
        camera.up = (0.0, 1.0, 0.0)
        camera.look_at = (0.0, 0.0, 0.0)
        camera.position = (0.0, 0.0, _CAMERA_HEIGHT)
        camera.fov = _FOV_RADIANS

    def _welcome(self, client: viser.ClientHandle) -> None:
        browser = Browser(client, self._session.status)
        with self._lock:
            self._browsers[client.client_id] = browser

    def _forget(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._browsers.pop(client.client_id, None)

    def _tell(self, client_id: int, reason: str) -> None:
        with self._lock:
            browser = self._browsers.get(client_id)
        if browser is not None:
            browser.client.add_notification(
                "Not accepted", reason, color="red", auto_close_seconds=8.0
            )

    def _draw(self, status: Status, now_s: float) -> None:
        with self._lock:
            browsers = list(self._browsers.values())
        self._controls.update(status)
        painted: dict[Look, np.ndarray] = {}
        for browser in browsers:
            look = browser.look
            if look not in painted:
                painted[look] = board_colours(status.snapshot, look)
            browser.update(status, painted[look], look, now_s)


def run_lab(
    spec: RunSpec,
    preset: str,
    seed: int,
    presets: Mapping[str, RunSpec],
    host: str,
    port: int,
    open_browser: bool,
) -> int:
    """Serve the live page until Ctrl-C; returns the exit code."""
    session = Session(spec, preset, seed, DEFAULT_SPEED, playing=True)
    lab = Lab(session, {preset: spec, **presets}, host, port)
    if port not in (0, lab.server.get_port()):
        _say(f"Port {port} is busy, so this uses {lab.server.get_port()}.")
    _say(f"pounce is at {lab.url}  (Ctrl-C ends it)")
    session.start()
    if open_browser:
        webbrowser.open(lab.url)
    try:
        lab.serve()
    except KeyboardInterrupt:
        _say("\nEnded.")
    finally:
        lab.close()
    return 0


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()
