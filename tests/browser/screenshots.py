"""Takes the README's pictures of the live page: ``python -m tests.browser.screenshots``."""

from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from app import presets
from tests.browser.conftest import LiveLab
from tests.conftest import BROWSER_ARGS, find_browser

FOLDER = Path(__file__).parent / "screenshots"
MOMENTS = {"cone": 6_000, "ring": 13_900, "avoid": 14_900, "converged": 48_000}
"""Name of a picture, and the trial of the ``timed`` run that it shows."""
PAUSE_MS = 4_000
"""For the page to draw what it has; only pictures depend on it."""


def take(page: Page, live: LiveLab, name: str, trial: int) -> None:
    """Go to a trial and take a picture of the whole page."""
    live.go_to_trial(trial)
    page.wait_for_timeout(PAUSE_MS)
    page.screenshot(path=FOLDER / f"{name}.png")


def main() -> None:
    """Take all pictures."""
    FOLDER.mkdir(exist_ok=True)
    live = LiveLab(presets.load("timed"), speed=20_000.0)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=find_browser(), args=list(BROWSER_ARGS)
        )
        page = browser.new_page(viewport={"width": 1366, "height": 768})
        page.goto(live.url)
        page.wait_for_timeout(PAUSE_MS)
        page.locator(".mantine-Notification-closeButton").first.dispatch_event("click")
        for name, trial in MOMENTS.items():
            take(page, live, name, trial)
        browser.close()
    live.close()


if __name__ == "__main__":
    main()
