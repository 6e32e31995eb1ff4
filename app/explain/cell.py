"""What is to be said about one cell: pure functions from a snapshot to words, numbers and HTML.

Cells are given by their grid coordinates in the world's own orientation. The HTML fits a panel of
330 pixels, and takes its colours from the page, so that it reads well on light and on dark.
"""

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.colours import css
from app.picture.theme import Theme
from app.util.html import element, joined
from app.words.numbers import counted, in_hundredths
from app.words.plain import HEADING_NAMES, MOVE_NAMES, plain
from learners import hunts
from learners.hunts import Hunt, Policy
from learners.kernel.state import NOT_REACHED
from learners.spec import MOVES
from sim import geometry
from sim.geometry import N_MOVES, STAY
from sim.world import CAPTURE, FLIGHT, READING_SHIFT, TIMEOUT, cell_at

ACTION_NAMES = tuple(
    "stay" if move == STAY else f"move {name}" for move, name in enumerate(MOVE_NAMES)
)
OUTCOME_NAMES = {CAPTURE: "capture", FLIGHT: "flight", TIMEOUT: "time-out"}
_PLURALS = {CAPTURE: "captures", FLIGHT: "flights", TIMEOUT: "time-outs"}

_HUNTS_NAMED = 4

_ACCENT = "#e8590c"
"""Marks what is greedy; readable on light and on dark."""


class OptionReading(NamedTuple):
    """What the selection knows of one option in a state."""

    name: str
    q: float
    visits: int
    greedy: bool
    """Whether no option is worth more; where several are greedy, they tie."""


class SkillReading(NamedTuple):
    """What a skill knows of the nine moves in a state."""

    name: str
    q: tuple[float, ...]
    """Local value of each move."""
    greedy: tuple[int, ...]
    """Moves of the largest value."""


@dataclass(frozen=True)
class CellReading:
    """All that a learner knows of the state in which a cell lies."""

    x: int
    y: int
    heading: int
    ring: int
    """From 0, outwards."""
    direction: int
    """Sector from 0, the first centred on east, counter-clockwise."""
    state: int
    """Number of the state among all of them: heading, then ring, then direction."""
    of_skills: tuple[int, int] | None
    """Ring and sector as skills see them, where these have sensors of their own."""
    seen: bool
    """Whether the cell lies in the prey's visual field."""
    options: tuple[OptionReading, ...]
    """Those present."""
    skills: tuple[SkillReading, ...]
    """Those present; none where the options are the primitive moves."""
    first_reach: int | None
    """Trial in which the state's value first rose above 0."""
    outcome: int
    """How a hunt from the cell ends if the learner neither explores nor learns."""


def policy_of(snapshot: Snapshot) -> Policy:
    """What is greedy in each state."""
    return hunts.greedy_moves(snapshot.selection_q, snapshot.skill_q)


def moment_of(snapshot: Snapshot) -> Hashable:
    """What tells a moment of a session from all others; commands act without a step."""
    return snapshot.generation, snapshot.step, snapshot.control.history


def actions_of(snapshot: Snapshot) -> tuple[str, ...]:
    """What it is to take each option, as people say it."""
    learner = snapshot.spec.learner
    return ACTION_NAMES if learner.options == MOVES else tuple(map(plain, learner.skills))


class HuntShown(NamedTuple):
    """A hunt from a cell, with the heading of its prey."""

    x: int
    y: int
    heading: int
    hunt: Hunt


def hunts_from(
    snapshot: Snapshot, starts: Sequence[tuple[int, int]], heading: int, seed: int = 0
) -> list[HuntShown]:
    """Hunts without exploring and without learning, from cells ``(x, y)``.

    The seed counts up from one hunt to the next, so that each breaks ties its own way.

    Raises:
        ValueError: a cell is off the grid.
    """
    world, policy = snapshot.world, policy_of(snapshot)
    return [
        HuntShown(x, y, heading, hunts.hunt(world, policy, cell_at(world, x, y), heading, number))
        for number, (x, y) in enumerate(starts, start=seed)
    ]


def reading_at(
    snapshot: Snapshot, x: int, y: int, heading: int, success: np.ndarray | None = None
) -> CellReading:
    """Read off a snapshot what is known about a cell.

    Args:
        snapshot: the moment.
        x: column of the cell.
        y: row of the cell.
        heading: of the prey.
        success: outcomes from each cell, ``(heading, y, x)``; without it one hunt is made.

    Raises:
        ValueError: the cell is off the grid.
    """
    cell = cell_at(snapshot.world, x, y)
    ring, direction = sensed(snapshot, cell)
    of_skills = sensed_by_skills(snapshot, cell)
    here = (heading, ring, direction)
    world = snapshot.spec.world
    first_reach = int(snapshot.first_reach[here])
    if success is None:
        outcome = hunts_from(snapshot, [(x, y)], heading)[0].hunt.outcome
    else:
        outcome = int(success[heading, y, x])
    return CellReading(
        x=x,
        y=y,
        heading=heading,
        ring=ring,
        direction=direction,
        state=heading * world.n_readings + ring * world.n_directions + direction,
        of_skills=None if snapshot.world.skill_states is None else of_skills,
        seen=bool(int(snapshot.world.cell_word[cell]) >> heading & 1),
        options=_options_read(snapshot, here),
        skills=_skills_read(snapshot, *of_skills),
        first_reach=None if first_reach == NOT_REACHED else first_reach,
        outcome=outcome,
    )


