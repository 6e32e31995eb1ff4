"""What stands written on the board: names, and labels."""

from collections.abc import Sequence
from typing import Final

import viser

from app.page.scene.parts import Writing
from app.picture.layer import Label
from app.picture.outlines import BOARD_UNITS

HEIGHT: Final = 0.34
_ABOVE: Final = 0.06
_MOST: Final = 16


class BoardNames(Writing):
    """What stands written on one browser's board, at most so many words."""

    def __init__(self, scene: viser.SceneApi, height: float = HEIGHT) -> None:
        super().__init__(scene, "board/names", height, _MOST)

    def show(self, labels: Sequence[Label], size: int) -> None:
        """Show the first of some labels on a board of so many cells along each side."""
        unit = BOARD_UNITS / size
        self.write(
            [(label.text, (label.east * unit, label.north * unit, _ABOVE)) for label in labels]
        )
