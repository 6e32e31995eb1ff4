"""A lab in this process, and pages in a real browser that look at it.

Tests ask the session what is true, and a page what it shows. Nothing waits for time to pass:
everything waits for a condition, and fails if that is not met within ``PATIENCE_S``.
"""

import contextlib
import io
import re
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import imageio.v3 as iio
import numpy as np
import pytest
from playwright.sync_api import (
    Browser,
    BrowserContext,
    ConsoleMessage,
    Locator,
    Page,
    ViewportSize,
    expect,
)

from app.documents import presets
from app.live.session import MOST_WAITING, Request, Session, Status, TrialOnce
from app.page.lab import Lab
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from learners.spec import RunSpec

PATIENCE_S = 30.0
VIEWPORT: ViewportSize = {"width": 1366, "height": 768}
"""The smallest screen on which everything has its place."""
SEED = 3

_CELL_COLOURS = """() => {
    const cells = window.__viserSceneTree?.getState()["/board/cells"];
    return cells ? Array.from(cells.message.props.colors) : [];
}"""

_HAS_CELLS_OF = """count => {
    const cells = window.__viserSceneTree?.getState()["/board/cells"];
    return cells?.message.props.colors.length === 3 * count;
}"""

_HAS_COLOURS = """colours => {
    const cells = window.__viserSceneTree?.getState()["/board/cells"];
    const shown = cells?.message.props.colors;
    return shown?.length === colours.length && shown.every((part, i) => part === colours[i]);
}"""

_PROJECT = """index => {
    const { camera, canvas, nodeRefFromName } = window.__viserMutable;
    const props = window.__viserSceneTree.getState()["/board/cells"].message.props;
    const centre = props.points.subarray(3 * index, 3 * index + 3);
    const place = camera.position.clone().set(...centre);
    nodeRefFromName["/board/cells"].localToWorld(place).project(camera);
    const box = canvas.getBoundingClientRect();
    const x = box.left + (place.x + 1) / 2 * box.width;
    const y = box.top + (1 - place.y) / 2 * box.height;
    return [Math.floor(x), Math.floor(y)];
}"""


def preset_of(name: str = "timed", *settings: str) -> RunSpec:
    """A shipped preset in a small world."""
    return presets.load(name, ["world.size=40", *settings])


class LiveLab:
    """A session with its page, served by this process; paused until somebody plays."""

    def __init__(self, spec: RunSpec, speed: float, results: Path) -> None:
        self.results = results
        """Folder below which experiments leave their results; made when it is needed."""
        offered = {name: preset_of(name) for name in ("timed", "hierarchical_2", "standard_q")}
        self.session = Session(spec, "timed", SEED, speed, playing=False)
        self.lab = Lab(self.session, {**offered, "timed": spec}, "127.0.0.1", 0, results=results)
        self.gone = threading.Event()
        """Set when a page has left."""
        self.lab.server.on_client_disconnect(lambda _: self.gone.set())
        self._drawing = threading.Thread(target=self.lab.serve, name="drawing")
        self.session.start()
        self._drawing.start()

    @property
    def url(self) -> str:
        """Address of the page, with one pixel of the screen for each pixel of the picture."""
        return f"{self.lab.url}/?fixedDpr=1"

    def ask(self, *requests: Request) -> Status:
        """The status in which all these requests have been answered."""
        ticket = max(self.session.submit(request) for request in requests)
        return self.wait_for(lambda status: status.answered >= ticket)

    def go_to_trial(self, trial: int) -> Status:
        """Learn, and stand still at the start of a trial."""
        status = self.session.status
        while status.snapshot.trial < trial:
            # A session takes only so many requests at a time.
            ahead = min(trial - status.snapshot.trial, MOST_WAITING)
            status = self.ask(*[TrialOnce()] * ahead)
        return status

    def wait_for(self, condition: Callable[[Status], bool]) -> Status:
        """The first status that meets a condition."""
        return self.session.wait_for(condition, PATIENCE_S)

    def colours(self, look: Look | None = None) -> np.ndarray:
        """Colours of all cells as a page of that look must have them, ``(y * x, 3) uint8``."""
        look = look or Look()
        picture = LAYERS[look.layer].paint(self.session.status.snapshot, look, Extras())
        return picture.colours

    def close(self) -> None:
        """End the page and the session."""
        self.lab.close()
        self._drawing.join()


