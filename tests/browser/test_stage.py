"""The stage around the board: where all stands in windows of every size, and what moves it."""

from typing import Any, NamedTuple

import pytest
from playwright.sync_api import Locator, Page, expect

from app.picture.look import Look
from app.picture.theme import DARK, LIGHT
from tests.support.screen import VIEWPORT, Begin, Shared

BOARD = "#pounce-stage .board"
# What may not lie over the board, or the board over it, where it is to be seen.
AROUND = (
    "#pounce-stage header, #pounce-stage footer, #pounce-stage .rail,"
    " #pounce-stage [data-slot-of=readings], #pounce-stage [data-slot-of=legend],"
    " [data-dock-region], #root .mantine-Paper-root:has([data-autosize])"
)
# A camera is where it was told to be only with the next frame. The bar, whose type grows with the
# stage, has its height a frame or two later, and then the board has other room.
SETTLED = """([board]) => {
    const { camera, cameraControl, canvas } = window.__viserMutable;
    const end = cameraControl.getPosition(camera.position.clone());
    const slot = document.querySelector(board).getBoundingClientRect();
    const seen = canvas.getBoundingClientRect();
    const near = (a, b) => Math.abs(a - b) < 1;
    const frame = document.querySelector("iframe.pounce-time");
    const within = frame.contentDocument.body.getBoundingClientRect();
    const bar = document.querySelector("#pounce-stage footer").getBoundingClientRect();
    const told = document.documentElement.style.getPropertyValue("--bar-height");
    return near(slot.left, seen.left) && near(slot.top, seen.top) && near(slot.width, seen.width)
        && near(slot.height, seen.height)
        && Math.abs(within.height - frame.getBoundingClientRect().height) < 1.01
        && near(bar.height, parseFloat(told))
        && camera.position.distanceTo(end) < 1e-3
        && Math.abs(camera.aspect - slot.width / slot.height) < 0.01;
}"""
# Where the corners of the board are seen, in pixels.
CORNERS = """() => {
    const { camera, canvas, nodeRefFromName } = window.__viserMutable;
    camera.updateMatrixWorld();
    const { points } = window.__viserSceneTree.getState()["/board/border"].message.props;
    const along = axis => points.filter((_, at) => at % 3 === axis);
    const box = canvas.getBoundingClientRect();
    return [Math.min, Math.max].map(end => {
        const place = camera.position.clone().set(end(...along(0)), end(...along(1)), 0);
        nodeRefFromName["/board/cells"].localToWorld(place).project(camera);
        return [box.left + (place.x + 1) / 2 * box.width, box.top + (1 - place.y) / 2 * box.height];
    });
}"""
OVERLAPS = """([board, around]) => {
    const a = document.querySelector(board).getBoundingClientRect();
    return [...document.querySelectorAll(around)].filter(node => {
        const b = node.getBoundingClientRect();
        return node.checkVisibility() && b.width > 0 && b.height > 0
            && Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
            && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
    }).map(node => node.outerHTML.slice(0, 80));
}"""
SMALL_TYPE = """([root, least]) => [...document.querySelectorAll(`${root} *`)].filter(node => {
    const says = [...node.childNodes].some(part => part.nodeType === 3 && part.data.trim());
    if (!says || !node.checkVisibility() || node.getClientRects().length === 0) return false;
    return parseFloat(getComputedStyle(node).fontSize) * node.currentCSSZoom < least - 0.01;
}).map(node => node.outerHTML.slice(0, 120))"""
# What the page's own scripts change after a change, unless there is one after which that is
# nothing, and who of them asks for the frames that follow.
DONE_AT_REST = """async () => {
    const { whenChanged } = await import(new URL("web/changes.js", location.href));
    const observer = new MutationObserver(() => {});
    observer.observe(document.body, { characterData: true, childList: true, subtree: true });
    const changes = await new Promise(done => {
        let rounds = 0;
        whenChanged(() => {
            const changed = observer.takeRecords().map(({ target }) => target.outerHTML);
            rounds += 1;
            if (rounds > 1 && (changed.length === 0 || rounds > 10)) return done(changed);
            document.body.append(document.createElement("i"));
            document.body.lastChild.remove();
        });
    });
    observer.disconnect();
    const ask = window.requestAnimationFrame;
    const frames = [];
    window.requestAnimationFrame = work => {
        const { stack } = new Error();
        if (stack.includes("/web/")) frames.push(stack);
        return ask(work);
    };
    for (let frame = 0; frame < 3; frame++) await new Promise(done => ask(done));
    window.requestAnimationFrame = ask;
    return { changes, frames };
}"""
UP = """() => window.__viserMutable.camera.quaternion.toArray()"""


class Size(NamedTuple):
    """A window, and which panels stand beside its stage at first."""

    width: int
    height: int
    open: str


