"""What a page looks like: the colours of light and of dark ones, and the shapes of dots."""

from collections.abc import Mapping
from typing import Final, Literal, NamedTuple

from sim.world import CAPTURE, FLIGHT, TIMEOUT

Colour = tuple[int, int, int]


class Theme(NamedTuple):
    """Colours of one kind of page, each ``(r, g, b)`` of 0...255.

    No two things on one screen have one colour. Those that are not here: values are green and
    yellow (:func:`app.picture.colours.gain_colours`), skills have a colour each
    (``OPTION_COLOURS`` there).
    """

    unknown: Colour
    """The board where nothing is known."""
    lines: Colour
    border: Colour
    field: Colour
    """The visual field: the prey's colour, for it is what the prey sees."""
    prey: Colour
    predator: Colour
    capture: Colour
    flight: Colour
    """The prey has noticed the predator and fled, or is expected to."""
    timeout: Colour
    forced: Colour
    """Exploration that the schedule, or somebody by hand, forces on the learner."""
    frozen: Colour
    """What is not to change; drawn as a hatch, for there is hardly a grey left."""
    zone: Colour
    """The circles between which trials start."""
    ink: Colour

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
    field=(20, 24, 32),
    prey=(20, 24, 32),
    predator=(213, 60, 0),
    capture=(0, 50, 170),
    flight=(185, 70, 225),
    timeout=(104, 110, 122),
    forced=(190, 120, 0),
    frozen=(150, 154, 162),
    zone=(72, 84, 104),
    ink=(30, 34, 42),
)
DARK = Theme(
    unknown=(30, 33, 40),
    lines=(48, 52, 62),
    border=(150, 158, 172),
    field=(250, 250, 252),
    prey=(250, 250, 252),
    predator=(255, 110, 45),
    capture=(110, 190, 255),
    flight=(200, 100, 250),
    timeout=(150, 155, 165),
    forced=(250, 180, 50),
    frozen=(104, 109, 120),
    zone=(176, 190, 214),
    ink=(232, 234, 240),
)
