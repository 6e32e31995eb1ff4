"""A report on paper: every table fits it, and what is closed on a screen is open there."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page

from app.documents import presets
from app.report import write
from sim.world import CAPTURE
from tests.support.folders import add_run, new_folder, seal

A4_WIDTH = 720
"""Pixels of A4 portrait within its margins."""

LEARNERS = ("timed", "standard_q", "hierarchical_3", "hierarchical_2")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report with findings and with variants."""
    folder = new_folder(tmp_path_factory.mktemp("print") / "results")
    values: dict[str, Any] = {
        "final_success": 0.123456,
        "greedy_success": 0.123456,
        "mean_hunt_length": 123.456,
    }
    counts: dict[str, Any] = {"captures": 12_345, "flights": 23_456, "timeouts": 34_567}
    for seed in range(6):
        for preset in LEARNERS:
            spec = presets.load(preset)
            file = folder / "arrays" / f"k{len(list((folder / 'arrays').iterdir()))}.npz"
            lasted = {"trials": spec.trials, "steps": 50 * spec.trials}
            settings = spec.model_dump_json()
            add_run(folder, seed, preset, settings=settings, **lasted, **values, **counts)
            log = {
                "outcome": np.full(spec.trials, CAPTURE, np.int8),
                "steps": np.full(spec.trials, 50, np.int32),
            }
            np.savez(file, **{**dict(np.load(file)), **log})
        for number in range(2):
            label = f"{number} {'long ' * 8}{'unbreakable' * 4}"
            add_run(folder, seed, variant=label, overrides={"x": number}, **values, **counts)
    seal(folder)
    return write.write_report([folder], None, False).page


@pytest.fixture
def printed(page: Page, written: Path) -> Page:
    """The report as it is printed."""
    page.set_viewport_size({"width": A4_WIDTH, "height": 1040})
    page.emulate_media(media="print")
    page.goto(written.as_uri())
    return page


def test_every_table_fits_the_paper(printed: Page) -> None:
    ends = printed.evaluate(
        "[...document.querySelectorAll('th, td, svg')].map(e => e.getBoundingClientRect().right)"
    )
    assert len(ends) > 100
    assert max(ends) <= A4_WIDTH + 1
    # Nothing is cut off in a box that scrolls, either.
    assert printed.evaluate("document.documentElement.scrollWidth") <= A4_WIDTH
    assert printed.locator("th", has_text="verdict").first.is_visible()


def test_what_is_closed_on_the_screen_is_open_on_paper(printed: Page) -> None:
    hidden = "d => [...d.children].filter(e => !e.checkVisibility({contentVisibilityAuto: true}))"
    count = printed.locator("details").count()
    assert count >= 2
    for index in range(count):
        assert printed.locator("details").nth(index).evaluate(f"d => ({hidden})(d).length") == 0
    printed.emulate_media(media="screen")
    assert printed.locator("details").first.evaluate(f"d => ({hidden})(d).length") > 0
