"""Change since A: how much nearer a capture is than it was at another moment, or farther.

The other moment may be of another run: then it is the difference of two that are side by side.
"""

from typing import Final, NamedTuple

import numpy as np
from markupsafe import Markup, escape

from app.live.snapshot import Snapshot
from app.picture.colours import FARTHER, NEARER, Ramp, amount_colours, css, palette
from app.picture.contours import Contour, edges
from app.picture.counted import counted_by
from app.picture.frames import in_frame
from app.picture.layer import Extras, Lack, Layer, Picture, blank
from app.picture.legend import bar, frame_in_words, hatch, legend, limits, patch_of_board, swatch
from app.picture.look import ALL, Look
from app.picture.raster import Raster, on_raster, raster, sensors_of
from app.picture.shading import SHOWN_FROM, Ruler, equivalent_steps, mean_of
from app.picture.theme import Colour, Theme
from app.picture.value_maps import counted_of, or_zero, reward_of
from app.util.html import element, joined
from app.words.glossary import term
from learners.learner_spec import LearnerSpec
from sim.spec import N_HEADINGS

_LEAST_STEPS: Final = 1.0
"""Less than a step is no change that anybody should look at."""
_MARKS: Final = (20.0, 5.0)
"""Steps at which the bar has a mark on both sides, besides those at its ends; the first of them
that are on it are what the legend says in words."""
_LEAST_SHARE: Final = 0.005
"""Less of the area than this is not told of."""
_SAME_ON_LIGHT: Final[Colour] = (204, 207, 213)
_SAME_ON_DARK: Final[Colour] = (68, 72, 82)
_NO_TABLE: Final = Lack(
    "no table selects",
    "A rule selects here, so no value says how far off a capture is, and none can come nearer.",
)
_NO_A: Final = (
    "There is no A yet. The key A makes the moment that you look at A; then go to another moment."
)


class _Change(NamedTuple):
    """What two moments say of each place, ``(distance, direction)``."""

    steps: np.ndarray
    """float64: mean change over the headings that know of it at both, NaN where none does."""
    was: np.ndarray
    """bool: at A at least half of the headings knew a way to a capture."""
    known: np.ndarray
    """bool: at this moment they do."""

    @property
    def both(self) -> np.ndarray:
        """Where there is a change to tell."""
        return self.was & self.known & ~np.isnan(self.steps)

    @property
    def new(self) -> np.ndarray:
        """Where a way to a capture is known, and was not."""
        return self.known & ~self.both

    @property
    def lost(self) -> np.ndarray:
        """Where one was known, and is no longer."""
        return self.was & ~self.known


class _Words(NamedTuple):
    """How the two moments, and what is different, are called."""

    what: str
    """In the legend, after "Steps to capture"."""
    against: str
    """In the caption, before what is different."""
    same: str
    """That nothing can be different."""
    unknown: str
    """That neither knows a way to a capture."""
    nearer: str
    farther: str
    new: str
    lost: str
    ends: tuple[str, str]
    """Of the bar: what comes after the steps on its left, and what stands on its right."""
    line: str
    """What the thick line is."""


def _words(snapshot: Snapshot, since: Snapshot, extras: Extras) -> _Words:
    if extras.names is not None:
        return _words_of_two(snapshot, since, *extras.names)
    word = "Since" if since.step <= snapshot.step else "Beside"
    return _Words(
        what=f"what changed since A, trial {since.trial:,}",
        against=f"{word} A, trial {since.trial:,}",
        same="this is A itself. Go to another moment to see what is different",
        unknown="no way to a capture is known at either moment",
        nearer="nearer",
        farther="farther",
        new="newly known",
        lost="no longer known",
        ends=("steps nearer", "as many farther"),
        line="Thick line: where value ends at this moment.",
    )


def _words_of_two(snapshot: Snapshot, since: Snapshot, other: str, own: str) -> _Words:
    at = f"at step {snapshot.step:,}"
    if since.step != snapshot.step:
        at = f"{at} and {since.step:,}"
    return _Words(
        what=f"{own} and {other}, {at}",
        against=f"{own} and {other}, {at}",
        same="each knows what the other knows",
        unknown="neither knows a way to a capture",
        nearer=f"nearer for {own}",
        farther=f"nearer for {other}",
        new=f"known to {own} alone",
        lost=f"known to {other} alone",
        ends=(f"steps nearer for {own}", f"as many for {other}"),
        line=f"Thick line: where value ends for {own}.",
    )


