"""Skill's own value: what a skill expects of its own reward, and its best moves."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.amounts import fitted
from app.picture.arrows import arrows, at_places
from app.picture.colours import css, gain_colours, over_board, palette
from app.picture.frames import TURNED, folds, in_frame
from app.picture.layer import Extras, Heeded, Lack, Layer, Picture, spread
from app.picture.legend import bar, bar_marks, frame_in_words, legend, patch_of_board, swatch
from app.picture.look import Look
from app.picture.options import greedy, option_names, option_shown, present
from app.picture.raster import Raster
from app.picture.shading import Ruler, Shading, fitted_shading, fixed_shading
from app.picture.theme import LIGHT
from app.picture.value_maps import own_least, own_most, value_scale
from app.util.html import element
from app.words.numbers import of_any_size
from learners.learner_spec import LearnerSpec
from learners.names import COMMANDS
from sim.spec import N_HEADINGS

_BELOW = 0.4
"""How strongly a place covers the board where a skill expects less than nothing."""
_LEAST_DREAD, _MOST_DREAD = 0.12, 0.8
"""The same of one that has something to lose: from hardly to all of it."""


def _sees(snapshot: Snapshot, look: Look) -> bool:
    """Whether the skill that is shown tells the prey's headings apart."""
    learner = snapshot.spec.learner
    return learner.sees_heading(learner.sub_policies[option_shown(snapshot, look)])


def _tables(snapshot: Snapshot, look: Look) -> np.ndarray:
    """Values of the skill that is shown, ``(heading, distance, direction, move)``.

    Of the headings that take part; of one that does not tell them apart, one for all of them.
    """
    option = option_shown(snapshot, look)
    if not _sees(snapshot, look):
        return snapshot.skill_q_of(option, snapshot.heading)[None]
    return in_frame(snapshot.skill_q[option], snapshot, look)


def _values(snapshot: Snapshot, look: Look) -> np.ndarray:
    """What the skill makes of each place, ``(heading, distance, direction)``: its best move.

    Of one that only has something to lose, its worst: the best of a place would be to stay away
    from harm, which is worth nothing nearly everywhere.
    """
    tables = _tables(snapshot, look)
    if own_most(snapshot, option_shown(snapshot, look)) > 0:
        return tables.max(axis=-1)
    return tables.min(axis=-1)


def _shading(snapshot: Snapshot, look: Look, values: np.ndarray) -> Shading:
    """A linear scale, up to the most that it can be worth."""
    most = own_most(snapshot, option_shown(snapshot, look))
    fixed = fixed_shading("linear", most)
    gamma = snapshot.spec.learner.gamma
    return fitted_shading(values, gamma, fixed, most) if look.fitted else fixed


def _dread(snapshot: Snapshot, look: Look, values: np.ndarray) -> Ruler | None:
    """The scale of what a skill expects to lose; None of one that has nothing to lose."""
    least = own_least(snapshot, option_shown(snapshot, look))
    if not least:
        return None
    fixed = Ruler(0.0, least, "root")
    return fitted(-values, fixed) if look.fitted else fixed


def _below(ruler: Ruler | None, values: np.ndarray, look: Look) -> np.ndarray:
    """Colours of values below 0, ``(..., 3) uint8``."""
    if ruler is None:
        colour = over_board(np.array(look.theme.timeout), _BELOW, look.theme)
        return np.broadcast_to(colour, (*values.shape, 3))
    cover = _LEAST_DREAD + (_MOST_DREAD - _LEAST_DREAD) * ruler.place(-values)
    return over_board(np.array(look.theme.flight), cover, look.theme)


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    tables = _tables(snapshot, look)
    each = _values(snapshot, look)
    values = each.mean(axis=0)
    shading = _shading(snapshot, look, each)
    colours = palette(gain_colours(), shading.gain.place(values))
    below = _below(_dread(snapshot, look, each), values, look)
    colours = np.where((values < 0)[..., None], below, colours)
    world, side = snapshot.spec.world, raster.side
    there = np.abs(tables).max(axis=(0, -1)) > 0
    picture = spread(over_board(colours, there, look.theme), raster.as_skills_see)
    moves = at_places(greedy(tables), world.of_skills, side)
    if _sees(snapshot, look) and folds(look):
        moves = TURNED[np.arange(N_HEADINGS)[:, None], moves] * (moves >= 0) - (moves < 0)
    ways = arrows(moves, world, side)
    # Values are bright on every page.
    ink = np.broadcast_to(np.array(LIGHT.ink, np.uint8), (len(ways.ends), 3))
    return picture._replace(arrows=ways.ends, arrow_colours=ink)


def _frame(snapshot: Snapshot, look: Look) -> Markup | str:
    if _sees(snapshot, look):
        return frame_in_words(snapshot, look, "the mean over its eight headings")
    who = "What obeys a command" if snapshot.spec.learner.options == COMMANDS else "A skill"
    return f"{who} does not know where the prey looks, so that is not shown. North is up."


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    each = _values(snapshot, look)
    dread = _dread(snapshot, look, each)
    option = option_shown(snapshot, look)
    parts: list[Markup] = []
    if own_most(snapshot, option) > 0:
        parts += value_scale(_shading(snapshot, look, each), look)
    if dread is not None:
        places = np.linspace(1.0, 0.0, 256)
        depths = -(dread.low + places**2 * (dread.high - dread.low))
        marks = [(1.0 - at, f"-{text}") for at, text in bar_marks(dread, of_any_size)]
        marks = [(at, "0" if text == "-0" else text) for at, text in sorted(marks)]
        parts.append(bar(_below(dread, depths, look).astype(np.float64), marks))
    key = patch_of_board(look, "nothing learned")
    if dread is None:
        colour = css(_below(None, np.zeros(()), look))
        key = swatch(colour, "below 0") + key
    parts.append(element("div", key))
    parts.append(element("div", "Arrows: its best move; none where moves tie."))
    name = option_names(snapshot)[option]
    title = f"What {name} expects of its own reward"
    if not own_most(snapshot, option) > 0:
        title = f"What {name} expects of the worst move"
    return legend(look, title, parts, _frame(snapshot, look), turns=_sees(snapshot, look))


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    tables = _tables(snapshot, look)
    option = option_shown(snapshot, look)
    name = option_names(snapshot)[option]
    if not tables.any():
        return f"{name} has learned nothing yet."
    absent = "" if option in present(snapshot) else " It is not among the skills now."
    if not own_most(snapshot, option) > 0:
        fears = f"What {name} has learned to fear: the stronger, the worse; with its best moves."
        return f"{fears}{absent}"
    return (
        f"What {name} has learned for itself: bright where it expects much of its own reward, with"
        f" its best moves.{absent}"
    )


def _lacks(learner: LearnerSpec) -> Lack | None:
    if learner.sub_policies:
        return None
    return Lack("no skills", "This learner has no skills, only the nine moves.")


def _titled(learner: LearnerSpec) -> str | None:
    return "Command's own value" if learner.options == COMMANDS else None


def _ignores(learner: LearnerSpec, option: int) -> frozenset[Heeded]:
    """Where the prey looks matters to a skill only if it sees that."""
    names = learner.sub_policies
    if option < len(names) and learner.sees_heading(names[option]):
        return frozenset()
    return frozenset({"frame"})


SKILL = Layer(
    "skill",
    "Skill's own value",
    _draw,
    _legend,
    _caption,
    about="skill",
    heeds=frozenset({"frame", "fitted"}),
    lacks=_lacks,
    titled=_titled,
    ignores=_ignores,
)
