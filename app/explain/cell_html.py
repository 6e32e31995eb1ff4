"""What is known about a cell, as HTML.

It fits a panel of 330 pixels, and takes its colours from the page, so that it reads well on light
and on dark.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from markupsafe import Markup

from app.explain.cell import (
    ACTION_NAMES,
    OUTCOME_NAMES,
    CellReading,
    HuntShown,
    OptionReading,
    SkillReading,
)
from app.explain.ruled import ruling_html
from app.explain.worth import Unit
from app.picture.colours import css
from app.picture.frames import folds
from app.picture.look import Look
from app.picture.theme import Theme
from app.util.html import element, joined
from app.words.glossary import term
from app.words.numbers import counted, significant
from app.words.plain import HEADING_NAMES, joined_by_and
from sim import geometry
from sim.geometry import N_MOVES, STAY
from sim.world import CAPTURE, FLIGHT, TIMEOUT

_PLURALS = {CAPTURE: "captures", FLIGHT: "flights", TIMEOUT: "time-outs"}

_HUNTS_NAMED = 4

_ACCENT = "#e8590c"
"""Marks what is greedy; readable on light and on dark."""


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
        " to set the predator down there for one hunt, without random moves and without learning.",
    )


def reading_html(reading: CellReading, look: Look) -> str:
    """A cell's reading: what the picture says there, where it is, and what is known of it.

    Args:
        reading: what is known.
        look: how the board is seen; what its colour means there comes first.
    """
    cell = element("b", f"Cell ({reading.x}, {reading.y})")
    lead = _LEADS.get(look.layer, _worth)(reading, look)
    outcome = element("b", OUTCOME_NAMES[reading.outcome])
    hunt = joined(
        ["A hunt from here without ", term("exploration", "random moves"), " ends in ", outcome],
        "",
    )
    return block(
        element("div", joined([cell, f": {lead}."], ""), style="font-size:1.15em"),
        "" if lead == _worth(reading, look) else element("div", _sentence(_worth(reading, look))),
        element("div", _place(reading)),
        element("div", _sensed_html(reading)),
        element("div", _frame(reading, look)),
        element("div", joined([_sentence(_reach(reading, look)), " ", hunt, "."], "")),
        element("div", reading.holding) if reading.holding else "",
        options_html(reading) if reading.ruling is None else ruling_html(reading.ruling),
        _roses_html(reading),
    )


def _worth(reading: CellReading, look: Look) -> str:
    """What the state is worth."""
    return reading.unit.in_words(max((option.q for option in reading.options), default=0.0))


def _worth_of_one(reading: CellReading, look: Look) -> str:
    """What the option that the picture is about is worth."""
    option = next((one for one in reading.options if one.place == look.option), None)
    if option is None:
        return _worth(reading, look)
    return f"with {option.name} now, {reading.unit.in_words(option.q)}"


def _chosen(reading: CellReading, look: Look) -> str:
    """What the learner does here."""
    if reading.ruling is not None:
        gives_way = [wish.name for wish in reading.ruling.wishes if wish.minds]
        if not gives_way:
            return "the skills agree"
        winner = max(reading.ruling.wishes, key=lambda wish: wish.decides)
        return f"{winner.name} has its way against {joined_by_and(gives_way)}"
    best = [option.name for option in reading.options if option.greedy]
    return f"it takes {best[0]}" if len(best) == 1 else f"no choice is best of {len(best)}"


def _visited(reading: CellReading, look: Look) -> str:
    """How often it has been here."""
    visits = counted(sum(option.visits for option in reading.options), "step")
    return f"{visits} so far began in this state, of {reading.steps_made:,}"


def _reach(reading: CellReading, look: Look) -> str:
    """When value came."""
    if reading.first_reach is None:
        return "never worth anything so far"
    return f"first worth something in trial {reading.first_reach:,}"


def _ends(reading: CellReading, look: Look) -> str:
    """How a hunt from here ends."""
    return f"a hunt from here ends in {OUTCOME_NAMES[reading.outcome]}"


def _gives_up(reading: CellReading, look: Look) -> str:
    """What it costs the skill that the picture is about that the move is not its own."""
    if reading.ruling is None or look.option >= len(reading.options):
        return _worth(reading, look)
    name = reading.options[look.option].name
    wish = next(wish for wish in reading.ruling.wishes if wish.name == name)
    if wish.w is not None:
        return f"W of {name} is {significant(wish.w)}"
    return f"the move costs {name} {significant(wish.loses, 2) if wish.minds else 'nothing'}"


_LEADS: Final[Mapping[str, Callable[[CellReading, Look], str]]] = {
    "option": _worth_of_one,
    "chosen": _chosen,
    "flow": _chosen,
    "stake": _gives_up,
    "visits": _visited,
    "reach": _reach,
    "success": _ends,
}
"""What the colour of a layer means at a place, by the layer's key; of all others it is value."""


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}."


