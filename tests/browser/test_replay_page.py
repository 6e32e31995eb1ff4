"""The replay page, opened from disk in a real browser that has no network."""

import base64
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import BrowserContext, Page, ViewportSize, expect

from app.documents import presets
from app.player import replay_page
from app.player.film import PLANES
from app.player.reel import recorded_run
from tests.support.access import AXE, FINDINGS
from tests.support.films import unpacked
from tests.support.replays import (
    HOSTILE,
    branchy_records,
    fewer_moments,
    recorded,
    small_branchy,
)
from tests.support.schedules import small_spec

PHONE: ViewportSize = {"width": 390, "height": 844}
WIDE: ViewportSize = {"width": 1366, "height": 768}
# Colours are bytes there, and base64 in what Python sends.
BOARDS = """async ([packed, planes]) => {
    const { openFilm } = await import("pounce/replay/film.js");
    const film = await openFilm(packed);
    const text = bytes => btoa(String.fromCharCode(...bytes));
    const found = [];
    for (let moment = 0; moment < film.shots.length; moment++)
        for (const name of film.views.keys())
            for (const isDark of [false, true]) {
                const board = film.board(name, moment, isDark);
                for (const plane of planes) if (board[plane]) board[plane] = text(board[plane]);
                found.push([film.shots[moment], name, isDark, board, film.said(name, moment)]);
            }
    return JSON.stringify(found);
}"""


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page of a small session with branches, names and marks."""
    path = tmp_path_factory.mktemp("replay") / "small.html"
    with fewer_moments():
        path.write_text(replay_page.replay_page(small_branchy()), "utf-8")
    return path


@pytest.fixture
def open_file(new_context: Callable[..., BrowserContext]) -> Iterator[Callable[..., Page]]:
    """Opens a page from disk without a network; anything that it asks for is a failure."""
    wrong: list[str] = []

    def open_it(path: Path, size: ViewportSize = WIDE, **options: Any) -> Page:
        context = new_context(viewport=size, **options)
        context.set_offline(True)
        page = context.new_page()
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("console", lambda said: wrong.append(said.text) if said.type == "error" else None)
        page.on(
            "request",
            lambda asked: (
                None
                if asked.url.startswith("data:") or asked.url == path.as_uri()
                else wrong.append(asked.url)
            ),
        )
        page.goto(path.as_uri())
        if options.get("java_script_enabled", True):
            expect(page.locator("html")).to_have_attribute("data-ready", "")
        return page

    yield open_it
    assert wrong == []


def trial(page: Page) -> int:
    """The trial that is shown."""
    text = page.locator("#readings .large > div").first.locator("div").last.inner_text()
    return int(text.replace(",", ""))


def scrub(page: Page, share: float) -> None:
    """Drag the playhead to a place along the axis."""
    axis = page.locator(".axis > .plot")
    axis.scroll_into_view_if_needed()
    box = axis.bounding_box()
    assert box is not None
    x, y = box["x"] + share * box["width"], box["y"] - 40
    page.mouse.move(box["x"] + 0.5 * box["width"], y)
    page.mouse.down()
    page.mouse.move(x, y, steps=4)
    page.mouse.up()


def test_what_is_decoded_in_a_browser_is_what_was_painted(
    open_file: Callable[..., Page], small: Path
) -> None:
    found = re.search(r'id="replay-film">([^<]+)<', small.read_text("utf-8"))
    assert found is not None
    decoded = json.loads(open_file(small).evaluate(BOARDS, [found[1], list(PLANES)]))
    shots = unpacked(base64.b64decode(found[1]))
    assert len(decoded) == len(shots) * 6 * 2
    by_place = iter(decoded)
    for shot in shots:
        for name, view in shot.views.items():
            for is_dark, board in ((False, view.light), (True, view.dark)):
                place, at, dark, drawn, said = next(by_place)
                assert (place["step"], place["trial"], at, dark) == (
                    *(shot.step, shot.trial, name, is_dark),
                )
                assert tuple(place["said"]) == shot.texts
                assert tuple(said) == view.texts
                assert drawn == json.loads(json.dumps(board))


def test_it_stands_still_until_it_is_played_and_scrubs(
    open_file: Callable[..., Page], small: Path
) -> None:
    page = open_file(small)
    last = trial(page)
    expect(page.get_by_role("button", name="Play what is looked at")).to_be_visible()
    sentence = page.locator("#sentence").inner_text()
    scrub(page, 0.1)
    page.wait_for_function(
        "t => !document.querySelector('#readings').textContent.includes(t)", arg=f"{last:,}"
    )
    assert 0 < trial(page) < last / 2
    assert page.locator("#sentence").inner_text() != sentence
    # Again and again: it does not come to its end, however slow this is.
    for key in ("a", "End", "l"):
        page.keyboard.press(key)
    page.keyboard.press("Space")
    pause = page.get_by_role("button", name="Pause")
    expect(pause).to_be_visible()
    before = trial(page)
    page.wait_for_function(
        "t => Number(document.querySelector('#readings .large div div:last-child')"
        ".textContent.replaceAll(',', '')) !== t",
        arg=before,
    )
    page.keyboard.press("Space")
    expect(pause).to_have_count(0)


def test_keys_go_through_moments_events_layers_and_headings(
    open_file: Callable[..., Page], small: Path
) -> None:
    page = open_file(small)
    last, press = trial(page), page.keyboard.press
    press("Home")
    expect(page.locator("#readings")).to_contain_text("Trial")
    page.wait_for_function(
        "document.querySelector('#readings .large div div:last-child').textContent === '0'"
    )
    press("BracketRight")
    place = page.locator(".transport .place")
    expect(place).to_contain_text(":")
    press("End")
    page.wait_for_function(
        "t => document.querySelector('#readings').textContent.includes(t)", arg=f"{last:,}"
    )
    press("Comma")
    page.wait_for_function(
        "t => !document.querySelector('#readings').textContent.includes(t)", arg=f"{last:,}"
    )
    press("3")
    expect(page.locator('[data-layer="reach"]')).to_have_attribute("aria-pressed", "true")
    expect(page.locator("#legend")).to_contain_text("Trial in which value first came")
    press("v")
    expect(page.locator("#frame")).to_have_value("each")
    expect(page.locator("#board")).to_have_attribute("aria-label", re.compile("First reach"))
    dark = page.locator("html").get_attribute("data-mantine-color-scheme") == "dark"
    press("d")
    expect(page.locator("html")).to_have_attribute(
        "data-mantine-color-scheme", "light" if dark else "dark"
    )
    page.locator("#frame").select_option("2")
    expect(page.locator("#board")).to_be_visible()


def test_lines_and_what_happened_can_be_gone_to_and_nothing_can_be_changed(
    open_file: Callable[..., Page], small: Path
) -> None:
    page = open_file(small)
    rows = page.locator(".tree .line")
    expect(rows).to_have_count(4)
    branch = page.locator(".tree .line:not(.live)").first
    branch.click()
    expect(branch).to_have_attribute("aria-current", "true")
    joins = (
        page.locator(".events table").first.get_by_role("button", name=re.compile("joins")).first
    )
    joins.click()
    expect(page.locator(".tree .line.live")).to_have_attribute("aria-current", "true")
    expect(page.locator(".transport .place")).to_contain_text("joins")
    branch.click(button="right")
    expect(page.get_by_role("menuitem")).to_have_text(["Look at it"])
    page.keyboard.press("Escape")
    # What somebody wrote is text.
    expect(page.get_by_text(HOSTILE[:80]).first).to_be_attached()
    assert page.locator("b[onclick]").count() == 0
    for label in ("Back to live", "Mark this moment"):
        expect(page.get_by_role("button", name=label)).to_have_count(0)


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("size", [WIDE, PHONE])
def test_a_checker_finds_nothing_serious(
    new_context: Callable[..., BrowserContext], small: Path, size: ViewportSize, dark: bool
) -> None:
    # The checker is put into the page, which its policy forbids otherwise.
    context = new_context(viewport=size, color_scheme="dark" if dark else "light", bypass_csp=True)
    page = context.new_page()
    page.goto(small.as_uri())
    expect(page.locator("html")).to_have_attribute("data-ready", "")
    page.locator("summary").click()
    page.evaluate(f"{AXE};0")
    assert page.evaluate(FINDINGS) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]


def test_without_scripts_there_is_a_picture_and_what_happened(
    open_file: Callable[..., Page], small: Path
) -> None:
    page = open_file(small, java_script_enabled=False)
    expect(page.locator("#poster svg")).to_be_visible()
    expect(page.locator("#board")).to_be_hidden()
    expect(page.locator(".stills figure")).to_have_count(4)
    expect(page.locator("noscript p")).to_be_visible()
    expect(page.locator(".events")).to_contain_text("circle clockwise joins")


def test_it_prints_as_four_pictures(open_file: Callable[..., Page], small: Path) -> None:
    page = open_file(small, color_scheme="dark")
    page.emulate_media(media="print")
    figures = page.locator(".stills figure")
    expect(figures).to_have_count(4)
    for figure in figures.all():
        expect(figure).to_be_visible()
        expect(figure.locator("figcaption")).to_contain_text("Trial ")
    expect(page.locator("main")).to_be_hidden()
    assert page.evaluate("getComputedStyle(document.documentElement).backgroundColor") in (
        "rgb(255, 255, 255)",
    )
    # Pictures of the board, each in its own four.
    assert page.pdf(format="A4").count(b"/Subtype /Image") >= 4


def test_a_whole_timed_run_and_a_long_session_with_branches_are_thinned_until_they_fit(
    open_file: Callable[..., Page], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Of a page that is smaller, with fewer moments: each of them has as much to it as ever.
    monkeypatch.setattr(replay_page, "MOST_BYTES", 700_000)
    whole = recorded_run(presets.load("timed", ()), "timed", 0)
    long = recorded(branchy_records(small_spec("trials=5000"), 60_000, n_branches=8))
    for name, session in (("timed", whole), ("long", long)):
        path = tmp_path / f"{name}.html"
        with fewer_moments():
            path.write_text(replay_page.replay_page(session), "utf-8")
        assert path.stat().st_size < replay_page.MOST_BYTES
        page = open_file(path)
        assert trial(page) == session.live.until_trial
        page.close()
