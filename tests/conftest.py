"""What all tests share: the browser, and how patient property-based tests are."""

import gc
import os
import sys
from collections.abc import Generator, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from app.experiments import task
from app.util.web_browser import find_chromium
from tests.support.browser import TEST_ARGS, advice

HARMLESS_WARNINGS = (
    # A page may go away between two lines of a frame; what was meant for it is rightly lost.
    "ignore:Queued a .* on a closed connection",
    # About a fixture of pytest-base-url.
    "ignore:Session-scoped fixtures defined as instance methods",
)

BROWSER_TESTS = Path(__file__).parent / "browser"
OTHER_BROWSER = frozenset(
    f"test_{name}.py"
    for name in (
        # These do not share a lab and a page with others.
        *("audience", "boards", "class", "class_place", "connection", "hunts", "lesson_card"),
        *("replay_page", "report_page", "report_print", "sessions"),
        *("access", "asked", "frame", "lesson_page", "lessons_played", "sharing"),
    )
)
"""Files of browser tests that take about half of the time of all."""
BEGINNING = ("browser", "report", "experiments", "learners")
"""Folders whose tests take longest, these first; what is short comes last, so that of several
workers none is at work long after the others."""

FAREWELLS = (
    *("live.worker", "live.wishes", "page.lab", "page.side.show"),
    *("lessons.twenty", "lessons.referee"),
)
"""Modules of threads that are waited for at their end, though not for ever."""

# Each of many processes would compile all modules anew that another one has not left compiled.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# The first call of a compiled function takes seconds; a shared machine is slow at times. The same
# examples each time, so that a test fails only where something has changed. And a machine that
# stands still makes no strategy slow.
settings.register_profile(
    "pounce",
    deadline=None,
    derandomize=True,
    database=None,
    max_examples=60,
    suppress_health_check=[HealthCheck.too_slow],
)
# To look for what these do not find: pytest --hypothesis-profile search.
settings.register_profile("search", deadline=None, max_examples=5_000)
settings.load_profile("pounce")


@pytest.fixture(scope="session", autouse=True)
def own_state(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep the sessions of labs that tests open away from the user's own."""
    os.environ["XDG_STATE_HOME"] = str(tmp_path_factory.mktemp("state"))


@pytest.fixture(scope="session", autouse=True)
def patient() -> Iterator[None]:
    """Give up nothing, and make no thread wait for others, because a process stands still.

    On a machine with much else to do that lasts for seconds: what is only late is then taken for
    lost, and a thread that is content with what others leave is left nothing.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("app.util.machine._MODEST", 0)
        patch.setattr("app.page.lesson.desk._PATIENCE_S", 600.0)
        for module in FAREWELLS:
            patch.setattr(f"app.{module}._FAREWELL_S", 60.0)
        for module in ("server", "watchers"):
            patch.setattr(f"app.server.{module}.HANDSHAKE_S", 60.0)
        yield


@pytest.fixture(scope="session")
def browser_type_launch_args(browser_type_launch_args: dict[str, Any]) -> dict[str, Any]:
    """Launch the system's browser; without one, browser tests skip, or fail where CI is set."""
    path = find_chromium()
    if path is None:
        if os.environ.get("CI"):
            pytest.fail(advice(), pytrace=False)
        pytest.skip(advice())
    return {**browser_type_launch_args, "executable_path": path, "args": list(TEST_ARGS)}


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Look for no garbage while tests are collected, and never at what stays until the end.

    That is half a million objects in each worker, and to look through them takes a quarter of a
    second each time.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark the browser tests, and put all where they hold up nobody.

    In one process the browser tests come last, after the quick tests; several workers begin with
    what takes longest.
    """
    for item in items:
        if _folder_of(item.path) == BROWSER_TESTS.name:
            item.add_marker(pytest.mark.browser)
            item.add_marker(pytest.mark.filterwarnings(*HARMLESS_WARNINGS))
    if hasattr(config, "workerinput"):
        items.sort(key=_place_among_workers)
    else:
        items.sort(key=lambda item: _folder_of(item.path) == BROWSER_TESTS.name)


@cache
def _folder_of(path: Path) -> str:
    """The folder of tests, or the file beside these, in which a test is."""
    return path.relative_to(BROWSER_TESTS.parent).parts[0]


def _place_among_workers(item: pytest.Item) -> int:
    folder = _folder_of(item.path)
    return BEGINNING.index(folder) if folder in BEGINNING else len(BEGINNING)


@pytest.hookimpl(optionalhook=True, wrapper=True)
def pytest_xdist_auto_num_workers() -> Generator[None, int, int]:
    """With ``-n auto``, one worker more than there are processors.

    Tests wait for half of their time: for a browser, for a program that starts, for a disk.
    """
    n_processors = yield
    return n_processors + ("PYTEST_XDIST_AUTO_NUM_WORKERS" not in os.environ)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """With ``--dist loadfile``, give browser tests to two workers, as if they were two files.

    Those of each share a lab and a page. More browsers that draw in software would hold each other
    up; with one alone, or with two of which one has much more to do, processors are idle at the
    end.
    """
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    browser_tests = f"{BROWSER_TESTS.relative_to(config.rootpath).as_posix()}/"

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            if not file.startswith(browser_tests):
                return super()._split_scope(nodeid)
            is_other = file.removeprefix(browser_tests) in OTHER_BROWSER
            return f"{browser_tests}other" if is_other else browser_tests

    return Scheduling(config, log)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Keys of the runs that are made."""
    made: list[str] = []
    perform = task.perform

    def count(of: task.Task, *others: Any) -> Any:
        made.append(of.key)
        return perform(of, *others)

    monkeypatch.setattr("app.experiments.crews.perform", count)
    return made
