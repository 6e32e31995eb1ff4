"""The board in one browser: heat map, prey, predator, trail and flashes.

One class, ``create -> update(moment) -> remove``. Handles are made once and their properties
assigned afterwards; only the render loop calls it. The board lies in the plane z = 0, twelve
units wide whatever the grid, the prey at the origin facing east.
"""

from typing import NamedTuple

import numpy as np
import viser

from app import pictures
from app.pictures import Theme
from app.snapshot import Snapshot, TrialEnd
from sim import geometry
from sim.spec import WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT, World

BOARD_UNITS = 12.0
_GRID_EVERY = 10
_ARC_POINTS = 48
_AWAY = (0.0, 0.0, -50.0)
"""Where things are kept that are not to be seen."""
_FLASH_S = 0.7
_FLASH_RADIUS = 0.1
_TRAIL_SEGMENTS = 120

# Heights above the board, so that what matters lies on top.
_Z_LINES, _Z_FIELD, _Z_TRAIL, _Z_FLASH, _Z_PREY, _Z_PREDATOR = 0.01, 0.02, 0.03, 0.035, 0.04, 0.05


class Look(NamedTuple):
    """How one browser wants the board drawn."""

    theme: Theme
    scale: pictures.Scale
    trail: bool


def in_preys_frame(world: World, cells: np.ndarray, heading: int | np.ndarray) -> np.ndarray:
    """Where cells lie when the prey faces east, ``(n, 2) float64`` in board units."""
    width = int(world.width)
    middle = world.size // 2
    east = cells % width - 1 - middle
    north = cells // width - 1 - middle
    turn = -np.asarray(heading) * np.pi / 4
    cos, sin = np.cos(turn), np.sin(turn)
    unit = BOARD_UNITS / world.size
    return np.stack([east * cos - north * sin, east * sin + north * cos], axis=-1) * unit


def cell_centres(spec: WorldSpec) -> np.ndarray:
    """Centres of all cells, ``(y * x, 3) float32`` in board units."""
    east, north = geometry.offsets(spec)
    flat = np.stack([east, north, np.zeros_like(east)], axis=-1).reshape(-1, 3)
    return (flat * BOARD_UNITS / spec.size).astype(np.float32)


def _segments(points: np.ndarray, z: float) -> np.ndarray:
    """A line through points ``(n, 2)`` as segments ``(n - 1, 2, 3) float32``."""
    lifted = np.column_stack([points, np.full(len(points), z)]).astype(np.float32)
    return np.stack([lifted[:-1], lifted[1:]], axis=1)


def _edges(spec: WorldSpec) -> tuple[float, float]:
    """West (south) and east (north) edge of the board in board units."""
    unit = BOARD_UNITS / spec.size
    middle = spec.size // 2
    return (-0.5 - middle) * unit, (spec.size - 0.5 - middle) * unit


def _border(spec: WorldSpec) -> np.ndarray:
    low, high = _edges(spec)
    corners = np.array([[low, low], [high, low], [high, high], [low, high], [low, low]])
    return _segments(corners, _Z_LINES)


def _grid(spec: WorldSpec) -> np.ndarray:
    low, high = _edges(spec)
    step = _GRID_EVERY * BOARD_UNITS / spec.size
    marks = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
    lines = [np.array([[mark, low], [mark, high]]) for mark in marks]
    lines += [np.array([[low, mark], [high, mark]]) for mark in marks]
    return np.concatenate([_segments(line, _Z_LINES) for line in lines])


def _visual_field(spec: WorldSpec) -> np.ndarray:
    radius = spec.vision_radius * BOARD_UNITS / 120
    angles = np.linspace(-np.pi / 2, np.pi / 2, _ARC_POINTS)
    arc = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return _segments(np.concatenate([arc, arc[:1]]), _Z_FIELD)


def _arrow(spec: WorldSpec) -> np.ndarray:
    tip, wing, tail = 0.62, 0.2, 0.12
    shaft = np.array([[tail, 0.0], [tip, 0.0]])
    head = np.array([[tip - wing, wing], [tip, 0.0], [tip - wing, -wing]])
    return np.concatenate([_segments(shaft, _Z_PREY), _segments(head, _Z_PREY)])


