"""Takes the documentation's pictures of the page.

``python -m tests.browser.screenshots [NAME ...]``; without names it takes all of them.
"""

import contextlib
import io
import re
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from PIL import Image
from playwright.sync_api import Browser, ViewportSize, expect, sync_playwright

from app.documents import experiments, presets
from app.live.race import thesis_four
from app.live.requests import Branch, StartRace
from app.player.reel import recorded_run
from app.player.replay_page import replay_page
from app.schedule.blocks import blocks_of
from app.schedule.edits import changed, moved, now_of
from app.util.web_browser import find_chromium
from learners.commands import SetSchedule
from tests.support.browser import BROWSER_ARGS
from tests.support.live import PATIENCE_S, SEED, LiveLab
from tests.support.pupil import Pupil
from tests.support.screen import VIEWPORT, Screen

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "pictures"
PHONE: ViewportSize = {"width": 390, "height": 844}
PAUSE_MS = 4_000
"""For the page to draw what it has; only pictures depend on it."""
LONGEST_S = 1_800.0
"""For an experiment to be over."""


BESIDE_TRIAL = 6_000
"""Trial that the live run has come to at least beside the results of an experiment."""


class Moment(NamedTuple):
    """A moment of the ``timed`` run that a picture shows."""

    trial: int
    window: ViewportSize = VIEWPORT
    presents: bool = False


MOMENTS = {
    "cone": Moment(6_000, presents=True),
    "arm": Moment(14_500, presents=True),
    "page": Moment(14_500),
    "phone": Moment(14_500, PHONE),
    "ring": Moment(24_000, presents=True),
    "filled": Moment(48_000, presents=True),
}

AUDIENCE = "audience"
"""Picture of the page of an audience on a phone, of the same moment as that of the lab's page."""

WALKS = ("past", "branches")
"""Pictures of the bar: at a past moment, and with branches."""
REPLAY = "replay"
REPLAY_TRIAL = 16_500
"""The end of the last exploration, which is in the table of what happened."""
WALKS_AT = 24_000
"""Trial of the live run then, at least."""
PAST_TRIAL = 13_000
FORK_TRIAL = 11_900
BRANCH_TRIAL = 17_000


LESSON = ("lesson_predict", "lesson_reveal", "lesson_class")
"""Pictures of a lesson: directions predicted, what came of them, and the question on a phone."""
LESSON_TITLE = "The cone"
LESSON_GUESS = (4, 5, 6)
LESSON_SEEN = (3, 4, 5)
"""Directions, counter-clockwise from straight ahead."""

RACE = "race"
"""The picture of the thesis's four side by side."""
RACE_STEPS = 1_000_000


class Shown(NamedTuple):
    """An experiment whose results a picture shows."""

    experiment: str
    seeds: int


RESULTS = {
    "experiments": Shown("figure_4_1", 10),
    "timing": Shown("timing_plane", 3),
}


def take(screen: Screen, name: str) -> None:
    """Take a picture of the whole page, with the mouse out of the way."""
    screen.page.mouse.move(0, 0)
    screen.page.wait_for_timeout(PAUSE_MS)
    screen.page.screenshot(path=FOLDER / f"{name}.png")


def run_experiment(screen: Screen, shown: Shown) -> None:
    """Run an experiment as a person would, and wait until its results are there."""
    screen.turn_to("Experiments")
    screen.choose("Experiment", experiments.titled(shown.experiment))
    # Whoever types before the experiment's own number is there loses what they typed.
    own = len(experiments.load(shown.experiment).seeds)
    expect(screen.field("Seeds")).to_have_value(str(own))
    screen.fill("Seeds", str(shown.seeds))
    cost = re.compile(rf"\d+ variants, {shown.seeds} seeds each\.")
    expect(screen.page.get_by_text(cost)).to_be_visible()
    screen.click("Start")
    over = re.compile(rf"All \d+ runs are in results/{shown.experiment} already")
    expect(screen.page.get_by_text(over)).to_be_visible(timeout=LONGEST_S * 1000)


