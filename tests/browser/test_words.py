"""Words that explain the page: terms where they stand, and the tour."""

from playwright.sync_api import Locator, expect

from app.words.glossary import TERMS
from tests.support.screen import Begin, Screen


def tip(screen: Screen) -> Locator:
    """What explains a term."""
    return screen.page.get_by_role("tooltip")


def offer(screen: Screen) -> Locator:
    """What offers the tour."""
    return screen.page.get_by_role("complementary", name="A tour of the page")


def test_a_term_is_explained_on_hover_focus_and_touch(begin: Begin) -> None:
    _, screen = begin()
    page = screen.page
    skill = screen.headline.get_by_text("skill", exact=True)
    explanation = f"skill: {TERMS['skill']}"
    expect(tip(screen)).to_be_hidden()

    skill.hover()
    expect(tip(screen)).to_have_text(explanation)
    box = tip(screen).bounding_box()
    assert box is not None
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= page.viewport_size["width"]  # type: ignore[index]
    page.mouse.move(0, 400)
    expect(tip(screen)).to_be_hidden()

    skill.focus()
    expect(tip(screen)).to_have_text(explanation)
    expect(skill).to_have_accessible_description(explanation)
    page.keyboard.press("Escape")
    expect(tip(screen)).to_be_hidden()

    # What is touched is clicked, and stays open without a pointer over it.
    page.evaluate("document.activeElement.blur()")
    skill.dispatch_event("click")
    expect(tip(screen)).to_have_text(explanation)
    page.mouse.click(5, 400)
    expect(tip(screen)).to_be_hidden()

    # In a panel as well as on the stage.
    page.locator("[data-dock-edge] .pounce-numbers").get_by_text("Success", exact=True).hover()
    expect(tip(screen)).to_have_text(f"success: {TERMS['success']}")


def test_the_tour_leads_from_stop_to_stop_and_is_declined_for_good(begin: Begin) -> None:
    live, screen = begin()
    page = screen.page
    # As a browser that has never been here; another test may have had the tour in this one.
    page.evaluate("localStorage.clear()")
    page.reload()
    screen.settle(live)
    card = page.get_by_role("dialog", name="Tour:")
    offer(screen).get_by_role("button", name="See five stops").click()
    for number, title in enumerate(
        ["The board", "What is going on", "Play, pause, speed", "Time", "Your turn"], start=1
    ):
        expect(card).to_contain_text(title)
        expect(card).to_contain_text(f"{number} of 5")
        expect(card.get_by_role("button", name="Done" if number == 5 else "Next")).to_be_focused()
        page.keyboard.press("ArrowRight")
    # It is over, and was the one time that it is offered.
    expect(card).to_have_count(0)
    expect(offer(screen)).to_be_hidden()

    screen.button("Tour").click()
    expect(card).to_contain_text("The board")
    card.get_by_role("button", name="Next").click()
    card.get_by_role("button", name="Back").click()
    expect(card).to_contain_text("1 of 5")
    page.keyboard.press("Escape")
    expect(card).to_have_count(0)
    expect(screen.button("Tour")).to_be_focused()