class BoardView:
    """What one browser sees of the board."""

    def __init__(self, scene: viser.SceneApi, snapshot: Snapshot, look: Look) -> None:
        self._scene = scene
        self._world_spec = snapshot.spec.world
        self._look = look
        self._colours = np.zeros((0, 3), np.uint8)
        self._trail_key: tuple[int, int, int] | None = None
        self._flashes: dict[int, tuple[TrialEnd, float]] = {}
        self._last_end: tuple[int, int] = (snapshot.generation, snapshot.trial - 1)
        self._create()

    def _create(self) -> None:
        scene, spec, theme = self._scene, self._world_spec, self._look.theme
        unit = BOARD_UNITS / spec.size
        centres = cell_centres(spec)
        self._cells = scene.add_point_cloud(
            "/board/cells",
            points=centres,
            colors=np.broadcast_to(np.array(theme.unknown, np.uint8), centres.shape).copy(),
            point_size=unit / 2,
            point_shading="flat",
            precision="float32",
        )
        self._lines = [
            scene.add_line_segments(
                f"/board/{name}", points, colour, thickness=thickness, thickness_units="screen"
            )
            for name, points, colour, thickness in [
                ("grid", _grid(spec), theme.lines, 1.0),
                ("border", _border(spec), theme.border, 2.0),
                ("field", _visual_field(spec), theme.field, 3.0),
                ("heading", _arrow(spec), theme.prey, 4.0),
            ]
        ]
        self._trail = scene.add_line_segments(
            "/board/trail",
            np.full((_TRAIL_SEGMENTS, 2, 3), _AWAY, np.float32),
            np.broadcast_to(np.array(theme.predator, np.uint8), (_TRAIL_SEGMENTS, 2, 3)).copy(),
            thickness=3.0,
            thickness_units="screen",
        )
        self._rims = self._dots("rims", theme.unknown, _FLASH_RADIUS * 1.5)
        self._flash = self._dots("flash", theme.unknown, _FLASH_RADIUS)
        self._prey = self._marker("prey", theme.prey, 0.13, _Z_PREY)
        self._halo = self._marker("halo", theme.unknown, 0.17, _Z_PREDATOR - 0.002)
        self._predator = self._marker("predator", theme.predator, 0.13, _Z_PREDATOR)

    def _dots(
        self, name: str, colour: tuple[int, int, int], radius: float
    ) -> viser.PointCloudHandle:
        return self._scene.add_point_cloud(
            f"/board/{name}",
            points=np.full((1, 3), _AWAY, np.float32),
            colors=colour,
            point_size=radius,
            point_shape="circle",
            point_shading="flat",
            precision="float32",
        )

    def _marker(
        self, name: str, colour: tuple[int, int, int], radius: float, z: float
    ) -> viser.PointCloudHandle:
        handle = self._dots(name, colour, radius)
        handle.points = np.zeros((1, 3), np.float32)
        handle.position = (0.0, 0.0, z)
        return handle

    def look_like(self, look: Look) -> None:
        """Draw with another look from now on."""
        if look.theme != self._look.theme:
            self._look = look
            self._rebuild()
        self._look = look

    def update(self, snapshot: Snapshot, colours: np.ndarray, now_s: float) -> None:
        """Show a moment.

        Args:
            snapshot: the moment.
            colours: colour of each cell, ``(y * x, 3) uint8``.
            now_s: a clock, for what fades.
        """
        if snapshot.spec.world != self._world_spec:
            self._world_spec = snapshot.spec.world
            self._rebuild()
        if not np.array_equal(colours, self._colours):
            self._cells.colors = colours
            self._colours = colours
        self._show_predator(snapshot)
        self._show_flashes(snapshot, now_s)

    def remove(self) -> None:
        """Take everything off the scene."""
        for handle in [*self._lines, self._cells, self._trail, self._flash, self._rims]:
            handle.remove()
        for handle in (self._prey, self._halo, self._predator):
            handle.remove()

    def _rebuild(self) -> None:
        self.remove()
        self._colours = np.zeros((0, 3), np.uint8)
        self._trail_key = None
        self._create()

    def _show_predator(self, snapshot: Snapshot) -> None:
        key = (snapshot.generation, snapshot.step, int(self._look.trail))
        if key == self._trail_key:
            return
        self._trail_key = key
        path = in_preys_frame(snapshot.world, snapshot.trail, snapshot.heading)
        east, north = (float(part) for part in path[-1])
        # By its points and not its position, which browsers apply a frame ahead of the trail.
        here = np.array([[east, north, 0.0]], np.float32)
        self._predator.points = here
        self._halo.points = here
        points = np.full((_TRAIL_SEGMENTS, 2, 3), _AWAY, np.float32)
        colours = np.zeros((_TRAIL_SEGMENTS, 2, 3), np.uint8)
        if self._look.trail and len(path) > 1:
            segments = _segments(path, _Z_TRAIL)[-_TRAIL_SEGMENTS:]
            age = np.linspace(1.0, 0.0, len(segments))[:, None, None]
            fresh = np.array(self._look.theme.predator, np.float64)
            faded = np.array(self._look.theme.unknown, np.float64)
            points[: len(segments)] = segments
            colours[: len(segments)] = np.rint(fresh * (1 - age) + faded * age)
        self._trail.points = points
        self._trail.colors = colours

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
        if not self._flashes:
            return
        self._flashes = {
            trial: (end, since)
            for trial, (end, since) in self._flashes.items()
            if now_s - since < _FLASH_S
        }
        theme = self._look.theme
        by_outcome = {CAPTURE: theme.capture, FLIGHT: theme.flight, TIMEOUT: theme.timeout}
        shown = len(self._flashes)
        points = np.full((max(shown, 1), 3), _AWAY, np.float32)
        colours = np.zeros((max(shown, 1), 3), np.uint8)
        for row, (end, _) in enumerate(self._flashes.values()):
            points[row, :2] = in_preys_frame(snapshot.world, np.array([end.cell]), end.heading)[0]
            points[row, 2] = _Z_FLASH
            colours[row] = by_outcome[end.outcome]
        self._flash.points = points
        self._flash.colors = colours
        self._rims.points = points - np.array([0.0, 0.0, 0.002], np.float32)
