"""Boards on canvases in a real browser, under the policy of a page in a frame."""

import base64
import functools
import io
import json
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import BrowserContext, ConsoleMessage, Page

from app.documents import presets
from app.live import snapshot
from app.live.snapshot import Snapshot
from app.page.success import success_of
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import ALL, FOLDED, Look
from app.picture.multiples import SIDE, TILES, all_headings
from app.picture.outlines import BOARD_UNITS, cell_centres, is_on_board
from app.picture.theme import DARK, LIGHT
from app.player.boards import board_sent, ground_sent, over_sent, world_sent
from app.player.moments import words_sent
from app.server.channels import Channels
from learners.run import Run
from tests.support.server import lab_of

SIZE, CELL = 40, 6
ROOM = 243
"""Side of a canvas in which a board of ``SIZE`` cells has ``CELL`` pixels for each."""

# Boards that a test makes, as they are called in it.
MAKE = """async ([name, world, parts, [width, height]]) => {
    const { Board } = await import(new URL("../../web/player/board.js", location.href));
    const canvas = document.createElement("canvas");
    canvas.style.cssText = `display: block; width: ${width}px; height: ${height}px`;
    document.body.append(canvas);
    const board = new Board(canvas);
    (window.boards ??= {})[name] = { board, canvas };
    if (world) board.world(world);
    for (const part of parts) board.show(part);
    board.resize();
    board.draw();
}"""
DRAW = """([name, parts]) => {
    const { board } = window.boards[name];
    for (const part of parts) board.show(part);
    board.draw();
}"""
PIXELS = "name => window.boards[name].canvas.toDataURL().split(',')[1]"
CELL_AT = """([name, x, y]) => {
    const { board, canvas } = window.boards[name];
    const { left, top } = canvas.getBoundingClientRect();
    return board.cellAt(left + x, top + y);
}"""


class Message(msgspec.Struct, tag_field="do", tag="nothing", forbid_unknown_fields=True):
    """What a page may send here."""


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Of a page with the policy of those in frames."""
    channels = Channels()
    with lab_of(channels=channels) as lab:
        channel = channels.enter(Message, lambda _: None, lambda: None)
        yield f"http://127.0.0.1:{lab.port}/{channel.address}"


@pytest.fixture
def page(new_context: Callable[..., BrowserContext], address: str) -> Iterator[Page]:
    yield from opened(new_context(viewport={"width": 1366, "height": 768}), address)


@pytest.fixture
def fine_page(new_context: Callable[..., BrowserContext], address: str) -> Iterator[Page]:
    """A page on a screen with four pixels where others have one."""
    context = new_context(viewport={"width": 1366, "height": 768}, device_scale_factor=2)
    yield from opened(context, address)


def opened(context: BrowserContext, address: str) -> Iterator[Page]:
    page = context.new_page()
    complaints: list[str] = []

    def note(message: ConsoleMessage) -> None:
        # Browsers ask for a picture for the tab by themselves.
        if message.type == "error" and not message.location["url"].endswith("favicon.ico"):
            complaints.append(message.text)

    page.on("console", note)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(address)
    yield page
    assert complaints == []


@functools.cache
def moment(preset: str = "timed", *settings: str) -> tuple[Snapshot, Extras]:
    run = Run(presets.load(preset, [f"world.size={SIZE}", *settings]), seed=3)
    run.advance(until_trial=300)
    early = snapshot.take(run, preset, 0)
    run.advance(until_trial=1_500)
    run.advance(max_steps=9)
    late = snapshot.take(run, preset, 0, early)
    return late, Extras(success_of(late, lambda: True), early)


def bare(moment: Snapshot, look: Look, extras: Extras) -> dict[str, Any]:
    """Colours and nothing over them but the border and the prey's dot."""
    return {**ground_sent(moment, look, extras), "hunt": None, "prey": None, "sees": False}


def pixels(page: Page, name: str = "a") -> np.ndarray:
    """``(y, x, 4) uint8`` from the north-west on."""
    png = base64.b64decode(page.evaluate(PIXELS, name))
    return np.array(Image.open(io.BytesIO(png)).convert("RGBA"))


def make(
    page: Page,
    moment: Snapshot,
    *parts: dict[str, Any],
    name: str = "a",
    room: tuple[int, int] = (ROOM, ROOM),
) -> None:
    page.evaluate(MAKE, [name, world_sent(moment.spec.world), list(parts), room])


def at_middles(drawn: np.ndarray) -> np.ndarray:
    """Colours in the middles of cells, row by row from the south-west, ``(y * x, 4)``."""
    first = (ROOM - SIZE * CELL + 1) // 2 + CELL // 2
    along = first + CELL * np.arange(SIZE)
    return drawn[along[:, None], along][::-1].reshape(-1, 4)


