"""Chosen skill: the option of most value in each place."""

from collections.abc import Callable
from typing import Final

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.arrows import arrows, at_places
from app.picture.colours import css
from app.picture.contours import Contour, edges
from app.picture.frames import folds, in_frame
from app.picture.giving_way import has_rule, minds
from app.picture.layer import Extras, Layer, Picture, spread
from app.picture.legend import frame_in_words, hatch, legend, patch_of_board, swatch
from app.picture.look import Look
from app.picture.options import (
    greedy,
    has_moves,
    kind_of,
    lone_option,
    option_colours,
    option_names,
    options_in_frame,
    present,
)
from app.picture.raster import Raster, on_raster
from app.picture.shading import SHOWN_FROM
from app.picture.theme import Colour
from app.picture.value_maps import or_zero
from app.util.html import element, joined
from app.words.plain import MOVE_NAMES, RULES_IN_WORDS
from learners.kernel.layout import regions_of
from learners.learner_spec import LearnerSpec
from learners.names import COMMANDS, MOVES

_CONTESTED_FROM = 1 / 4
"""Share of the headings for which skills must be at odds for it to be seen who has its way."""
_AGREED_ON_LIGHT: Final[Colour] = (204, 207, 213)
_AGREED_ON_DARK: Final[Colour] = (68, 72, 82)
_MOVE_SIGNS = "↙↓↘←·→↖↑↗"


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    choice = _choices(snapshot, look)
    names = _names(snapshot)
    votes = np.stack([(choice == k).sum(axis=0, dtype=np.int8) for k in range(len(names))])
    fewest = _fewest(snapshot, len(choice))
    if has_rule(snapshot):
        # They agree in nearly all places for nearly all headings: what is contested comes first.
        fewest = _CONTESTED_FROM * len(choice)
        votes[-1][(votes[:-1] >= fewest).any(axis=0)] = 0
    most, winner = votes.max(axis=0), votes.argmax(axis=0)
    # As many headings for another option would make the colour an accident.
    is_clear = ((votes == most).sum(axis=0) == 1) & (most >= fewest)
    board = np.array(look.theme.unknown, np.uint8)
    colours = _colours(snapshot, look)[winner].astype(np.uint8)
    picture = spread(np.where(is_clear[..., None], colours, board), raster)
    world = snapshot.spec.world
    is_split = on_raster(~is_clear & _is_learned(snapshot, look), raster)
    picture.colours[is_split & raster.rising] = look.theme.frozen
    if has_moves(snapshot):
        # Nine colours are too many to keep apart, so moves are drawn as what they are, too.
        ways = arrows(at_places(choice, world, raster.side), world, raster.side)
        return picture._replace(arrows=ways.ends)
    if lone_option(snapshot) is not None:
        return picture
    regions = on_raster(np.where(is_clear, winner, -1), raster)
    return picture._replace(regions=regions, names=names, edges=_edges_of(snapshot, look))


def _choices(snapshot: Snapshot, look: Look) -> np.ndarray:
    """What is chosen by the headings that take part, ``(heading, distance, direction)``.

    -1 where nothing is best; where a rule selects and the move costs no skill anything, the number
    after those of the options.
    """
    choice = greedy(options_in_frame(snapshot, look))
    if not has_rule(snapshot):
        return choice
    is_contested = in_frame(np.asarray(minds(snapshot).any(axis=0)), snapshot, look)
    is_known = in_frame(_is_known_to_skills(snapshot), snapshot, look)
    return np.where(is_known, np.where(is_contested, choice, snapshot.choice_q.shape[-1]), -1)


def _is_known_to_skills(snapshot: Snapshot) -> np.ndarray:
    """Where some skill has learned something, ``(heading, distance, direction)``."""
    known = (snapshot.skill_q != 0).any(axis=(0, -1))
    return np.broadcast_to(known, snapshot.value.shape)


def _names(snapshot: Snapshot) -> tuple[str, ...]:
    """What stands on the board: the options, and that all agree where that can be."""
    return (*option_names(snapshot), *(("they agree",) if has_rule(snapshot) else ()))


def _colours(snapshot: Snapshot, look: Look) -> np.ndarray:
    """(name, 3) float64."""
    colours = option_colours(snapshot, look.theme)
    if not has_rule(snapshot):
        return colours
    agreed = _AGREED_ON_DARK if look.theme.is_dark else _AGREED_ON_LIGHT
    return np.vstack([colours[: snapshot.choice_q.shape[-1]], np.array(agreed, np.float64)])


