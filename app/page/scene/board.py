"""The board in one browser: the picture of a layer, prey, predator, trail, flashes, overlays.

One class, ``create -> update(moment) -> remove``. Handles are made once and their properties
assigned afterwards; only the render loop calls it.
"""

from typing import Any

import numpy as np
import viser

from app.live.snapshot import Snapshot, TrialEnd
from app.page.scene import outlines
from app.page.scene.names import BoardNames
from app.page.scene.outlines import BOARD_UNITS, cell_centres, lifted, on_picture
from app.page.widgets import assign
from app.picture.colours import to_linear
from app.picture.layer import Picture
from app.picture.layers import LAYERS
from app.picture.look import OF_TRIAL, Look, heading_shown
from app.picture.theme import OUTCOME_SHAPES, Colour, Shape, Theme
from sim.spec import WorldSpec

FLAT_TARGET = (0.0, 0.0, 0.0)
FLAT_CAMERA = (0.0, 0.0, 10.8)
"""The whole board from above; each page moves its camera to where the board fits its window."""

_PREY_RADIUS, _PREDATOR_RADIUS, _HALO_RADIUS = 0.13, 0.13, 0.17
_FARTHEST = 1e6
"""Board units from the prey at which nothing is looked for any more."""
AWAY = (0.0, 0.0, -50.0)
"""Where things are kept that are not to be seen."""
_FLASH_S = 0.7
_FLASH_RADIUS = 0.1
_TRAIL_SEGMENTS = 120
_PATH_POINTS = 60
_PATHS_EVERY_S = 1.0
_LINES_EVERY_S = 1.0

# Heights above the board, so that what matters lies on top.
_Z_LINES, _Z_FIELD, _Z_TRAIL, _Z_FLASH, _Z_PREY, _Z_PREDATOR = 0.01, 0.02, 0.03, 0.035, 0.04, 0.05