def sensed(snapshot: Snapshot, cell: int) -> tuple[int, int]:
    """Ring and direction that the selection reads at a cell."""
    reading = int(snapshot.world.cell_word[cell]) >> int(READING_SHIFT)
    return divmod(reading, snapshot.spec.world.n_directions)


def sensed_by_skills(snapshot: Snapshot, cell: int) -> tuple[int, int]:
    """Ring and direction that skills read at a cell."""
    skill_states = snapshot.world.skill_states
    if skill_states is None:
        return sensed(snapshot, cell)
    return divmod(int(skill_states[cell]), snapshot.spec.world.of_skills.n_directions)


def _options_read(snapshot: Snapshot, here: tuple[int, int, int]) -> tuple[OptionReading, ...]:
    q, visits = snapshot.selection_q[here], snapshot.visits[here]
    return tuple(
        OptionReading(name, float(q[option]), int(visits[option]), bool(q[option] == q.max()))
        for option, name in enumerate(actions_of(snapshot))
        if np.isfinite(q[option])
    )


def _skills_read(snapshot: Snapshot, ring: int, direction: int) -> tuple[SkillReading, ...]:
    readings = []
    for skill, name in enumerate(snapshot.spec.learner.skills):
        if name in snapshot.present:
            q = snapshot.skill_q[skill, ring, direction]
            best = tuple(np.flatnonzero(q == q.max()).tolist())
            readings.append(SkillReading(plain(name), tuple(q.tolist()), best))
    return tuple(readings)


def block(*parts: str) -> str:
    """HTML of a panel from parts that are escaped unless they are markup."""
    style = "padding:0 0.7em 0.4em;font-size:0.82em;line-height:1.4"
    return str(element("div", joined(parts, ""), style=style))


def nothing_chosen_html() -> str:
    """What to do, while no cell is chosen."""
    return block(
        element("b", "Click a cell"),
        " to see what the learner knows about it. ",
        element("b", "Shift-click"),
        " to set the predator down there for one hunt, in which it neither explores nor learns.",
    )


def reading_html(reading: CellReading) -> str:
    """A cell's reading: where it is, what is known of it, and the skills' roses."""
    sight = "in the prey's sight" if reading.seen else "out of the prey's sight"
    cell = element("b", f"Cell ({reading.x}, {reading.y})")
    state = (
        f"Ring {reading.ring}, direction {reading.direction},"
        f" prey facing {HEADING_NAMES[reading.heading]}: state {reading.state:,}."
    )
    numbering = "Rings count from the prey outwards, directions from the east counter-clockwise"
    reach = (
        "It has never been worth more than 0."
        if reading.first_reach is None
        else f"First worth more than 0 in trial {reading.first_reach:,}."
    )
    outcome = element("b", OUTCOME_NAMES[reading.outcome])
    return block(
        element("div", joined([cell, f", {sight}"], ""), style="font-size:1.15em"),
        element("div", state, title=f"{numbering}, all from 0"),
        _of_skills(reading),
        element("div", joined([f"{reach} Hunting greedily from here ends in ", outcome, "."], "")),
        options_html(reading.options),
        _roses_html(reading),
    )


def _of_skills(reading: CellReading) -> str:
    """Where skills see the cell, if otherwise than the selection does."""
    if reading.of_skills is None or not reading.skills:
        return ""
    ring, direction = reading.of_skills
    return element("div", f"Skills see ring {ring}, direction {direction}.")


def options_html(options: Sequence[OptionReading]) -> Markup:
    """Table of the options' values and visits, the greedy ones marked and ties named."""
    head = (
        element("th", name, style=f"font-weight:400;text-align:{side};padding:{pad}")
        for name, side, pad in [
            ("Option", "left", "0"),
            ("Q", "right", "0 0 0 0.8em"),
            ("Visits", "right", "0 0 0 0.8em"),
        ]
    )
    rows = [element("tr", joined(head, ""), style="opacity:0.6;font-size:0.9em")]
    rows += map(_option_row, options)
    style = "width:100%;border-collapse:collapse;margin-top:0.4em;font-variant-numeric:tabular-nums"
    table = element("table", joined(rows, ""), style=style)
    tied = [option.name for option in options if option.greedy]
    if len(tied) < 2:
        return table
    names = "all of them" if len(tied) == len(options) else ", ".join(tied)
    return table + element("div", f"Tied, so that chance decides: {names}.", style="opacity:0.7")


