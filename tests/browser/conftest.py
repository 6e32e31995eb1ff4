"""Labs in this process, and pages in a real browser that look at them."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, expect

from app.server import admission
from learners.spec import RunSpec
from tests.support.live import PATIENCE_S, LiveLab, preset_of
from tests.support.screen import VIEWPORT, Begin, OpenPage, Screen, Shared, StartLab

FIRST_TRIAL = 100
"""Where a lab stands that no test has begun in a way of its own."""


@pytest.fixture(autouse=True)
def no_double_clicks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Clicks of tests may come faster than people's, and each is meant."""
    monkeypatch.setattr(admission, "DOUBLE_S", 0.0)


@pytest.fixture
def start_lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[StartLab]:
    """Starts labs, paused at the beginning of a trial, and ends them after the test."""
    started: list[LiveLab] = []

    def start(
        spec: RunSpec | None = None, trial: int = 0, speed: float = 20_000.0, opening: bool = False
    ) -> LiveLab:
        results = tmp_path_factory.mktemp("lab") / "results"
        live = LiveLab(spec or preset_of(), speed, results, opening)
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


class Stage:
    """The lab and the page that tests use one after the other."""

    def __init__(self, browser: Browser, folder: Callable[[], Path]) -> None:
        self._browser, self._folder = browser, folder
        self._shared: Shared | None = None

    @property
    def shared(self) -> Shared:
        """Both as the test before has left them; at the first trial of all if there was none."""
        if self._shared is None:
            expect.set_options(timeout=PATIENCE_S * 1000)
            live = LiveLab(preset_of(), 20_000.0, self._folder())
            live.go_to_trial(FIRST_TRIAL)
            context = self._browser.new_context(viewport=VIEWPORT)
            context.set_default_timeout(PATIENCE_S * 1000)
            context.grant_permissions(["clipboard-read", "clipboard-write"])
            self._shared = Shared(live, Screen(context.new_page()))
            self._shared.screen.open(live)
        return self._shared

    def begin(
        self, preset: str = "timed", *settings: str, trial: int = 0, speed: float = 20_000.0
    ) -> Shared:
        """Both as new ones would be: paused at the beginning of a trial of another run."""
        live, screen = self.shared
        live.begin(preset, *settings, speed=speed, results=self._folder())
        live.go_to_trial(trial)
        screen.tidy()
        expect(screen.reading("Trial")).to_have_text(f"{trial:,}")
        expect(screen.reading("Viewers")).to_have_count(0)
        screen.expect_cell_colours(live.colours())
        return self.shared

    def clear(self) -> None:
        """What is open begins as a new one would, for the tests of another file."""
        if self._shared is not None:
            self.begin(trial=FIRST_TRIAL)

    def close(self) -> None:
        """End both."""
        if self._shared is not None:
            self._shared.screen.page.context.close()
            self._shared.live.close()
            self._shared = None


@pytest.fixture(scope="session")
def only_stage(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stage]:
    """A lab and a page, opened when they are needed; a page takes seconds to open."""
    stage = Stage(browser, lambda: tmp_path_factory.mktemp("lab") / "results")
    yield stage
    stage.close()


@pytest.fixture(scope="module")
def stage(only_stage: Stage) -> Stage:
    """The lab and the page as new ones, for the tests of a file."""
    only_stage.clear()
    return only_stage


@pytest.fixture
def shared(stage: Stage, request: pytest.FixtureRequest) -> Iterator[Shared]:
    """A lab and a page as the test before has left them; the page may log no error."""
    failures = request.session.testsfailed
    yield stage.shared
    if request.session.testsfailed > failures:
        # Whatever state it has left them in, it is not the next test that fails for it.
        stage.close()
    else:
        assert stage.shared.screen.complaints == []


@pytest.fixture
def begin(stage: Stage, shared: Shared) -> Begin:
    """Has the lab and the page of the file begin as new ones, each time that it is called."""
    return stage.begin
