"""The board in one browser: the picture of a layer, prey, predator, trail, flashes, overlays.

One class, ``create -> update(moment) -> remove``. Handles are made once and their properties
assigned afterwards; only the render loop calls it. The board lies in the plane z = 0, twelve
units wide whatever the grid, the prey at the origin.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import viser

from app.layers import Picture
from app.look import OF_TRIAL, Look, heading_shown
from app.pictures import Theme
from app.snapshot import Snapshot, TrialEnd
from sim import geometry
from sim.spec import STANDARD_SIZE, WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT, World

BOARD_UNITS = 12.0
SURFACE_UNITS = 2.4
"""Height of the largest value when the board is drawn as a surface."""

FLAT_TARGET = (0.0, -2.65, 0.0)
FLAT_CAMERA = (0.0, -2.65, 15.6)
"""The whole board from above, with room for the timeline below it."""
SURFACE_CAMERA = (0.0, -17.5, 12.5)
SURFACE_TARGET = (0.0, -2.6, 0.0)

_GRID_EVERY = 10
_ARC_POINTS = 48
_CIRCLE_POINTS = 73
_RAY_POINTS = 400
_AWAY = (0.0, 0.0, -50.0)
"""Where things are kept that are not to be seen."""
_FLASH_S = 0.7
_FLASH_RADIUS = 0.1
_TRAIL_SEGMENTS = 120
_PATH_POINTS = 60
_PATHS_EVERY_S = 1.0
_LINES_EVERY_S = 1.0

# Heights above the board, so that what matters lies on top.
_Z_LINES, _Z_FIELD, _Z_TRAIL, _Z_FLASH, _Z_PREY, _Z_PREDATOR = 0.01, 0.02, 0.03, 0.035, 0.04, 0.05


def on_picture(
    world: World, cells: np.ndarray, heading: int | np.ndarray, shown: int
) -> np.ndarray:
    """Where cells of a trial lie in a picture whose prey faces another way.

    Args:
        world: the world.
        cells: ``(n,)`` cells.
        heading: the prey's heading in that trial.
        shown: the heading in the picture.

    Returns:
        ``(n, 2) float64`` in board units.
    """
    width = int(world.width)
    middle = world.size // 2
    east = cells % width - 1 - middle
    north = cells // width - 1 - middle
    turn = (shown - np.asarray(heading)) * np.pi / 4
    cos, sin = np.cos(turn), np.sin(turn)
    unit = BOARD_UNITS / world.size
    return np.stack([east * cos - north * sin, east * sin + north * cos], axis=-1) * unit


def cell_centres(spec: WorldSpec) -> np.ndarray:
    """Centres of all cells, ``(y * x, 3) float32`` in board units."""
    east, north = geometry.offsets(spec)
    flat = np.stack([east, north, np.zeros_like(east)], axis=-1).reshape(-1, 3)
    return (flat * BOARD_UNITS / spec.size).astype(np.float32)


def _segments(points: np.ndarray) -> np.ndarray:
    """A line through points ``(n, 2)`` as segments ``(n - 1, 2, 2)``."""
    return np.stack([points[:-1], points[1:]], axis=1)


def _edges(spec: WorldSpec) -> tuple[float, float]:
    """West (south) and east (north) edge of the board in board units."""
    unit = BOARD_UNITS / spec.size
    middle = spec.size // 2
    return (-0.5 - middle) * unit, (spec.size - 0.5 - middle) * unit


def _border(spec: WorldSpec) -> np.ndarray:
    low, high = _edges(spec)
    return _segments(np.array([[low, low], [high, low], [high, high], [low, high], [low, low]]))


def _grid(spec: WorldSpec) -> np.ndarray:
    low, high = _edges(spec)
    step = _GRID_EVERY * BOARD_UNITS / spec.size
    marks = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
    lines = [np.array([[mark, low], [mark, high]]) for mark in marks]
    lines += [np.array([[low, mark], [high, mark]]) for mark in marks]
    return np.concatenate([_segments(line) for line in lines])


def _turned(points: np.ndarray, heading: int) -> np.ndarray:
    """Points drawn for a prey that faces east, for one that faces another way."""
    cos, sin = np.cos(heading * np.pi / 4), np.sin(heading * np.pi / 4)
    return points @ np.array([[cos, sin], [-sin, cos]])


def _visual_field(spec: WorldSpec, heading: int) -> np.ndarray:
    radius = spec.vision_radius * BOARD_UNITS / STANDARD_SIZE
    angles = np.linspace(-np.pi / 2, np.pi / 2, _ARC_POINTS)
    arc = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return _segments(_turned(np.concatenate([arc, arc[:1]]), heading))


def _arrow(heading: int) -> np.ndarray:
    tip, wing, tail = 0.62, 0.2, 0.12
    shaft = np.array([[tail, 0.0], [tip, 0.0]])
    head = np.array([[tip - wing, wing], [tip, 0.0], [tip - wing, -wing]])
    return np.concatenate([_segments(_turned(part, heading)) for part in (shaft, head)])


def _circle(radius: float) -> np.ndarray:
    angles = np.linspace(0, 2 * np.pi, _CIRCLE_POINTS)
    return _segments(radius * np.column_stack([np.cos(angles), np.sin(angles)]))


def _within(segments: np.ndarray, spec: WorldSpec) -> np.ndarray:
    """The segments that lie on the board."""
    low, high = _edges(spec)
    return segments[((segments >= low) & (segments <= high)).all(axis=(1, 2))]


def _sensors(spec: WorldSpec) -> np.ndarray:
    """Rings, and sectors from the first ring outwards."""
    unit = BOARD_UNITS / spec.size
    edges = geometry.ring_edges(spec) * unit
    parts = [_circle(edge) for edge in edges]
    radii = np.linspace(edges[0], edges[-1], 40)
    for sector in range(spec.n_directions):
        angle = (sector + 0.5) * 2 * np.pi / spec.n_directions
        parts.append(_segments(radii[:, None] * np.array([[np.cos(angle), np.sin(angle)]])))
    return _within(np.concatenate(parts), spec)


def _start_zone(spec: WorldSpec) -> np.ndarray:
    unit = BOARD_UNITS / STANDARD_SIZE
    return np.concatenate([_circle(radius * unit) for radius in spec.start_radius])


def _arrows(picture: Picture, spec: WorldSpec) -> np.ndarray:
    """The arrows of a picture as segments ``(3 n, 2, 2)`` in board units."""
    if picture.arrows is None or not len(picture.arrows):
        return np.zeros((0, 2, 2))
    tails, heads = picture.arrows[:, 0], picture.arrows[:, 1]
    back = 0.38 * (tails - heads)
    left = heads + back @ np.array([[0.8, 0.6], [-0.6, 0.8]])
    right = heads + back @ np.array([[0.8, -0.6], [0.6, 0.8]])
    pairs = [np.stack(pair, axis=1) for pair in ((tails, heads), (heads, left), (heads, right))]
    return np.concatenate(pairs) * (BOARD_UNITS / spec.size)


@dataclass(frozen=True)
class _Ground:
    """How high the picture is at a place."""

    spec: WorldSpec
    height: np.ndarray | None
    """(y, x) float32 in board units; None where the board is flat."""

    def under(self, points: np.ndarray) -> np.ndarray:
        """Height at points ``(..., 2)``."""
        if self.height is None:
            return np.zeros(points.shape[:-1])
        middle, unit = self.spec.size // 2, BOARD_UNITS / self.spec.size
        index = np.clip(np.rint(points / unit).astype(int) + middle, 0, self.spec.size - 1)
        return self.height[index[..., 1], index[..., 0]]

    def lifted(self, points: np.ndarray, above: float) -> np.ndarray:
        """Points ``(..., 2)`` so far above the ground, ``(..., 3) float32``."""
        z = self.under(points) + above
        return np.concatenate([points, z[..., None]], axis=-1).astype(np.float32)


class BoardView:
    """What one browser sees of the board."""

    def __init__(self, scene: viser.SceneApi, snapshot: Snapshot, look: Look) -> None:
        self._scene = scene
        self._spec = snapshot.spec.world
        self._look = look
        self._flashes: dict[int, tuple[TrialEnd, float]] = {}
        self._last_end = (snapshot.generation, snapshot.trial - 1)
        self._handles: list[Any] = []
        self._create()

    def _create(self) -> None:
        spec, theme = self._spec, self._look.theme
        self._sent: dict[str, Any] = {}
        self._ground = _Ground(spec, None)
        self._lines_at = self._paths_at = float("-inf")
        centres = cell_centres(spec)
        unit = BOARD_UNITS / spec.size
        self._cells = self._keep(
            self._scene.add_point_cloud(
                "/board/cells",
                points=centres,
                colors=np.broadcast_to(np.array(theme.unknown, np.uint8), centres.shape).copy(),
                point_size=unit / 2,
                point_shading="flat",
                precision="float32",
            )
        )
        self._border = self._line("border", theme.border, 2.0)
        self._grid = self._line("grid", theme.lines, 1.0)
        self._sensors = self._line("sensors", theme.border, 1.0)
        self._zone = self._line("start_zone", theme.capture, 2.0)
        self._field = self._line("field", theme.field, 3.0)
        self._arrow = self._line("heading", theme.prey, 4.0)
        self._flow = self._line("flow", theme.ink, 2.0)
        # Each part of these has a colour of its own; a line that starts with one takes no others.
        of_parts = np.zeros((1, 2, 3), np.uint8)
        self._paths = self._line("paths", of_parts, 2.0)
        self._trail = self._line("trail", of_parts, 3.0)
        self._rims = self._dots("rims", theme.unknown, _FLASH_RADIUS * 1.5)
        self._flash = self._dots("flash", theme.unknown, _FLASH_RADIUS)
        self._prey = self._dots("prey", theme.prey, 0.13)
        self._halo = self._dots("halo", theme.unknown, 0.17)
        self._predator = self._dots("predator", theme.predator, 0.13)
        self._set(self._border, "border", self._flat(_border(spec), _Z_LINES))
        self._set(self._grid, "grid", self._flat(_grid(spec), _Z_LINES))

    def _keep(self, handle: Any) -> Any:
        self._handles.append(handle)
        return handle

    def _line(self, name: str, colour: tuple[int, int, int] | np.ndarray, thickness: float) -> Any:
        return self._keep(
            self._scene.add_line_segments(
                f"/board/{name}",
                np.full((1, 2, 3), _AWAY, np.float32),
                colour,
                thickness=thickness,
                thickness_units="screen",
            )
        )

    def _dots(self, name: str, colour: tuple[int, int, int], radius: float) -> Any:
        return self._keep(
            self._scene.add_point_cloud(
                f"/board/{name}",
                points=np.full((1, 3), _AWAY, np.float32),
                colors=colour,
                point_size=radius,
                point_shape="circle",
                point_shading="flat",
                precision="float32",
            )
        )

    def _flat(self, segments: np.ndarray, z: float) -> np.ndarray:
        return _Ground(self._spec, None).lifted(segments, z)

    def _set(
        self, handle: Any, name: str, points: np.ndarray, colours: np.ndarray | None = None
    ) -> None:
        """Send points, and colours of each, only if they differ from what was sent before."""
        if points.shape[0] == 0:
            points = np.full((1, *points.shape[1:]), _AWAY, np.float32)
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
        if look.surface != self._look.surface:
            unit = BOARD_UNITS / self._spec.size
            self._cells.point_size = unit if look.surface else unit / 2
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
        """East and north of where a ray meets the board as it is drawn, None if it does not."""
        start, along = np.array(origin, float), np.array(direction, float)
        if along[2] >= -1e-9:
            return None
        # From above everything to below everything there is.
        highest, lowest = SURFACE_UNITS * 1.05, -SURFACE_UNITS * 1.05
        if self._ground.height is None:
            highest = lowest = 0.0
        times = np.linspace(highest - start[2], lowest - start[2], _RAY_POINTS) / along[2]
        points = start + times[:, None] * along
        met = points[:, 2] <= self._ground.under(points[:, :2]) + 1e-9
        if not met.any():
            return None
        east, north, _ = points[int(met.argmax())]
        return float(east), float(north)

    def remove(self) -> None:
        """Take everything off the scene."""
        for handle in self._handles:
            handle.remove()
        self._handles.clear()

    def _show_cells(self, picture: Picture) -> None:
        points = cell_centres(self._spec) if "cells" not in self._sent else self._sent["cells"][0]
        if self._look.surface:
            size = self._spec.size
            height = _smoothed(picture.height.reshape(size, size)) * SURFACE_UNITS
            points = points.copy()
            points[:, 2] = height.ravel()
            self._ground = _Ground(self._spec, height)
        elif self._ground.height is not None:
            points = cell_centres(self._spec)
            self._ground = _Ground(self._spec, None)
        former = self._sent.get("cells", (None, None))
        if former[0] is not None and not np.array_equal(former[0], points):
            self._cells.points = points
        if former[1] is None or not np.array_equal(former[1], picture.colours):
            self._cells.colors = picture.colours
        self._sent["cells"] = (points, picture.colours)

    def _show_overlays(self, snapshot: Snapshot, picture: Picture) -> None:
        look, spec, lifted = self._look, self._spec, self._ground.lifted
        shown = heading_shown(look, snapshot.heading)
        flat = not look.surface
        _show(self._grid, look.grid and flat)
        _show(self._sensors, look.sensors and flat)
        _show(self._zone, look.start_zone and flat)
        _show(self._field, look.field)
        if look.sensors:
            self._set(self._sensors, "sensors", self._flat(_sensors(spec), _Z_LINES))
        if look.start_zone:
            self._set(self._zone, "zone", self._flat(_start_zone(spec), _Z_FIELD))
        self._set(self._field, "field", lifted(_visual_field(spec, shown), _Z_FIELD))
        self._set(self._arrow, "arrow", lifted(_arrow(shown), _Z_PREY))
        self._set(self._prey, "prey", lifted(np.zeros((1, 2)), _Z_PREY))
        self._set(self._flow, "flow", lifted(_arrows(picture, spec), _Z_FIELD))

    def _show_predator(self, snapshot: Snapshot) -> None:
        shown = heading_shown(self._look, snapshot.heading)
        path = on_picture(snapshot.world, snapshot.trail, snapshot.heading, shown)
        # By its points and not its position, which browsers apply a frame ahead of the trail.
        here = self._ground.lifted(path[-1:], _Z_PREDATOR)
        self._set(self._predator, "predator", here)
        self._set(self._halo, "halo", here - np.array([0, 0, 0.002], np.float32))
        points = np.zeros((0, 2, 3), np.float32)
        colours = np.zeros((0, 2, 3), np.uint8)
        if self._look.trail and len(path) > 1:
            points = self._ground.lifted(_segments(path)[-_TRAIL_SEGMENTS:], _Z_TRAIL)
            colours = _fading(self._look.theme, len(points))
        self._set(self._trail, "trail", points, colours)

    def _show_paths(self, snapshot: Snapshot) -> None:
        _show(self._paths, self._look.paths)
        if not self._look.paths:
            return
        shown = heading_shown(self._look, snapshot.heading)
        parts, colours = [], []
        for path in snapshot.paths:
            chosen = np.unique(np.linspace(0, len(path.cells) - 1, _PATH_POINTS).astype(int))
            points = on_picture(snapshot.world, path.cells[chosen], path.heading, shown)
            segments = _within(_segments(points), self._spec)
            parts.append(segments)
            colour = in_linear_light(np.array(outcome_colour(self._look.theme, path.outcome)))
            colours.append(np.broadcast_to(colour, (len(segments), 2, 3)))
        if parts:
            lines = self._ground.lifted(np.concatenate(parts), _Z_TRAIL)
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
        colours = np.array(
            [outcome_colour(self._look.theme, end.outcome) for end in ends], np.uint8
        ).reshape(-1, 3)
        # Turned by half a quarter, the corners of another trial's board lie outside this one.
        low, high = _edges(self._spec)
        inside = ((places >= low) & (places <= high)).all(axis=1)
        points, colours = self._ground.lifted(places[inside], _Z_FLASH), colours[inside]
        self._set(self._flash, "flash", points, colours)
        self._set(self._rims, "rims", points - np.array([0, 0, 0.002], np.float32))


def _smoothed(height: np.ndarray) -> np.ndarray:
    """Heights without cliffs, whose sides a surface of points would not show, ``(y, x)``.

    The mean over 5 x 5 cells; the colours stay those of each cell.
    """
    reach = 2
    width = 2 * reach + 1
    for axis in (0, 1):
        padded = np.pad(
            height, [(reach, reach) if a == axis else (0, 0) for a in (0, 1)], mode="edge"
        )
        total = np.cumsum(padded, axis=axis, dtype=np.float64)
        total = np.insert(total, 0, 0.0, axis=axis)
        n = height.shape[axis]
        upper = np.take(total, np.arange(width, n + width), axis=axis)
        lower = np.take(total, np.arange(n), axis=axis)
        height = (upper - lower) / width
    return height.astype(np.float32)


def outcome_colour(theme: Theme, outcome: int) -> tuple[int, int, int]:
    """Colour of a way to end."""
    return {CAPTURE: theme.capture, FLIGHT: theme.flight, TIMEOUT: theme.timeout}[outcome]


def _fading(theme: Theme, n_segments: int) -> np.ndarray:
    """Colours of a trail from the oldest segment to the newest, ``(n, 2, 3) uint8``."""
    age = np.linspace(1.0, 0.0, n_segments)[:, None, None]
    fresh, faded = np.array(theme.predator, float), np.array(theme.unknown, float)
    return in_linear_light(np.broadcast_to(fresh * (1 - age) + faded * age, (n_segments, 2, 3)))


def in_linear_light(colours: np.ndarray) -> np.ndarray:
    """Colours as the page takes them for parts of lines, ``(..., 3) uint8``.

    It converts a colour of a whole line from sRGB, and takes those of its parts as linear.
    """
    share = np.asarray(colours, float) / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.rint(linear * 255).astype(np.uint8)


def _show(handle: Any, visible: bool) -> None:
    if handle.visible != visible:
        handle.visible = visible
