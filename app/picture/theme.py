"""What a page looks like: the colours of light and of dark ones, and the shapes of dots."""

from collections.abc import Mapping
from typing import Final, Literal, NamedTuple

from sim.world import CAPTURE, FLIGHT, TIMEOUT

Colour = tuple[int, int, int]


class Theme(NamedTuple):
    """Colours of one kind of page, each ``(r, g, b)`` of 0...255."""

    unknown: Colour
    """The board where nothing is known."""
    lines: Colour
    border: Colour
    field: Colour
    """The visual field."""
    prey: Colour
    predator: Colour
    capture: Colour
    flight: Colour
    timeout: Colour
    loss: Colour
    zone: Colour
    """The circles between which trials start."""
    ink: Colour
    forced: Colour
    """Forced exploration, wherever it is shown."""

    @property
    def is_dark(self) -> bool:
        """Whether the page is darker than what is written on it."""
        return sum(self.unknown) < sum(self.ink)

    def of_outcome(self, outcome: int) -> Colour:
        """Colour of a way to end a trial; that of the board for what is not known."""
        colours = {CAPTURE: self.capture, FLIGHT: self.flight, TIMEOUT: self.timeout}
        return colours.get(outcome, self.unknown)


Shape = Literal["circle", "diamond", "square"]
OUTCOME_SHAPES: Final[Mapping[int, Shape]] = {
    CAPTURE: "circle",
    FLIGHT: "diamond",
    TIMEOUT: "square",
}
"""Dots of ended trials, for those who cannot tell their colours apart."""

LIGHT = Theme(
    unknown=(244, 245, 247),
    lines=(222, 225, 230),
    border=(90, 98, 110),
    field=(60, 20, 90),
    prey=(20, 24, 32),
    predator=(213, 60, 0),
    capture=(0, 120, 180),
    flight=(80, 0, 160),
    timeout=(136, 141, 151),
    loss=(112, 0, 220),
    zone=(0, 130, 70),
    ink=(30, 34, 42),
    forced=(190, 24, 110),
)
DARK = Theme(
    unknown=(30, 33, 40),
    lines=(48, 52, 62),
    border=(150, 158, 172),
    field=(245, 235, 255),
    prey=(250, 250, 252),
    predator=(255, 140, 60),
    capture=(90, 200, 255),
    flight=(190, 120, 255),
    timeout=(120, 125, 135),
    loss=(105, 15, 255),
    zone=(120, 225, 140),
    ink=(232, 234, 240),
    forced=(255, 128, 190),
)