_SIDES: Final = (
    "straight ahead of the prey",
    "ahead of the prey, on its left",
    "on the prey's left",
    "behind the prey, on its left",
    "straight behind the prey",
    "behind the prey, on its right",
    "on the prey's right",
    "ahead of the prey, on its right",
)
"""Where something is for the prey, counter-clockwise, each an eighth of all round."""


def _place(reading: CellReading) -> str:
    """Where a cell is, in words."""
    if reading.away == 0:
        return "Here is the prey."
    side = _SIDES[round(reading.bearing / 45) % len(_SIDES)]
    sight = "the prey sees it" if reading.seen else "the prey does not see it"
    return f"{_sentence(side)[:-1]}, {counted(round(reading.away), 'cell')} away; {sight}."


def _sensed_html(reading: CellReading) -> Markup:
    """What of that the predator senses."""
    senses = [
        term("state", "State"),
        ", which is all that the predator senses of that: ",
        term("sensor ring", "ring"),
        f" {reading.ring + 1} of {reading.n_rings}, ",
        term("direction"),
        f" {reading.direction + 1} of {reading.n_directions},"
        f" prey facing {HEADING_NAMES[reading.heading]}.",
    ]
    if reading.of_skills is not None and reading.skills:
        ring, direction = reading.of_skills
        senses.append(f" Skills sense ring {ring + 1}, direction {direction + 1}.")
    return joined(senses, "")


def _frame(reading: CellReading, look: Look) -> str:
    """Of which heading the numbers are, where the picture is of all."""
    if not folds(look):
        return ""
    return (
        "The numbers are for a prey facing east, which is right here; the board's colours sum up"
        " all eight headings."
    )


def options_html(reading: CellReading) -> Markup:
    """Table of the options' values and visits, the greedy ones marked and ties named."""
    options, unit = reading.options, reading.unit
    head = (
        element("th", name, style=f"font-weight:400;text-align:{side};padding:{pad}")
        for name, side, pad in [
            (term("option", "Choice"), "left", "0"),
            (term("steps to capture", f"{unit.noun.capitalize()}s"), "right", "0 0 0 0.8em"),
            (term("Q"), "right", "0 0 0 0.8em"),
            ("Visits", "right", "0 0 0 0.8em"),
        ]
    )
    rows = [element("tr", joined(head, ""), style="opacity:0.75;font-size:0.9em")]
    rows += [_option_row(option, unit) for option in options]
    style = "width:100%;border-collapse:collapse;margin-top:0.4em;font-variant-numeric:tabular-nums"
    table = element("table", joined(rows, ""), style=style)
    notes = [
        f"Visits: of its {reading.steps_made:,} steps, those that made this choice in this state."
    ]
    tied = [option.name for option in options if option.greedy]
    if len(tied) > 1:
        names = "all of them" if len(tied) == len(options) else ", ".join(tied)
        notes.insert(0, f"Tied, so that chance decides: {names}.")
    return table + element("div", " ".join(notes), style="opacity:0.75")


def _option_row(option: OptionReading, unit: Unit) -> Markup:
    # A figure space is as wide as the mark.
    mark = "\N{BLACK RIGHT-POINTING SMALL TRIANGLE}" if option.greedy else "\N{FIGURE SPACE}"
    name = joined([element("span", mark, style=f"color:{_ACCENT}"), f" {option.name}"], "")
    right = "text-align:right;padding:0 0 0 0.8em"
    cells = (
        element("td", name),
        element("td", unit.steps_in_words(option.q), style=right),
        element("td", significant(option.q), style=right),
        element("td", f"{option.visits:,}", style=right),
    )
    style = "font-weight:700" if option.greedy else "opacity:0.8"
    return element("tr", joined(cells, ""), style=style)


def _roses_html(reading: CellReading) -> Markup:
    """A compass rose for each skill, or one for the nine moves where they are the options."""
    skills = reading.skills
    about = (
        f"What each {'command' if reading.unit.noun == 'command' else 'skill'} makes of the nine"
        " moves: longer is better for its purpose, orange is best; below, worst to best."
    )
    if not skills:
        about = "The nine moves: longer is better, orange is best; below, worst to best Q."
        q = tuple(option.q for option in reading.options)
        best = tuple(move for move, option in enumerate(reading.options) if option.greedy)
        skills = (SkillReading("moves", q, best),)
    figures = (
        element(
            "div",
            joined(
                [
                    rose_svg(skill.q, skill.greedy),
                    element("div", skill.name),
                    element("div", _range(skill.q), style="opacity:0.75"),
                ],
                "",
            ),
            style="width:5.9rem;text-align:center;line-height:1.15;font-size:0.9em",
        )
        for skill in skills
    )
    row = element("div", joined(figures, ""), style="display:flex;flex-wrap:wrap")
    return element("div", about, style="margin-top:0.5em;opacity:0.75") + row


def _range(q: Sequence[float]) -> str:
    low, high = significant(min(q), 2), significant(max(q), 2)
    return f"all {low}" if low == high else f"{low} to {high}"


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
        title = element("title", f"{ACTION_NAMES[move]}: {significant(q[move])}")
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
