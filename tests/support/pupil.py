"""Whoever is taken through a lesson, in a page of the lab: by what is on the card, and no more."""

import re
from typing import Any

from playwright.sync_api import Frame, FrameLocator, Locator, expect

from app.documents.lesson_grammar import OCTANTS
from app.documents.lesson_questions import Asked
from app.lessons.markup import plain_of
from tests.support.screen import Screen

FRAME = "iframe.pounce-lesson"
STOPS = """() => [...document.querySelectorAll("*")].filter(node => node.tabIndex >= 0
        && node.checkVisibility({ visibilityProperty: true }) && node.getClientRects().length
        && !node.matches("iframe, [role=term]"))
    .map(node => node.textContent.trim() || node.outerHTML.slice(0, 80))"""
"""Where the keyboard comes to in a page, by what is written there."""
SIDE = "iframe.pounce-side"
_MOST_HINTS = 3
_MOST_PRESSES = 60
_WORK_S = 240.0
"""For so long at most a button says what it begins: one runs an experiment."""
_PRESS = "(node, label) => node.textContent === label && (node.click(), true)"


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
        # Behind the list, the card that was left is as it was.
        expect(dot).to_be_visible()
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

    def give(self, asked: Asked, value: Any) -> None:
        """Answer what a card asks by hand, as its kind of question wants it; not committed yet.

        Args:
            asked: the question.
            value: the answer, as JSON has it.
        """
        place = self.card.locator(".asked")
        match asked.ask:
            case "choice" | "direction":
                place.locator(".choice", has=self.page.locator(f'input[value="{value}"]')).click()
            case "sectors":
                for octant, part in zip(OCTANTS, place.get_by_role("checkbox").all(), strict=True):
                    if (part.get_attribute("aria-checked") == "true") != (octant in value):
                        part.press("Space")
            case "order":
                self._put_in_order([plain_of(dict(asked.choices)[each]) for each in value])
            case "sketch":
                place.locator("summary").click()
                fields = place.get_by_role("spinbutton").all()
                for field, (_, reward) in zip(fields, value, strict=True):
                    self._type(field, round(reward))
            case _:
                self._type(place.get_by_role("spinbutton"), value)

    def _put_in_order(self, labels: list[str]) -> None:
        for place, label in enumerate(labels):
            items = self.card.locator(".order li > span")
            for _ in range(items.all_inner_texts().index(label) - place):
                self.button(f"Move {label} up").click()
            expect(items.nth(place)).to_have_text(label)

    def commit(self, sure: int) -> None:
        """Let the answer stand; of 0 to 2, how sure one is, where that is asked."""
        if self.card.locator(".sure").first.is_visible():
            self.card.locator(".sure").nth(sure).click()
        expect(self.primary).to_have_text("Commit")
        expect(self.primary).not_to_have_attribute("aria-disabled", "true")
        self.primary.click()
        expect(self.card.locator(".asked.locked-in")).to_have_count(1)

    @property
    def controls(self) -> list[str]:
        """What the card has to be used, by what stands on it; without what stands below it."""
        return [
            label.strip()
            for label in self.card.locator(
                ".controls button, .controls legend, .controls label > span:first-child"
            ).all_inner_texts()
        ]

    def expect_revealed(self) -> Locator:
        """Wait until it is told what came out."""
        reveal = self.card.locator(".reveal:not(.unseen)")
        expect(reveal.locator(".picture")).not_to_be_empty()
        return reveal

    def _type(self, field: Locator, number: float) -> None:
        field.fill(f"{number:.10g}")
        field.press("Tab")

    def press(self) -> bool:
        """Press what stands below the card, if that does what is asked for; whether it does."""
        label = self.primary.inner_text()
        if label == "Next" or self.primary.get_attribute("aria-disabled") == "true":
            return False
        # In one go: it may become what leads on to the next card.
        if self.primary.evaluate(_PRESS, label):
            expect(self.primary).not_to_have_text(label, timeout=_WORK_S * 1000)
        return True

    def do_it(self) -> None:
        """Do what the card asks for, with what stands below it; with hints where nothing does."""
        if not self.press():
            self.be_helped()
        ready = self.card.locator("footer .primary:not([aria-disabled])")
        for _ in range(_MOST_PRESSES):
            expect(ready).to_have_count(1)
            if ready.inner_text() == "Next":
                return
            self.press()
        raise AssertionError(self.primary.inner_text())

    def race(self) -> None:
        """Have the last hint begin the race, and let that go on as far as it is to."""
        self.be_helped()
        expect(self.primary).to_have_text("Next")
        side = self.page.frame_locator(SIDE)
        side.get_by_role("button", name="Back to one board").click()
        expect(self.page.locator("html:not([data-side])")).to_have_count(1)

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