def _edges_of(snapshot: Snapshot, look: Look) -> Callable[[], tuple[Contour, ...]]:
    """Lines between the regions that a manager tells apart, if there is one."""
    regions, world = regions_of(snapshot.spec), snapshot.spec.world
    if regions is None:
        return tuple
    of_reading = regions.of_reading.reshape(world.n_distances, world.n_directions)
    parts = [edges(of_reading == region, world) for region in range(int(regions.n_regions))]
    return lambda: (Contour(np.concatenate(parts), look.theme.border),)


def _fewest(snapshot: Snapshot, n_headings: int) -> float:
    """Headings that must choose an option for its colour: of nine moves hardly one has half."""
    return 1.0 if has_moves(snapshot) else SHOWN_FROM * n_headings


def _is_learned(snapshot: Snapshot, look: Look) -> np.ndarray:
    """Where any option has a value in any heading that takes part, ``(distance, direction)``."""
    return (or_zero(in_frame(snapshot.selection_q, snapshot, look)) != 0).any(axis=(0, -1))


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    colours, names = option_colours(snapshot, look.theme), option_names(snapshot)
    kind = kind_of(snapshot)
    if has_rule(snapshot):
        return _legend_of_rule(snapshot, look)
    if has_moves(snapshot):
        key = _compass(colours)
    else:
        key = joined((swatch(css(colours[k]), names[k]) for k in present(snapshot)), "")
    split = "headings disagree" if folds(look) else f"no {kind} clearly best"
    key += hatch(css(look.theme.frozen), split)
    part = element("div", key + patch_of_board(look, "nothing learned"))
    parts = [part]
    if snapshot.spec.learner.options == COMMANDS:
        parts.append(element("div", "Lines: regions, each of which is one place to the manager."))
    each = f"the {kind} that {_how_many(snapshot)} of its headings choose"
    frame = frame_in_words(snapshot, look, each)
    return legend(look, f"The {kind} of most value", parts, frame)


def _legend_of_rule(snapshot: Snapshot, look: Look) -> Markup:
    colours, names = _colours(snapshot, look), _names(snapshot)
    key = [swatch(css(colours[k]), f"{names[k]} decides") for k in present(snapshot)]
    key.append(swatch(css(colours[-1]), "all would move alike, or do not mind"))
    key.append(hatch(css(look.theme.frozen), "headings disagree"))
    key.append(patch_of_board(look, "nothing learned"))
    frame = frame_in_words(snapshot, look, "what holds for at least two of its headings")
    title = f"Whose move is made: {RULES_IN_WORDS[snapshot.spec.learner.selection]}"
    return legend(look, title, [element("div", joined(key, ""))], frame)


def _how_many(snapshot: Snapshot) -> str:
    return "most" if has_moves(snapshot) else "at least half"


def _compass(colours: np.ndarray) -> Markup:
    """The nine moves where they point."""
    cells = (
        element(
            "span",
            _MOVE_SIGNS[move],
            style=f"background:{css(colours[move])};text-align:center;border-radius:2px;"
            f"color:{'#fff' if colours[move].mean() < 128 else '#111'}",
            title=MOVE_NAMES[move],
        )
        for move in (6, 7, 8, 3, 4, 5, 0, 1, 2)
    )
    style = (
        "display:inline-grid;grid-template-columns:repeat(3,1.6em);gap:2px;"
        "vertical-align:middle;margin:0.2em 1em 0.2em 0"
    )
    return element("span", joined(cells, ""), style=style)


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    lone = lone_option(snapshot)
    if lone is not None:
        return f"{lone}, so there is no choice yet."
    if has_rule(snapshot):
        return (
            "Which skill has its way where another would rather move otherwise; grey where the move"
            " costs no skill anything."
        )
    kind = kind_of(snapshot)
    if folds(look):
        return (
            f"The {kind} that {_how_many(snapshot)} of the prey's headings would choose in each"
            " place; hatched where they disagree."
        )
    return (
        f"The {kind} that the learner takes in each place when it does not explore;"
        " hatched where none is clearly best."
    )


def _titled(learner: LearnerSpec) -> str | None:
    if learner.selection != "learned":
        return "Who decides"
    if learner.options == COMMANDS:
        return "Commands of the manager"
    return "Chosen move" if learner.options == MOVES else None


CHOSEN = Layer(
    "chosen",
    "Chosen skill",
    _draw,
    _legend,
    _caption,
    heeds=frozenset({"frame"}),
    titled=_titled,
)
