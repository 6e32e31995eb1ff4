"""My learner on a phone: it is played by touch and by keyboard, and is there after a reload."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from app.audience.audience import Audience
from app.audience.own import Beginning, Own
from app.picture.layer import Extras
from app.picture.look import Look
from app.player.presented import Presented
from tests.support.access import AXE, FINDINGS
from tests.support.live import PATIENCE_S, preset_of
from tests.support.phones import Phones

FITS = """() => document.documentElement.scrollWidth <= innerWidth"""
LOW = """() => [...document.querySelectorAll("#own button, #own select, #own input")]
    .filter(node => node.checkVisibility() && node.getBoundingClientRect().height < 44)
    .map(node => node.outerHTML)"""
"""What one could miss with a thumb."""
HIDDEN = """() => {
    const bar = document.getElementById("own-controls").getBoundingClientRect();
    return bar.bottom > innerHeight + 1 || bar.top < 0;
}"""


@pytest.fixture
def audience() -> Iterator[Audience]:
    """What looks at a presenter who has just begun, and has no lab."""
    expect.set_options(timeout=PATIENCE_S * 1000)
    audience = Audience(lambda _: None, "127.0.0.1", 0, has_own=True)
    status = Own(Beginning("timed", preset_of(), 3), 3).status()
    moment = {"line": 0, "step": 0, "trial": 0, "live": True}
    audience.show(status, Presented(status, Look(), Extras(), None, moment))
    yield audience
    audience.close()


@pytest.fixture
def phone(browser: Browser, audience: Audience) -> Iterator[Page]:
    phones = Phones(browser, audience)
    yield phones.open(dark=True)
    phones.close()
    assert phones.complaints == []


def test_each_has_a_learner_to_play_with(phone: Page, audience: Audience) -> None:
    mine = phone.get_by_role("button", name="My learner")
    own = phone.get_by_role("region", name="My learner")
    expect(own).to_be_hidden()
    mine.tap()
    expect(own).to_be_visible()
    expect(phone.get_by_role("region", name="Board")).to_be_hidden()
    expect(own.locator("#own-sentence")).to_contain_text("Paused.")
    expect(own.locator("#own-whose")).to_contain_text("The seed of your learner is 4: 3 and")

    # By keyboard: what is pressed keeps the focus, whatever it is called then.
    speed = own.get_by_role("slider", name="Speed")
    speed.press("End")
    expect(speed).to_have_attribute("aria-valuetext", "100 k steps/s")
    for _ in range(2):
        speed.press("ArrowLeft")
    expect(speed).to_have_attribute("aria-valuetext", "2 k steps/s")
    play = own.get_by_role("button", name="Play")
    play.press("Enter")
    expect(own.get_by_role("button", name="Pause")).to_be_focused()
    phone.wait_for_function(
        """() => Number(document.querySelector("#own-readings .large > div > :last-child")
            ?.textContent.replaceAll(",", "")) > 50"""
    )

    # So slow that what is explored from here on is explored for as long as all of this takes.
    speed.press("Home")
    expect(speed).to_have_attribute("aria-valuetext", "20 steps/s")

    # By touch.
    own.get_by_role("combobox", name="Add").select_option("avoid")
    own.get_by_role("button", name="Add", exact=True).tap()
    expect(own.get_by_role("button", name="Add circle clockwise")).to_be_visible()
    # The schedule has it explored from there on.
    own.get_by_role("button", name="Stop exploring avoid").tap()
    own.get_by_role("combobox", name="Explore").select_option("avoid")
    own.get_by_role("button", name="Explore").tap()
    expect(own.get_by_role("button", name="Stop exploring avoid")).to_be_visible()
    assert phone.evaluate(FITS)
    assert phone.evaluate(LOW) == []
    assert not phone.evaluate(HIDDEN)
    phone.evaluate(f"{AXE};0")
    assert phone.evaluate(FINDINGS) == []

    # It stays theirs, and goes on, while they look at something else or load the page again.
    phone.get_by_role("button", name="Presenter").tap()
    expect(own).to_be_hidden()
    phone.reload()
    mine.tap()
    expect(own.get_by_role("button", name="Stop exploring avoid")).to_be_visible()
    own.get_by_role("button", name="Pause").tap()
    expect(own.locator("#own-sentence")).to_contain_text("Paused.")
    assert audience.own is not None
    assert audience.own.learners == 1
    phone.keyboard.press("Escape")
    expect(own).to_be_hidden()
