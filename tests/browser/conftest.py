"""Labs in this process, and pages in a real browser that look at them."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, expect

from app.live.requests import EndRace, LeaveLesson
from app.page import lab
from app.server import admission, pace
from learners.spec import RunSpec
from tests.support.costs import try_for_a_moment
from tests.support.live import PATIENCE_S, LiveLab, preset_of
from tests.support.pupil import Pupil
from tests.support.screen import (
    VIEWPORT,
    Begin,
    BeginTwo,
    OpenPage,
    Screen,
    Shared,
    StartLab,
    Two,
)

FRAME_S = 0.2
"""Between pictures of a run that learns: each costs as much as a hundred thousand steps."""
FIRST_TRIAL = 100
"""Where a lab stands that no test has begun in a way of its own."""


@pytest.fixture(scope="package", autouse=True)
def short_pilots() -> Iterator[None]:
    """No test reads how long an experiment would take, which each lab tries out by itself."""
    with pytest.MonkeyPatch.context() as patch:
        try_for_a_moment(patch)
        yield


@pytest.fixture(scope="package", autouse=True)
def few_pictures() -> Iterator[None]:
    """Nobody looks at a run that learns; what is asked for is answered as soon as ever."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lab, "_FRAME_S", FRAME_S)
        yield


@pytest.fixture(autouse=True)
def no_double_clicks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Clicks and keys of tests may come faster than people's, and each is meant."""
    monkeypatch.setattr(admission, "DOUBLE_S", 0.0)
    monkeypatch.setattr(pace, "REPEAT_S", 0.0)


@pytest.fixture
def start_lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[StartLab]:
    """Starts labs, paused at the beginning of a trial, and ends them after the test."""
    started: list[LiveLab] = []

    def start(
        spec: RunSpec | None = None,
        trial: int = 0,
        speed: float = 20_000.0,
        opening: bool = False,
        sessions: Path | None = None,
    ) -> LiveLab:
        results = tmp_path_factory.mktemp("lab") / "results"
        live = LiveLab(spec or preset_of(), speed, results, opening, sessions)
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

    def open_one(live: LiveLab) -> Screen:
        context = new_context(viewport=VIEWPORT)
        context.set_default_timeout(PATIENCE_S * 1000)
        screen = Screen(context.new_page())
        screens.append(screen)
        screen.open(live)
        return screen

    yield open_one
    assert [complaint for screen in screens for complaint in screen.complaints] == []


class Stage:
    """The lab and the page that tests use one after the other, and a second page for some."""

    def __init__(self, browser: Browser, folder: Callable[[], Path]) -> None:
        self._browser, self._folder = browser, folder
        self._shared: Shared | None = None
        self._other: Screen | None = None

    @property
    def shared(self) -> Shared:
        """Both as the test before has left them; at the first trial of all if there was none."""
        if self._shared is None:
            expect.set_options(timeout=PATIENCE_S * 1000)
            live = LiveLab(preset_of(), 20_000.0, self._folder())
            self._shared = Shared(live, self._new_page())
            try:
                live.go_to_trial(FIRST_TRIAL)
                self._shared.screen.open(live)
            except BaseException:
                # A lab that is not closed keeps this process from ending.
                self.close()
                raise
        return self._shared

    @property
    def pages(self) -> list[Screen]:
        """All that are open, the second one last."""
        pages = [self.shared.screen, *([self._other] if self._other else [])]
        return [screen for screen in pages if not screen.page.is_closed()]

    @property
    def complaints(self) -> list[str]:
        """What pages have logged as an error."""
        others = [self._other] if self._other else []
        return [line for page in (self.shared.screen, *others) for line in page.complaints]

    def begin(
        self, preset: str = "timed", *settings: str, trial: int = 0, speed: float = 20_000.0
    ) -> Shared:
        """Both as new ones would be: paused at the beginning of a trial of another run."""
        self._close_other()
        self._begin(preset, *settings, trial=trial, speed=speed)
        return self.shared

    def begin_two(self, preset: str = "timed", *settings: str, trial: int = 0) -> Two:
        """Likewise with a second page, which is left open for the next test that wants one."""
        if len(self.pages) == 1:
            self._close_other()
            self._other = self._new_page()
            self._other.open(self.shared.live)
        self._begin(preset, *settings, trial=trial, speed=20_000.0)
        return Two(self.shared.live, *self.pages)

    def _new_page(self) -> Screen:
        """An empty page in a browser profile of its own."""
        context = self._browser.new_context(viewport=VIEWPORT)
        context.set_default_timeout(PATIENCE_S * 1000)
        context.grant_permissions(["clipboard-read", "clipboard-write"])
        return Screen(context.new_page())

    def _begin(self, preset: str, *settings: str, trial: int, speed: float) -> None:
        live = self.shared.live
        live.begin(preset, *settings, speed=speed, results=self._folder())
        live.go_to_trial(trial)
        pages = self.pages
        for screen in pages:
            screen.tidy()
            expect(screen.reading("Trial")).to_have_text(f"{trial:,}")
            viewers = screen.reading("Viewers")
            if len(pages) > 1:
                expect(viewers).to_have_text(f"{len(pages)}")
            else:
                expect(viewers).to_have_count(0)
            screen.expect_cell_colours(live.colours())
            # A run may look like the one before: only its number tells them apart.
            screen.expect_line(live.session.status.snapshot.generation)

    def _close_other(self) -> None:
        if self._other is not None:
            self._other.page.context.close()
            self._other = None

    def clear(self) -> None:
        """What is open begins as a new one would, for the tests of another file."""
        if self._shared is not None:
            self.begin(trial=FIRST_TRIAL)

    def close(self) -> None:
        """End all."""
        self._close_other()
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
        assert stage.complaints == []


@pytest.fixture
def begin(stage: Stage, shared: Shared) -> Begin:
    """Has the lab and the page of the file begin as new ones, each time that it is called."""
    return stage.begin


@pytest.fixture
def begin_two(stage: Stage, shared: Shared) -> BeginTwo:
    """Likewise with two pages, of which the second one takes seconds to open the first time.

    Tests of a file that want it stand one after the other: it is closed for all others.
    """
    return stage.begin_two


@pytest.fixture
def pupil(shared: Shared, begin: Begin) -> Iterator[Pupil]:
    """Somebody in front of a page on which no lesson is; none is left when they have gone, nor
    what ran side by side for one."""
    live, screen = begin()
    pupil = Pupil(screen)
    yield pupil
    live.ask(LeaveLesson())
    live.ask(EndRace())
    if pupil.learn.get_attribute("aria-pressed") == "true":
        pupil.button("Close").click()
    expect(screen.page.locator("html:not([data-lesson])")).to_have_count(1)
    screen.page.set_viewport_size(VIEWPORT)
