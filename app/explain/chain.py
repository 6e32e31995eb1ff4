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
from app.words.numbers import significant
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
_TIMES = "\N{MULTIPLICATION SIGN}"

Ending = Literal["capture", "flight", "loop", "unknown", "limit"]


class Link(NamedTuple):
    """One backup of a chain, with its numbers: target = reward + gamma * future."""

    x: int
    y: int
    option: str
    move: int
    reward: float
    gamma: float
    future: float
    """Largest value of the present options in the next cell's state; 0 where the trial ends."""
    q: float
    """Value of the option in this cell's state."""
    unit: Unit

    @property
    def target(self) -> float:
        """What the value is learned towards."""
        return self.reward + self.gamma * self.future


class Chain(NamedTuple):
    """The greedy way from a cell to the reward that feeds its value."""

    links: tuple[Link, ...]
    cells: tuple[int, ...]
    """The cell of each link, and the one that the last link leads to."""
    last: tuple[int, int]
    """Grid coordinates of the last of the cells."""
    ending: Ending


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
    ``limit`` links.

    Raises:
        ValueError: the cell is off the grid.
    """
    policy, initial_q = policy_of(snapshot), np.float32(snapshot.spec.learner.initial_q)
    cells = [cell_at(snapshot.world, x, y)]
    links: list[Link] = []
    been = {cells[0]}
    ending: Ending = "limit"
    while len(links) < limit:
        if snapshot.value[(heading, *sensed(snapshot, cells[-1]))] == initial_q:
            ending = "unknown"
            break
        steps = _greedy_steps(snapshot, policy, cells[-1], heading)
        step = min(steps, key=lambda step: (step.cell_t in been, -step.link.target))
        links.append(step.link)
        cells.append(step.cell_t)
        if step.outcome != ONGOING:
            ending = "capture" if step.outcome == CAPTURE else "flight"
            break
        if step.cell_t in been:
            ending = "loop"
            break
        been.add(step.cell_t)
    return Chain(tuple(links), tuple(cells), board_xy(snapshot.world, cells[-1]), ending)


class _Step(NamedTuple):
    link: Link
    cell_t: int
    outcome: int


def _greedy_steps(snapshot: Snapshot, policy: Policy, cell: int, heading: int) -> Iterator[_Step]:
    """The steps that the learner might make from a cell without exploring."""
    world, names, unit = snapshot.world, actions_of(snapshot), Unit.of(snapshot)
    ring, direction = sensed(snapshot, cell)
    x, y = board_xy(world, cell)
    reward_of = {
        ONGOING: 0.0,
        CAPTURE: float(world.capture_reward),
        FLIGHT: float(world.flight_reward),
    }
    for option in _members(policy.options[heading, ring, direction]):
        q = float(snapshot.selection_q[heading, ring, direction, option])
        view = heading % policy.moves.shape[1]
        for move in _members(policy.moves[(option, view, *sensed_by_skills(snapshot, cell))]):
            after, outcome = hunts.stepped(world, U(cell), U(heading), U(move))
            cell_t, future = int(after), 0.0
            if outcome == ONGOING:
                future = float(snapshot.value[(heading, *sensed(snapshot, cell_t))])
            gamma = snapshot.spec.learner.gamma
            link = Link(x, y, names[option], move, reward_of[outcome], gamma, future, q, unit)
            yield _Step(link, cell_t, outcome)


def _members(bits: np.integer) -> list[int]:
    return [member for member in range(int(bits).bit_length()) if int(bits) >> member & 1]


def action_text(link: Link) -> str:
    """What is done: option and move, or the move alone where it is itself the option."""
    move = ACTION_NAMES[link.move]
    return move if link.option == move else f"{link.option}, {move}"


def sum_text(link: Link) -> str:
    """The update of a link with its numbers filled in, which add up as they are shown."""
    future = float(f"{link.future:.{_DIGITS}g}")
    target = link.reward + link.gamma * future
    in_steps = ""
    # Of a reward nothing is to come; any other target is that of a place.
    if future > 0 and target > 0:
        steps = link.unit.steps_in_words(target)
        in_steps = f" ({steps} {'step' if steps == '1' else 'steps'})"
    return (
        f"{significant(link.reward)} + {link.gamma:g} {_TIMES} {significant(future)}"
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
    about = _about(chain.links[0]) if chain.links else ""
    return block(about, links, element("div", ending_text(chain)))


def _about(link: Link) -> Markup:
    """What the sums say."""
    parts = [
        "What each ",
        term("Q"),
        " is learned towards: the ",
        term("reward"),
        f" of the step + {link.gamma:g} {_TIMES} the ",
        term("value"),
        " of the place that it leads to.",
    ]
    return element("div", joined(parts, ""))


def _link_html(place: int, link: Link) -> Markup:
    style = "white-space:nowrap;font-variant-numeric:tabular-nums"
    content = joined([f"{action_text(link)}: ", element("span", sum_text(link), style=style)], "")
    return element("li", content, value=str(place), title=f"from ({link.x}, {link.y})")
