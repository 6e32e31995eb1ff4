"""Labs in this process, and pages in a real browser that look at them."""

from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Browser, BrowserContext, expect

from learners.spec import RunSpec
from tests.support.live import PATIENCE_S, LiveLab, preset_of
from tests.support.screen import VIEWPORT, OpenPage, Screen, Shared, StartLab


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
