"""Skill's own value: what a skill expects of its own reward, and its best moves."""

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.arrows import arrows, at_places
from app.picture.colours import css, gain_colours, over_board, palette
from app.picture.layer import Extras, Layer, Picture, blank, spread
from app.picture.legend import legend, patch_of_board, swatch
from app.picture.look import Look
from app.picture.options import greedy, option_names, option_shown, present
from app.picture.raster import Raster
from app.picture.shading import Shading, fitted_shading, fixed_shading
from app.picture.theme import LIGHT
from app.picture.value_maps import value_scale
from app.util.html import element
from app.words.plain import HEADING_NAMES
from learners.comparators.feudal import SEARCHED
from learners.names import COMMANDS, SEARCH

_BELOW = 0.4
"""How strongly a place covers the board where a skill expects less than nothing."""


def _table(snapshot: Snapshot, look: Look) -> np.ndarray | None:
    """The local table of the skill that is shown, ``(distance, direction, move)``, if any."""
    if not len(snapshot.skill_q):
        return None
    return snapshot.skill_q_of(option_shown(snapshot, look), snapshot.heading)


def _most(snapshot: Snapshot, option: int) -> float:
    """What it is worth at most: nothing earns more than that at every step."""
    learner = snapshot.spec.learner
    if learner.options == COMMANDS:
        # What obeys is rewarded once, and then its task is over.
        searched = float(SEARCHED) * abs(snapshot.spec.world.capture_reward)
        return searched or 1.0 if learner.sub_policies[option] == SEARCH else 1.0
    earned = 1.0
    if learner.local_rewards == "signed":
        weights = learner.reward_of(learner.skills[option])
        # A move covers at most the diagonal of a cell, towards the prey or round it.
        earned = float(np.sqrt(2.0) * (max(abs(weights.gain), abs(weights.arc)) or 1.0))
    return earned / (1.0 - learner.gamma)


def _shading(snapshot: Snapshot, look: Look, values: np.ndarray) -> Shading:
    """A linear scale, up to the most that it can be worth."""
    most = _most(snapshot, option_shown(snapshot, look))
    fixed = fixed_shading("linear", most)
    gamma = snapshot.spec.learner.gamma
    return fitted_shading(values, gamma, fixed, most) if look.fitted else fixed


def _draw(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    table = _table(snapshot, look)
    if table is None:
        return blank(look, raster)
    values = table.max(axis=-1)
    shading = _shading(snapshot, look, values)
    colours = palette(gain_colours(), shading.gain.place(values))
    below = over_board(np.array(look.theme.timeout), _BELOW, look.theme)
    colours = np.where((values < 0)[..., None], below, colours)
    world, side = snapshot.spec.world, raster.side
    there = np.abs(table).max(axis=-1) > 0
    picture = spread(over_board(colours, there, look.theme), raster.as_skills_see)
    ways = arrows(at_places(greedy(table)[None], world.of_skills, side), world, side)
    # Values are bright on every page.
    ink = np.broadcast_to(np.array(LIGHT.ink, np.uint8), (len(ways.ends), 3))
    return picture._replace(arrows=ways.ends, arrow_colours=ink)


def _frame(snapshot: Snapshot, option: int) -> str:
    learner = snapshot.spec.learner
    if learner.sub_policies and learner.sees_heading(learner.sub_policies[option]):
        return f"For a prey that looks {HEADING_NAMES[snapshot.heading]}, as now. North is up."
    who = "What obeys a command" if learner.options == COMMANDS else "A skill"
    return f"{who} does not know where the prey looks, so that is not shown. North is up."


def _legend(snapshot: Snapshot, look: Look, extras: Extras) -> Markup:
    table = _table(snapshot, look)
    frame = _frame(snapshot, option_shown(snapshot, look))
    if table is None:
        return legend(look, "No skill", [], frame, turns=False)
    shading = _shading(snapshot, look, table.max(axis=-1))
    below = swatch(css(over_board(np.array(look.theme.timeout), _BELOW, look.theme)), "below 0")
    parts = [
        *value_scale(shading, look),
        element("div", below + patch_of_board(look, "nothing learned")),
        element("div", "Arrows: its best move; none where moves tie."),
    ]
    name = option_names(snapshot)[option_shown(snapshot, look)]
    title = f"What {name} expects of its own reward"
    return legend(look, title, parts, frame, turns=False)


def _caption(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    table = _table(snapshot, look)
    if table is None:
        return "This learner has no skills, only the nine moves."
    option = option_shown(snapshot, look)
    name = option_names(snapshot)[option]
    if not table.any():
        return f"{name} has learned nothing yet."
    absent = "" if option in present(snapshot) else " It is not among the skills now."
    return (
        f"What {name} has learned for itself: bright where it expects much of its own reward, with"
        f" its best moves.{absent}"
    )


SKILL = Layer(
    "skill",
    "Skill's own value",
    _draw,
    _legend,
    _caption,
    about="skill",
    heeds=frozenset({"fitted"}),
)
