"""The first hunts in a real browser, and one that is watched there."""

import math
import threading

import pytest
from playwright.sync_api import expect

from app.live.requests import Begin, Pause, Play, Request
from app.page.panels import hunts as panel
from tests.support.live import preset_of
from tests.support.screen import OpenPage, StartLab

_WORDS = """board => [0, 1, 2].map(number =>
    window.__viserSceneTree?.getState()[`/${board}/tags/${number}`]?.message.props.text)"""
_IS_THERE = "name => Boolean(window.__viserSceneTree?.getState()[name])"


def test_the_first_hunts_are_seen_once_the_board_is_and_another_can_be_watched(
    start_lab: StartLab, open_page: OpenPage, monkeypatch: pytest.MonkeyPatch
) -> None:
    live = start_lab(preset_of("timed", "world.vision_radius=27"), opening=True)
    submit, begun = live.session.submit, list[Request]()

    def begin_and_pause(request: Request, *rest: object) -> int:
        ticket = submit(request, *rest)
        if isinstance(request, Begin):
            begun.append(request)
            # However long the page takes for the rest, the first hunt is still there to be seen.
            ticket = submit(Pause())
        return ticket

    monkeypatch.setattr(live.session, "submit", begin_and_pause)
    screen = open_page(live)
    said = screen.page.locator('[data-slot-of="opening"]')
    status = live.wait_for(lambda status: bool(begun) and not status.playing)
    assert (status.snapshot.trial, status.snapshot.trial_step) == (0, 0)
    expect(said).to_contain_text("first hunts, slowed down to be seen: 1 of 3")
    screen.page.wait_for_function(f"() => ({_WORDS})('board')[2] === 'predator'")
    assert screen.page.evaluate(_WORDS, "board") == ["what it sees", "prey", "predator"]

    said.get_by_role("link", name="Skip").click()
    live.wait_for(lambda status: status.opening is None)
    expect(said).to_have_text("Watch a hunt")
    live.ask(Play())
    live.wait_for(lambda status: status.snapshot.trial > 100)

    seen, way = threading.Event(), panel._Watched.way
    # However long the page takes, the hunt is under way until it was looked at.
    monkeypatch.setattr(
        panel._Watched, "way", lambda self, now_s: way(self, now_s if seen.is_set() else -math.inf)
    )
    screen.page.keyboard.press("w")
    expect(said).to_contain_text("with what it knows at trial")
    screen.page.wait_for_function(_IS_THERE, arg="/watched/predator")
    seen.set()
    expect(said).to_contain_text(" after ")
    screen.page.wait_for_function(f"() => ({_WORDS})('watched')[2] !== 'predator'")
    word = screen.page.evaluate(_WORDS, "watched")[2]
    assert word in ("caught", "noticed", "out of time")
    assert word.split()[0] in said.inner_text().lower()
    # Nobody else sees it, nor does the learner wait.
    trial = live.session.status.snapshot.trial
    live.wait_for(lambda status: status.snapshot.trial > trial)
    said.get_by_role("link", name="Stop").click()
    expect(said).to_have_text("Watch a hunt")
    screen.page.wait_for_function(f"name => !({_IS_THERE})(name)", arg="/watched/predator")
