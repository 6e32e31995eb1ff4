"""Inspection in one browser: the panel about a cell, and what it draws on the board.

What a person asks for waits for the next moment that this browser is shown, and is about that.
Everything is drawn in the world's own orientation, as the board is: a folded picture is that of a
prey facing east.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import viser

from app.explain.cell import HuntShown, hunts_from, moment_of, reading_at
from app.explain.cell_html import hunts_html, nothing_chosen_html, reading_html
from app.explain.chain import Chain, chain_html, chain_of
from app.live.snapshot import Snapshot
from app.page.inbox import Intent
from app.page.scene.parts import AWAY, Viewer, in_linear_light
from app.page.widgets import CALM, Choice, assign
from app.picture.frames import folds
from app.picture.look import Look, heading_shown
from app.picture.outlines import BOARD_UNITS, kept_on_board, on_picture, segments
from app.picture.theme import Colour, Theme
from app.words.plain import HEADING_NAMES
from learners import hunts
from sim.geometry import HEADINGS
from sim.spec import WorldSpec
from sim.world import World, board_xy

RING_HUNTS = 16
_REQUESTS_KEPT = 32
"""Requests between two updates beyond these are dropped, the oldest first."""
_AS_SHOWN = -1
"""In the place of a heading."""
_FACINGS = {
    "as on the board": _AS_SHOWN,
    **{name: heading for heading, name in enumerate(HEADING_NAMES)},
}

_NO_LINE = np.full((1, 2, 3), AWAY, np.float32)
"""A handle must have something to draw."""
_RIM_DEPTH = 0.001
"""How far below its line a rim lies."""
_Z_HUNTS, _Z_CHAIN, _Z_ENDS, _Z_CELL = 0.031, 0.036, 0.038, 0.045
_MARK_UNITS = 0.11
"""Half the side of the mark of a cell, where the cell itself would be too small to see."""
_END_RADIUS = 0.07
_DASH_UNITS = 0.3
"""Of a dashed line."""
_DRAWN = 2_000
"""Cells of a hunt's way that are drawn; one that takes longer goes in circles by then."""

_Request = Callable[[Snapshot, Look], None]


