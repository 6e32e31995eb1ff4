"""A page in a real browser, by what a person sees and does there.

The words are those of `tests.support.person.Person`, who does the same where there is no browser.
Nothing waits for time to pass: everything waits for a condition, and fails if that is not met
within ``PATIENCE_S``.
"""

import contextlib
import io
import re
import threading
from collections.abc import Callable, Iterator
from typing import Any, Literal, NamedTuple

import imageio.v3 as iio
import numpy as np
import pytest
from playwright.sync_api import (
    ConsoleMessage,
    Frame,
    FrameLocator,
    Locator,
    Page,
    ViewportSize,
    expect,
)

from tests.support.live import PATIENCE_S, LiveLab

VIEWPORT: ViewportSize = {"width": 1366, "height": 768}
"""The smallest screen on which everything has its place."""

FIRST_LAYER = "State value"

_LOADING_S = 3 * PATIENCE_S

_CELL_COLOURS = """() => {
    const cells = window.__viserSceneTree?.getState()["/board/cells"];
    return cells ? Array.from(cells.message.props.colors) : [];
}"""

_HAS_KEYS = "html[data-has-keys]"
"""Before that, what is typed is no key of the lab's yet."""

_HAS_CELLS_OF = """count => {
    const cells = window.__viserSceneTree?.getState()["/board/cells"];
    return cells?.message.props.colors.length === 3 * count;
}"""

_HAS_COLOURS = """colours => {
    const cells = window.__viserSceneTree?.getState()["/board/cells"];
    const shown = cells?.message.props.colors;
    return shown?.length === colours.length && shown.every((part, i) => part === colours[i]);
}"""

_UNFOLDING = '[style*="will-change: height"]'
"""A folder that is being opened or closed."""

_PUT_DOWN = """() => {
    const notices = document.querySelectorAll(".mantine-Notification-closeButton");
    notices.forEach(button => button.click());
    document.activeElement?.blur();
}"""
"""Puts notices away, and takes the keyboard from whatever has it."""

_FRAME = "iframe.pounce-time"
_HAS_TIME = """() => {
    const page = document.querySelector("iframe.pounce-time")?.contentDocument;
    return page?.documentElement?.dataset.connection === "open" && !!page.querySelector(".lane");
}"""

_HAS_ITS_HEIGHT = """() => {
    const frame = document.querySelector("iframe.pounce-time");
    const { height } = frame.contentDocument.body.getBoundingClientRect();
    return Math.abs(frame.clientHeight - height) < 1.5;
}"""

_COMES_TO = """async ([part, patience, ...given]) => {
    const { state } = await import(new URL(`../../web/${part}/state.js`, location.href));
    const until = performance.now() + patience;
    const look = WANTED;
    while (!look() && performance.now() < until)
        await new Promise(done => setTimeout(done, 10));
    return look();
}"""
_IS_OF_LINE = """() => {
    const { bar, moment, held } = state;
    const [line, step] = given;
    return bar?.line === line && moment?.line === line && !held
        && (step === null || (bar.end.step === step && moment.step === step));
}"""
_IS_NEAR = """() => {
    const { moment, scrub } = state;
    const [unit, place, off] = given;
    return scrub === null && moment && Math.abs(moment[unit] - place) <= off && moment;
}"""
TWO_FRAMES = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
"""What is drawn with the next frame is drawn after these."""
HEAR = """selector => {
    const root = document.documentElement;
    window.heard = new Set();
    window.ear?.disconnect();
    window.ear = new MutationObserver(() => {
        for (const node of document.querySelectorAll(selector)) window.heard.add(node.textContent);
    });
    window.ear.observe(root, { childList: true, characterData: true, subtree: true });
}"""
"""Has a page note what some of it says from now on: it goes away by itself."""
HAS_HEARD = "words => [...window.heard].some(text => text.includes(words))"
_SEND = """async message => {
    const { send } = await import(new URL("../../web/player/pipe.js", location.href));
    return send(message);
}"""

