"""An audience of a lab with a real port: what it is shown, and that all that it sends changes
nothing."""

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from websockets.exceptions import ConnectionClosed

from app.audience import audience as audience_module
from app.audience import views
from app.audience.wishes import MOST_MOMENTS
from app.live.requests import Pause, Play, SetSpeed
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import ALL, Look
from app.picture.theme import DARK
from app.player.boards import ground_sent, over_sent
from learners.kernel.state import digest
from learners.run import replay
from tests.support.audiences import FOLLOW, Shown, hostile_texts
from tests.support.live import SEED
from tests.support.server import get_path
from tests.support.watching import Page


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shown]:
    shown = Shown(tmp_path_factory.mktemp("lab"))
    yield shown
    shown.close()


def as_sent(board: dict[str, Any]) -> dict[str, Any]:
    return msgspec.json.decode(msgspec.json.encode(board))


def until(page: Page, condition: Callable[[dict[str, dict[str, Any]]], bool]) -> None:
    """Take in letters until what has come meets a condition."""
    while not condition(page.parts):
        page.receive()


def is_of(board: dict[str, Any]) -> Callable[[dict[str, dict[str, Any]]], bool]:
    return lambda parts: parts.get("ground", {}).get("board") == as_sent(board)


# --- What is shown --------------------------------------------------------------------------------


def test_before_anybody_presents_that_is_said(tmp_path: Path) -> None:
    new = Shown(tmp_path, trial=0)
    try:
        page = new.page()
        page.receive_until("stand")
        assert page.parts["stand"] == {"kind": "stand", "begun": False}
        assert "ground" not in page.parts
        new.present()
        until(page, lambda parts: parts["stand"]["begun"])
    finally:
        new.close()


@pytest.mark.parametrize("look", [Look(), Look(layer="chosen", frame=2), Look(frame=ALL)])
def test_the_presenters_view_is_seen_on_light_and_dark_devices(shown: Shown, look: Look) -> None:
    pages = [shown.page(), shown.page({"do": "follow", "dark": True})]
    shown.present(look)
    snapshot = shown.live.session.status.snapshot
    for page, theme in zip(pages, (look.theme, DARK), strict=True):
        themed = look._replace(theme=theme)
        until(page, is_of(ground_sent(snapshot, themed, Extras(), rests=True)))
        over = as_sent(over_sent(snapshot, themed, Extras()))
        until(page, lambda parts, over=over: parts["over"]["board"] == over)
        assert page.parts["legend"]["title"] == LAYERS[look.layer].title
        assert page.parts["bar"]["bar"] == {"bar": 1}


def test_what_one_looks_at_alone_is_that_moment(shown: Shown) -> None:
    shown.present()
    now = shown.live.session.status.snapshot
    step = now.step // 2
    wish = {"do": "look", "dark": False, "layer": "visits", "of": 0, "frame": 1, "step": step}
    page = shown.page(wish)
    page.receive_until("moment", "ground")
    there = page.parts["moment"]["step"]
    assert 0 <= step - there <= 2 * now.step / MOST_MOMENTS
    at = shown.live.stopped_at(there)
    look = Look(layer="visits", frame=1)
    expected = as_sent(ground_sent(at, look, Extras(), rests=True))
    until(page, lambda parts: parts["ground"]["board"]["colours"] == expected["colours"])
    assert not page.parts["moment"]["live"]
    page.send(FOLLOW)
    until(page, lambda parts: parts["moment"]["live"] and parts["stand"]["follows"])


def test_what_is_there_already_is_not_sent_again(shown: Shown) -> None:
    shown.present()
    page = shown.page()
    page.receive_until("ground", "moment", "bar")
    shown.present(Look(layer="reach"))
    kinds = {part["kind"] for part in page.receive()}
    assert "ground" in kinds
    assert kinds.isdisjoint({"lab", "world", "bar", "offer"})