def cell_under(place: tuple[float, float], size: int) -> tuple[int, int] | None:
    """Grid coordinates of the cell at a place, None off the board.

    Args:
        place: east and north of the prey, in board units.
        size: cells along each side of the grid.
    """
    x, y = (math.floor(part * size / BOARD_UNITS + 0.5) + size // 2 for part in place)
    return (x, y) if 0 <= x < size and 0 <= y < size else None


def board_points(world: World, cells: Sequence[int] | np.ndarray, z: float) -> np.ndarray:
    """Centres of cells, ``(n, 3) float32`` in board units."""
    flat = on_picture(world, np.asarray(cells, np.int64), heading=0, shown=0)
    return np.column_stack([flat, np.full(len(flat), z)]).astype(np.float32)


def ring_radius(spec: WorldSpec, chosen: tuple[int, int] | None) -> float:
    """Radius of a ring of hunts in cells: through the chosen cell, or through the start zone."""
    nearest, farthest = (radius * spec.scale for radius in spec.start_radius)
    if chosen is None:
        return (nearest + farthest) / 2
    middle = spec.size // 2
    return max(math.hypot(chosen[0] - middle, chosen[1] - middle), 1.0)


def _nudge_html(clicks: int) -> str:
    """Has the page's script (``app/web/tabs.js``) turn to the tab when there is one click more."""
    return f'<div hidden data-open-tab="Inspect" data-times="{clicks}"></div>'


class _Strokes:
    """Lines of one kind on a board, each in its colour and with a rim that sets it off."""

    def __init__(self, scene: viser.SceneApi, name: str, pixels: float) -> None:
        self._rim, self._line = (
            scene.add_line_segments(
                f"/inspect/{name}/{part}",
                _NO_LINE,
                np.zeros(_NO_LINE.shape, np.uint8),
                thickness=thickness,
                thickness_units="screen",
            )
            for part, thickness in [("rim", pixels + 2.5), ("line", pixels)]
        )

    def show(self, lines: Sequence[np.ndarray], colours: Sequence[Colour], rim: Colour) -> None:
        """Draw lines ``(n, 2, 3)``, each in its colour; sends nothing if they are drawn already."""
        points = np.concatenate([_NO_LINE, *lines]).astype(np.float32)
        inks = [
            np.broadcast_to(in_linear_light(colour), line.shape)
            for line, colour in zip(lines, colours, strict=True)
        ]
        _place(self._line, points, np.concatenate([np.zeros(_NO_LINE.shape, np.uint8), *inks]))
        under = points - np.array([0.0, 0.0, _RIM_DEPTH], np.float32)
        _place(self._rim, under, np.broadcast_to(in_linear_light(rim), points.shape))


def _place(handle: Any, points: np.ndarray, colors: np.ndarray) -> None:
    """Give a handle other points and colours, if they are others."""
    if not (np.array_equal(handle.points, points) and np.array_equal(handle.colors, colors)):
        handle.points = points
        handle.colors = colors


class _Overlay:
    """What inspection draws on one board: create, show, remove."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._hunts = _Strokes(scene, "hunts", 3.5)
        self._facing = _Strokes(scene, "facing", 2.5)
        self._chain = _Strokes(scene, "chain", 2.5)
        self._cell = _Strokes(scene, "cell", 3.0)
        self._ends = scene.add_point_cloud(
            "/inspect/ends",
            points=_NO_LINE[0, :1],
            colors=np.zeros((1, 3), np.uint8),
            point_size=_END_RADIUS,
            point_shape="circle",
            point_shading="flat",
            precision="float32",
        )

    def show_cell(self, world: World, chosen: tuple[int, int] | None, theme: Theme) -> None:
        """Mark a cell."""
        marks = [] if chosen is None else [_square(world, chosen)]
        self._cell.show(marks, [theme.ink] * len(marks), theme.unknown)

    def show_chain(self, world: World, chain: Chain | None, theme: Theme) -> None:
        """Draw the way of a chain, dashed, so that a hunt on the same way is seen as well."""
        ways = [] if chain is None else [_dashed(world, chain.cells)]
        self._chain.show(ways, [theme.ink] * len(ways), theme.unknown)

    def show_hunts(
        self, snapshot: Snapshot, hunts: Sequence[HuntShown], heading: int, look: Look
    ) -> None:
        """Draw hunts' ways, their ends, and the heading of those that differ from the picture's."""

        def kept(cells: Sequence[int] | np.ndarray, z: float) -> np.ndarray:
            # A corner of the grid lies outside of a board of all headings, which is round.
            points = board_points(snapshot.world, cells, z)
            points[:, :2] = kept_on_board(points[:, :2], snapshot.spec.world, folds(look))
            return points

        theme = look.theme
        colours = [theme.of_outcome(shown.hunt.outcome) for shown in hunts]
        ways = [kept(shown.hunt.cells[:_DRAWN], _Z_HUNTS) for shown in hunts]
        self._hunts.show([segments(way) for way in ways], colours, theme.unknown)
        others = sorted({shown.heading for shown in hunts} - {heading})
        self._facing.show(
            [_arrow(other) for other in others], [theme.prey] * len(others), theme.unknown
        )
        ends = kept([shown.hunt.cells[-1] for shown in hunts], _Z_ENDS)
        _place(
            self._ends,
            np.concatenate([_NO_LINE[0, :1], ends]),
            np.array([(0, 0, 0), *colours], np.uint8),
        )


def _dashed(world: World, cells: Sequence[int]) -> np.ndarray:
    """Segments ``(n, 2, 3)`` of a way: as many on as off, and those at its end on."""
    lines = segments(board_points(world, cells, _Z_CHAIN))
    every = max(round(_DASH_UNITS * world.size / BOARD_UNITS), 1)
    return lines[np.arange(len(lines))[::-1] // every % 2 == 0]


def _square(world: World, cell: tuple[int, int]) -> np.ndarray:
    """Mark of a cell, ``(4, 2, 3)``: its outline, or one that is large enough to be seen."""
    unit = BOARD_UNITS / world.size
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
    flat = (np.array(cell) - world.size // 2) * unit + max(unit / 2, _MARK_UNITS) * corners
    return segments(np.column_stack([flat, np.full(len(flat), _Z_CELL)]))


def _arrow(heading: int) -> np.ndarray:
    """Where the prey faces, from its cell, ``(3, 2, 3)``; longer than the board's own arrow."""
    east, north = HEADINGS[heading] / np.hypot(*HEADINGS[heading])
    turn = np.array([[east, north], [-north, east]])
    flat = np.array([[0.15, 0.0], [0.9, 0.0], [0.72, 0.13], [0.9, 0.0], [0.72, -0.13]]) @ turn
    points = np.column_stack([flat, np.full(len(flat), _Z_CHAIN)]).astype(np.float32)
    return np.stack([points[[0, 1]], points[[2, 3]], points[[3, 4]]])


class Inspection:
    """The inspection of one browser."""

    def __init__(
        self, client: Viewer, container: Any, wake: Callable[[], None] = lambda: None
    ) -> None:
        """Build the panel and the overlays, all empty.

        Args:
            client: the browser.
            container: a tab or folder of this browser.
            wake: called after each request, so that the render loop need not be waited for.
        """
        self._client = client
        self._wake = wake
        self._requests: deque[_Request] = deque(maxlen=_REQUESTS_KEPT)
        self._chosen: tuple[int, int] | None = None
        self._why = False
        self._hunts: deque[HuntShown] = deque(maxlen=RING_HUNTS)
        self._hunts_made = 0
        self._run: tuple[int, int] | None = None
        self._success: np.ndarray | None = None
        self._cell_key: tuple[object, ...] | None = None
        self._hunts_key: tuple[object, ...] | None = None
        self._clicks = 0
        """On cells so far."""
        self._overlay = _Overlay(client.scene)
        # Outside of the tab, which is there only while it is turned to.
        self._nudge = client.gui.add_html(_nudge_html(0))
        self._build(client.gui, container)

    def take_click(self, place: tuple[float, float], shift: bool) -> None:
        """Inspect the cell at a place; with shift hunt from it, the prey as in the picture.

        Args:
            place: east and north of the prey, in board units.
            shift: whether the key was held.
        """
        self._ask(partial(self._clicked, place, shift))

    def look_into(self, cell: tuple[int, int] | None) -> None:
        """Inspect a cell and say why it has its value; None for none, and nothing more of it."""
        self._ask(partial(self._looked_into, cell))

    def update(self, snapshot: Snapshot, look: Look, success: np.ndarray | None = None) -> None:
        """Carry out what was asked for and show what has changed; the render loop calls this.

        Args:
            snapshot: the moment.
            look: how this browser wants to see the board.
            success: outcomes from each cell, ``(heading, y, x)``, if there is a map of them.
        """
        self._start_over_with_another_run(snapshot)
        while self._requests:
            self._requests.popleft()(snapshot, look)
        heading = heading_shown(look, snapshot.heading)
        self._show_cell(snapshot, heading, look, success)
        self._show_hunts(snapshot, heading, look)

    def _build(self, gui: viser.GuiApi, container: Any) -> None:
        with container:
            self._reading = gui.add_html(nothing_chosen_html())
            self._prey_faces = Choice(
                gui,
                "Prey faces",
                _FACINGS,
                hint="Where the prey looks in the hunts that you ask for here",
            )
            self._here = gui.add_button(
                "Hunt here",
                icon=viser.Icon.TARGET_ARROW,
                color=CALM,
                hint="One hunt from the chosen cell, without random moves and without learning",
                disabled=True,
            )
            ring = gui.add_button(
                "Sixteen hunts from a ring",
                icon=viser.Icon.CIRCLE_DOTTED,
                color=CALM,
                hint="Hunts from all round the prey, as far off as the chosen cell",
            )
            clear = gui.add_button("Clear", icon=viser.Icon.ERASER, color=CALM)
            self._results = gui.add_html("")
            self._explained = gui.add_checkbox(
                "Why this value?", False, hint="Follow the best moves to the reward it comes from"
            )
            self._reasons = gui.add_html("")
        self._explained.on_update(Intent(lambda _, on: self._ask(partial(self._explain, on))))
        self._here.on_click(Intent(lambda _, __: self._ask(self._hunt_here)))
        ring.on_click(Intent(lambda _, __: self._ask(self._hunt_ring)))
        clear.on_click(Intent(lambda _, __: self._ask(self._clear)))

    def _ask(self, request: _Request) -> None:
        self._requests.append(request)
        self._wake()

    def _clicked(
        self, place: tuple[float, float], shift: bool, snapshot: Snapshot, look: Look
    ) -> None:
        cell = cell_under(place, snapshot.world.size)
        if cell is None:
            return
        self._chosen = cell
        self._clicks += 1
        if shift:
            self._hunt([cell], heading_shown(look, snapshot.heading), snapshot)

    def _hunt_here(self, snapshot: Snapshot, look: Look) -> None:
        if self._chosen is not None:
            self._hunt([self._chosen], self._heading_asked(snapshot, look), snapshot)

    def _hunt_ring(self, snapshot: Snapshot, look: Look) -> None:
        world = snapshot.world
        radius = ring_radius(snapshot.spec.world, self._chosen)
        cells = hunts.ring_of_starts(world, radius, RING_HUNTS)
        starts = [board_xy(world, cell) for cell in cells]
        self._hunt(starts, self._heading_asked(snapshot, look), snapshot)

    def _explain(self, on: bool, *_: object) -> None:
        self._why = on

    def _looked_into(self, cell: tuple[int, int] | None, *_: object) -> None:
        self._chosen, self._why = cell, cell is not None
        assign(self._explained, "value", self._why)

    def _clear(self, *_: object) -> None:
        self._chosen = None
        self._hunts.clear()

    def _heading_asked(self, snapshot: Snapshot, look: Look) -> int:
        asked = self._prey_faces.chosen
        return heading_shown(look, snapshot.heading) if asked == _AS_SHOWN else asked

    def _hunt(self, starts: Sequence[tuple[int, int]], heading: int, snapshot: Snapshot) -> None:
        self._hunts.extend(hunts_from(snapshot, starts, heading, self._hunts_made))
        self._hunts_made += len(starts)

    def _start_over_with_another_run(self, snapshot: Snapshot) -> None:
        """Hunts of a run that is over, and a cell of another grid, mean nothing any more."""
        generation, size = self._run or (snapshot.generation, snapshot.world.size)
        if generation != snapshot.generation:
            self._hunts.clear()
        if size != snapshot.world.size:
            self._chosen = None
        self._run = (snapshot.generation, snapshot.world.size)

    def _show_cell(
        self, snapshot: Snapshot, heading: int, look: Look, success: np.ndarray | None
    ) -> None:
        """Show what is known of the chosen cell, and why; sends nothing if nothing has changed."""
        chosen, why, theme = self._chosen, self._why, look.theme
        key: tuple[object, ...] = (chosen, self._clicks, why, look)
        if chosen is not None:
            key = (*key, moment_of(snapshot), heading, id(success))
        if key == self._cell_key:
            return
        self._cell_key = key
        # Kept, because a key with its id would mean nothing once it were gone.
        self._success = success
        reading, reasons, chain = nothing_chosen_html(), "", None
        if chosen is not None:
            reading = reading_html(reading_at(snapshot, *chosen, heading, success), look)
            if why:
                chain = chain_of(snapshot, *chosen, heading)
                reasons = chain_html(chain)
        with self._client.atomic():
            assign(self._nudge, "content", _nudge_html(self._clicks))
            assign(self._reading, "content", reading)
            assign(self._reasons, "content", reasons)
            assign(self._here, "disabled", chosen is None)
            self._overlay.show_cell(snapshot.world, chosen, theme)
            self._overlay.show_chain(snapshot.world, chain, theme)

    def _show_hunts(self, snapshot: Snapshot, heading: int, look: Look) -> None:
        """Show the hunts; sends nothing if nothing has changed."""
        hunts, theme = tuple(self._hunts), look.theme
        key = (self._hunts_made, heading, folds(look), theme) if hunts else (theme,)
        if key == self._hunts_key:
            return
        self._hunts_key = key
        results = hunts_html(hunts, theme) if hunts else ""
        with self._client.atomic():
            assign(self._results, "content", results)
            self._overlay.show_hunts(snapshot, hunts, heading, look)
