"""Words beside what moves on the board, and beside the prey, on a scene of viser's."""

from collections.abc import Sequence
from typing import Final

import viser

from app.page.scene.parts import Writing
from app.player.tags import HEIGHT, Tag, places_of

_Z: Final = 0.3
_MOST: Final = 3
"""Words that are there at once."""


class Tags(Writing):
    """Words on one board."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        super().__init__(scene, name, HEIGHT, _MOST)

    def show(self, tags: Sequence[Tag], clear: Sequence[tuple[float, float]] = ()) -> None:
        """Show these, three at most, and no others; what has not changed is not sent."""
        places = places_of(tags, clear)
        self.write(
            [
                (tag.text, (round(east, 3), round(north, 3), _Z))
                for tag, (east, north) in zip(tags, places, strict=True)
            ]
        )
