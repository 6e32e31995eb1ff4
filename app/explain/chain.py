"""The chain of backups that feeds a cell's value: how it is followed, and how it is told."""

from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np
from markupsafe import Markup

from app.explain.cell import ACTION_NAMES, actions_of, policy_of, sensed, sensed_by_skills
from app.explain.cell_html import block
from app.explain.worth import Unit
from app.live.snapshot import Snapshot
from app.util.html import element, joined
from app.words.glossary import term
from app.words.numbers import counted, significant
from learners import hunts
from learners.hunts import Policy
from sim.bits import U
from sim.world import CAPTURE, FLIGHT, ONGOING, board_xy, cell_at

LINKS_SHOWN = 12
_FIRST_LINKS = 8
"""Of a chain that is too long, so many are shown from its start, and the rest from its end."""
LINKS_FOLLOWED = 600

_DIGITS = 3
"""Of each number that mean something."""
_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_TIMES = "\N{MULTIPLICATION SIGN}"

Ending = Literal["capture", "flight", "loop", "unknown", "limit", "rule"]


class Link(NamedTuple):
    """One backup of a chain, with its numbers: target = reward + gamma ** power * future."""

    x: int
    y: int
    option: str
    move: int
    """The first one, where a choice is kept for several."""
    reward: float
    """Of all its steps, discounted as the learner does."""
    gamma: float
    future: float
    """Largest value of the present options in the next cell's state; 0 where the trial ends."""
    q: float
    """Value of the option in this cell's state."""
    unit: Unit
    power: int = 1
    """How often what follows is discounted: once, or once for each step of a choice."""
    steps: int = 1
    """For which the choice is kept."""

    @property
    def target(self) -> float:
        """What the value is learned towards."""
        return self.reward + self.gamma**self.power * self.future


class Chain(NamedTuple):
    """The greedy way from a cell to the reward that feeds its value."""

    links: tuple[Link, ...]
    cells: tuple[int, ...]
    """All on the way: that of the first link, and those that each leads to."""
    last: tuple[int, int]
    """Grid coordinates of the last of the cells."""
    ending: Ending
    trace: float = 0.0
    """What is left of an update one move earlier, where earlier moves learn from it as well."""


def chain_of(
    snapshot: Snapshot, x: int, y: int, heading: int, limit: int = LINKS_FOLLOWED
) -> Chain:
    """Follow the greedy backups from a cell to the reward that feeds its value.

    Each link takes a greedy option and one of its greedy moves, and has the numbers of the update
    that this step would make: Q(s, o) is learned towards r + gamma * max Q(s', .).

    The learner knows states and not cells, and many cells share a state. The chain goes from cell
    to cell, because only cells have a next one, and the numbers are those of the cells' states; so
    a Q is near its target, and not equal to it: other cells of the state pull it their own way.

    Where greedy options or moves tie, the chain prefers a cell where it has not been yet, and then
    the largest target, since that is what feeds the value. It ends with the trial, with a cell
    where it has been, where the best value is still the one the table began with, or after
    ``limit`` links. Where choices or commands are kept, each link is one of them, with all of its
    steps. Where a rule selects there is no chain: no value there is learned from the next.

    Raises:
        ValueError: the cell is off the grid.
    """
    learner = snapshot.spec.learner
    if learner.selection != "learned":
        return Chain((), (cell_at(snapshot.world, x, y),), (x, y), "rule")
    policy, initial_q = policy_of(snapshot), np.float32(learner.initial_q)
    cells = [cell_at(snapshot.world, x, y)]
    links: list[Link] = []
    been = {cells[0]}
    ending: Ending = "limit"
    while len(links) < limit:
        if snapshot.value[(heading, *sensed(snapshot, cells[-1]))] == initial_q:
            ending = "unknown"
            break
        steps = _greedy_steps(snapshot, policy, cells[-1], heading)
        step = min(steps, key=lambda step: (step.cells[-1] in been, -step.link.target))
        links.append(step.link)
        cells += step.cells
        if step.outcome != ONGOING:
            ending = "capture" if step.outcome == CAPTURE else "flight"
            break
        if step.cells[-1] in been:
            ending = "loop"
            break
        been.add(step.cells[-1])
    trace = learner.gamma * learner.trace_decay if learner.trace_decay is not None else 0.0
    return Chain(tuple(links), tuple(cells), board_xy(snapshot.world, cells[-1]), ending, trace)


