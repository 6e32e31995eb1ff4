"""Regions of the board that a card speaks of: outlined, and a place in one that is looked into."""

from typing import Any, Final

import numpy as np
import viser

from app.lessons.regions import masks
from app.live.snapshot import Snapshot
from app.page.scene.parts import Parts, Viewer
from app.picture.frames import folds
from app.picture.look import ALL, Look, heading_shown
from app.picture.outlines import lifted, region_lines
from app.picture.raster import raster
from app.picture.theme import Theme
from sim.spec import WorldSpec

ROOT: Final = "/marked"
"""Below which all of it is drawn."""
_Z_EDGE, _Z_RIM = 0.0275, 0.027


class Marked:
    """The region that is outlined on one browser's board. The render loop alone draws it."""

    def __init__(self, client: Viewer) -> None:
        self._client = client
        self._drawn: tuple[Theme, _Drawn] | None = None
        self._key: tuple[Any, ...] | None = None

    def show(self, region: str | None, snapshot: Snapshot, look: Look) -> None:
        """Outline a region, or none; sends nothing if nothing has changed."""
        world, heading = snapshot.spec.world, heading_shown(look, snapshot.heading)
        region = None if look.frame == ALL else region
        key = None if region is None else (region, world, heading, folds(look), look.theme)
        if key == self._key:
            return
        self._key = key
        with self._client.atomic():
            if self._drawn is not None and (region is None or self._drawn[0] != look.theme):
                self._drawn[1].remove()
                self._drawn = None
            if region is None:
                return
            if self._drawn is None:
                self._drawn = look.theme, _Drawn(self._client.scene, look.theme)
            edge = region_lines(masks(world)[region], world, heading, folds(look))
            self._drawn[1].show(edge)


class _Drawn(Parts):
    def __init__(self, scene: viser.SceneApi, theme: Theme) -> None:
        super().__init__(scene, ROOT.removeprefix("/"))
        self._rim = self._line("rim", theme.unknown, 6.5)
        self._edge = self._line("edge", theme.ink, 3.0)

    def show(self, edge: np.ndarray) -> None:
        """Draw segments ``(n, 2, 2)``."""
        self._set(self._rim, "rim", lifted(edge, _Z_RIM))
        self._set(self._edge, "edge", lifted(edge, _Z_EDGE))


def cells_of(region: str, world: WorldSpec, heading: int) -> np.ndarray:
    """Which cells of the board lie in a region, ``(y, x) bool``.

    Args:
        region: its name.
        world: the world.
        heading: where the prey looks.
    """
    turned = np.roll(masks(world)[region], heading * world.n_directions // 8, axis=1)
    return turned.ravel().take(raster(world).states).reshape(world.size, world.size)


def heading_known(region: str, snapshot: Snapshot) -> int:
    """A heading of the prey for which something in a region is worth something: east if it is one,
    or if there is none."""
    world = snapshot.spec.world
    states = raster(world).states
    for heading, known in enumerate(snapshot.value):
        cells = cells_of(region, world, heading)
        if (cells & (known.ravel().take(states).reshape(cells.shape) > 0)).any():
            return heading
    return 0


def place_in(region: str, snapshot: Snapshot, heading: int) -> tuple[int, int] | None:
    """A cell of a region that is good to be looked into: one with a value if there is any, from
    where hunts begin if it can be, and in the midst of those.

    Args:
        region: its name.
        snapshot: the moment.
        heading: where the prey looks.

    Returns:
        Its column and row; None if sensors are so coarse, or the board so small, that the region
        has none.
    """
    world = snapshot.spec.world
    cells = cells_of(region, world, heading)
    value = snapshot.value[heading].ravel().take(raster(world).states).reshape(cells.shape)
    y, x = np.indices(cells.shape)
    middle = world.size // 2
    away = np.hypot(x - middle, y - middle)
    starts = away <= world.start_radius[1] * world.scale
    better = (cells & (value > 0) & starts, cells & (value > 0), cells)
    chosen = next((part for part in better if part.any()), None)
    if chosen is None:
        return None
    rows, columns = np.nonzero(chosen)
    off = np.hypot(rows - rows.mean(), columns - columns.mean())
    nearest = int(off.argmin())
    return int(columns[nearest]), int(rows[nearest])
