"""The card of a lesson by itself: it is told states, and what a person does there is kept."""

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, Locator, expect

from tests.support.access import AXE, FINDINGS
from tests.support.live import PATIENCE_S
from tests.support.taught import Taught
from tests.support.told import PARTS, STATES, TRIALS, asks, card, told

PHONE = {"width": 390, "height": 844}
COLUMN = {"width": 396, "height": 768}
# What is to be pressed and is lower than a finger, but for a link within words.
SMALL = """() => [...document.querySelectorAll(
        "button, select, input[type=number], input[type=range], summary, label:has(input)")]
    .filter(node => node.checkVisibility() && node.getBoundingClientRect().height < 43.5)
    .map(node => node.outerHTML)"""
WIDER = """() => [...document.querySelectorAll("body *")].filter(node =>
    node.checkVisibility() && node.getBoundingClientRect().right > innerWidth + 1
    && !node.closest(".unseen")).map(node => node.outerHTML.slice(0, 100))"""
FOCUSED = (
    "() => document.activeElement.closest('h1')?.textContent ?? document.activeElement.tagName"
)
FRAMES = """async () => {
    const ask = window.requestAnimationFrame;
    let asked = 0;
    window.requestAnimationFrame = work => { asked += 1; return ask(work); };
    for (let frame = 0; frame < 5; frame++) await new Promise(done => ask(done));
    window.requestAnimationFrame = ask;
    return asked;
}"""


@pytest.fixture(scope="module")
def page_of_card(browser: Browser) -> Iterator[Taught]:
    """One page for all tests, which are told whole states."""
    expect.set_options(timeout=PATIENCE_S * 1000)
    context = browser.new_context(viewport=COLUMN)  # pyright: ignore[reportArgumentType]
    context.set_default_timeout(PATIENCE_S * 1000)
    yield Taught(context.new_page())
    context.close()


@pytest.fixture
def taught(page_of_card: Taught) -> Iterator[Taught]:
    """The page of a card that was told nothing; it may log no error."""
    page_of_card.page.set_viewport_size(COLUMN)  # pyright: ignore[reportArgumentType]
    page_of_card.open()
    yield page_of_card
    assert page_of_card.complaints == []


def button(taught: Taught, name: str) -> Locator:
    return taught.page.get_by_role("button", name=name, exact=True)


def answer_of(taught: Taught) -> Any:
    """The last answer that was said."""
    answers = [message["value"] for message in taught.said if message["do"] == "answer"]
    return answers[-1] if answers else None


@pytest.mark.parametrize("dark", [False, True])
def test_a_checker_finds_nothing_serious_on_any_card(taught: Taught, dark: bool) -> None:
    taught.open(dark)
    taught.page.evaluate(f"{AXE};0")
    found = {}
    for name, state in STATES.items():
        taught.hear(state)
        if findings := taught.page.evaluate(FINDINGS):
            found[name] = findings
    assert found == {}


def test_all_can_be_hit_by_a_finger_and_nothing_is_cut_on_any_card(taught: Taught) -> None:
    for size in (PHONE, COLUMN, {"width": 300, "height": 768}):
        taught.page.set_viewport_size(size)  # pyright: ignore[reportArgumentType]
        for name, state in STATES.items():
            taught.hear(state)
            assert (name, taught.page.evaluate(SMALL)) == (name, [])
            assert (name, taught.page.evaluate(WIDER)) == (name, [])


def test_a_new_card_is_begun_at_its_heading_and_an_old_one_keeps_the_focus(taught: Taught) -> None:
    taught.hear(STATES["say"])
    assert taught.page.evaluate(FOCUSED) == "Which way round?. Card 1 of 9. Look"
    button(taught, "Next").focus()
    # The same card, with something else.
    taught.hear(told(card("say", "It goes on."), at=0, furthest=0))
    assert taught.page.evaluate(FOCUSED) == "BUTTON"
    taught.hear(STATES["direction"])
    assert taught.page.evaluate(FOCUSED) == "Which way round?. Card 4 of 9. What do you expect?"


def test_a_choice_is_made_by_keyboard_and_committed_with_how_sure_one_is(taught: Taught) -> None:
    taught.hear(STATES["direction"])
    page = taught.page
    commit = button(taught, "Commit")
    expect(commit).to_have_attribute("aria-disabled", "true")
    commit.click(force=True)
    assert taught.said == []
    page.get_by_role("radio", name="Clockwise", exact=True).focus()
    page.keyboard.press("ArrowDown")
    assert answer_of(taught) == "counter"
    expect(page.locator("footer .why")).to_have_text("Say how sure you are.")
    page.get_by_role("radio", name="90 %").check()
    commit.click()
    # What was chosen comes with it: it may have been lost with a connection.
    assert taught.said == [
        {"do": "answer", "id": "a_ask", "value": "counter"},
        {"do": "commit", "id": "a_ask", "confidence": 90},
    ]
    taught.hear(STATES["committed"])
    for radio in page.get_by_role("radio").all():
        expect(radio).to_be_disabled()
    expect(button(taught, "Next")).to_have_attribute("aria-disabled", "true")
    # Who has pressed the button still has it.
    expect(page.locator("footer .primary")).to_be_focused()
    expect(page.locator("footer .why")).to_contain_text("It learns on to trial 8,000")


