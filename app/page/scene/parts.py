"""What is drawn on a board is made of lines and dots, made once and sent when they have changed."""

from collections.abc import Sequence
from typing import Any, Final, Protocol

import numpy as np
import viser

from app.page.widgets import assign
from app.picture.colours import to_linear
from app.picture.theme import Colour, Shape

AWAY: Final = (0.0, -1000.0, -50.0)
"""Where things are kept that are not to be seen: not just below the board, which may have gaps."""
OF_PARTS: Final = np.zeros((1, 2, 3), np.uint8)
"""Colour of a line each part of which has one; a line that starts with one alone has no others."""


class Viewer(Protocol):
    """What is needed of a `viser.ClientHandle` to draw and write for one browser alone."""

    @property
    def gui(self) -> viser.GuiApi: ...

    @property
    def scene(self) -> viser.SceneApi: ...

    def atomic(self) -> Any: ...


class Parts:
    """Lines and dots on a scene, under one name."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._scene, self._name = scene, name
        self._handles: list[Any] = []
        self._sent: dict[str, Any] = {}

    def remove(self) -> None:
        """Take everything off the scene."""
        for handle in self._handles:
            handle.remove()
        self._handles.clear()
        self._sent.clear()

    def _keep(self, handle: Any) -> Any:
        self._handles.append(handle)
        return handle

    def _line(self, name: str, colour: Colour | np.ndarray, thickness: float) -> Any:
        return self._keep(
            self._scene.add_line_segments(
                f"/{self._name}/{name}",
                np.full((1, 2, 3), AWAY, np.float32),
                colour,
                thickness=thickness,
                thickness_units="screen",
            )
        )

    def _dots(
        self, name: str, colour: Colour | np.ndarray, radius: float, shape: Shape = "circle"
    ) -> Any:
        return self._keep(
            self._scene.add_point_cloud(
                f"/{self._name}/{name}",
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


class Writing:
    """Words on a scene, at most so many at once."""

    def __init__(self, scene: viser.SceneApi, name: str, height: float, most: int) -> None:
        """``height`` is that of a line in board units, so that it grows with the board."""
        # All at once: a board that takes the place of another one in a page has what that has.
        self._labels: list[Any] = [
            scene.add_label(
                f"/{name}/{number}",
                "",
                position=AWAY,
                anchor="center-center",
                font_size_mode="scene",
                font_scene_height=height,
                visible=False,
            )
            for number in range(most)
        ]

    def write(self, words: Sequence[tuple[str, tuple[float, float, float]]]) -> None:
        """Show the first of these, each in its middle, and no others; nothing is sent twice."""
        for label, (text, place) in zip(self._labels, words, strict=False):
            assign(label, "text", text)
            if tuple(label.position) != place:
                label.position = place
            assign(label, "visible", True)
        for label in self._labels[len(words) :]:
            assign(label, "visible", False)

    def remove(self) -> None:
        """Take all off the scene."""
        for label in self._labels:
            label.remove()
        self._labels.clear()


def in_linear_light(colours: np.ndarray | Colour) -> np.ndarray:
    """Colours as the page takes them for parts of lines, ``(..., 3) uint8``.

    The page converts a colour of a whole line from sRGB, and takes those of its parts as linear.
    """
    return np.rint(to_linear(np.asarray(colours, float) / 255) * 255).astype(np.uint8)