def _option_row(option: OptionReading) -> Markup:
    # A figure space is as wide as the mark.
    mark = "\N{BLACK RIGHT-POINTING SMALL TRIANGLE}" if option.greedy else "\N{FIGURE SPACE}"
    name = joined([element("span", mark, style=f"color:{_ACCENT}"), f" {option.name}"], "")
    right = "text-align:right;padding:0 0 0 0.8em"
    cells = (
        element("td", name),
        element("td", in_hundredths(option.q), style=right),
        element("td", f"{option.visits:,}", style=right),
    )
    style = "font-weight:700" if option.greedy else "opacity:0.8"
    return element("tr", joined(cells, ""), style=style)


def _roses_html(reading: CellReading) -> Markup:
    """A compass rose for each skill, or one for the nine moves where they are the options."""
    skills = reading.skills
    if not skills:
        q = tuple(option.q for option in reading.options)
        best = tuple(move for move, option in enumerate(reading.options) if option.greedy)
        skills = (SkillReading("moves", q, best),)
    figures = (
        element(
            "div",
            rose_svg(skill.q, skill.greedy) + element("div", skill.name, style="font-size:0.9em"),
            style="width:5.9rem;text-align:center;line-height:1.15",
        )
        for skill in skills
    )
    return element("div", joined(figures, ""), style="display:flex;flex-wrap:wrap;margin-top:0.5em")


def rose_svg(q: Sequence[float], best: Sequence[int]) -> Markup:
    """Nine values as a compass rose: a petal for each way, longer where it is worth more.

    North is up; the dot in the middle is staying. The greedy moves are marked.

    Args:
        q: value of each move.
        best: the greedy moves.
    """
    low, high = min(q), max(q)
    share = [(value - low) / (high - low) if high > low else 0.5 for value in q]
    parts = [Markup('<circle r="42" fill="none" stroke="currentColor" stroke-opacity="0.18"/>')]
    # The marked ones come last, so that they lie on top.
    for move in sorted(range(N_MOVES), key=lambda move: move in best):
        paint, opacity = (_ACCENT, "1") if move in best else ("currentColor", "0.4")
        title = element("title", f"{ACTION_NAMES[move]}: {in_hundredths(q[move])}")
        if move == STAY:
            dot = {"r": f"{2.5 + 4.5 * share[move]:.1f}", "fill": paint, "fill-opacity": opacity}
            parts.append(element("circle", title, **dot))
            continue
        east, north = geometry.MOVES[move] / math.hypot(*geometry.MOVES[move])
        inner, outer = 11.0, 14.0 + 26.0 * share[move]
        petal = {
            "x1": f"{inner * east:.1f}",
            "y1": f"{-inner * north:.1f}",
            "x2": f"{outer * east:.1f}",
            "y2": f"{-outer * north:.1f}",
            "stroke": paint,
            "stroke-opacity": opacity,
            "stroke-width": "6",
            "stroke-linecap": "round",
        }
        parts.append(element("line", title, **petal))
    frame = {"viewBox": "-46 -46 92 92", "width": "84", "height": "84", "role": "img"}
    return element("svg", joined(parts, ""), **frame, **{"aria-label": "values of the nine moves"})


def hunts_html(hunts: Sequence[HuntShown], theme: Theme) -> str:
    """How hunts ended: one by one while they are few, counted when they are many."""
    if len(hunts) <= _HUNTS_NAMED:
        ends = (_outcome_html(one.hunt.outcome, _hunt_text(one), theme) for one in hunts)
        return block(*(element("div", end) for end in ends))
    by_outcome = {
        outcome: sum(shown.hunt.outcome == outcome for shown in hunts) for outcome in OUTCOME_NAMES
    }
    lines = (
        _outcome_html(outcome, f"{n} {(OUTCOME_NAMES if n == 1 else _PLURALS)[outcome]}", theme)
        for outcome, n in by_outcome.items()
        if n
    )
    return block(element("b", f"{len(hunts)} hunts"), " ", joined(lines, " "))


def _hunt_text(shown: HuntShown) -> str:
    return (
        f"from ({shown.x}, {shown.y}), prey facing {HEADING_NAMES[shown.heading]}:"
        f" {OUTCOME_NAMES[shown.hunt.outcome]} after {counted(shown.hunt.steps, 'step')}"
    )


def _outcome_html(outcome: int, text: str, theme: Theme) -> Markup:
    dot = element(
        "span",
        "",
        style="display:inline-block;width:0.7em;height:0.7em;border-radius:50%;"
        f"background:{css(theme.of_outcome(outcome))};margin-right:0.35em",
    )
    return element("span", joined([dot, text], ""), style="display:inline-block")