def test_an_answer_is_not_forgotten_while_the_lab_says_nothing_of_it(taught: Taught) -> None:
    taught.page.clock.install()
    taught.open()
    taught.hear(STATES["direction"])
    chosen = taught.page.get_by_role("radio", name="Clockwise", exact=True)
    chosen.check()
    taught.page.get_by_role("radio", name="90 %").check()
    taught.page.clock.run_for(60_000)
    expect(chosen).to_be_checked()
    button(taught, "Commit").click()
    assert [message["do"] for message in taught.said] == ["answer", "answer", "commit"]


def test_a_number_is_typed_or_pushed_and_stays_within_bounds(taught: Taught) -> None:
    taught.hear(STATES["number"])
    field = taught.page.get_by_role("spinbutton")
    field.fill("9999")
    field.press("Tab")
    assert answer_of(taught) == 3456
    expect(field).to_have_value("3456")
    slider = taught.page.get_by_role("slider")
    slider.focus()
    slider.press("Home")
    assert answer_of(taught) == 0
    expect(field).to_have_value("0")


def test_parts_of_the_board_are_chosen_by_click_and_by_key(taught: Taught) -> None:
    taught.hear(STATES["sectors"])
    part = taught.page.get_by_role("checkbox", name="behind", exact=True)
    expect(part).to_be_checked()
    part.press("Space")
    assert answer_of(taught) == ["nw"]
    part.press("ArrowLeft")
    below = taught.page.get_by_role("checkbox", name="behind right", exact=True)
    expect(below).to_be_focused()
    below.press("Enter")
    assert answer_of(taught) == ["nw", "sw"]
    taught.page.get_by_role("checkbox", name="ahead", exact=True).click()
    assert answer_of(taught) == ["e", "nw", "sw"]


def test_moments_and_curves_can_be_typed(taught: Taught) -> None:
    taught.hear(STATES["moment"])
    field = taught.page.get_by_label("Trial", exact=True)
    field.fill("24500")
    field.press("Tab")
    assert answer_of(taught) == 24_500
    # Of what is asked about no moment lies before.
    field.fill("100")
    field.press("Tab")
    assert answer_of(taught) == 24_000
    taught.hear(STATES["sketch"])
    taught.page.get_by_text("Or type six rewards").click()
    field = taught.page.get_by_label("Reward at trial 11,500")
    field.fill("-20")
    field.press("Tab")
    assert answer_of(taught) == [[trial, -20] for trial in TRIALS]
    field = taught.page.get_by_label("Reward at trial 17,000")
    field.fill("60")
    field.press("Tab")
    assert answer_of(taught) == [*([trial, -20] for trial in TRIALS[:-1]), [17_000, 60]]


def test_an_order_is_made_by_buttons_and_arrows_and_is_one_from_the_beginning(
    taught: Taught,
) -> None:
    taught.hear(STATES["order"])
    first = [value for value, _ in PARTS]
    button(taught, "Commit").click()
    assert taught.said == [
        {"do": "answer", "id": "a_ask", "value": first},
        {"do": "commit", "id": "a_ask", "confidence": None},
    ]
    up = button(taught, "Move Timers up")
    up.click()
    assert answer_of(taught) == ["timers", "exploration", "freeze", "safe"]
    expect(up).to_be_focused()
    button(taught, "Move Timers down").press("ArrowDown")
    assert answer_of(taught) == first


@pytest.mark.parametrize(
    ("name", "lines"),
    [
        ("number revealed", ["400 states", "130 states", "89 to 165 states"]),
        ("moment revealed", ["24,000", "32,000", "27,000 to 41,250"]),
        ("sectors revealed", ["left flank; behind", "behind left; behind"]),
        (
            "sketch revealed",
            [
                "0, 10, 20, 30, 40, 50",
                "13, \N{MINUS SIGN}20, \N{MINUS SIGN}18, 60, 52, 66",
                "\N{MINUS SIGN}26 to 74",
            ],
        ),
    ],
)
def test_what_came_out_is_said_in_words_beside_its_picture(
    taught: Taught, name: str, lines: list[str]
) -> None:
    taught.hear(STATES[name])
    said = taught.page.locator(".reveal dd").all_text_contents()
    assert said[: len(lines)] == lines
    expect(taught.page.locator(".reveal .words")).to_have_text("So it was in all runs.")
    expect(taught.page.locator(".reveal")).to_contain_text("You were 70 % sure.")


def test_a_reveal_has_guess_run_others_and_class_and_no_mark(taught: Taught) -> None:
    taught.hear(STATES["class revealed"])
    rows = taught.page.locator(".bars > li")
    expect(rows.nth(0)).to_contain_text("Clockwiseyou expected0 of 2029 of 3121 of 31")
    expect(rows.nth(1)).to_contain_text("Counter-clockwisethis run20 of 200 of 316 of 31")
    text = taught.page.locator(".reveal").inner_text().lower()
    assert not any(word in text for word in ("wrong", "right.", "correct", "score", "points"))


