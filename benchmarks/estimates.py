"""What experiments are estimated to take against what they take, with a page open beside them.

    python -m benchmarks.estimates [--pages N] [--paused] [--workers N] [EXPERIMENT:SEEDS ...]

Starts a lab that learns at its usual speed, opens so many pages of it in a headless Chromium that
draws without a graphics card (the worst case), and makes each experiment as the page's *Start*
does. The ratio of a line is that of the estimate to the time taken: from 0.67 to 1.5 is right. The
time that a machine is given hangs on what else it is at, so run it on one that has nothing to do.
"""

import argparse
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Final, NamedTuple

from app.documents import experiments, presets
from app.documents.experiments import Experiment
from app.live.requests import Play
from app.live.session import Session
from app.page.lab import Lab
from app.util.machine import available_cores
from app.util.web_browser import find_chromium

SPEED: Final = 20_000.0
"""Steps per second, at which a lab begins."""
USUAL: Final = ("figure_4_1:1", "freeze:1", "ablation:1")
_BROWSER_ARGS: Final = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
_SETTLED_S: Final = 10.0
"""After which a page has been drawn and only follows."""


class Compared(NamedTuple):
    """An experiment, and what it took."""

    name: str
    estimated_s: float
    taken_s: float

    @property
    def ratio(self) -> float:
        """Of the estimate to what it took."""
        return self.estimated_s / self.taken_s


@contextmanager
def opened_lab(n_pages: int, playing: bool, results: Path) -> Iterator[Lab]:
    """A lab with so many pages in a browser, drawn and at rest but for what they follow."""
    spec = presets.load("timed")
    session = Session(spec, "timed", 0, SPEED, playing=False)
    lab = Lab(session, {"timed": spec}, "127.0.0.1", 0, results=results)
    drawing = threading.Thread(target=lab.serve)
    session.start()
    drawing.start()
    with ExitStack() as stack:
        stack.callback(drawing.join)
        stack.callback(lab.close)
        if n_pages:
            from playwright.sync_api import sync_playwright

            play = stack.enter_context(sync_playwright())
            browser = play.chromium.launch(
                executable_path=find_chromium(), args=list(_BROWSER_ARGS)
            )
            stack.callback(browser.close)
            for _ in range(n_pages):
                page = browser.new_page(viewport={"width": 1366, "height": 768})
                page.goto(lab.url)
                page.wait_for_timeout(1_000 * _SETTLED_S)
        if playing:
            session.submit(Play())
            time.sleep(_SETTLED_S / 2)
        yield lab


def compared(lab: Lab, experiment: Experiment, workers: int) -> Compared:
    """Estimate an experiment as the page does, and make it."""
    beside = (len(lab.browsers), lab.session.status.playing)
    estimated_s = lab.service.quote(experiment, workers, beside).plan.seconds
    began = time.monotonic()
    lab.service.start(experiment, workers)
    lab.service.wait()
    return Compared(experiment.name, estimated_s, time.monotonic() - began)


def main(words: Sequence[str] | None = None) -> None:
    """Print a line for each experiment."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pages", type=int, default=1)
    parser.add_argument("--paused", action="store_true")
    parser.add_argument("--workers", type=int, default=max(available_cores() - 1, 1))
    parser.add_argument("experiments", nargs="*", default=USUAL, metavar="EXPERIMENT:SEEDS")
    asked = parser.parse_args(words)
    with (
        tempfile.TemporaryDirectory() as folder,
        opened_lab(asked.pages, not asked.paused, Path(folder)) as lab,
    ):
        for name, _, n_seeds in (text.partition(":") for text in asked.experiments):
            found = compared(lab, experiments.load(name, int(n_seeds or 1)), asked.workers)
            print(
                f"{found.name}: estimated {found.estimated_s:.1f} s, took {found.taken_s:.1f} s,"
                f" ratio {found.ratio:.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