SIZES = {
    "a laptop": Size(1366, 768, "left right"),
    "125 %": Size(1093, 614, "right"),
    "150 %": Size(911, 512, ""),
    "200 %": Size(683, 384, ""),
    "a projector": Size(1024, 768, "right"),
    "full HD": Size(1920, 1080, "left right"),
    "a large screen": Size(2560, 1440, "left right"),
    "a phone": Size(390, 844, ""),
    "a phone on its side": Size(844, 390, ""),
}


def resize(page: Page, size: Size) -> None:
    """Give the window a size, and wait until the board fits it."""
    page.set_viewport_size({"width": size.width, "height": size.height})
    page.wait_for_function("open => document.documentElement.dataset.open === open", arg=size.open)
    settle(page)


def settle(page: Page) -> None:
    """Wait until the canvas lies where the stage has its board."""
    page.wait_for_function(SETTLED, arg=[BOARD])


def side_of(page: Page) -> float:
    """How long the side of the board is on the screen, in pixels."""
    settle(page)
    (left, bottom), (right, top) = page.evaluate(CORNERS)
    assert right - left == pytest.approx(bottom - top, rel=0.01)
    return right - left


def button_of_stage(page: Page, name: str) -> Locator:
    return page.locator("#pounce-stage").get_by_role("button", name=name, exact=True)


@pytest.mark.parametrize("name", SIZES)
def test_nothing_lies_over_the_board_and_all_is_within_reach(shared: Shared, name: str) -> None:
    page, size = shared.screen.page, SIZES[name]
    resize(page, size)
    # A panel that folds is over the board on its way.
    page.wait_for_function(f"parts => ({OVERLAPS})(parts).length === 0", arg=[BOARD, AROUND])
    room = page.locator(BOARD).bounding_box()
    assert room is not None
    # It just fits, in whichever direction there is less room.
    fits = min(room["width"], room["height"])
    assert 0.95 * fits < side_of(page) < fits
    for slot in ("task", "sentence"):
        shown = page.locator(f"[data-slot-of={slot}]")
        shown.scroll_into_view_if_needed()
        expect(shown).to_be_in_viewport()
    if name == "a phone":
        expect(shared.screen.button("One trial")).to_be_hidden()
        page.get_by_text("pounce", exact=True).click()
        shared.screen.button("One trial").click(trial=True)
        page.get_by_text("pounce", exact=True).click()
        button_of_stage(page, "Play").click(trial=True)
        return
    for edge, tab, control in (
        ("left", "File", shared.screen.button("Load experiment")),
        ("left", "Now", shared.screen.field("Layer")),
        ("right", "Experiments", shared.screen.button("Start")),
        ("right", "Run", shared.screen.button("Start again")),
    ):
        # On the rail of a panel that is folded, or among the tabs of one that is open.
        button_of_stage(page, tab).or_(shared.screen.tab(tab)).locator("visible=true").click()
        expect(page.locator(f"[data-dock-region={edge}]")).to_be_visible()
        control.click(trial=True)
    if size.open != "left right":
        # One at a time; and what lies over the board goes when the board is wanted.
        expect(page.locator("[data-dock-region=left]")).to_be_hidden()
    if not size.open:
        page.mouse.click(room["x"] + 20, room["y"] + 20)
        expect(page.locator("[data-dock-region=right]")).to_be_hidden()
    page.set_viewport_size(VIEWPORT)


@pytest.mark.parametrize("name", ["a laptop", "full HD"])
def test_type_and_targets_are_large_enough_and_grow_with_the_window(
    shared: Shared, name: str
) -> None:
    page, size = shared.screen.page, SIZES[name]
    resize(page, size)
    scale = min(size.width / 1366, size.height / 768)
    for tab in ("Run", "Steer", "Now"):
        shared.screen.turn_to(tab)
    assert page.evaluate(SMALL_TYPE, ["[data-dock-region]", 13 * scale]) == []
    assert page.evaluate(SMALL_TYPE, ["#pounce-stage", 13 * scale]) == []
    for control in page.locator("[role=slider], input[type=checkbox], [data-dock-tab]").all():
        box = control.bounding_box()
        assert box is None or min(box["width"], box["height"]) >= 24 * scale - 0.5
    page.set_viewport_size(VIEWPORT)