def branch(live: LiveLab) -> int:
    """Make three branches as people would; returns the number of the one to look at."""
    fork = live.place_of(FORK_TRIAL)
    then = live.session.snapshot_at(fork)
    plan, now = then.spec.schedule, now_of(then)
    circle = next(
        block.id
        for block in blocks_of(then)
        if block.skill == "circle_clockwise" and block.kind == "exploration"
    )
    plans = (
        moved(plan, "introduction:avoid", -2_500, now),
        changed(plan, circle, now, probability=0.3),
        moved(plan, "introduction:avoid", 3_000, now),
    )
    for other in plans:
        n_lines = len(live.session.status.lines)
        live.session.submit(Branch(fork, SetSchedule(other)))
        live.wait_for(lambda status, n=n_lines: len(status.lines) > n)
    status = live.wait_for(lambda status: not any(line.is_growing for line in status.lines))
    return next(line.number for line in status.lines if line.parent is not None)


def show_time(screen: Screen, live: LiveLab, names: list[str]) -> None:
    """Take the pictures of the bar."""
    if live.session.status.snapshot.trial < WALKS_AT:
        live.go_to_trial(WALKS_AT)
    if "past" in names:
        screen.tell("seek_trial", trial=PAST_TRIAL)
        take(screen, "past")
    if "branches" in names:
        screen.tell("look", line=branch(live))
        screen.tell("seek_trial", trial=BRANCH_TRIAL)
        take(screen, "branches")
    screen.tell("live")


def show_audience(browser: Browser, live: LiveLab) -> None:
    """Take the picture of a page that looks on."""
    if live.session.status.snapshot.trial < MOMENTS["phone"].trial:
        live.go_to_trial(MOMENTS["phone"].trial)
    assert live.audience is not None
    page = browser.new_page(viewport=PHONE, device_scale_factor=2)
    page.goto(live.audience.addresses[0])
    page.wait_for_timeout(PAUSE_MS)
    page.screenshot(path=FOLDER / f"{AUDIENCE}.png")
    page.close()


def show_race(screen: Screen, live: LiveLab) -> None:
    """Take the picture of the race."""
    live.ask(StartRace(thesis_four(presets.load, SEED), playing=False))
    race = live.session.race
    assert race is not None
    race.run_to(RACE_STEPS)
    race.wait_for(lambda status: status.step == RACE_STEPS, PATIENCE_S)
    for key in "cp":
        screen.page.keyboard.press(key)
    expect(screen.page.frame_locator("iframe.pounce-side").locator(".tile")).to_have_count(4)
    # What is measured of each comes one after the other.
    greedy = screen.page.frame_locator("iframe.pounce-side").locator(".tile .greedy b")
    for place in range(4):
        expect(greedy.nth(place)).not_to_have_text("\N{EN DASH}")
    take(screen, RACE)
    for _ in range(2):
        screen.page.keyboard.press("Escape")
    expect(screen.page.locator("iframe.pounce-side")).to_have_count(0)