def test_all_who_see_the_same_are_painted_for_once(
    shown: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    painted: list[Look] = []
    true_part = audience_module.pictures.ground_part

    def ground_part(status: Any, look: Look, extras: Extras) -> bytes:
        painted.append(look)
        return true_part(status, look, extras)

    shown.present()
    monkeypatch.setattr(audience_module.pictures, "ground_part", ground_part)
    pages = [shown.page() for _ in range(12)]
    shown.present(Look(layer="visits"))
    snapshot = shown.live.session.status.snapshot
    board = ground_sent(snapshot, Look(layer="visits"), Extras(), rests=True)
    for page in pages:
        until(page, is_of(board))
    assert painted.count(Look(layer="visits")) == 1


def test_however_much_the_presenter_has_done_the_run_is_seen_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A picture that goes by itself would be made up for by minutes of silence.
    for name in ("BYTES_PER_S", "_BYTES_AT_ONCE"):
        monkeypatch.setattr(views, name, 1.0)
    shown = Shown(tmp_path)
    try:
        shown.live.ask(SetSpeed(1_000.0), Play())
        page = shown.page()
        for look in (Look(), Look(layer="visits"), Look(layer="chosen")):
            step, title = shown.present(look).moment["step"], LAYERS[look.layer].title
            until(page, lambda parts, of=title: parts.get("legend", {}).get("title") == of)
        shown.live.wait_for(lambda status: status.snapshot.step > step)
        shown.present(look)
        until(page, lambda parts: parts["moment"]["step"] > step)
    finally:
        shown.close()


def test_who_is_away_is_said_to_be(shown: Shown) -> None:
    page = shown.page()
    shown.present(is_away=True)
    until(page, lambda parts: parts.get("stand", {}).get("away", False))
    shown.present()
    until(page, lambda parts: not parts["stand"]["away"])


def test_a_view_that_cannot_be_painted_harms_no_other(
    shown: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown.present()
    page = shown.page()
    page.receive_until("ground")
    true_part = audience_module.pictures.ground_part

    def ground_part(status: Any, look: Look, extras: Extras) -> bytes:
        if look.layer == "flow":
            raise RuntimeError("no flow")
        return true_part(status, look, extras)

    with monkeypatch.context() as patched:
        patched.setattr(audience_module.pictures, "ground_part", ground_part)
        shown.present(Look(layer="flow"))
        shown.page({"do": "look", "dark": False, "layer": "flow"})
        shown.present(Look(layer="visits"))
        board = ground_sent(
            shown.live.session.status.snapshot, Look(layer="visits"), Extras(), rests=True
        )
        until(page, is_of(board))


# --- That nothing which it sends does anything ----------------------------------------------------


def test_whatever_it_sends_the_learner_is_as_if_it_had_sent_nothing(tmp_path: Path) -> None:
    shown = Shown(tmp_path)
    try:
        port = shown.audience.watchers.port
        status = shown.live.ask(Play())
        before = (status.speed, status.lines, status.marks)
        for path in (
            "/time/",
            "/call/play",
            "/s/x",
            "/side/",
            "/?token=x",
            "/socket",
            "/web/lab.js",
        ):
            get_path(port, path, {}).read()
        page = shown.page()
        for message in hostile_texts():
            shown.present()
            with contextlib.suppress(ConnectionClosed):
                page.socket.send(message)
        for n in range(30):
            # Newest wins: each of many pages wishes another moment.
            shown.page({"do": "look", "dark": n % 2 == 0, "layer": "value", "step": 7 * n})
        page.send(FOLLOW)
        shown.present()
        page.receive_until("ground")
        after = shown.live.ask(Pause())
        snapshot = after.snapshot
        assert (after.speed, after.lines[:1], after.marks)[0::2] == before[0::2]
        assert len(after.lines) == len(before[1])
        assert after.error is None
        assert not snapshot.control.history or all(
            event.author == "schedule" for event in snapshot.control.history
        )
        alone = replay(snapshot.preset_spec, SEED, [], snapshot.step)
        past = shown.live.session.past_of(snapshot.generation)
        assert past is not None
        made = past.run_at(snapshot.step)
        assert made is not None
        assert digest(made.state) == digest(alone.state)
        assert (snapshot.selection_q == shown.live.stopped_at(snapshot.step).selection_q).all()
    finally:
        shown.close()


def test_no_checkpoint_is_kept_for_it(shown: Shown) -> None:
    past = shown.live.session.past_of(shown.live.session.status.snapshot.generation)
    assert past is not None
    shown.present()
    kept = past.kept
    steps = [past.end_step * n // 6 for n in range(1, 6)]
    for step in steps:
        page = shown.page({"do": "look", "dark": False, "step": step})
        page.receive_until("ground")
    assert past.kept == kept


def test_nothing_that_it_is_sent_is_a_secret(shown: Shown) -> None:
    shown.present()
    page = shown.page()
    page.receive_until("ground", "bar", "moment", "offer")
    text = msgspec.json.encode(page.parts).decode()
    assert "token" not in text
    assert str(shown.live.lab.server.get_port()) not in text
    assert str(shown.live.results) not in text
