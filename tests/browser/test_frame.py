"""The frame of the time bar in a real browser: it looks and acts as a part of the page."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import msgspec
import pytest
import viser
from playwright.sync_api import BrowserContext, Page, expect

from app.page.slots import slot_html
from app.picture.layers import LAYERS
from app.server.channels import Channel, Channels
from app.server.server import close_server, open_server
from tests.support.live import PATIENCE_S
from tests.support.proxy import proxy_to
from tests.support.screen import VIEWPORT, Begin, Shared

FRAME = "iframe.pounce-time"
IS_OPEN: Any = """frame => document.querySelector(frame)?.contentDocument?.documentElement
    ?.dataset.connection === "open" """
IS_ANOTHER: Any = """frame => {
    const root = document.querySelector(frame)?.contentDocument?.documentElement;
    return root?.dataset.former === undefined;
}"""
FITS: Any = """([frame, width]) => {
    const node = document.querySelector(frame);
    const root = node.contentDocument.documentElement;
    const style = getComputedStyle(document.documentElement);
    const [zoom, scale] = ["--stage-zoom", "--stage-scale"].map(
        name => Number(style.getPropertyValue(name)),
    );
    const larger = Math.min(Math.max(Math.min(innerWidth / 1366, innerHeight / 768), 1), 3);
    const type = parseFloat(node.contentWindow.getComputedStyle(root).fontSize);
    const isLaidOut = innerWidth === width && Math.abs(scale - larger) < 0.01;
    // Type grows with the stage; nothing is scrolled within.
    const isWritten = Math.abs(type - 16 * zoom) < 0.1 && root.scrollWidth <= root.clientWidth;
    const body = node.contentDocument.body.getBoundingClientRect();
    const box = node.getBoundingClientRect();
    return isLaidOut && isWritten && body.height > 100 && Math.abs(body.height - box.height) < 1.01
        && Math.abs(body.width - box.width) < 1.01;
}"""
ABSENT = "The time bar does not come up in this browser."


def of_frame(page: Page, script: str) -> Any:
    """What a script finds in the frame, given its root."""
    return page.frame_locator(FRAME).locator("html").evaluate(script)


def wait_for(page: Page, condition: Any) -> None:
    page.wait_for_function(condition, arg=FRAME)


@pytest.mark.parametrize(
    ("size", "presented"),
    [
        ((1366, 768), False),
        ((390, 844), False),
        ((1920, 1080), False),
        ((1366, 768), True),
        ((1024, 768), True),
    ],
)
def test_the_frame_is_as_high_as_what_is_in_it(
    shared: Shared, size: tuple[int, int], presented: bool
) -> None:
    page = shared.screen.page
    wait_for(page, IS_OPEN)
    page.set_viewport_size({"width": size[0], "height": size[1]})
    if presented:
        page.keyboard.press("p")
        expect(page.frame_locator(FRAME).locator("html")).to_have_attribute("data-present", "")
    page.wait_for_function(FITS, arg=[FRAME, size[0]])
    if presented:
        expect(page.locator(FRAME)).to_be_in_viewport(ratio=0.98)
        page.keyboard.press("Escape")
        expect(page.frame_locator(FRAME).locator("html")).not_to_have_attribute("data-present", "")
    page.set_viewport_size(VIEWPORT)


def test_the_frame_has_the_colours_of_the_page(begin: Begin) -> None:
    _, screen = begin()
    root = screen.page.frame_locator(FRAME).locator("html")
    screen.turn_to_overlays()
    for name in ("dark", "light"):
        screen.check("Dark", name == "dark")
        expect(root).to_have_attribute("data-mantine-color-scheme", name)
        text: Any = """frame => {
            const own = document.querySelector(frame).contentDocument.body;
            const around = document.querySelector("#pounce-stage");
            return getComputedStyle(own).color === getComputedStyle(around).color;
        }"""
        wait_for(screen.page, text)
    screen.page.get_by_text("Show", exact=True).click()


def test_keys_act_in_the_frame_as_they_do_beside_it(begin: Begin) -> None:
    live, screen = begin(trial=100)
    page = screen.page
    first, second, *_ = LAYERS.values()
    wait_for(page, IS_OPEN)
    page.frame_locator(FRAME).locator("body").focus()
    page.frame_locator(FRAME).locator("body").evaluate(
        "body => body.ownerDocument.defaultView.focus()"
    )
    assert page.evaluate("frame => document.activeElement.matches(frame)", FRAME)
    page.keyboard.press("2")
    expect(screen.field("Layer")).to_have_value(second.title)
    page.keyboard.press("Space")
    live.wait_for(lambda status: status.playing)
    page.keyboard.press("Space")
    live.wait_for(lambda status: not status.playing)
    # Those that are handled there are not done twice, and what is typed there is no key.
    trial = live.session.status.snapshot.trial
    page.frame_locator(FRAME).locator("body").evaluate(
        """body => {
            const field = body.ownerDocument.createElement("input");
            body.append(field);
            field.focus();
        }"""
    )
    page.keyboard.type("t1")
    field = page.frame_locator(FRAME).locator("body > input")
    expect(field).to_have_value("t1")
    field.evaluate("field => field.remove()")
    page.keyboard.press("1")
    expect(screen.field("Layer")).to_have_value(first.title)
    assert live.ask().snapshot.trial == trial


def test_a_frame_that_is_loaded_anew_shows_all_though_nothing_goes_on(begin: Begin) -> None:
    _, screen = begin(trial=100)
    lanes = screen.page.frame_locator(FRAME).locator(".lane")
    expect(lanes.first).to_be_visible()
    for _ in range(3):
        # What is left on the page that goes away is not on the one that comes.
        of_frame(screen.page, "root => root.dataset.former = ''")
        screen.page.evaluate(
            "frame => document.querySelector(frame).contentWindow.location.reload()", FRAME
        )
        wait_for(screen.page, IS_ANOTHER)
        wait_for(screen.page, IS_OPEN)
        expect(lanes.first).to_be_visible()
        expect(screen.page.frame_locator(FRAME).locator(".transport")).to_be_visible()


class Seek(msgspec.Struct, tag_field="do", tag="seek", forbid_unknown_fields=True):
    """Any message."""

    step: int


class Host:
    """A server without a lab, whose pages have a frame."""

    def __init__(self, port: int = 0) -> None:
        self.channels = Channels()
        self.server = open_server(port=port, channels=self.channels, label="a frame")
        self.server.on_client_connect(self._welcome)
        self.made: list[Channel] = []
        self.opened = threading.Event()

    def _welcome(self, client: viser.ClientHandle) -> None:
        channel = self.channels.enter(Seek, lambda message: None, self.opened.set)
        self.made.append(channel)
        client.gui.add_html(slot_html("bar", channel.frame_html("Time bar")))


@contextmanager
def served(port: int = 0) -> Iterator[Host]:
    host = Host(port)
    try:
        yield host
    finally:
        close_server(host.server)


@pytest.fixture
def page(new_context: Callable[..., BrowserContext]) -> Page:
    expect.set_options(timeout=PATIENCE_S * 1000)
    context = new_context(viewport=VIEWPORT)
    context.set_default_timeout(PATIENCE_S * 1000)
    return context.new_page()


def test_the_frame_is_found_below_a_path(page: Page) -> None:
    with served() as host, proxy_to(host.server.get_port()) as proxy:
        page.goto(f"http://127.0.0.1:{proxy}/keeps")
        wait_for(page, IS_OPEN)
        assert host.opened.wait(PATIENCE_S)


def test_a_frame_comes_back_with_the_lab_and_loads_nothing_from_elsewhere(page: Page) -> None:
    asked: set[str] = set()
    page.on("request", lambda request: asked.add(request.url.split("?")[0]))
    with served() as host:
        port = host.server.get_port()
        page.goto(f"http://127.0.0.1:{port}/")
        wait_for(page, IS_OPEN)
        former = host.made[-1].address
    expect(page.locator("#lab-connection")).to_contain_text("The lab does not answer")
    with served(port) as host:
        assert host.opened.wait(PATIENCE_S)
        wait_for(page, IS_OPEN)
        assert host.made[-1].address != former
    assert all(url.startswith((f"http://127.0.0.1:{port}/", "blob:", "data:")) for url in asked)


def test_a_frame_that_does_not_come_up_is_said(page: Page) -> None:
    page.route("**/time/**", lambda route: route.abort())
    with served() as host:
        page.goto(f"http://127.0.0.1:{host.server.get_port()}/")
        said = page.locator("#pounce-stage footer").get_by_role("status")
        expect(said).to_contain_text(ABSENT)