_BOX = """node => {
    const { left, top, width, height } = node.getBoundingClientRect();
    return [left, top, width, height];
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


class Box(NamedTuple):
    """Where something is, in pixels."""

    left: float
    top: float
    width: float
    height: float


def box_of(part: Locator) -> Box:
    """Where something is in its own page, be that a frame that moves about in another page."""
    return Box(*part.evaluate(_BOX))


def comes_to(frame: Frame, part: Literal["time", "side"], wanted: str, *given: Any) -> Any:
    """Wait until a frame's page is in a state; what is then so.

    Args:
        frame: a page of its own.
        part: which of them it is.
        wanted: a function of JavaScript that looks at its ``state`` and what is ``given``. What it
            returns is returned once that is true, and in any case after a while.
    """
    script = _COMES_TO.replace("WANTED", wanted)
    return frame.evaluate(script, [part, PATIENCE_S * 1000, *given])


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
        self.page.goto(live.url, timeout=_LOADING_S * 1000)
        self.settle(live)

    def settle(self, live: LiveLab) -> None:
        """Wait until a page that loads shows everything."""
        cells = live.session.status.snapshot.spec.world.size**2
        # What loads takes many times as long on a machine under load as what is there already.
        self.page.wait_for_function(_HAS_CELLS_OF, arg=cells, timeout=_LOADING_S * 1000)
        expect(self.legend).to_be_attached()
        expect(self.page.locator(_HAS_KEYS)).to_be_attached()

    def tidy(self) -> None:
        """Put away what is open, and show what a page shows at first."""
        if self.page.viewport_size != VIEWPORT:
            self.page.set_viewport_size(VIEWPORT)
        self.page.evaluate(_PUT_DOWN)
        self.page.mouse.move(0, 0)
        dialog = self.page.get_by_role("dialog")
        if dialog.count():
            self.page.keyboard.press("Escape")
            expect(dialog).to_have_count(0)
        if self.results.is_visible():
            self.close_results()
        for tab in ("Now", "Run"):
            self.turn_to(tab)
        if self.field("Layer").input_value() != FIRST_LAYER:
            self.choose("Layer", FIRST_LAYER)

    # Reading

    @property
    def headline(self) -> Locator:
        """The sentence above the board."""
        return self.page.locator('[data-slot-of="sentence"]')

    @property
    def said(self) -> Locator:
        """What was just done by hand, on the board."""
        return self.page.get_by_role("status").and_(self.page.locator("[data-slot-of=said]"))

    @property
    def legend(self) -> Locator:
        """What the colours mean, in the panel."""
        return self.page.locator("#root .pounce-legend")

    def notice(self, title: str) -> Locator:
        """What the page was told of late, under a title."""
        notices = self.page.locator(".mantine-Notification-root")
        return notices.filter(has=self.page.get_by_text(title, exact=True))

    def reading(self, label: str) -> Locator:
        """The number under a label, or beside it."""
        numbers = self.page.locator("[data-dock-edge] .pounce-numbers")
        cell = numbers.get_by_text(label, exact=True).locator("xpath=ancestor-or-self::div[1]")
        return cell.locator("xpath=following-sibling::div")

    @property
    def time(self) -> FrameLocator:
        """The time bar, which is a page of its own in a frame."""
        return self.page.frame_locator(_FRAME)

    @property
    def time_page(self) -> Frame:
        """The same as one in which scripts can be run, once it is connected and shows a bar."""
        self.page.wait_for_function(_HAS_TIME)
        frame = self.page.locator(_FRAME).element_handle().content_frame()
        assert frame is not None
        return frame

    def tell(self, do: str, **what: Any) -> None:
        """Send what a hand on the time bar sends."""
        assert self.time_page.evaluate(_SEND, {"do": do, **what})

    def expect_line(self, line: int, step: int | None = None) -> None:
        """Wait until the time bar is that of a line, and as far as that has come."""
        assert comes_to(self.time_page, "time", _IS_OF_LINE, line, step)

    def expect_place(self, unit: Literal["step", "trial"], place: int, off: int = 0) -> int:
        """Wait until the time bar knows that the page shows a moment, at most so far off; where."""
        found = comes_to(self.time_page, "time", _IS_NEAR, unit, place, off)
        assert found
        return int(found[unit])

    def rest(self) -> None:
        """Wait until the time bar's frame has the height of what is in it, and rests."""
        assert self.time_page
        self.page.wait_for_function(_HAS_ITS_HEIGHT)
        self.page.locator(_FRAME).element_handle().wait_for_element_state("stable")

    def text(self, words: str) -> Locator:
        """Something that says these words."""
        return self.page.get_by_text(words)

    @property
    def results(self) -> Locator:
        """What the panel with the results holds."""
        return self.page.locator(".pounce-results")

    @property
    def results_button(self) -> Locator:
        """Opens the panel with the results in this browser."""
        return self.page.get_by_role("button", name=re.compile("^Show results of "))

    def reads(self, words: str) -> bool:
        """Wait until the page says so; what a tab has that is not turned to does not count."""
        expect(self.text(words).locator("visible=true")).to_be_visible()
        return True

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
        """A button by what is written on it, but for that which undoes what was just done."""
        found = self.page.get_by_role("button", name=name, exact=True)
        return found.and_(self.page.locator(":not([data-slot-of=said] *)"))

    def tab(self, name: str) -> Locator:
        """A tab by what is written on it."""
        return self.page.get_by_role("tab", name=name, exact=True)

    def checkbox(self, label: str) -> Locator:
        """A checkbox by its label."""
        return self.page.get_by_role("checkbox", name=label, exact=True)

    def field(self, label: str) -> Locator:
        """A field to type into, or a list to choose from, by its label."""
        return self.page.get_by_label(label, exact=True).and_(self.page.locator("input"))

    def click(self, name: str) -> None:
        """Click on a button."""
        self.button(name).click()

    def turn_to(self, tab: str) -> None:
        """Turn to a tab. One that is shown is left alone: clicked, it would be drawn anew."""
        if self.tab(tab).get_attribute("aria-selected") != "true":
            self.tab(tab).click()
        expect(self.tab(tab)).to_have_attribute("aria-selected", "true")

    def turn_to_overlays(self) -> None:
        """Open what may be drawn over every layer."""
        self.turn_to("Now")
        self.unfold("Show", self.checkbox("Dark"))

    def unfold(self, folder: str, within: Locator) -> None:
        """Open a folder if it is closed, and wait until it is open: what is in it moves till then.

        Args:
            folder: what is written on it.
            within: something that is in it.
        """
        if not within.is_visible():
            self.page.get_by_text(folder, exact=True).click()
        expect(within).to_be_visible()
        expect(self.page.locator(_UNFOLDING)).to_have_count(0)

    @contextlib.contextmanager
    def told(self, words: str) -> Iterator[None]:
        """Wait at the end until there was a notice with these words, be it gone by then."""
        self.page.evaluate(HEAR, ".mantine-Notification-root")
        yield
        self.page.wait_for_function(HAS_HEARD, arg=words)

    def show_results(self) -> None:
        """Open the panel with the results from the tab."""
        self.turn_to("Experiments")
        self.results_button.click()
        expect(self.results).to_be_visible()

    @property
    def results_close(self) -> Locator:
        """Closes the panel with the results."""
        return self.page.get_by_role("link", name=re.compile("^Close"))

    def close_results(self) -> None:
        """Close the panel with the results."""
        self.results_close.click()
        expect(self.results).to_be_hidden()

    def choose(self, label: str, option: str) -> None:
        """Choose from a list."""
        self.field(label).click()
        self.page.get_by_role("option", name=option, exact=True).click()
        # A list that closes takes the focus back.
        expect(self.page.get_by_role("option")).to_have_count(0)
        expect(self.field(label)).to_have_value(option)

    def check(self, label: str, checked: bool = True) -> None:
        """Tick a box, or not; the page may take a moment to show it."""
        box = self.checkbox(label)
        if box.is_checked() != checked:
            box.click()
        expect(box).to_be_checked(checked=checked)

    def fill(self, label: str, text: object) -> None:
        """Type into a field, and finish that."""
        self.field(label).fill(str(text))
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


class Shared(NamedTuple):
    """A lab and a page of it that several tests of a file use, one after the other."""

    live: LiveLab
    screen: Screen


class Two(NamedTuple):
    """A lab and two pages of it, each in a browser profile of its own."""

    live: LiveLab
    one: Screen
    other: Screen


Begin = Callable[..., Shared]
BeginTwo = Callable[..., Two]
StartLab = Callable[..., LiveLab]
OpenPage = Callable[..., Screen]