@pytest.mark.parametrize(("frame", "theme"), [(FOLDED, LIGHT), (3, DARK)], ids=["folded", "one"])
def test_each_cell_has_the_colour_that_the_layer_paints(page: Page, frame: int, theme: Any) -> None:
    taken, extras = moment()
    make(page, taken)
    for key, layer in LAYERS.items():
        look = layer.heeded(
            Look(layer=key, frame=frame, theme=theme, flight=True), taken.spec.learner
        )
        page.evaluate(DRAW, ["a", [bare(taken, look, extras)]])
        drawn = at_middles(pixels(page))
        middles = cell_centres(taken.spec.world)[:, :2]
        there = is_on_board(middles, taken.spec.world, look.frame == FOLDED)
        # Its border lies over the outermost cells of a round board; the prey in the middle.
        away = np.hypot(*middles.T) * SIZE / BOARD_UNITS
        clear = (away > 1.5) & (away < SIZE / 2 - 2 if look.frame == FOLDED else away > 0)
        painted = layer.paint(taken, look, extras).colours
        np.testing.assert_array_equal(drawn[there & clear, :3], painted[there & clear], key)
        assert (drawn[there & clear, 3] == 255).all()
        assert (drawn[~there & (away > SIZE / 2 + 1), 3] == 0).all()


def test_each_heading_has_its_own_tile(page: Page) -> None:
    taken, extras = moment()
    # As wide as makes each pixel of a tile three of the canvas.
    side = round(3 * SIDE / 0.24)
    room = (round(side / 0.988) + 1, 600)
    make(page, taken, room=room)
    for key in ("value", "chosen", "reach", "success"):
        look = Look(layer=key, frame=ALL)
        page.evaluate(DRAW, ["a", [bare(taken, look, extras)]])
        drawn = pixels(page)
        painted = all_headings(taken, look, LAYERS[key], extras).colours.reshape(8, SIDE, SIDE, 3)
        for tile in TILES:
            x = room[0] / 2 + tile.east * side
            y = room[1] / 2 - tile.north * side
            for row, column in ((5, 5), (50, 12), (20, 48)):
                at = round(y + (SIDE / 2 - row - 0.5) * 3), round(x + (column + 0.5 - SIDE / 2) * 3)
                expected = painted[tile.heading, row, column]
                np.testing.assert_array_equal(drawn[at][:3], expected, f"{key} {tile}")


def test_boards_of_different_worlds_are_drawn_beside_each_other(page: Page) -> None:
    one, extras = moment()
    other, of_other = moment("hierarchical_3", "world.n_directions=16", "world.n_distances=9")
    look = Look(layer="visits", frame=0)
    make(page, one, bare(one, look, extras), name="a")
    make(page, other, bare(other, look, of_other), name="b")
    page.evaluate(DRAW, ["a", []])
    for taken, more, name in ((one, extras, "a"), (other, of_other, "b")):
        painted = LAYERS["visits"].paint(taken, look, more).colours
        middles = cell_centres(taken.spec.world)[:, :2]
        clear = np.abs(middles).max(axis=1) * SIZE / BOARD_UNITS > 1.5
        np.testing.assert_array_equal(at_middles(pixels(page, name))[clear, :3], painted[clear])


def test_a_board_of_a_world_that_is_not_known_yet_waits_for_it(page: Page) -> None:
    taken, extras = moment()
    sent = board_sent(taken, Look(), extras)
    page.evaluate(MAKE, ["a", None, [sent], [ROOM, ROOM]])
    assert not pixels(page).any()
    page.evaluate("world => window.boards.a.board.world(world)", world_sent(taken.spec.world))
    page.evaluate(DRAW, ["a", []])
    assert pixels(page).any()
    other, of_other = moment("timed", "world.n_distances=9")
    page.evaluate(DRAW, ["a", [board_sent(other, Look(), of_other)]])
    assert not pixels(page).any()


def test_lines_stay_until_others_come_but_not_over_another_view(page: Page) -> None:
    taken, extras = moment()
    look, other = Look(layer="flow", frame=0), Look(layer="flow", frame=1)
    plain = bare(taken, look, extras)
    make(page, taken, plain)
    without = pixels(page)
    page.evaluate(DRAW, ["a", [over_sent(taken, look, extras)]])
    lined = pixels(page)
    assert (lined != without).any()
    page.evaluate(DRAW, ["a", [plain]])
    np.testing.assert_array_equal(pixels(page), lined)
    page.evaluate(DRAW, ["a", [bare(taken, other, extras)]])
    np.testing.assert_array_equal(pixels(page), without)
    page.evaluate(DRAW, ["a", [plain]])
    np.testing.assert_array_equal(pixels(page), lined)


