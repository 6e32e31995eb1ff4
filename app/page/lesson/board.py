"""A question about the octants round the prey, asked and answered on the board of one browser.

While it is open a click on the board chooses an octant, or takes it back. What was guessed is
outlined and hatched; what came of it is filled, and numbers say in how many runs it was so. All of
it is drawn for this browser alone, over the board, and gone with the question.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final, NamedTuple

import numpy as np
import viser

from app.lessons.words import Words, words_of
from app.live.snapshot import Snapshot
from app.page.scene.parts import Parts, Viewer, Writing
from app.page.widgets import assign
from app.picture import octants
from app.picture.frames import rim
from app.picture.look import ALL, Look, heading_shown
from app.picture.octants import OCTANTS, Fill
from app.picture.outlines import BOARD_UNITS, lifted, segments
from app.picture.theme import Theme

ROOT: Final = "/asked"
"""Below which all of it is drawn."""

_INNER: Final = 0.42
"""Radius at which octants begin: the prey has its own room."""
_INSET: Final = 0.06
_HATCH_APART: Final = 0.42
_GUESS_OUTER: Final = 0.9
"""How far outlines of a guess reach, as a share of the radius of the board."""
_RUN, _RUN_BAND = 0.2, 0.85
"""How strongly the run's octants are filled, and the band along their rim."""
_BAND: Final = (0.92, 0.985)
"""From where to where that band is, as shares of the radius."""
_FAINTEST, _STRONGEST = 0.1, 0.75
"""How strongly those are filled that nobody of a class chose, and that all did."""
_HEAT: Final = (0.14, 0.56)
"""From where to where the answers of a class are drawn, as shares of the radius of the board."""
_PIXELS: Final = 480
_HEAT_COLOUR: Final = ((192, 86, 0), (255, 169, 77))
"""Of a class's answers, on a light page and on a dark one, as on the card."""
_SMALL, _LARGE = 0.41, 0.5
"""Heights of words, in board units."""
_NAMES_AT, _HEAT_AT = 0.74, 0.37
"""Where names and numbers stand, as shares of the radius."""
_LEGEND_AT: Final = (4.03, 5.72)
"""East and north of the legend's corners."""
# Heights above the board: fills below lines and hunts, what was guessed above.
_Z_FILLS, _Z_BORDERS, _Z_HATCH, _Z_RIM, _Z_GUESS, _Z_WORDS = (
    *(0.012, 0.022, 0.0225),
    *(0.0285, 0.029, 0.06),
)


class OctantsAsked(NamedTuple):
    """What is asked about the octants, and what is known of the answer."""

    guess: frozenset[str] = frozenset()
    """Those that were chosen, as in :data:`app.picture.octants.OCTANTS`."""
    locked: bool = False
    """Whether the guess stands."""
    run: frozenset[str] | None = None
    """Those that it came to in this run; None as long as that is not to be seen."""
    twenty: Mapping[str, int] | None = None
    """Of each, in how many of some runs it came to it."""
    runs: int = 20
    """So many."""
    others: Mapping[str, float] | None = None
    """Of each, what share of a class chose it."""
    language: str = "en"
    """In which it is asked."""

    @property
    def words(self) -> Words:
        """Of the language in which it is asked."""
        return words_of(self.language)

    @property
    def is_open(self) -> bool:
        """Whether the guess can be changed."""
        return not self.locked


Toggled = Callable[[frozenset[str]], object]
"""Called with the whole of a guess that a click made another."""


class BoardAsk:
    """What one browser is asked on its board. The render loop alone has to do with it."""

    def __init__(self, client: Viewer, wake: Callable[[], object] = lambda: None) -> None:
        """``wake`` lets the render loop draw at once."""
        self._client, self._wake = client, wake
        self._asked: OctantsAsked | None = None
        self._toggled: Toggled = _nobody
        self._drawn: _Drawn | None = None
        self._key: tuple[object, ...] | None = None

    @property
    def asked(self) -> OctantsAsked | None:
        """What is asked now."""
        return self._asked

    def ask(self, asked: OctantsAsked | None, toggled: Toggled | None = None) -> None:
        """Ask this from now on, or nothing any more; ``toggled`` hears of what is chosen."""
        self._asked, self._toggled = asked, toggled or _nobody
        self._wake()

    def take_place(self, place: tuple[float, float], snapshot: Snapshot, look: Look) -> bool:
        """Take a click on the board, if it chooses an octant; whether it is done with.

        Args:
            place: east and north of the prey, in board units.
            snapshot: the moment that is seen.
            look: how it is seen.
        """
        asked = self._asked
        if asked is None or not asked.is_open or look.frame == ALL:
            return False
        cell = BOARD_UNITS / snapshot.world.size
        if max(abs(place[0]), abs(place[1])) > cell / 2:
            octant = octants.octant_at(*place, heading_shown(look, snapshot.heading))
            if octant is not None:
                self._toggled(asked.guess ^ {octant})
        self._wake()
        return True

    def update(self, snapshot: Snapshot, look: Look) -> None:
        """Show what is asked on the board of a moment; sends nothing if nothing has changed."""
        asked = self._asked if look.frame != ALL else None
        heading, size = heading_shown(look, snapshot.heading), snapshot.world.size
        key = None if asked is None else (asked, heading, look.theme, size)
        if key == self._key:
            return
        former, self._key = self._key, key
        with self._client.atomic():
            if asked is None or (former is not None and former[2] != look.theme):
                self._remove()
            if asked is not None:
                if self._drawn is None:
                    self._drawn = _Drawn(self._client.scene, look.theme)
                radius = rim(snapshot.spec.world) * BOARD_UNITS / size
                self._drawn.show(asked, heading, radius)

    def _remove(self) -> None:
        if self._drawn is not None:
            self._drawn.remove()
            self._drawn = None