def _since(snapshot: Snapshot, extras: Extras) -> Snapshot | None:
    """The moment A, if it is of a world with the same places, and its values count the same."""
    since = extras.since
    if since is None or sensors_of(since.spec.world) != sensors_of(snapshot.spec.world):
        return None
    if counted_by(since.spec.learner) != counted_by(snapshot.spec.learner):
        return None
    return since


def _steps(snapshot: Snapshot) -> np.ndarray:
    """Steps to capture, ``(heading, distance, direction) float64``; NaN where there is no value."""
    gamma = snapshot.spec.learner.gamma
    return equivalent_steps(or_zero(snapshot.value), reward_of(snapshot), gamma)


def _change(snapshot: Snapshot, since: Snapshot, look: Look) -> _Change:
    then, now = (in_frame(_steps(moment), snapshot, look) for moment in (since, snapshot))
    differences = now - then
    both = ~np.isnan(differences)
    fewest = SHOWN_FROM * len(now)
    return _Change(
        steps=mean_of(np.where(both, differences, 0.0), both.sum(axis=0), np.nan),
        was=(~np.isnan(then)).sum(axis=0) >= fewest,
        known=(~np.isnan(now)).sum(axis=0) >= fewest,
    )


def _ruler(snapshot: Snapshot, since: Snapshot, look: Look) -> Ruler:
    """Of the size of a change; the same for what is nearer and for what is farther."""
    most = counted_of(snapshot).most_changed
    if look.fitted:
        # Of all headings, whatever the frame.
        sizes = np.abs(_steps(snapshot) - _steps(since))
        most = max(float(np.nan_to_num(sizes).max()), _LEAST_STEPS)
    return Ruler(0.0, most, "root")


def _same(theme: Theme) -> Colour:
    return _SAME_ON_DARK if theme.is_dark else _SAME_ON_LIGHT


def _colours(steps: np.ndarray, ruler: Ruler, theme: Theme) -> np.ndarray:
    """Colours of changes, ``(..., 3) uint8``."""
    level = ruler.place(np.abs(steps))
    nearer = palette(amount_colours(NEARER, theme), level)
    farther = palette(amount_colours(FARTHER, theme), level)
    colours = np.where((steps < 0)[..., None], nearer, farther)
    is_same = np.abs(steps) < _LEAST_STEPS
    return np.rint(np.where(is_same[..., None], np.array(_same(theme)), colours)).astype(np.uint8)


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    since = _since(snapshot, extras)
    picture = blank(look, raster)
    if since is None:
        return picture
    theme, world = look.theme, snapshot.spec.world
    change = _change(snapshot, since, look)
    both = on_raster(change.both, raster)
    colours = _colours(np.nan_to_num(change.steps), _ruler(snapshot, since, look), theme)
    picture.colours[both] = on_raster(colours, raster)[both]
    new = on_raster(change.new, raster) & raster.rising
    picture.colours[new] = _strongest(NEARER, theme)
    lost = on_raster(change.lost, raster) & raster.falling
    picture.colours[lost] = _strongest(FARTHER, theme)

    def known_edges() -> tuple[Contour, ...]:
        return (Contour(edges(change.known, world), theme.ink, is_edge=True),)

    return picture._replace(edges=known_edges)


def _strongest(ramp: Ramp, theme: Theme) -> np.ndarray:
    return np.rint(amount_colours(ramp, theme)[-1]).astype(np.uint8)


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    since = _since(snapshot, extras)
    knew = "knew a way at both moments" if extras.names is None else "know a way in both"
    frame = frame_in_words(snapshot, look, f"the mean of those that {knew}")
    if since is None:
        return legend(look, _title(extras), [element("div", _why_none(extras))], frame)
    theme, ruler = look.theme, _ruler(snapshot, since, look)
    words = _words(snapshot, since, extras)
    marks = [steps for steps in _MARKS if steps < ruler.high / 2]
    said = marks[0] if marks else ruler.high
    nearer, farther, same = (_colours(np.array(at), ruler, theme) for at in (-said, said, 0.0))
    key = [
        swatch(css(nearer), f"{words.nearer} by {_number(said)}"),
        swatch(css(farther), f"{words.farther} by {_number(said)}"),
        swatch(css(same), "by less than 1"),
    ]
    patterns = [
        hatch(css(_strongest(NEARER, theme)), words.new),
        hatch(css(_strongest(FARTHER, theme)), words.lost, falls=True),
        patch_of_board(look, "no value"),
    ]
    left, right = words.ends
    nouns = counted_of(snapshot).nouns
    left = left.replace("steps", nouns, 1)
    return legend(
        look,
        escape(f"{nouns.capitalize()} to capture: {words.what}")
        if nouns != "steps"
        else term("steps to capture", "Steps to capture") + f": {words.what}",
        [
            bar(_bar(ruler, theme), _bar_marks(ruler, marks, look)),
            limits(look, f"{_number(ruler.high)} {left}", right),
            element("div", joined(key, "")),
            element("div", joined(patterns, "")),
            element("div", words.line, class_="lines"),
        ],
        frame,
    )


