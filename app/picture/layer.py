"""What a layer is, and what it draws: colours, arrows and names from a snapshot and a look."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.contours import Contour
from app.picture.look import OF_TRIAL, Look
from app.picture.raster import Raster, on_raster, raster
from learners.learner_spec import LearnerSpec


@dataclass(frozen=True, eq=False)
class SuccessMap:
    """How hunts without exploration end, by where they start."""

    outcomes: np.ndarray
    """(heading, y, x) int8: ``CAPTURE``, ``FLIGHT`` or ``TIMEOUT``; 0 where not known."""
    trial: int
    """Trial whose tables were followed."""
    generation: int
    """Run of the session to which they belong."""


@dataclass(frozen=True)
class Extras:
    """What layers show besides a snapshot."""

    success: SuccessMap | None = None
    since: Snapshot | None = None
    """The moment A, which another one is set against."""
    names: tuple[str, str] | None = None
    """What the run of A is called and what the other one is, where they are two side by side."""


class Label(NamedTuple):
    """What stands written at a place of the board."""

    text: str
    east: float
    """Cells east of the prey, and north of it."""
    north: float


class Over(NamedTuple):
    """What is drawn over the colours of a picture."""

    contours: tuple[Contour, ...] = ()
    """Lines, the last on top."""
    labels: tuple[Label, ...] = ()


class Picture(NamedTuple):
    """What a layer draws."""

    colours: np.ndarray
    """(y * x, 3) uint8."""
    arrows: np.ndarray | None = None
    """(n, 2, 2) float32: tail and head, each in cells east and north of the prey."""
    arrow_colours: np.ndarray | None = None
    """(n, 3) uint8; without them arrows have the colour of writing."""
    regions: np.ndarray | None = None
    """(y * x,) int: which of the names holds in each cell, -1 for none."""
    names: tuple[str, ...] = ()
    """What stands on the board where its colour is to be seen, for those who cannot tell it."""
    edges: Callable[[], tuple[Contour, ...]] = tuple
    """Lines round regions, over all others."""
    within: Callable[[], Over] = Over
    """Other lines, and labels; they take longer to find than all colours and edges."""

    def over(self) -> Over:
        """All lines and labels, which are drawn less often than colours."""
        within = self.within()
        return Over((*within.contours, *self.edges()), within.labels)


Heeded = Literal["frame", "scale", "fitted", "flight"]


class Lack(NamedTuple):
    """What a learner has not that a layer is about."""

    word: str
    """In a few words, for the list of layers."""
    why: str
    """In a sentence, in the place of what would be seen."""


class Layer(NamedTuple):
    """One thing that the board can show."""

    key: str
    title: str
    draw: Callable[[Snapshot, Look, Extras, Raster], Picture]
    """Draws on any raster; arrows are for a raster of one pixel for each cell."""
    legend: Callable[[Snapshot, Look, Extras], Markup]
    """For a narrow panel: what the colours mean, and the limits of their scale."""
    caption: Callable[[Snapshot, Look, Extras], str]
    """One line on what is being seen."""
    about: Literal["nothing", "option", "skill"] = "nothing"
    """Whether it shows one option, or one skill, of the look."""
    heeds: frozenset[Heeded] = frozenset({"frame", "fitted"})
    """What of a look matters to it.

    One that heeds no frame does not depend on where the prey looks, and is drawn as the world is,
    without the prey's heading and what it sees.
    """

    by: Literal["state", "cell"] = "state"
    """What its colours depend on, besides the patterns of a raster: on the state alone that lies
    under a pixel, or on its cell."""
    lacks: Callable[[LearnerSpec], Lack | None] = lambda learner: None
    """Why there is nothing to see of a learner; None where there is."""
    titled: Callable[[LearnerSpec], str | None] = lambda learner: None
    """What it is called for a learner; None where by its title."""
    ignores: Callable[[LearnerSpec, int], frozenset[Heeded]] = lambda learner, option: frozenset()
    """What it does not heed of a look for a learner, if it is about such an option or skill."""

    def title_of(self, learner: LearnerSpec) -> str:
        """What it is called where it shows a learner."""
        return self.titled(learner) or self.title

    def listed(self, learner: LearnerSpec) -> str:
        """How a list of layers names it: with what the learner lacks, where it shows nothing."""
        lack = self.lacks(learner)
        return self.title_of(learner) + (f" ({lack.word})" if lack else "")

    def heeds_of(self, learner: LearnerSpec | None, option: int = 0) -> frozenset[Heeded]:
        """What of a look matters to it for a learner; None if it is not known which one."""
        return self.heeds if learner is None else self.heeds - self.ignores(learner, option)

    def heeded(self, look: Look, learner: LearnerSpec | None) -> Look:
        """A look in which what does not matter to this layer is as it is at first."""
        heeds = self.heeds_of(learner, look.option)
        return look._replace(
            frame=look.frame if "frame" in heeds else OF_TRIAL,
            scale=look.scale if "scale" in heeds else "steps",
            fitted="fitted" in heeds and look.fitted,
            flight="flight" in heeds and look.flight,
        )

    def paint(self, snapshot: Snapshot, look: Look, extras: Extras) -> Picture:
        """The picture on the board."""
        return self.draw(snapshot, look, extras, raster(snapshot.spec.world))


def spread(colours: np.ndarray, raster: Raster) -> Picture:
    """A picture from colours of states, ``(distance, direction, 3)``."""
    return Picture(on_raster(colours.astype(np.uint8, copy=False), raster))


def blank(look: Look, raster: Raster) -> Picture:
    """The empty board."""
    board = np.array(look.theme.unknown, np.uint8)
    return Picture(np.tile(board, (len(raster.cells), 1)))