class _Step(NamedTuple):
    link: Link
    cells: tuple[int, ...]
    """To which it leads, one after the other."""
    outcome: int


def _greedy_steps(snapshot: Snapshot, policy: Policy, cell: int, heading: int) -> Iterator[_Step]:
    """The steps that the learner might make from a cell without exploring.

    Where a choice is kept it is all of its steps, of moves that tie the first each time.
    """
    world, names, unit = snapshot.world, actions_of(snapshot), Unit.of(snapshot)
    gamma, once = snapshot.spec.learner.gamma, _discounts_once(snapshot)
    ring, direction = sensed(snapshot, cell)
    x, y = board_xy(world, cell)
    reward_of = {
        ONGOING: 0.0,
        CAPTURE: float(world.capture_reward),
        FLIGHT: float(world.flight_reward),
    }
    for option in _members(policy.options[heading, ring, direction]):
        q = float(snapshot.selection_q[heading, ring, direction, option])
        for move in _greedy_of(snapshot, policy, option, cell, heading):
            made, outcome = _made(snapshot, policy, option, move, cell, heading)
            future = 0.0
            if outcome == ONGOING:
                future = float(snapshot.value[(heading, *sensed(snapshot, made[-1]))])
            # All but the last of the steps earn nothing, or the trial would have ended.
            reward = reward_of[outcome] * (1.0 if once else gamma ** (len(made) - 1))
            power = 1 if once else len(made)
            link = Link(x, y, names[option], move, reward, gamma, future, q, unit, power, len(made))
            yield _Step(link, made, outcome)


def _discounts_once(snapshot: Snapshot) -> bool:
    """Whether what follows is discounted once for all steps of a choice."""
    held = snapshot.spec.learner.held
    return held is None or held.discount == "choice"


def _greedy_of(
    snapshot: Snapshot, policy: Policy, option: int, cell: int, heading: int
) -> list[int]:
    """The greedy moves of an option at a cell."""
    view = heading % policy.moves.shape[1]
    return _members(policy.moves[(option, view, *sensed_by_skills(snapshot, cell))])


def _made(
    snapshot: Snapshot, policy: Policy, option: int, move: int, cell: int, heading: int
) -> tuple[tuple[int, ...], int]:
    """The cells to which a choice leads that begins with a move, and what the last one ends in."""
    world, kept = snapshot.world, policy.kept
    ring, direction = sensed(snapshot, cell)
    n_directions = snapshot.spec.world.n_directions
    cells: list[int] = []
    outcome = ONGOING
    begun = None if kept is None else int(kept.group[ring * n_directions + direction])
    while outcome == ONGOING:
        after, outcome = hunts.stepped(world, U(cell), U(heading), U(move))
        cell = int(after)
        cells.append(cell)
        ring, direction = sensed(snapshot, cell)
        if kept is None or len(cells) >= kept.most:
            break
        if int(kept.group[ring * n_directions + direction]) != begun:
            break
        move = _greedy_of(snapshot, policy, option, cell, heading)[0]
    return tuple(cells), outcome


def _members(bits: np.integer) -> list[int]:
    return [member for member in range(int(bits).bit_length()) if int(bits) >> member & 1]


def action_text(link: Link) -> str:
    """What is done: option and move, or the move alone where it is itself the option."""
    move = ACTION_NAMES[link.move]
    if link.steps > 1:
        return f"{link.option} for {counted(link.steps, 'step')}"
    return move if link.option == move else f"{link.option}, {move}"