def test_the_cell_under_a_pointer_is_the_one_that_is_seen_there(page: Page) -> None:
    taken, extras = moment()
    make(page, taken, board_sent(taken, Look(frame=0), extras))
    first = (ROOM - SIZE * CELL + 1) // 2

    def cell(x: float, y: float) -> Any:
        return page.evaluate(CELL_AT, ["a", x, y])

    for x, y in ((0, 0), (20, 20), (39, 39), (7, 31)):
        place = first + (x + 0.5) * CELL, first + (SIZE - y - 0.5) * CELL
        assert cell(*place) == {"east": x - 20, "north": y - 20, "heading": None}
    assert cell(0, 0) is None
    page.evaluate(DRAW, ["a", [board_sent(taken, Look(), extras)]])
    assert cell(first + 3, first + 3) is None, "a corner is off the round board"
    assert cell(ROOM / 2 + 3, ROOM / 2 - 3) == {"east": 0, "north": 0, "heading": None}
    page.evaluate(DRAW, ["a", [board_sent(taken, Look(frame=ALL), extras)]])
    headings = {
        tile.heading: cell(ROOM / 2 + tile.east * 240, ROOM / 2 - tile.north * 240)
        for tile in TILES
    }
    assert {key: found["heading"] for key, found in headings.items()} == {k: k for k in range(8)}


def test_a_cell_is_marked(page: Page) -> None:
    taken, extras = moment()
    make(page, taken, bare(taken, Look(frame=0), extras))
    plain = pixels(page)
    page.evaluate("window.boards.a.board.mark({ east: -10, north: 5 })")
    page.evaluate(DRAW, ["a", []])
    rows, columns = np.nonzero((pixels(page) != plain).any(axis=-1))
    first = (ROOM - SIZE * CELL + 1) // 2
    assert (columns.min() + columns.max() + 1) / 2 == pytest.approx(first + 10.5 * CELL, abs=1)
    assert (rows.min() + rows.max() + 1) / 2 == pytest.approx(first + 14.5 * CELL, abs=1)
    page.evaluate("window.boards.a.board.mark(null)")
    page.evaluate(DRAW, ["a", []])
    np.testing.assert_array_equal(pixels(page), plain)


def test_it_is_as_sharp_as_the_screen_and_sharper_on_paper(fine_page: Page) -> None:
    page = fine_page
    taken, extras = moment()
    make(page, taken, bare(taken, Look(frame=0), extras))
    widths = "['width', 'height'].map(side => window.boards.a.canvas[side])"
    assert page.evaluate(widths) == [2 * ROOM, 2 * ROOM]
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert page.evaluate(widths) == [4 * ROOM, 4 * ROOM]
    assert pixels(page)[2 * ROOM + 40, 2 * ROOM + 40, 3] == 255
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert page.evaluate(widths) == [2 * ROOM, 2 * ROOM]
    # It follows its style.
    page.evaluate("window.boards.a.canvas.style.width = '300px'")
    page.wait_for_function("window.boards.a.canvas.width === 600")


def test_many_changes_are_drawn_once_with_the_next_frame(page: Page) -> None:
    taken, extras = moment()
    sent = board_sent(taken, Look(), extras)
    make(page, taken, sent)
    counts = page.evaluate(
        """async sent => {
            const { board } = window.boards.a;
            const frame = () => new Promise(requestAnimationFrame);
            await frame();
            const before = board.drawn;
            for (let i = 0; i < 20; i++) board.show(sent);
            const during = board.drawn;
            await frame();
            await frame();
            board.show(sent);
            board.remove();
            await frame();
            return [during - before, board.drawn - before];
        }""",
        sent,
    )
    assert counts == [0, 1]


def test_it_says_what_it_is_to_those_who_cannot_see_it(page: Page) -> None:
    taken, extras = moment()
    make(page, taken, board_sent(taken, Look(), extras))
    text = words_sent(taken, Look(), extras)["described"]
    page.evaluate("text => window.boards.a.board.describe(text)", text)
    board = page.get_by_role("img", name=text, exact=True)
    assert board.count() == 1
    assert "40 by 40 cells" in text
    assert "State value" in text


def test_a_legend_has_its_colours_where_no_style_may_stand_in_a_text(page: Page) -> None:
    taken, extras = moment()
    legend = words_sent(taken, Look(), extras)["legend"]
    found = page.evaluate(
        """async legend => {
            const { put } = await import(new URL("../../web/player/html.js", location.href));
            const place = document.body.appendChild(document.createElement("div"));
            put(place, legend);
            const backgrounds = [...place.querySelectorAll("*")].map(
                node => getComputedStyle(node).backgroundImage);
            return [place.textContent, backgrounds.some(each => each.includes("gradient"))];
        }""",
        json.loads(json.dumps(legend)),
    )
    assert "Thick line: where value ends" in found[0]
    assert found[1]
