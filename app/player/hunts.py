"""Hunts as they are drawn: the way of the predator, and where and how the last ones ended."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from app.live.snapshot import Snapshot, TrialPath
from app.picture.frames import folds
from app.picture.look import Look
from app.picture.outlines import BOARD_UNITS, kept_on_board, on_picture
from app.picture.theme import Theme
from app.player.tags import Tag
from sim.spec import STANDARD_SIZE, WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT, World

ENDED: Final[Mapping[int, str]] = {
    CAPTURE: "caught",
    FLIGHT: "noticed",
    TIMEOUT: "out of time",
}
"""What stands on the board where a hunt has ended."""


_FIELD_NAME: Final = "what it sees"
_FIELD_PLACE: Final = (1.3, 1.05)
"""Of that in the field of a prey that faces east, clear of its arrow, in board units."""
_ARROW_PLACE: Final = (0.45, 0.0)
"""Of the middle of that arrow."""
_LEAST_FIELD: Final = 2.4
"""Radius of a field, in board units, in which that has room."""

_TRAIL_STEPS = 120
_WHOLE_STEPS = 2_000
"""Of a hunt that has ended; one that takes longer has gone in circles before."""
_PATH_POINTS = 60
_FADED: Final = 0.7
"""How much of its colour the oldest dot has lost."""


@dataclass(frozen=True)
class Way:
    """What there is to be drawn of one hunt."""

    cells: np.ndarray
    """(step + 1,) int64: where the predator was, and is now."""
    heading: int
    """Of the prey."""
    outcome: int | None = None
    """How it ended, if it has."""

    @property
    def shown(self) -> np.ndarray:
        """(step + 1,) int64: the cells of it that are drawn."""
        most = _TRAIL_STEPS if self.outcome is None else _WHOLE_STEPS
        return self.cells[-1 - most :]


class Ends(NamedTuple):
    """The last trials that have ended, oldest first."""

    places: np.ndarray
    """(trial, 2) float64: where, in board units."""
    outcomes: np.ndarray
    """(trial,) int64: how."""
    colours: np.ndarray
    """(trial, 3) uint8: of each outcome, paler with age in trials; so what stands still does not
    fade, nor is there more where it is fast."""


def way_of(snapshot: Snapshot, rests: bool) -> Way:
    """The hunt that is shown at a moment.

    That of the running trial; where the learner rests at the start of one, that which has ended.
    """
    if rests and snapshot.trial_step == 0 and snapshot.ends:
        last = snapshot.ends[-1]
        # Of a long one, the way may not be known any more.
        cells = snapshot.paths[-1].cells if snapshot.paths else np.array([last.cell])
        return Way(cells, last.heading, last.outcome)
    return Way(snapshot.trail, snapshot.heading)


def placed(
    world: World,
    spec: WorldSpec,
    look: Look,
    cells: np.ndarray,
    heading: int | np.ndarray,
    shown: int,
) -> np.ndarray:
    """Where cells of trials are drawn, ``(n, 2)``: what has no place there, at its edge."""
    places = on_picture(world, cells, heading, shown).reshape(-1, 2)
    return kept_on_board(places, spec, folds(look))


def ends_of(snapshot: Snapshot, look: Look, shown: int, theme: Theme) -> Ends:
    """The ends that are drawn in a picture whose prey faces ``shown``."""
    ends = snapshot.ends if look.hunts else ()
    cells = np.array([end.cell for end in ends], np.int64)
    headings = np.array([end.heading for end in ends], np.int64)
    places = placed(snapshot.world, snapshot.spec.world, look, cells, headings, shown)
    age = np.linspace(_FADED, 0.0, len(ends))[:, None]
    fresh = np.array([theme.of_outcome(end.outcome) for end in ends], float).reshape(-1, 3)
    colours = np.rint(fresh * (1 - age) + np.array(theme.unknown) * age).astype(np.uint8)
    return Ends(places, np.array([end.outcome for end in ends], np.int64), colours)


def sketched(snapshot: Snapshot, look: Look, path: TrialPath, shown: int) -> np.ndarray:
    """Some points of a path, its first and last among them, ``(n, 2)``."""
    chosen = np.unique(np.linspace(0, len(path.cells) - 1, _PATH_POINTS).astype(int))
    cells = path.cells[chosen]
    return placed(snapshot.world, snapshot.spec.world, look, cells, path.heading, shown)


# Words ----------------------------------------------------------------------------------------


def names_of(spec: WorldSpec, look: Look, way: Way, here: np.ndarray, shown: int) -> list[Tag]:
    """What is what; where the predator is that has ended its hunt stands what that came to."""
    tags: list[Tag] = []
    if look.field and spec.vision_radius * BOARD_UNITS / STANDARD_SIZE >= _LEAST_FIELD:
        tags.append(Tag(_FIELD_NAME, _turned(_FIELD_PLACE, shown), within=True))
    tags.append(Tag("prey", (0.0, 0.0)))
    word = "predator" if way.outcome is None else ENDED.get(way.outcome, "predator")
    return [*tags, Tag(word, (float(here[0]), float(here[1])))]


def end_of(way: Way, here: np.ndarray) -> list[Tag]:
    """What a hunt came to, beside where it ended; nothing of one that goes on."""
    word = "" if way.outcome is None else ENDED.get(way.outcome, "")
    return [Tag(word, (float(here[0]), float(here[1])))] if word else []


def arrow_middle(shown: int) -> tuple[float, float]:
    """The middle of the prey's arrow in a picture, which no word is to cover."""
    return _turned(_ARROW_PLACE, shown)


def _turned(place: tuple[float, float], heading: int) -> tuple[float, float]:
    """A place beside a prey that faces east, beside one that faces another way."""
    turned = np.exp(1j * heading * np.pi / 4) * complex(*place)
    return float(turned.real), float(turned.imag)