class Screen:
    """One page of the lab, by what a person sees and does there."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.complaints: list[str] = []
        page.on("console", self._note)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))

    def _note(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.complaints.append(message.text)

    def open(self, live: LiveLab) -> None:
        """Go to the page, and wait until it shows everything."""
        self.page.goto(live.url)
        self.settle(live)

    def settle(self, live: LiveLab) -> None:
        """Wait until a page that loads shows everything, and put the notice on software away."""
        cells = live.session.status.snapshot.spec.world.size**2
        self.page.wait_for_function(_HAS_CELLS_OF, arg=cells)
        expect(self.legend).to_be_attached()
        notice = self.page.get_by_role("alert").filter(has_text="Software WebGL")
        notice.get_by_role("button").click()
        expect(notice).to_have_count(0)

    # Reading

    @property
    def headline(self) -> Locator:
        """Title and sentence."""
        return self.page.get_by_text("the timing of skills changes what is learned").locator(
            "xpath=../.."
        )

    @property
    def legend(self) -> Locator:
        """What the colours mean."""
        return self.page.get_by_text("The half-disc is what the prey sees").locator("xpath=..")

    def reading(self, label: str) -> Locator:
        """The number under a label."""
        return self.page.get_by_text(label, exact=True).locator("xpath=following-sibling::div")

    def text(self, words: str) -> Locator:
        """Something that says these words."""
        return self.page.get_by_text(words)

    def cell_colours(self) -> np.ndarray:
        """Colours of all cells as the page has them, ``(y * x, 3) uint8``."""
        return np.array(self.page.evaluate(_CELL_COLOURS), np.uint8).reshape(-1, 3)

    def expect_cell_colours(self, colours: np.ndarray) -> None:
        """Wait until the page has exactly these colours."""
        self.page.wait_for_function(_HAS_COLOURS, arg=colours.ravel().tolist())

    def place_of(self, cell: int) -> tuple[int, int]:
        """Pixel at the centre of a cell, ``(x, y)``."""
        x, y = self.page.evaluate(_PROJECT, cell)
        return x, y

    def expect_pixel(self, place: tuple[int, int], colour: np.ndarray) -> None:
        """Wait until a pixel of the screen has exactly this colour."""
        clip = {"x": place[0], "y": place[1], "width": 1, "height": 1}
        seen: list[list[int]] = []
        # Each picture waits for a new frame to be drawn.
        for _ in range(30):
            seen.append(picture(self.page.screenshot(clip=clip))[0, 0].tolist())
            if seen[-1] == colour.tolist():
                return
        pytest.fail(f"the pixel at {place} was {seen[-1]} and never {colour.tolist()}")

    # Doing

    def button(self, name: str) -> Locator:
        """A button by what is written on it."""
        return self.page.get_by_role("button", name=name, exact=True)

    def checkbox(self, label: str) -> Locator:
        """A checkbox by its label."""
        return self.page.get_by_role("checkbox", name=label, exact=True)

    def field(self, label: str) -> Locator:
        """A field to type into, or a list to choose from, by its label."""
        return self.page.get_by_label(label, exact=True).and_(self.page.locator("input"))

    def turn_to(self, tab: str) -> None:
        """Turn to another tab."""
        self.page.get_by_role("tab", name=tab, exact=True).click()

    def choose(self, label: str, option: str) -> None:
        """Choose from a list."""
        self.field(label).click()
        self.page.get_by_role("option", name=option, exact=True).click()
        # A list that closes takes the focus back.
        expect(self.page.get_by_role("option")).to_have_count(0)
        expect(self.field(label)).to_have_value(option)

    def type(self, label: str, text: str) -> None:
        """Type into a field, and finish that."""
        self.field(label).fill(text)
        self.field(label).press("Enter")

    def upload(self, button: str, name: str, text: str) -> None:
        """Load a file of that name, with a button for it."""
        with self.page.expect_file_chooser() as chooser:
            self.button(button).click()
        chooser.value.set_files({"name": name, "mimeType": "text/yaml", "buffer": text.encode()})


def picture(png: bytes) -> np.ndarray:
    """A screenshot as ``(y, x, 3) uint8``."""
    return np.asarray(iio.imread(io.BytesIO(png), extension=".png"))[..., :3]


def colours_in(css: str) -> list[list[int]]:
    """The colours in a piece of CSS, in order."""
    found = re.findall(r"rgb\((\d+), ?(\d+), ?(\d+)\)", css)
    return [[int(part) for part in colour] for colour in found]


@contextlib.contextmanager
def arriving(handle: Any) -> Iterator[None]:
    """Waits until what is typed into a widget here has come to the server.

    A page sends only the newest of all changes within 50 ms, whatever widgets they belong to.
    """
    arrived = threading.Event()
    handle.on_update(lambda _: arrived.set())
    yield
    assert arrived.wait(PATIENCE_S)


StartLab = Callable[..., LiveLab]
OpenPage = Callable[..., Screen]


@pytest.fixture
def start_lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[StartLab]:
    """Starts labs, paused at the beginning of a trial, and ends them after the test."""
    started: list[LiveLab] = []

    def start(spec: RunSpec | None = None, trial: int = 0, speed: float = 20_000.0) -> LiveLab:
        live = LiveLab(spec or preset_of(), speed, tmp_path_factory.mktemp("lab") / "results")
        started.append(live)
        if trial:
            live.go_to_trial(trial)
        return live

    yield start
    for live in started:
        live.close()


@pytest.fixture
def open_page(
    start_lab: StartLab, new_context: Callable[..., BrowserContext]
) -> Iterator[OpenPage]:
    """Opens pages, each in a browser profile of its own; none may log an error."""
    expect.set_options(timeout=PATIENCE_S * 1000)
    screens: list[Screen] = []

    def open_one(live: LiveLab, on_request: Callable[[str], None] = lambda url: None) -> Screen:
        context = new_context(viewport=VIEWPORT)
        context.set_default_timeout(PATIENCE_S * 1000)
        screen = Screen(context.new_page())
        screens.append(screen)
        screen.page.on("request", lambda request: on_request(request.url))
        screen.open(live)
        return screen

    yield open_one
    assert [complaint for screen in screens for complaint in screen.complaints] == []


class Shared(NamedTuple):
    """A lab and a page of it that several tests of a file use, one after the other."""

    live: LiveLab
    screen: Screen


@pytest.fixture(scope="module")
def shared(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shared]:
    """One lab and one page for a file; the page may log no error."""
    expect.set_options(timeout=PATIENCE_S * 1000)
    live = LiveLab(preset_of(), 20_000.0, tmp_path_factory.mktemp("lab") / "results")
    live.go_to_trial(100)
    context = browser.new_context(viewport=VIEWPORT)
    context.set_default_timeout(PATIENCE_S * 1000)
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    screen = Screen(context.new_page())
    screen.open(live)
    yield Shared(live, screen)
    context.close()
    live.close()
    assert screen.complaints == []