def test_a_presentation_has_the_stage_alone_in_large_type(shared: Shared) -> None:
    live, (_, screen) = shared.live, shared
    page = screen.page
    resize(page, SIZES["a laptop"])
    before = side_of(page)
    page.keyboard.press("p")
    expect(page.locator("[data-dock-region=left]")).to_be_hidden()
    settle(page)
    assert side_of(page) > 1.2 * before
    for slot in ("task", "sentence", "readings", "legend", "bar"):
        expect(page.locator(f"[data-slot-of={slot}]")).to_be_in_viewport()
    expect(page.locator("iframe.pounce-time")).to_be_in_viewport(ratio=0.98)
    assert page.evaluate(SMALL_TYPE, ["#pounce-stage", 18]) == []
    # Keys act as ever.
    trial = live.session.status.snapshot.trial
    page.keyboard.press("t")
    live.wait_for(lambda status: status.snapshot.trial == trial + 1)
    button_of_stage(page, "Play").click()
    live.wait_for(lambda status: status.playing)
    button_of_stage(page, "Pause").click()
    live.wait_for(lambda status: not status.playing)
    page.keyboard.press("Escape")
    expect(page.locator("[data-dock-region=left]")).to_be_visible()
    assert side_of(page) == pytest.approx(before, rel=0.01)
    button_of_stage(page, "Present").click()
    expect(page.locator("[data-dock-region=left]")).to_be_hidden()
    button_of_stage(page, "Exit").click()
    expect(page.locator("[data-dock-region=left]")).to_be_visible()


def test_a_drag_moves_the_board_and_nothing_tilts_it(shared: Shared) -> None:
    page = shared.screen.page
    resize(page, SIZES["a laptop"])
    home, up = page.evaluate(CORNERS), page.evaluate(UP)
    reset = button_of_stage(page, "Reset view")
    expect(reset).to_be_hidden()
    (left, bottom), (right, top) = home
    page.mouse.move((left + right) / 2, (top + bottom) / 2)
    page.mouse.down()
    page.mouse.move((left + right) / 2 + 60, (top + bottom) / 2 + 30, steps=4)
    page.mouse.up()
    expect(reset).to_be_visible()
    settle(page)
    moved = page.evaluate(CORNERS)
    assert moved == [pytest.approx([x + 60, y + 30], abs=2) for x, y in home]
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowUp")
    # What a person has zoomed stays so in another window.
    page.mouse.wheel(0, -400)
    page.wait_for_function(
        f"side => ({CORNERS})()[1][0] - ({CORNERS})()[0][0] > side", arg=1.1 * (right - left)
    )
    zoom = side_of(page) / (right - left)
    fitted = {}
    for size in ("a projector", "a laptop"):
        resize(page, SIZES[size])
        fitted[size] = side_of(page)
    assert fitted["a laptop"] == pytest.approx(zoom * (right - left), rel=0.01)
    assert page.evaluate(UP) == pytest.approx(up, abs=1e-6)
    reset.click()
    expect(reset).to_be_hidden()
    settle(page)
    assert page.evaluate(CORNERS) == [pytest.approx(corner, abs=1) for corner in home]


def test_the_board_grows_at_once_as_panels_fold(shared: Shared) -> None:
    page = shared.screen.page
    resize(page, SIZES["a laptop"])
    sides = [side_of(page)]
    for edge in ("left", "right"):
        page.locator(f"[data-dock-region={edge}] [data-dock-region-collapse]").click()
        expect(page.locator(f"[data-dock-region={edge}]")).to_be_hidden()
        sides.append(side_of(page))
    assert sides[0] * 1.1 < sides[1] < sides[2]
    # What the folded panels said is said beside the board, and goes on being told.
    live = shared.live
    trial = live.session.status.snapshot.trial
    page.keyboard.press("t")
    expect(page.locator("[data-slot-of=readings]")).to_contain_text(f"{trial + 1:,}")
    expect(page.locator("[data-slot-of=legend]")).to_be_in_viewport()
    for tab in ("Now", "Run"):
        button_of_stage(page, tab).click()
    assert side_of(page) == pytest.approx(sides[0], rel=0.01)


def test_the_page_is_dark_where_the_browser_asks_for_it_until_somebody_chooses(
    begin: Begin,
) -> None:
    live, screen = begin()
    page = screen.page
    scheme: Any = "([name]) => document.documentElement.dataset.mantineColorScheme === name"
    # As a browser in which nobody has chosen yet.
    page.evaluate("localStorage.removeItem('pounce-scheme')")
    page.emulate_media(color_scheme="dark")
    page.reload()
    screen.settle(live)
    page.wait_for_function(scheme, arg=["dark"])
    screen.expect_cell_colours(live.colours(Look(theme=DARK)))
    expect(screen.text("Software WebGL")).to_be_hidden()
    screen.turn_to_overlays()
    expect(screen.checkbox("Dark")).to_be_checked()
    screen.check("Dark", False)
    page.wait_for_function("() => localStorage.getItem('pounce-scheme') === 'light'")
    page.reload()
    screen.settle(live)
    page.wait_for_function(scheme, arg=["light"])
    screen.expect_cell_colours(live.colours(Look(theme=LIGHT)))
    page.emulate_media(color_scheme="light")


def test_a_page_at_rest_does_nothing_by_itself(begin: Begin) -> None:
    _, screen = begin()
    done: dict[str, list[str]] = screen.page.evaluate(DONE_AT_REST)
    # What is done after a change is no change, after which it would be done for ever.
    assert done["changes"] == []
    # A page that asks for frames is drawn, and drawing is dear where it is done in software.
    assert done["frames"] == []