def test_a_check_that_can_no_longer_come_true_offers_the_moment_before(taught: Taught) -> None:
    page = taught.page
    taught.hear(STATES["to do"])
    expect(page.get_by_role("status").filter(has_text="12 %")).to_be_visible()
    button(taught, "Give me a hint").click()
    button(taught, "Add circle clockwise now").click()
    assert taught.said == [
        {"do": "hint"},
        {"do": "use", "control": "add_skill.circle_clockwise", "value": None},
    ]
    taught.hear(STATES["never"])
    button(taught, "Go back to before").click()
    assert taught.said == [{"do": "rewind"}]
    taught.hear(STATES["done"])
    expect(page.locator(".verdict")).to_have_text("Done at trial 7,412.")
    button(taught, "Next").click()
    assert taught.said == [{"do": "next"}]


def test_what_a_button_is_about_to_become_is_not_done_by_a_click_on_what_it_says(
    taught: Taught,
) -> None:
    taught.hear(STATES["to do"])
    primary = taught.page.locator("footer .primary")
    said = primary.inner_text()
    at_once = "(button, state) => { window.hear(state); button.click(); }"
    primary.evaluate(at_once, STATES["done"])
    expect(primary).to_have_text("Next")
    assert said != "Next"
    assert taught.said == []


def test_the_lessons_few_controls_say_what_they_were_set_to(taught: Taught) -> None:
    taught.hear(STATES["done"])
    page = taught.page
    button(taught, "Play").click()
    page.get_by_role("slider", name="Speed").press("ArrowRight")
    page.get_by_role("radio", name="First reach").check()
    button(taught, "Freeze").click()
    # What cannot be used now says why, and does nothing.
    button(taught, "Explore circle clockwise").click(force=True)
    said = {message["control"]: message["value"] for message in taught.said}
    assert said == {"play": None, "speed": 200_000, "layer": "reach", "freeze": True}


def test_one_goes_where_one_was_and_no_farther(taught: Taught) -> None:
    taught.hear(STATES["direction"])
    button(taught, "Card 2 of 9").click()
    button(taught, "Card 9 of 9").click(force=True)
    button(taught, "Back").click()
    taught.page.get_by_label("Language").select_option("de")
    button(taught, "Open everything").click()
    assert taught.said == [
        {"do": "go", "card": 1},
        {"do": "back"},
        {"do": "language", "language": "de"},
        {"do": "free"},
    ]
    taught.hear(STATES["German"])
    expect(taught.page.locator("html")).to_have_attribute("lang", "de")
    expect(button(taught, "Festlegen")).to_be_visible()


def test_the_list_goes_on_where_one_left_off(taught: Taught) -> None:
    taught.hear(STATES["list"])
    assert taught.page.evaluate(FOCUSED) == "Lessons"
    button(taught, "Go on at card 7: The cone").click()
    button(taught, "From the beginning: The cone").click()
    button(taught, "Start: All at once?").click()
    assert [(one["name"], one["again"]) for one in taught.said] == [
        ("the_cone", False),
        ("the_cone", True),
        ("all_at_once", True),
    ]


def test_a_lesson_is_sent_in_parts_that_come_whole(taught: Taught) -> None:
    taught.hear(STATES["list"])
    text = "title: Größe ✓\n" * 200
    taught.page.locator("input[type=file]").set_input_files(
        {"name": "mine.yaml", "mimeType": "text/yaml", "buffer": text.encode()}
    )
    taught.page.wait_for_function(
        "window.sent.length > 0 && window.sent.length === window.sent[0].parts"
    )
    parts = taught.said
    assert "".join(part["text"] for part in parts) == text
    assert [part["part"] for part in parts] == list(range(len(parts)))
    assert max(len(part["text"].encode()) for part in parts) < 4_000


def test_whoever_presents_sees_how_many_have_answered(taught: Taught) -> None:
    taught.hear(STATES["class asked"])
    expect(taught.page.locator(".vote")).to_contain_text("4821 at http://192.168.0.7:8090")
    expect(taught.page.get_by_role("status").filter(has_text="12 of 31")).to_be_visible()
    expect(button(taught, "Ask the class")).to_be_hidden()
    for name in ("Vote again", "Reveal with the run", "End and forget"):
        button(taught, name).click()
    assert [one["do"] for one in taught.said] == ["vote_again", "reveal_class", "end_class"]
    notes = taught.page.get_by_text("Wait until five have answered.")
    expect(notes).to_be_hidden()
    taught.page.get_by_text("Notes for the teacher").click()
    expect(notes).to_be_visible()


def test_what_people_wrote_is_text(taught: Taught) -> None:
    shown = card("ask", "&lt;img src=x onerror=alert(1)&gt;", ask=asks("direction", options=[]))
    taught.hear(told(shown, title="<img src=x onerror=alert(1)>", said="<b>no</b>"))
    assert taught.page.locator(".lesson img, .said b").count() == 0


def test_a_card_at_rest_does_nothing(taught: Taught) -> None:
    taught.hear(STATES["to do"])
    assert taught.page.evaluate(FRAMES) == 0
