"""The board in one browser: the picture of a layer, the prey, hunts, overlays.

One class, ``create -> update(moment) -> remove``. Handles are made once and their properties
assigned afterwards; only the render loop calls it.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import viser

from app.live.snapshot import Snapshot
from app.page.scene.hunt import HuntView
from app.page.scene.names import HEIGHT, BoardNames
from app.page.scene.parts import AWAY, OF_PARTS, Parts, in_linear_light
from app.page.widgets import assign
from app.picture import outlines
from app.picture.contours import Contour
from app.picture.frames import folds
from app.picture.layer import Picture
from app.picture.layers import LAYERS
from app.picture.look import ALL, OF_TRIAL, Look, heading_shown
from app.picture.multiples import SHARE, SIDE, TILES, tile_at
from app.picture.outlines import BOARD_UNITS, cell_centres, lifted
from app.player.names import middles
from sim.spec import WorldSpec

FLAT_TARGET = (0.0, 0.0, 0.0)
FLAT_CAMERA = (0.0, 0.0, 10.8)
"""The whole board from above; each page moves its camera to where the board fits its window."""

_PREY_RADIUS = 0.13
_TILE_HEIGHT = 0.29
"""Of the name above each of all headings."""
_TILE_ARROW = 2.0
"""How much longer the prey's arrow is in a tile, where it would be a dot."""
_FARTHEST = 1e6
"""Board units from the prey at which nothing is looked for any more."""
_LINES_EVERY_S = 1.0

# Heights above the board, so that what matters lies on top.
_Z_LINES, _Z_FIELD, _Z_PREY = 0.01, 0.02, 0.04