class BoardView:
    """What one browser sees of the board."""

    def __init__(self, scene: viser.SceneApi, snapshot: Snapshot, look: Look) -> None:
        self._scene = scene
        self._spec = snapshot.spec.world
        self._look: Look = look
        self._flashes: dict[int, tuple[TrialEnd, float]] = {}
        self._last_end = (snapshot.generation, snapshot.trial - 1)
        self._handles: list[Any] = []
        self._create()

    def _create(self) -> None:
        spec, theme = self._spec, self._look.theme
        self._lines_at = self._paths_at = float("-inf")
        centres = cell_centres(spec)
        empty = np.broadcast_to(np.array(theme.unknown, np.uint8), centres.shape).copy()
        self._sent: dict[str, Any] = {"cells": (centres, empty)}
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
        self._flow = self._line("flow", theme.ink, 2.0)
        # Each part of these has a colour of its own; a line that starts with one takes no others.
        of_parts = np.zeros((1, 2, 3), np.uint8)
        self._paths = self._line("paths", of_parts, 2.0)
        self._trail = self._line("trail", of_parts, 3.0)
        self._rims = self._dots("rims", theme.unknown, _FLASH_RADIUS * 1.5)
        self._flash = {
            outcome: self._dots(f"flash/{shape}", theme.of_outcome(outcome), _FLASH_RADIUS, shape)
            for outcome, shape in OUTCOME_SHAPES.items()
        }
        self._prey = self._dots("prey", theme.prey, _PREY_RADIUS)
        self._halo = self._dots("halo", theme.unknown, _HALO_RADIUS)
        self._predator = self._dots("predator", theme.predator, _PREDATOR_RADIUS)
        self._names = self._keep(BoardNames(self._scene))
        self._set(self._border, "border", lifted(outlines.border(spec), _Z_LINES))
        self._set(self._grid, "grid", lifted(outlines.grid(spec), _Z_LINES))

    def _keep(self, handle: Any) -> Any:
        self._handles.append(handle)
        return handle

    def _line(self, name: str, colour: tuple[int, int, int] | np.ndarray, thickness: float) -> Any:
        return self._keep(
            self._scene.add_line_segments(
                f"/board/{name}",
                np.full((1, 2, 3), AWAY, np.float32),
                colour,
                thickness=thickness,
                thickness_units="screen",
            )
        )

    def _dots(
        self, name: str, colour: tuple[int, int, int], radius: float, shape: Shape = "circle"
    ) -> Any:
        return self._keep(
            self._scene.add_point_cloud(
                f"/board/{name}",
                points=np.full((1, 3), AWAY, np.float32),
                colors=colour,
                point_size=radius,
                point_shape=shape,
                point_shading="flat",
                precision="float32",
            )
        )

    def _set(
        self, handle: Any, name: str, points: np.ndarray, colours: np.ndarray | None = None
    ) -> None:
        """Send points, and colours of each, only if they differ from what was sent before."""
        if points.shape[0] == 0:
            points = np.full((1, *points.shape[1:]), AWAY, np.float32)
            colours = None if colours is None else np.zeros(points.shape, np.uint8)
        former = self._sent.get(name)
        same = (
            former is not None
            and np.array_equal(former[0], points)
            and (colours is None or np.array_equal(former[1], colours))
        )
        if same:
            return
        self._sent[name] = (points, colours)
        handle.points = points
        if colours is not None:
            handle.colors = colours

    def update(self, snapshot: Snapshot, picture: Picture, look: Look, now_s: float) -> None:
        """Show a moment.

        Args:
            snapshot: the moment.
            picture: what the look's layer makes of it.
            look: how this browser wants to see it.
            now_s: a clock, for what fades.
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
        self._show_predator(snapshot)
        self._show_flashes(snapshot, now_s)
        if changed or now_s - self._paths_at >= _PATHS_EVERY_S:
            self._show_paths(snapshot)
            self._paths_at = now_s

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

    def remove(self) -> None:
        """Take everything off the scene."""
        for handle in self._handles:
            handle.remove()
        self._handles.clear()

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
        assign(self._field, "visible", look.field)
        if look.sensors:
            lines = outlines.sensors(_as_shown(spec, look))
            self._set(self._sensors, "sensors", lifted(lines, _Z_LINES))
        if look.start_zone:
            self._set(self._zone, "zone", lifted(outlines.start_zone(spec), _Z_FIELD))
        self._set(self._field, "field", lifted(outlines.visual_field(spec, shown), _Z_FIELD))
        self._set(self._arrow, "arrow", lifted(outlines.arrow(shown), _Z_PREY))
        self._set(self._prey, "prey", lifted(np.zeros((1, 2)), _Z_PREY))
        self._set(self._flow, "flow", lifted(outlines.arrow_lines(picture, spec), _Z_FIELD))
        self._names.show(picture, self._sent["cells"][0])

    def _show_predator(self, snapshot: Snapshot) -> None:
        shown = heading_shown(self._look, snapshot.heading)
        path = on_picture(snapshot.world, snapshot.trail, snapshot.heading, shown)
        # By its points and not its position, which browsers apply a frame ahead of the trail.
        here = lifted(path[-1:], _Z_PREDATOR)
        self._set(self._predator, "predator", here)
        self._set(self._halo, "halo", here - np.array([0, 0, 0.002], np.float32))
        points = np.zeros((0, 2, 3), np.float32)
        colours = np.zeros((0, 2, 3), np.uint8)
        if self._look.trail and len(path) > 1:
            steps = outlines.segments(path)[-_TRAIL_SEGMENTS:]
            points = lifted(steps, _Z_TRAIL)
            colours = _fading(self._look.theme, len(steps))
        self._set(self._trail, "trail", points, colours)

    def _show_paths(self, snapshot: Snapshot) -> None:
        assign(self._paths, "visible", self._look.paths)
        if not self._look.paths:
            return
        shown = heading_shown(self._look, snapshot.heading)
        parts: list[np.ndarray] = []
        colours: list[np.ndarray] = []
        for path in snapshot.paths:
            chosen = np.unique(np.linspace(0, len(path.cells) - 1, _PATH_POINTS).astype(int))
            points = on_picture(snapshot.world, path.cells[chosen], path.heading, shown)
            part = outlines.within(outlines.segments(points), self._spec)
            parts.append(part)
            colour = in_linear_light(self._look.theme.of_outcome(path.outcome))
            colours.append(np.broadcast_to(colour, (len(part), 2, 3)))
        if parts:
            lines = lifted(np.concatenate(parts), _Z_TRAIL)
            self._set(self._paths, "paths", lines, np.concatenate(colours))

    def _show_flashes(self, snapshot: Snapshot, now_s: float) -> None:
        generation, last = self._last_end
        if generation != snapshot.generation:
            last = -1
            self._flashes.clear()
        for end in snapshot.ends:
            if end.trial > last:
                self._flashes[end.trial] = (end, now_s)
                last = end.trial
        self._last_end = (snapshot.generation, last)
        self._flashes = {
            trial: (end, since)
            for trial, (end, since) in self._flashes.items()
            if now_s - since < _FLASH_S
        }
        shown = heading_shown(self._look, snapshot.heading)
        ends = [end for end, _ in self._flashes.values()]
        cells = np.array([end.cell for end in ends], np.int64)
        headings = np.array([end.heading for end in ends], np.int64)
        places = on_picture(snapshot.world, cells, headings, shown).reshape(-1, 2)
        outcomes = np.array([end.outcome for end in ends], np.int64)
        # Turned by half a quarter, the corners of another trial's board lie outside this one.
        low, high = outlines.edges(self._spec)
        inside = ((places >= low) & (places <= high)).all(axis=1)
        points = lifted(places[inside], _Z_FLASH)
        for outcome, handle in self._flash.items():
            self._set(handle, f"flash {outcome}", points[outcomes[inside] == outcome])
        self._set(self._rims, "rims", points - np.array([0, 0, 0.002], np.float32))


def _as_shown(spec: WorldSpec, look: Look) -> WorldSpec:
    """The world as it is seen by whom the layer is about: by a skill, or by the selection."""
    return spec.of_skills if LAYERS[look.layer].about == "skill" else spec


def _fading(theme: Theme, n_segments: int) -> np.ndarray:
    """Colours of a trail from the oldest segment to the newest, ``(n, 2, 3) uint8``."""
    age = np.linspace(1.0, 0.0, n_segments)[:, None, None]
    fresh, faded = np.array(theme.predator, float), np.array(theme.unknown, float)
    return in_linear_light(np.broadcast_to(fresh * (1 - age) + faded * age, (n_segments, 2, 3)))


def in_linear_light(colours: np.ndarray | Colour) -> np.ndarray:
    """Colours as the page takes them for parts of lines, ``(..., 3) uint8``.

    The page converts a colour of a whole line from sRGB, and takes those of its parts as linear.
    """
    return np.rint(to_linear(np.asarray(colours, float) / 255) * 255).astype(np.uint8)
