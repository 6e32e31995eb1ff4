"""A class of thirty, two of them in browsers, and a presenter who asks it what a lesson asks."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect

from app.audience.audience import Audience
from app.live.requests import LeaveLesson
from tests.support.access import AXE, FINDINGS
from tests.support.classes import Pupils
from tests.support.live import PATIENCE_S, LiveLab, preset_of
from tests.support.phones import Phones
from tests.support.pupil import Pupil
from tests.support.screen import Screen

LAPTOP: ViewportSize = {"width": 1366, "height": 768}
TITLE = "The cone"
ASKS = 1
"""The card that asks which octants get value, and those that go with it."""
N_SIMULATED = 28
REVEAL = ".reveal:not(.unseen)"
"""What came out, once there is something to see of it."""
# What reaches beyond the right edge of a page that is wider than its window.
WIDE = """() => document.documentElement.scrollWidth <= innerWidth ? []
    : [...document.querySelectorAll("body *")]
        .filter(node => node.getBoundingClientRect().right > innerWidth)
        .map(node => `${node.tagName} ${node.id} ${node.getAttribute("class")}`)"""


class Class:
    """The presenter's browser, two phones, and all the others."""

    def __init__(self, live: LiveLab, presenter: Pupil, browser: Browser) -> None:
        self.live, self.presenter = live, presenter
        self.devices = Phones(browser, self.audience)
        self.phones = [self.devices.open(dark=dark) for dark in (False, True)]
        for phone in self.phones:
            expect(phone.locator("#seat")).to_be_visible()
        self.others = Pupils(self.audience.watchers.port, N_SIMULATED)

    @property
    def audience(self) -> Audience:
        assert self.live.audience is not None
        return self.live.audience

    def leave(self) -> None:
        self.others.close()
        self.devices.close()


@pytest.fixture(scope="module")
def taught(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Class]:
    expect.set_options(timeout=PATIENCE_S * 1000)
    folder = tmp_path_factory.mktemp("lab")
    live = LiveLab(preset_of(), 20_000.0, folder / "results", classroom=True)
    try:
        context = browser.new_context(viewport=LAPTOP)
        context.set_default_timeout(PATIENCE_S * 1000)
        screen = Screen(context.new_page())
        screen.open(live)
        taught = Class(live, Pupil(screen), browser)
        yield taught
        taught.leave()
        live.ask(LeaveLesson())
        context.close()
        assert taught.devices.complaints == []
    finally:
        live.close()


def accessible(page: Page) -> None:
    page.evaluate(AXE)
    assert page.evaluate(FINDINGS) == []


def test_a_class_is_asked_votes_again_and_sees_what_the_run_did(taught: Class) -> None:
    presenter, (phone, dark), others = taught.presenter, taught.phones, taught.others
    expect(phone.locator("#answered")).to_contain_text("Questions come here")
    presenter.start(TITLE)
    expect(phone.locator("#card-of")).to_have_text("The cone: card 1 of 10")
    presenter.primary.click()
    presenter.expect_card(ASKS)
    vote = presenter.card.locator(".vote")
    vote.get_by_role("button", name="Ask the class").click()
    expect(vote.locator(".counted")).to_have_text("0 of 30 have answered")
    for page in taught.phones:
        expect(page.locator("#ask .compass")).to_be_visible()
        assert page.evaluate(WIDE) == []
    accessible(phone)
    phone.get_by_role("checkbox", name="behind", exact=True).click()
    # By the keyboard as well.
    dark.get_by_role("checkbox", name="ahead", exact=True).focus()
    dark.keyboard.press("Space")
    others.answer(lambda n: ["w"] if n % 2 else ["e", "ne", "se"])
    for page in taught.phones:
        expect(page.locator("#answered")).to_contain_text("Your answer counts")
    expect(vote.locator(".counted")).to_have_text("30 of 30 have answered")
    expect(presenter.card.locator(REVEAL)).to_have_count(0)

    vote.get_by_role("button", name="Vote again").click()
    expect(vote.locator(".counted")).to_have_text("0 of 30 have answered")
    expect(phone.locator("#again")).to_contain_text("whose shape is another")
    expect(phone.get_by_role("checkbox", checked=True)).to_have_count(0)
    phone.get_by_role("checkbox", name="behind", exact=True).click()
    # It answers nothing this time, and comes back with the seat it had.
    seat = dark.locator("#seat").text_content() or ""
    dark.reload()
    expect(dark.locator("#seat")).to_have_text(seat)
    others.wait_for(lambda pupil: pupil.parts["lesson"]["ask"]["round"] == 2)
    others.answer(lambda n: ["w", "nw", "sw"] if n % 4 else ["w"])
    expect(vote.locator(".counted")).to_have_text("29 of 30 have answered")

    # The presenter has an answer of their own, and goes on to what the run does.
    presenter.answer(first=True)
    presenter.go_on(ASKS + 1)
    for page in taught.phones:
        expect(page.locator("#ask")).to_be_hidden()
    expect(presenter.card.locator(REVEAL)).to_have_count(0)
    presenter.be_helped()
    presenter.go_on(ASKS + 2)
    presenter.answer(first=True)
    vote.get_by_role("button", name="Reveal with the run").click()
    for page in taught.phones:
        came = page.locator(f"#came {REVEAL}")
        expect(came).to_contain_text("the class (29)")
        expect(came).to_contain_text("the class at first (30)")
        expect(came).to_contain_text("this run")
        assert page.evaluate(WIDE) == []
    expect(presenter.card.locator(REVEAL)).to_contain_text("the class (29)")
    accessible(dark)


def test_when_it_ends_seats_and_answers_are_forgotten(taught: Class) -> None:
    presenter, (phone, _) = taught.presenter, taught.phones
    end = presenter.card.locator(".vote").get_by_role("button", name="End and forget")
    end.click()
    expect(phone.locator("#answered")).to_contain_text("all that it answered is forgotten")
    expect(phone.locator("#seat")).to_be_hidden()
    expect(presenter.card.locator(REVEAL)).not_to_contain_text("the class")
    phone.get_by_role("button", name="Take a seat").click()
    expect(phone.locator("#seat")).to_contain_text("1,")
    assert taught.audience.room is not None
    assert len(taught.audience.room.seats.all) == 1


def test_in_german_the_class_reads_german(taught: Class) -> None:
    presenter, (phone, _) = taught.presenter, taught.phones
    presenter.card.get_by_label("Language").select_option("de")
    expect(phone.locator("#card-of")).to_contain_text("Karte")
    expect(phone.locator("html")).to_have_attribute("lang", "de")
