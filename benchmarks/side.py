"""What a real browser shows of four runs side by side while all of them learn at full speed.

The browser draws in software, on the same machine: the slowest screen that anybody will look at.
What counts are pictures of all four boards, and what the learners do meanwhile.
"""

import statistics
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from app.documents import presets
from app.live.race import thesis_four
from app.live.requests import StartRace
from app.live.session import Session
from app.live.worker import FULL_SPEED
from app.page.lab import Lab
from app.util.web_browser import CHROMIUM_ADVICE, find_chromium
from learners.names import MAX_TRIALS
from learners.spec import RunSpec

BOARDS: Final = 4
TURN_S: Final = 3.0
"""For so long pictures are counted, once for each repetition."""
_WIDTH, _HEIGHT = 1366, 768
_PATIENCE_MS: Final = 60_000.0
_ARGUMENTS: Final = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",
    "--disable-background-networking",
    "--no-first-run",
)
_HAS_BOARD: Final = """() => {
    const cells = window.__viserSceneTree?.getState()["/board/cells"];
    const hasKeys = document.documentElement.matches("[data-has-keys]");
    return hasKeys && cells?.message.props.colors.length > 0;
}"""
"""The board is drawn last of all, and no key acts before the page knows which there are."""
_FRAME: Final = "iframe.pounce-side"
# Asked from the page around, which is there: a frame that is still loading takes its scripts along.
_IS_SHOWN: Final = """([frame, boards]) =>
    document.querySelector(frame).contentWindow.pounceSide?.().length === boards"""
_COUNT: Final = """([frame, seconds]) => new Promise(done => {
    const { contentWindow } = document.querySelector(frame);
    const before = contentWindow.pounceSide();
    const began = performance.now();
    const look = () => {
        const took = (performance.now() - began) / 1000;
        const each = contentWindow.pounceSide().map((drawn, board) => drawn - before[board]);
        const isEnough = Math.min(...each) > 0 || took > 10 * seconds + 60;
        if (took >= seconds && isEnough) done(Math.min(...each) / took);
        else setTimeout(look, 1000 * Math.max(seconds - took, 0.05));
    };
    look();
})"""
"""For so many seconds, and until each board was drawn once: on a busy machine that takes longer."""


def measure_side(repetitions: int, progress: Callable[[str], None]) -> dict[str, float]:
    """Pictures a second that a browser shows of the thesis's four, and their learners' rate.

    Returns:
        ``{"boards", "shown_per_s", "steps_per_s", "learner_share"}``: pictures of the board that is
        drawn least often; steps a second that each run makes meanwhile; that as a share of its rate
        while no browser looks; medians.

    Raises:
        RuntimeError: there is no browser, or the page does not show the runs.
    """
    try:
        from playwright.sync_api import Error, sync_playwright
    except ImportError as error:
        raise RuntimeError("this needs the Python package playwright") from error
    program = find_chromium()
    if program is None:
        raise RuntimeError(f"no browser: {CHROMIUM_ADVICE}")
    spec = presets.load("timed")
    session = Session(spec, "timed", 0, FULL_SPEED, playing=False)
    with tempfile.TemporaryDirectory() as folder:
        lab = Lab(session, {"timed": spec}, "127.0.0.1", 0, Path(folder))
        session.start()
        drawing = threading.Thread(target=lab.serve, name="drawing")
        drawing.start()
        try:
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(executable_path=program, args=list(_ARGUMENTS))
                page = browser.new_page(viewport={"width": _WIDTH, "height": _HEIGHT})
                progress("opening the page")
                return _measure(session, lab, page, repetitions, progress)
        except Error as error:
            raise RuntimeError(f"the page did not show the runs: {error}") from error
        finally:
            lab.close()
            drawing.join()


def _endless(name: str) -> RunSpec:
    return presets.load(name).model_copy(update={"trials": MAX_TRIALS})


def _measure(
    session: Session, lab: Lab, page: Any, repetitions: int, progress: Callable[[str], None]
) -> dict[str, float]:
    page.goto(lab.url, timeout=_PATIENCE_MS)
    page.wait_for_function(_HAS_BOARD, timeout=_PATIENCE_MS)
    shown: list[float] = []
    rates: list[float] = []
    alone: list[float] = []
    for turn in range(repetitions):
        progress(f"counting: {turn + 1} of {repetitions}")
        session.submit(StartRace(thesis_four(_endless, turn)))
        _wait(lambda seed=turn: _seed(session) == seed)
        before, began_s = _steps(session), time.perf_counter()
        time.sleep(TURN_S / 3)
        alone.append(_rate(session, before, began_s))
        # Nobody else looks, so closing it lets the runs stand still.
        page.keyboard.press("c")
        page.wait_for_selector(_FRAME, timeout=_PATIENCE_MS)
        page.wait_for_function(_IS_SHOWN, arg=[_FRAME, BOARDS], timeout=_PATIENCE_MS)
        before, began_s = _steps(session), time.perf_counter()
        shown.append(page.evaluate(_COUNT, [_FRAME, TURN_S]))
        rates.append(_rate(session, before, began_s))
        page.keyboard.press("c")
        page.wait_for_selector(_FRAME, state="detached", timeout=_PATIENCE_MS)
    shares = [rate / free for rate, free in zip(rates, alone, strict=True)]
    return {
        "boards": BOARDS,
        "shown_per_s": round(statistics.median(shown), 2),
        "steps_per_s": round(statistics.median(rates)),
        "learner_share": round(statistics.median(shares), 3),
    }


def _seed(session: Session) -> int | None:
    race = session.race
    return None if race is None or not race.status.step else race.status.entries[0].seed


def _steps(session: Session) -> int:
    race = session.race
    if race is None or race.status.error is not None:
        raise RuntimeError("the runs have stopped")
    return race.status.step


def _rate(session: Session, before: int, began_s: float) -> float:
    """Steps a second of each run since it had made so many, of which there is one more at least."""
    _wait(lambda: _steps(session) > before)
    return (_steps(session) - before) / (time.perf_counter() - began_s)


def _wait(is_so: Callable[[], bool]) -> None:
    until_s = time.perf_counter() + _PATIENCE_MS / 1e3
    while not is_so():
        if time.perf_counter() > until_s:
            raise RuntimeError("the runs stand still")
        time.sleep(0.01)