def discount_text(link: Link) -> str:
    """The discount of what follows: the learner's, as often as it counts."""
    power = "" if link.power == 1 else str(link.power).translate(_RAISED)
    return f"{link.gamma:g}{power}"


def sum_text(link: Link) -> str:
    """The update of a link with its numbers filled in, which add up as they are shown."""
    future = float(f"{link.future:.{_DIGITS}g}")
    target = link.reward + link.gamma**link.power * future
    in_steps = ""
    # Of a reward nothing is to come; any other target is that of a place.
    if future > 0 and target > 0:
        steps = link.unit.steps_in_words(target)
        noun = link.unit.noun
        in_steps = f" ({steps} {noun if steps == '1' else f'{noun}s'})"
    return (
        f"{significant(link.reward)} + {discount_text(link)} {_TIMES} {significant(future)}"
        f" = {significant(target)}{in_steps}; Q = {significant(link.q)}"
    )


def ending_text(chain: Chain) -> str:
    """What a chain ends with, in a sentence."""
    x, y = chain.last
    match chain.ending:
        case "capture":
            return "There the prey is caught, and nothing follows: this reward feeds the chain."
        case "flight":
            return "There the prey notices and flees, and nothing follows: this is what is feared."
        case "loop":
            return (
                f"Back to ({x}, {y}), where the chain has been. A circle feeds nothing: the value"
                " comes from other cells of these states, and from steps taken by chance."
            )
        case "unknown" if chain.links:
            return f"At ({x}, {y}) nothing is known yet."
        case "unknown":
            return "Nothing is known here yet: the value is the one that the table began with."
        case "rule":
            return (
                "No chain leads from here to a capture: a rule selects, and each skill learns from"
                " its own reward alone."
            )
        case "limit":
            return f"And so on: only {len(chain.links)} links are followed."


def chain_html(chain: Chain) -> str:
    """A chain as a numbered list, its middle folded where it is long."""
    items = [_link_html(place, link) for place, link in enumerate(chain.links, start=1)]
    hidden = len(items) - LINKS_SHOWN
    if hidden > 0:
        more = element("li", f"… {hidden} more …", style="list-style:none;opacity:0.7")
        items[_FIRST_LINKS : _FIRST_LINKS + hidden] = [more]
    links = element("ol", joined(items, ""), style="margin:0.3em 0;padding-left:2.2em")
    about = _about(chain) if chain.links else ""
    return block(about, links, element("div", ending_text(chain)))


def _about(chain: Chain) -> Markup:
    """What the sums say."""
    link = chain.links[0]
    noun, nouns = link.unit.noun, f"{link.unit.noun}s"
    each = {"choice": "kept choice"}.get(noun, noun)
    discount = f"{link.gamma:g}"
    if any(one.power > 1 for one in chain.links):
        each, discount = "kept choice", f"{link.gamma:g}, once for each of its steps,"
    parts = [
        "What each ",
        term("Q"),
        " is learned towards: the ",
        term("reward"),
        f" of the {each} + {discount} {_TIMES} the ",
        term("value"),
        " of the place that it leads to.",
    ]
    if noun != "step":
        parts.append(f" However many steps it takes, so value counts {nouns}.")
    if chain.trace:
        parts.append(
            " Each error is learned at once by the moves before it as well: by"
            f" {chain.trace:.3g} of it one move earlier, {chain.trace**2:.2g} two, and so on."
        )
    return element("div", joined(parts, ""))


def _link_html(place: int, link: Link) -> Markup:
    style = "white-space:nowrap;font-variant-numeric:tabular-nums"
    content = joined([f"{action_text(link)}: ", element("span", sum_text(link), style=style)], "")
    return element("li", content, value=str(place), title=f"from ({link.x}, {link.y})")