def _number(steps: float) -> str:
    return f"{steps:.0f}" if steps >= 10 else f"{steps:.2g}"


def _bar(ruler: Ruler, theme: Theme) -> np.ndarray:
    """Colours of the bar, ``(256, 3)``: what is nearest on its left, what is farthest right."""
    place = np.linspace(-1.0, 1.0, 256)
    # The ruler is by the root.
    return _colours(np.sign(place) * place**2 * ruler.high, ruler, theme).astype(np.float64)


def _bar_marks(ruler: Ruler, marks: list[float], look: Look) -> list[tuple[float, str]]:
    end = _number(ruler.high) + ("" if look.fitted else "+")
    texts = [(1.0, end), *((float(ruler.place(steps)), _number(steps)) for steps in marks)]
    left = [(0.5 - place / 2, text) for place, text in texts]
    right = [(0.5 + place / 2, text) for place, text in reversed(texts)]
    return [*left, (0.5, "0"), *right]


def _title(extras: Extras) -> str:
    if extras.names is None:
        return "Change since A"
    other, own = extras.names
    return f"Difference of {own} and {other}"


def _why_none(extras: Extras) -> str:
    """What to do, or why nothing is to be seen."""
    if extras.names is not None:
        return (
            "Their worlds have other places, or their values count other things, so they cannot be"
            " set against one another."
        )
    if extras.since is None:
        return _NO_A
    return "A is a moment of another world, or of another kind of learner; set A (key A) anew."


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    since = _since(snapshot, extras)
    if since is None:
        return f"{_title(extras)}: {_why_none(extras)}"
    words = _words(snapshot, since, extras)
    is_itself = (since.generation, since.step) == (snapshot.generation, snapshot.step)
    if is_itself and extras.names is None:
        return f"{words.against}: {words.same}."
    if not (snapshot.value > 0).any() and not (since.value > 0).any():
        return f"{words.against}: {words.unknown}."
    if extras.names is not None and np.array_equal(snapshot.value, since.value):
        return f"{words.against}: {words.same}."
    nearer, farther, new, lost = _shares(snapshot, since, look)
    parts = [f"a capture is {words.nearer} in {nearer:.0%} of the area that has value"]
    parts.append(f"{words.farther} in {farther:.0%}")
    parts += [
        f"{what} in {share:.0%}"
        for what, share in ((words.new, new), (words.lost, lost))
        if share >= _LEAST_SHARE
    ]
    return f"{words.against}: {', '.join(parts)}."


def _shares(snapshot: Snapshot, since: Snapshot, look: Look) -> np.ndarray:
    """How much of the area that has or had value came nearer, went away, is new, and is lost."""
    frames = range(N_HEADINGS) if look.frame == ALL else (look.frame,)
    pixels = raster(snapshot.spec.world)
    areas = np.zeros(5)
    for frame in frames:
        change = _change(snapshot, since, look._replace(frame=frame))
        steps = np.where(change.both, np.nan_to_num(change.steps), 0.0)
        kinds = (
            steps <= -_LEAST_STEPS,
            steps >= _LEAST_STEPS,
            change.new,
            change.lost,
            change.was | change.known,
        )
        areas += [on_raster(places, pixels).sum() for places in kinds]
    return areas[:-1] / max(areas[-1], 1)


def _lacks(learner: LearnerSpec) -> Lack | None:
    return None if counted_by(learner) else _NO_TABLE


CHANGE = Layer(
    "change",
    "Change since A",
    _draw,
    _legend,
    _caption,
    lacks=_lacks,
)