class BoardView(Parts):
    """What one browser sees of the board."""

    def __init__(self, scene: viser.SceneApi, snapshot: Snapshot, look: Look) -> None:
        super().__init__(scene, "board")
        self._spec = snapshot.spec.world
        self._look: Look = look
        self._create()

    def _create(self) -> None:
        spec, theme = self._spec, self._look.theme
        self._lines_at = float("-inf")
        is_apart, is_round = self._look.frame == ALL, folds(self._look)
        centres = outlines.tile_pixels(spec) if is_apart else cell_centres(spec)
        if is_round:
            centres[~outlines.is_on_board(centres[:, :2], spec, is_round)] = AWAY
        side = SHARE / SIDE if is_apart else 1 / spec.size
        empty = np.broadcast_to(np.array(theme.unknown, np.uint8), centres.shape).copy()
        self._sent["cells"] = (centres, empty)
        self._cells = self._keep(
            self._scene.add_point_cloud(
                "/board/cells",
                points=centres,
                colors=empty,
                point_size=BOARD_UNITS * side / 2,
                point_shading="flat",
                precision="float32",
            )
        )
        self._border = self._line("border", theme.border, 2.0)
        self._grid = self._line("grid", theme.lines, 1.0)
        self._sensors = self._line("sensors", theme.border, 1.0)
        self._zone = self._line("start_zone", theme.zone, 2.0)
        self._field = self._line("field", theme.field, 3.0)
        self._arrow = self._line("heading", theme.prey, 4.0)
        self._flow = self._line("flow", OF_PARTS, 4.0)
        self._contours = self._line("contours", OF_PARTS, 1.0)
        self._edges = self._line("edges", OF_PARTS, 2.5)
        self._prey = self._dots("prey", theme.prey, _PREY_RADIUS * (0.5 if is_apart else 1))
        self._hunts: HuntView = self._keep(HuntView(self._scene, theme))
        self._names = self._keep(BoardNames(self._scene, _TILE_HEIGHT if is_apart else HEIGHT))
        border = outlines.tiles_border(spec) if is_apart else outlines.border(spec, is_round)
        self._set(self._border, "border", lifted(border, _Z_FIELD))
        self._set(self._grid, "grid", lifted(outlines.grid(spec, is_round), _Z_LINES))

    def update(
        self,
        snapshot: Snapshot,
        picture: Picture,
        look: Look,
        now_s: float,
        rests: bool = False,
        named: bool = False,
    ) -> None:
        """Show a moment.

        Args:
            snapshot: the moment.
            picture: what the look's layer makes of it.
            look: how this browser wants to see it.
            now_s: a clock, for what is drawn less often.
            rests: whether the learner stands still.
            named: whether there are names on prey and predator.
        """
        if _form(snapshot.spec.world, look) != _form(self._spec, self._look):
            self.remove()
            self._spec, self._look = snapshot.spec.world, look
            self._create()
        changed = look != self._look or snapshot.spec.world != self._spec
        self._spec, self._look = snapshot.spec.world, look
        self._show_cells(picture)
        if changed or now_s - self._lines_at >= _LINES_EVERY_S or look.frame == OF_TRIAL:
            self._show_overlays(snapshot, picture)
            self._lines_at = now_s
        # A hunt has one heading.
        of_hunts = look._replace(hunts=False) if look.frame == ALL else look
        self._hunts.update(snapshot, of_hunts, now_s, rests, named, changed)

    def place_under(
        self, origin: tuple[float, float, float], direction: tuple[float, float, float]
    ) -> tuple[float, float] | None:
        """East and north of where a ray meets the board as it is drawn, None if it does not.

        Args:
            origin: of the ray, in board units.
            direction: of the ray, of any length.
        """
        start, along = np.array(origin, float), np.array(direction, float)
        with np.errstate(all="ignore"):
            met = start - start[2] / along[2] * along
        # What a page sends may be anything; no comparison holds for what is not a number.
        if not (along[2] < 0 <= start[2] and (np.abs(met) < _FARTHEST).all()):
            return None
        if not outlines.is_on_board(met[:2], self._spec, folds(self._look)):
            return None
        return float(met[0]), float(met[1])

    def heading_under(
        self, origin: tuple[float, float, float], direction: tuple[float, float, float]
    ) -> int | None:
        """The heading whose picture a ray meets, where all are side by side; None otherwise."""
        place = self.place_under(origin, direction) if self._look.frame == ALL else None
        tile = tile_at(*(np.array(place) / BOARD_UNITS).tolist()) if place else None
        return None if tile is None else tile.heading

    def _show_cells(self, picture: Picture) -> None:
        points, colours = self._sent["cells"]
        if not np.array_equal(colours, picture.colours):
            self._cells.colors = picture.colours
            self._sent["cells"] = (points, picture.colours)

    def _show_overlays(self, snapshot: Snapshot, picture: Picture) -> None:
        look, spec = self._look, self._spec
        shown, is_round = heading_shown(look, snapshot.heading), folds(look)
        is_whole = look.frame != ALL
        assign(self._grid, "visible", look.grid and is_whole)
        assign(self._sensors, "visible", look.sensors and is_whole)
        assign(self._zone, "visible", look.start_zone and is_whole)
        turns = "frame" in LAYERS[look.layer].heeds_of(snapshot.spec.learner, look.option)
        assign(self._field, "visible", look.field and turns)
        assign(self._arrow, "visible", turns)
        if look.sensors:
            lines = outlines.sensors(_as_shown(spec, look), is_round)
            self._set(self._sensors, "sensors", lifted(lines, _Z_LINES))
        if look.start_zone:
            self._set(self._zone, "zone", lifted(outlines.start_zone(spec), _Z_FIELD))
        field = self._of_each(partial(outlines.visual_field, spec), shown)
        self._set(self._field, "field", lifted(field, _Z_FIELD))
        longer = _TILE_ARROW if look.frame == ALL else 1.0
        arrow = self._of_each(lambda heading: outlines.arrow(heading) * longer, shown)
        self._set(self._arrow, "arrow", lifted(arrow, _Z_PREY))
        prey = self._of_each(lambda _: np.zeros((1, 2)), shown)
        self._set(self._prey, "prey", lifted(prey, _Z_PREY))
        self._show_arrows(picture)
        over = picture.over()
        self._show_contours(over.contours)
        self._names.show((*middles(picture), *over.labels), spec.size)

    def _of_each(self, outline: Callable[[int], np.ndarray], shown: int) -> np.ndarray:
        """Points ``(..., 2)`` drawn for a heading: the one that is shown, or each in its place."""
        if self._look.frame != ALL:
            return outline(shown)
        return np.concatenate([tile.place(outline(tile.heading), BOARD_UNITS) for tile in TILES])

    def _show_arrows(self, picture: Picture) -> None:
        lines, there = outlines.arrow_lines(picture, self._spec, folds(self._look))
        inks = picture.arrow_colours
        if inks is None:
            inks = np.broadcast_to(np.array(self._look.theme.ink), (len(there), 3))
        # An arrow is three lines, each with two ends.
        colours = np.repeat(np.tile(in_linear_light(inks[there]), (3, 1))[:, None], 2, axis=1)
        self._set(self._flow, "flow", lifted(lines, _Z_FIELD), colours)

    def _show_contours(self, contours: Sequence[Contour]) -> None:
        for handle, name, is_edge in (
            (self._contours, "contours", False),
            (self._edges, "edges", True),
        ):
            lines = [line for line in contours if line.is_edge == is_edge]
            parts, colours = outlines.contour_lines(lines, self._spec, folds(self._look))
            self._set(handle, name, lifted(parts, _Z_LINES), in_linear_light(colours))


def _form(spec: WorldSpec, look: Look) -> tuple[object, ...]:
    """What is given to the parts of a board when they are made, and does not change."""
    return spec.size, look.theme, folds(look), look.frame == ALL


def _as_shown(spec: WorldSpec, look: Look) -> WorldSpec:
    """The world as it is seen by whom the layer is about: by a skill, or by the selection."""
    return spec.of_skills if LAYERS[look.layer].about == "skill" else spec
