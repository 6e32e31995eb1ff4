"""Whoever is taken through a lesson, in a page of the lab: by what is on the card, and no more."""

import re

from playwright.sync_api import Frame, FrameLocator, Locator, expect

from tests.support.screen import Screen

FRAME = "iframe.pounce-lesson"
_MOST_HINTS = 3


class Pupil:
    """Reads cards, answers, and does what there is to do."""

    def __init__(self, screen: Screen) -> None:
        self.screen, self.page = screen, screen.page

    @property
    def card(self) -> FrameLocator:
        """The page with the card, or the list."""
        return self.page.frame_locator(FRAME)

    @property
    def card_page(self) -> Frame:
        """The same as one in which scripts can be run."""
        frame = self.page.locator(FRAME).element_handle().content_frame()
        assert frame is not None
        return frame

    @property
    def learn(self) -> Locator:
        """What opens the list, or leads back."""
        return self.page.locator("#pounce-stage .learn")

    @property
    def primary(self) -> Locator:
        """The one thing to do next."""
        return self.card.locator("footer .primary")

    def button(self, name: str | re.Pattern[str]) -> Locator:
        """A button of the card by its name."""
        return self.card.get_by_role("button", name=name, exact=True)

    def start(self, title: str) -> None:
        """Take a lesson from the list, from its beginning."""
        self.learn.click()
        again = re.compile(f"^(Start|From the beginning): {re.escape(title)}$")
        self.card.get_by_role("button", name=again).click()
        self.expect_card(0)

    def expect_card(self, place: int) -> None:
        """Wait until a card is shown, and waits for nothing but what somebody does."""
        dot = self.card.locator(".dots button").nth(place)
        expect(dot).to_have_attribute("aria-current", "step")
        expect(self.card.locator("footer .why[data-busy]")).to_have_count(0)

    @property
    def kind(self) -> str:
        """Of the card that is shown."""
        return self.card.locator(".lesson").get_attribute("data-kind") or ""

    def answer(self, first: bool) -> None:
        """Answer with what stands first, or last, and commit it; sure if it is the first."""
        card, end = self.card, 0 if first else -1
        asked = card.locator(".asked")
        if asked.locator(".choice").count():
            asked.locator(".choice").nth(end).click()
        elif asked.locator(".compass").count():
            asked.get_by_role("checkbox").nth(end).click()
        elif asked.locator(".order").count():
            asked.get_by_role("button").nth(1).click()
        elif asked.locator(".sketch").count():
            if not asked.get_by_role("spinbutton").first.is_visible():
                asked.locator("summary").click()
            self._type(asked.get_by_role("spinbutton").first, -20 if first else 40)
        else:
            self._type(asked.get_by_role("spinbutton"), 0 if first else 1_000)
        if asked.locator(".sure").first.is_visible():
            asked.locator(".sure").nth(end).click()
        expect(self.primary).not_to_have_attribute("aria-disabled", "true")
        expect(self.primary).to_have_text("Commit")
        self.primary.click()
        expect(self.primary).not_to_have_text("Commit")

    def _type(self, field: Locator, number: int) -> None:
        field.fill(f"{number}")
        field.press("Tab")

    def be_helped(self) -> None:
        """Take all hints, of which the last one does what is to be done."""
        hints = self.card.locator(".hints > li")
        more = self.button("Give me a hint")
        for count in range(1, _MOST_HINTS):
            if not more.is_visible():
                break
            more.click()
            expect(hints).to_have_count(count)
        does_it = self.button("Do it for me")
        if does_it.is_visible():
            does_it.click()

    def go_on(self, place: int) -> None:
        """Go on to a card, once it may be gone to."""
        expect(self.primary).to_have_text("Next")
        expect(self.primary).not_to_have_attribute("aria-disabled", "true")
        self.primary.click()
        self.expect_card(place)
