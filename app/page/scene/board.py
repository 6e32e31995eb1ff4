"""The board in one browser: the picture of a layer, the prey, hunts, overlays.

One class, ``create -> update(moment) -> remove``. Handles are made once and their properties
assigned afterwards; only the render loop calls it.
"""

import numpy as np
import viser

from app.live.snapshot import Snapshot
from app.page.scene import outlines
from app.page.scene.hunt import HuntView
from app.page.scene.names import BoardNames
from app.page.scene.outlines import BOARD_UNITS, cell_centres, lifted
from app.page.scene.parts import Parts, in_linear_light
from app.page.widgets import assign
from app.picture.layer import Picture
from app.picture.layers import LAYERS
from app.picture.look import OF_TRIAL, Look, heading_shown
from sim.spec import WorldSpec

FLAT_TARGET = (0.0, 0.0, 0.0)
FLAT_CAMERA = (0.0, 0.0, 10.8)
"""The whole board from above; each page moves its camera to where the board fits its window."""

_PREY_RADIUS = 0.13
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
        centres = cell_centres(spec)
        empty = np.broadcast_to(np.array(theme.unknown, np.uint8), centres.shape).copy()
        self._sent["cells"] = (centres, empty)
        self._cells = self._keep(
            self._scene.add_point_cloud(
                "/board/cells",
                points=centres,
                colors=empty,
                point_size=BOARD_UNITS / spec.size / 2,
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
        # Each arrow has a colour of its own; a line that starts with one takes no others.
        self._flow = self._line("flow", np.zeros((1, 2, 3), np.uint8), 4.0)
        self._prey = self._dots("prey", theme.prey, _PREY_RADIUS)
        self._hunts: HuntView = self._keep(HuntView(self._scene, theme))
        self._names = self._keep(BoardNames(self._scene))
        self._set(self._border, "border", lifted(outlines.border(spec), _Z_LINES))
        self._set(self._grid, "grid", lifted(outlines.grid(spec), _Z_LINES))

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
        if snapshot.spec.world.size != self._spec.size or look.theme != self._look.theme:
            self.remove()
            self._spec, self._look = snapshot.spec.world, look
            self._create()
        changed = look != self._look or snapshot.spec.world != self._spec
        self._spec, self._look = snapshot.spec.world, look
        self._show_cells(picture)
        if changed or now_s - self._lines_at >= _LINES_EVERY_S or look.frame == OF_TRIAL:
            self._show_overlays(snapshot, picture)
            self._lines_at = now_s
        self._hunts.update(snapshot, look, now_s, rests, named, changed)

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
        return float(met[0]), float(met[1])

    def _show_cells(self, picture: Picture) -> None:
        points, colours = self._sent["cells"]
        if not np.array_equal(colours, picture.colours):
            self._cells.colors = picture.colours
            self._sent["cells"] = (points, picture.colours)

    def _show_overlays(self, snapshot: Snapshot, picture: Picture) -> None:
        look, spec = self._look, self._spec
        shown = heading_shown(look, snapshot.heading)
        assign(self._grid, "visible", look.grid)
        assign(self._sensors, "visible", look.sensors)
        assign(self._zone, "visible", look.start_zone)
        turns = LAYERS[look.layer].turns
        assign(self._field, "visible", look.field and turns)
        assign(self._arrow, "visible", turns)
        if look.sensors:
            lines = outlines.sensors(_as_shown(spec, look))
            self._set(self._sensors, "sensors", lifted(lines, _Z_LINES))
        if look.start_zone:
            self._set(self._zone, "zone", lifted(outlines.start_zone(spec), _Z_FIELD))
        self._set(self._field, "field", lifted(outlines.visual_field(spec, shown), _Z_FIELD))
        self._set(self._arrow, "arrow", lifted(outlines.arrow(shown), _Z_PREY))
        self._set(self._prey, "prey", lifted(np.zeros((1, 2)), _Z_PREY))
        self._show_arrows(picture)
        self._names.show(picture, spec.size)

    def _show_arrows(self, picture: Picture) -> None:
        lines = lifted(outlines.arrow_lines(picture, self._spec), _Z_FIELD)
        inks = picture.arrow_colours
        if inks is None:
            inks = np.broadcast_to(np.array(self._look.theme.ink), (len(lines) // 3, 3))
        colours = np.repeat(np.tile(in_linear_light(inks), (3, 1))[:, None], 2, axis=1)
        self._set(self._flow, "flow", lines, colours)


def _as_shown(spec: WorldSpec, look: Look) -> WorldSpec:
    """The world as it is seen by whom the layer is about: by a skill, or by the selection."""
    return spec.of_skills if LAYERS[look.layer].about == "skill" else spec