def take_replay() -> None:
    """Take the picture of a replay page, which needs no lab."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = Path(folder) / "replay.html"
        path.write_text(replay_page(recorded_run(presets.load("timed"), "timed", 0)), "utf-8")
        browser = playwright.chromium.launch(
            executable_path=find_chromium(), args=list(BROWSER_ARGS)
        )
        page = browser.new_page(viewport=VIEWPORT)
        page.goto(path.as_uri())
        expect(page.locator("html")).to_have_attribute("data-ready", "")
        page.locator(f'.events tr[data-step] button:text-is("{REPLAY_TRIAL:,}")').click()
        page.mouse.move(0, 0)
        page.wait_for_timeout(PAUSE_MS)
        page.screenshot(path=FOLDER / "replay.png")
        browser.close()


def take_lesson(name: str) -> None:
    """Take a picture of a lesson, in a lab of its own; a class is there where it is asked."""
    is_of_class = name == LESSON[-1]
    live = LiveLab(presets.load("timed"), 20_000.0, Path("results"), classroom=is_of_class)
    live.dpr = 1.0
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=find_chromium(), args=list(BROWSER_ARGS)
            )
            screen = Screen(browser.new_page(viewport=VIEWPORT))
            screen.open(live)
            screen.click("No, thanks")
            pupil = Pupil(screen)
            pupil.start(LESSON_TITLE)
            pupil.go_on(1)
            if is_of_class:
                show_class(browser, live, pupil)
            else:
                predict(pupil, LESSON_GUESS)
                pupil.card.locator(".sure").nth(1).click()
                if name == LESSON[1]:
                    pupil.primary.click()
                    see_what_came(pupil)
                take_small(screen, name)
            browser.close()
    finally:
        live.close()


def predict(pupil: Pupil, octants: Iterable[int]) -> None:
    """Choose directions on the card."""
    for octant in octants:
        pupil.card.get_by_role("checkbox").nth(octant).click()


def see_what_came(pupil: Pupil) -> None:
    """Let it learn, and say what is to be seen."""
    pupil.go_on(2)
    pupil.primary.click()
    pupil.go_on(3)
    predict(pupil, LESSON_SEEN)
    pupil.primary.click()
    expect(pupil.card.get_by_text("20 runs")).to_be_visible()
    # The board has it a moment later.
    pupil.page.wait_for_timeout(2 * PAUSE_MS)


def show_class(browser: Browser, live: LiveLab, pupil: Pupil) -> None:
    """Take the picture of a phone on which the class is asked what the card asks."""
    assert live.audience is not None
    page = browser.new_page(viewport=PHONE, device_scale_factor=1.5)
    page.goto(live.audience.addresses[0])
    pupil.button("Ask the class").click()
    expect(page.get_by_role("checkbox").first).to_be_visible()
    for octant in LESSON_GUESS:
        page.get_by_role("checkbox").nth(octant).click()
    page.wait_for_timeout(PAUSE_MS)
    keep_small(page.screenshot(), LESSON[-1])
    page.close()


def take_small(screen: Screen, name: str) -> None:
    """Take a picture of the whole page, in few colours."""
    screen.page.mouse.move(0, 0)
    screen.page.wait_for_timeout(PAUSE_MS)
    keep_small(screen.page.screenshot(), name)


def keep_small(picture: bytes, name: str) -> None:
    """Keep a picture in no more colours than a page of text and a map have."""
    image = Image.open(io.BytesIO(picture)).convert("RGB")
    image = image.quantize(256, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    image.save(FOLDER / f"{name}.png", optimize=True)


def main(names: list[str]) -> None:
    """Take these pictures."""
    FOLDER.mkdir(exist_ok=True)
    expect.set_options(timeout=PATIENCE_S * 1000)
    if REPLAY in names:
        take_replay()
    for name in LESSON:
        if name in names:
            take_lesson(name)
    if set(names) <= {REPLAY, *LESSON}:
        return
    # The page names the folder of the results: as it is called where somebody starts the lab.
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        live = LiveLab(
            presets.load("timed"), speed=20_000.0, results=Path("results"), audience=True
        )
        live.dpr = 1.0
        try:
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(
                    executable_path=find_chromium(), args=list(BROWSER_ARGS)
                )
                screen = Screen(browser.new_page(viewport=VIEWPORT))
                screen.open(live)
                # What newcomers are asked has been answered in the browser of most pictures.
                screen.click("No, thanks")
                for name, moment in MOMENTS.items():
                    if name in names:
                        live.go_to_trial(moment.trial)
                        screen.page.set_viewport_size(moment.window)
                        if moment.presents:
                            screen.page.keyboard.press("p")
                        take(screen, name)
                        screen.page.keyboard.press("Escape")
                screen.page.set_viewport_size(VIEWPORT)
                if AUDIENCE in names:
                    show_audience(browser, live)
                if any(name in names for name in WALKS):
                    show_time(screen, live, names)
                if RACE in names:
                    show_race(screen, live)
                for name, shown in RESULTS.items():
                    if name in names:
                        if live.session.status.snapshot.trial < BESIDE_TRIAL:
                            live.go_to_trial(BESIDE_TRIAL)
                        run_experiment(screen, shown)
                        take(screen, name)
                browser.close()
        finally:
            live.close()


if __name__ == "__main__":
    known = [*MOMENTS, AUDIENCE, *WALKS, RACE, *RESULTS, REPLAY, *LESSON]
    wanted = sys.argv[1:] or known
    unknown = [name for name in wanted if name not in known]
    if unknown:
        sys.exit(f"no picture is called {', '.join(unknown)}; there are {', '.join(known)}")
    main(wanted)
