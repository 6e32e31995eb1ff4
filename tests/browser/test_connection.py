"""What the page says when it has no connection, and that it finds the lab behind a proxy.

The server alone is enough for this; there is no learner behind it.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import pytest
import viser
from playwright.sync_api import BrowserContext, Locator, Page, expect

from app.server.access import Access
from app.server.origin import declared_name
from app.server.server import close_server, open_server
from tests.support.live import PATIENCE_S
from tests.support.proxy import proxy_to

LABEL = "behind a proxy"
TOKEN = "correct-horse-battery"

NewContext = Callable[..., BrowserContext]


@contextmanager
def served(
    port: int = 0, names: tuple[str, ...] = (), access: Access | None = None
) -> Iterator[viser.ViserServer]:
    server = open_server(port=port, label=LABEL, names=[*map(declared_name, names)], access=access)
    try:
        yield server
    finally:
        close_server(server)


@pytest.fixture
def page(new_context: NewContext) -> Page:
    expect.set_options(timeout=PATIENCE_S * 1000)
    context = new_context(viewport={"width": 900, "height": 600})
    context.set_default_timeout(PATIENCE_S * 1000)
    return context.new_page()


def notice(page: Page) -> Locator:
    return page.locator("#lab-connection")


def expect_connection(page: Page) -> None:
    expect(page.locator("html")).to_have_attribute("data-connection", "connected")
    expect(notice(page)).to_be_empty()


def test_the_page_finds_the_lab_below_a_path(page: Page) -> None:
    with ExitStack() as stack:
        server = stack.enter_context(served())
        proxy = stack.enter_context(proxy_to(server.get_port()))
        for path in ("keeps", "forged/?fixedDpr=1"):
            page.goto(f"http://127.0.0.1:{proxy}/{path}")
            expect_connection(page)
        # A link of the page is found from there too.
        assert page.evaluate("fetch('why').then(answer => answer.status)") == 204


def test_the_page_says_which_name_to_declare_and_then_it_works(page: Page) -> None:
    with ExitStack() as stack:
        server = stack.enter_context(served())
        port = server.get_port()
        proxy = stack.enter_context(proxy_to(port))
        page.goto(f"http://127.0.0.1:{proxy}/plain/")
        expect(notice(page)).to_contain_text(f"--name 127.0.0.1:{proxy}")
        close_server(server)
        stack.enter_context(served(port, names=(f"127.0.0.1:{proxy}",)))
        # It was told what to do, and finds out by itself that it was done.
        expect_connection(page)


def test_the_page_says_that_a_proxy_lets_no_websocket_through(page: Page) -> None:
    with served() as server, proxy_to(server.get_port()) as proxy:
        page.goto(f"http://127.0.0.1:{proxy}/deaf/")
        expect(notice(page)).to_contain_text("pass on the headers Upgrade and Connection")


def test_a_lost_lab_is_said_in_words_until_it_is_back(page: Page) -> None:
    with served() as server:
        port = server.get_port()
        page.goto(f"http://127.0.0.1:{port}/")
        expect_connection(page)
        expect(page).to_have_title(LABEL)
        server.gui.add_html('<span hidden data-tab-title="timed &amp; pounce"></span>')
        expect(page).to_have_title("timed & pounce")
    expect(notice(page)).to_have_attribute("role", "status")
    expect(notice(page)).to_contain_text("The lab does not answer")
    expect(notice(page)).to_contain_text("this page reconnects by itself")
    with served(port):
        expect_connection(page)


def test_the_token_opens_the_page_and_leaves_the_address(page: Page) -> None:
    access = Access(TOKEN)
    with served(access=access) as server, proxy_to(server.get_port()) as proxy:
        address = f"http://127.0.0.1:{server.get_port()}/"
        page.goto(address)
        page.get_by_label("Token").fill("not-the-token-at-all")
        page.get_by_role("button", name="Enter").click()
        expect(page.get_by_text("That is not the token of this lab")).to_be_visible()
        page.get_by_label("Token").fill(TOKEN)
        page.get_by_role("button", name="Enter").click()
        expect_connection(page)
        assert TOKEN not in page.url
        assert page.evaluate("document.cookie") == ""
        page.reload()
        expect_connection(page)
        page.goto(f"http://127.0.0.1:{proxy}/keeps/?fixedDpr=1&{access.question()[1:]}")
        expect_connection(page)
        assert "fixedDpr=1" in page.url
        assert TOKEN not in page.url
