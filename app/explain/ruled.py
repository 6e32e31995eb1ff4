"""Why a move is made where a rule selects, and how long a choice holds: for the state of a cell."""

from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from app.live.snapshot import Snapshot
from app.picture.giving_way import costs, learned_w, minds
from app.util.html import element, joined
from app.words.numbers import counted, significant
from app.words.plain import MOVE_NAMES, RULES_IN_WORDS, joined_by_and, plain
from learners.comparators.feudal import MOST_STEPS
from learners.kernel.layout import regions_of
from learners.kernel.state import weights_of
from sim.geometry import N_MOVES

State = tuple[int, int, int]
"""Heading, ring and direction."""


class Wish(NamedTuple):
    """What a skill makes of a state in which a rule selects."""

    name: str
    weight: float
    expects: float
    """w max Q: its happiness if it makes the move."""
    wants: tuple[int, ...]
    """Its best moves."""
    loses: float
    """What the rule's move costs it, w (max Q - Q)."""
    minds: bool
    """Whether that is worth speaking of."""
    w: float | None
    """What it has learned that losing costs it; None where that is not learned."""
    decides: float
    """How often it makes the move, of all ways in which ties may break."""


class Ruling(NamedTuple):
    """How a rule selects in a state."""

    rule: str
    """Its name in a preset."""
    moves: tuple[int, ...]
    """That may be made."""
    wishes: tuple[Wish, ...]
    """Of the skills present."""


def ruling_at(snapshot: Snapshot, here: State) -> Ruling | None:
    """How the rule selects in a state; None where a table does."""
    choices, learner = snapshot.choices, snapshot.spec.learner
    if choices is None:
        return None
    heading = here[0]
    lost, is_minded, w_values = costs(snapshot), minds(snapshot), learned_w(snapshot)
    weights = weights_of(learner)
    made = 0
    wishes: list[Wish] = []
    for skill, name in enumerate(learner.skills):
        if name not in snapshot.present:
            continue
        q = snapshot.skill_q_of(skill, heading)[here[1:]]
        share = float(choices.share[(*here, skill)])
        if share > 0:
            made |= int(choices.moves[(skill, *here)])
        wishes.append(
            Wish(
                name=plain(name),
                weight=float(weights[skill]),
                expects=float(weights[skill] * q.max()),
                wants=tuple(np.flatnonzero(q == q.max()).tolist()),
                loses=float(lost[(skill, *here)]),
                minds=bool(is_minded[(skill, *here)]),
                w=None if w_values is None else float(w_values[(skill, *here)]),
                decides=share,
            )
        )
    moves = tuple(move for move in range(N_MOVES) if made >> move & 1)
    return Ruling(learner.selection, moves, tuple(wishes))


def ruling_in_words(ruling: Ruling) -> str:
    """Whose move is made there, and who gives way, in a sentence or two."""
    move = _moves_in_words(ruling.moves)
    rule = RULES_IN_WORDS[ruling.rule]
    said = f"The move is {rule}: {move}."
    gives_way = [wish for wish in ruling.wishes if wish.minds]
    if not gives_way:
        return f"{said} It costs no skill anything."
    names = joined_by_and([wish.name for wish in gives_way])
    way = "gives way" if len(gives_way) == 1 else "give way"
    lost = joined_by_and([significant(wish.loses, 2) for wish in gives_way])
    return f"{said} {names[:1].upper()}{names[1:]} {way}, which costs {lost} of its own reward."


def _moves_in_words(moves: tuple[int, ...]) -> str:
    if len(moves) == N_MOVES:
        return "any, by chance"
    return " or ".join(MOVE_NAMES[move] for move in moves)


def ruling_html(ruling: Ruling) -> Markup:
    """The sentence, and a table of what each skill wants, expects and gives up."""
    has_w = any(wish.w is not None for wish in ruling.wishes)
    weighs = any(wish.weight != 1 for wish in ruling.wishes)
    titles = [
        ("Skill", "left"),
        ("wants", "left"),
        *([("weight", "right")] if weighs else []),
        ("expects", "right"),
        ("gives up", "right"),
        *([("W", "right")] if has_w else []),
        ("decides", "right"),
    ]
    rows = [
        element(
            "tr",
            joined([element("th", title, style=_cell(side)) for title, side in titles], ""),
            style="opacity:0.75;font-size:0.9em",
        )
    ]
    for wish in ruling.wishes:
        wants = "any" if len(wish.wants) == N_MOVES else _moves_in_words(wish.wants)
        if len(wish.wants) > _NAMED:
            wants = f"{len(wish.wants)} alike" if len(wish.wants) < N_MOVES else "any"
        texts = [
            (wish.name, "left"),
            (wants, "left"),
            *([(significant(wish.weight), "right")] if weighs else []),
            (significant(wish.expects), "right"),
            (significant(wish.loses, 2) if wish.minds else "0", "right"),
            *([(significant(wish.w or 0.0), "right")] if has_w else []),
            (f"{wish.decides:.0%}", "right"),
        ]
        cells = [element("td", text, style=_cell(side)) for text, side in texts]
        bold = "font-weight:700" if wish.decides > 1 / 2 else "opacity:0.8"
        rows.append(element("tr", joined(cells, ""), style=bold))
    style = "width:100%;border-collapse:collapse;margin-top:0.4em;font-variant-numeric:tabular-nums"
    table = element("table", joined(rows, ""), style=style)
    note = "Expects: its own best value here, times its weight. Decides: of all ways to break ties."
    return (
        element("div", element("b", ruling_in_words(ruling)), style="margin-top:0.4em")
        + table
        + element("div", note, style="opacity:0.75")
    )


_NAMED = 2
"""Moves that a table names; of more it says how many."""


def _cell(side: str) -> str:
    return (
        f"font-weight:inherit;text-align:{side};padding:0 0 0 {'0' if side == 'left' else '0.6em'}"
    )


def holding_at(snapshot: Snapshot, here: State) -> str:
    """How long a choice or command holds that is given in a state, and whether one does now.

    Empty where each step has a choice of its own.
    """
    learner, world = snapshot.spec.learner, snapshot.spec.world
    heading, ring, direction = here
    reading = ring * world.n_directions + direction
    regions, held = regions_of(snapshot.spec), learner.held
    if regions is not None:
        region = int(regions.of_reading[reading])
        inside = regions.of_reading == region
        rings, directions = np.nonzero(inside.reshape(world.n_distances, world.n_directions))
        said = (
            f"To the manager this is one place with all of rings {rings.min() + 1} to"
            f" {rings.max() + 1}, directions {directions.min() + 1} to {directions.max() + 1}. A"
            f" command that is given here holds until that is left, {MOST_STEPS} steps at most."
        )
        now = snapshot.commanded
        if now is None or now.region != region or heading != snapshot.heading:
            return said
        name = plain(learner.sub_policies[now.command])
        left = counted(MOST_STEPS - now.steps, "step")
        return f"{said} Now {name} holds here, for {left} more at most."
    if held is None:
        return ""
    most = counted(held.most, "step")
    until = f"until the place changes, {most} at most" if held.until == "change" else f"for {most}"
    said = f"A choice that is made here is kept {until}."
    now = snapshot.held
    state = (heading * world.n_distances + ring) * world.n_directions + direction
    if now is None or now.state != state:
        return said
    name = plain(learner.sub_policies[now.option]) if learner.sub_policies else ""
    name = name or f"moving {MOVE_NAMES[now.option]}"
    left = counted(held.most - now.steps, "step")
    return f"{said} Now {name} is kept, for {left} more at most."