def _nobody(_: frozenset[str]) -> None:
    """Hears of what nobody waits for."""


class _Drawn(Parts):
    """What is drawn of a question."""

    def __init__(self, scene: viser.SceneApi, theme: Theme) -> None:
        super().__init__(scene, ROOT.removeprefix("/"))
        self._theme = theme
        self._borders = self._line("borders", theme.border, 1.5)
        self._hatch = self._line("hatch", theme.ink, 1.5)
        self._rim = self._line("rim", theme.unknown, 8.0)
        self._guess = self._line("guess", theme.ink, 4.5)
        self._words: Writing = self._keep(Writing(scene, "asked/words", _SMALL, len(OCTANTS) + 4))
        self._numbers: Writing = self._keep(Writing(scene, "asked/numbers", _LARGE, len(OCTANTS)))
        self._fills: Any = None
        self._filled: tuple[object, ...] = ()

    def show(self, asked: OctantsAsked, heading: int, radius: float) -> None:
        """Draw it.

        Args:
            asked: what is asked, and what is known.
            heading: where the prey looks in the picture.
            radius: of the board, in board units.
        """
        outer = _GUESS_OUTER * radius
        guess = octants.in_order(asked.guess)
        lines, strokes = [np.zeros((0, 2, 2))], [np.zeros((0, 2, 2))]
        for octant in guess:
            edge = octants.outline(octant, _INNER, outer, _INSET, heading)
            lines.append(segments(edge))
            strokes.append(octants.hatch(octant, _INNER, outer, _HATCH_APART, heading))
        edges = np.concatenate(lines)
        self._set(self._guess, "guess", lifted(edges, _Z_GUESS))
        self._set(self._rim, "rim", lifted(edges, _Z_RIM))
        self._set(self._hatch, "hatch", lifted(np.concatenate(strokes), _Z_HATCH))
        between = octants.borders(_INNER, radius, heading)
        self._set(self._borders, "borders", lifted(between, _Z_BORDERS))
        self._show_fills(tuple(self._fills_of(asked, radius)), heading)
        words = [*_names_of(asked, heading, radius), *_legend_of(asked)]
        self._words.write([(text, (*at, _Z_WORDS)) for text, at in words])
        numbers = _shares_of(asked, heading, radius)
        self._numbers.write([(text, (*at, _Z_WORDS)) for text, at in numbers])

    def _fills_of(self, asked: OctantsAsked, radius: float) -> Iterable[Fill]:
        for octant in octants.in_order(asked.run or ()):
            yield Fill(octant, _INNER, radius, self._theme.capture, _RUN)
            inner, outer = (share * radius for share in _BAND)
            yield Fill(octant, inner, outer, self._theme.capture, _RUN_BAND)
        heat = _HEAT_COLOUR[self._theme.is_dark]
        for octant in OCTANTS if asked.others is not None else ():
            share = (asked.others or {}).get(octant, 0.0)
            strength = _FAINTEST + share * (_STRONGEST - _FAINTEST)
            yield Fill(octant, _HEAT[0] * radius, _HEAT[1] * radius, heat, strength)

    def _show_fills(self, fills: tuple[Fill, ...], heading: int) -> None:
        if (fills, heading) == self._filled:
            return
        self._filled = (fills, heading)
        image = octants.filled(fills, BOARD_UNITS, _PIXELS, heading)
        if self._fills is None:
            if not fills:
                return
            self._fills = self._keep(
                self._scene.add_image(
                    f"{ROOT}/fills",
                    image,
                    BOARD_UNITS,
                    BOARD_UNITS,
                    format="png",
                    cast_shadow=False,
                    receive_shadow=False,
                    position=(0.0, 0.0, _Z_FILLS),
                )
            )
            return
        self._fills.image = image
        assign(self._fills, "visible", bool(fills))


_Words = list[tuple[str, tuple[float, float]]]


def _names_of(asked: OctantsAsked, heading: int, radius: float) -> _Words:
    """What stands in each octant: its name, or, once that is known, in how many runs it was so."""

    def text(octant: str) -> str:
        if asked.twenty is None:
            return asked.words.octant(octant)
        return asked.words.say("board.k_of_n", k=asked.twenty.get(octant, 0), n=asked.runs)

    return [(text(o), octants.middle(o, _NAMES_AT * radius, heading)) for o in OCTANTS]


def _shares_of(asked: OctantsAsked, heading: int, radius: float) -> _Words:
    """Of each octant, how many of a class chose it."""
    if asked.others is None:
        return []
    return [
        (
            asked.words.percent(asked.others.get(o, 0.0)),
            octants.middle(o, _HEAT_AT * radius, heading),
        )
        for o in OCTANTS
    ]


def _legend_of(asked: OctantsAsked) -> _Words:
    """What is what, in the corners that a round board leaves."""
    (east, north), say = _LEGEND_AT, asked.words.say
    words: _Words = []
    if asked.guess:
        words.append((say("board.guess"), (-east, north)))
    if asked.twenty is not None:
        words.append((say("board.numbers", n=asked.runs), (east, north)))
    if asked.run is not None:
        words.append((say("board.run"), (-east, -north)))
    if asked.others is not None:
        words.append((say("board.class"), (east, -north)))
    return words
