"""A report in a browser: for those who do not see it well, on a phone, and without a network."""

from pathlib import Path

import pytest
from playwright.sync_api import Page, ViewportSize, expect

from app.report import write
from tests.support.access import AXE, FINDINGS
from tests.support.folders import add_run, new_folder

PHONE: ViewportSize = {"width": 390, "height": 844}
WIDE: ViewportSize = {"width": 1366, "height": 768}


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report with curves, differences, runs and a long table."""
    folder = new_folder(tmp_path_factory.mktemp("access") / "results")
    for seed in range(3):
        add_run(folder, seed)
        for number in range(3):
            sets = {"learner.epsilon": number / 10, "learner.gamma": 0.8}
            add_run(folder, seed, variant=f"with ε {number / 10}", overrides=sets)
    return write.write_report([folder], None, False).page


@pytest.mark.parametrize("size", [WIDE, PHONE])
def test_a_checker_finds_nothing_serious_in_a_report(
    page: Page, written: Path, size: ViewportSize
) -> None:
    page.set_viewport_size(size)
    page.goto(written.as_uri())
    for details in page.locator("summary").all():
        details.click()
    page.evaluate(f"{AXE};0")
    assert page.evaluate(FINDINGS) == []


def test_a_report_asks_for_nothing_and_fits_a_phone(page: Page, written: Path) -> None:
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.set_viewport_size(PHONE)
    page.goto(written.as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    assert asked == [written.as_uri()]


def test_the_switch_shows_one_view_at_a_time_by_keys_as_well(page: Page, written: Path) -> None:
    page.goto(written.as_uri())
    views = page.locator(".views").first
    figures = views.locator("figure")
    expect(figures).to_have_count(3)
    expect(figures.nth(0)).to_be_visible()
    expect(figures.nth(1)).to_be_hidden()
    views.locator("label").nth(1).click()
    expect(figures.nth(0)).to_be_hidden()
    expect(figures.nth(1)).to_be_visible()
    page.keyboard.press("ArrowRight")
    expect(figures.nth(2)).to_be_visible()
    page.emulate_media(media="print")
    expect(figures.nth(2)).to_be_visible()
    expect(views.locator(".on-paper").nth(2)).to_be_visible()
    expect(views.locator("label").first).to_be_hidden()
