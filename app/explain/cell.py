"""What is to be said about one cell: pure functions from a snapshot to words, numbers and HTML.

Cells are given by their grid coordinates in the world's own orientation. The HTML fits a panel of
330 pixels, and takes its colours from the page, so that it reads well on light and on dark.
"""

import math
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from typing import Literal, NamedTuple

import numpy as np

from app.live.snapshot import Snapshot
from app.picture.colours import css
from app.picture.theme import Theme
from app.words.numbers import in_hundredths
from app.words.plain import HEADING_NAMES, MOVE_NAMES, plain
from learners import hunts
from learners.hunts import Hunt, Policy
from learners.kernel.state import NOT_REACHED
from learners.spec import MOVES
from sim import geometry
from sim.bits import U
from sim.geometry import N_MOVES, STAY
from sim.world import CAPTURE, FLIGHT, ONGOING, STATE_SHIFT, TIMEOUT, board_xy, cell_at

ACTION_NAMES = tuple(
    "stay" if move == STAY else f"move {name}" for move, name in enumerate(MOVE_NAMES)
)
OUTCOME_NAMES = {CAPTURE: "capture", FLIGHT: "flight", TIMEOUT: "time-out"}
_PLURALS = {CAPTURE: "captures", FLIGHT: "flights", TIMEOUT: "time-outs"}

LINKS_SHOWN = 12
_FIRST_LINKS = 8
"""Of a chain that is too long, so many are shown from its start, and the rest from its end."""
LINKS_FOLLOWED = 600
_HUNTS_NAMED = 4

_TIMES = "\N{MULTIPLICATION SIGN}"
_ACCENT = "#e8590c"
"""Marks what is greedy; readable on light and on dark."""

Ending = Literal["capture", "flight", "loop", "unknown", "limit"]


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


def policy_of(snapshot: Snapshot) -> Policy:
    """What is greedy in each state."""
    options_are_moves = snapshot.spec.learner.options == MOVES
    return hunts.greedy_moves(snapshot.selection_q, None if options_are_moves else snapshot.skill_q)


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
    ring, direction = _sensed(snapshot, cell)
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
        state=heading * world.n_skill_states + ring * world.n_directions + direction,
        seen=bool(int(snapshot.world.cell_word[cell]) >> heading & 1),
        options=_options_read(snapshot, here),
        skills=_skills_read(snapshot, ring, direction),
        first_reach=None if first_reach == NOT_REACHED else first_reach,
        outcome=outcome,
    )


def _sensed(snapshot: Snapshot, cell: int) -> tuple[int, int]:
    """Ring and direction of a cell."""
    skill_state = int(snapshot.world.cell_word[cell]) >> int(STATE_SHIFT)
    return divmod(skill_state, snapshot.spec.world.n_directions)


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
    cells, links = [cell_at(snapshot.world, x, y)], []
    been = {cells[0]}
    ending: Ending = "limit"
    while len(links) < limit:
        if snapshot.value[(heading, *_sensed(snapshot, cells[-1]))] == initial_q:
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
    world, names = snapshot.world, actions_of(snapshot)
    ring, direction = _sensed(snapshot, cell)
    x, y = board_xy(world, cell)
    reward_of = {
        ONGOING: 0.0,
        CAPTURE: float(world.capture_reward),
        FLIGHT: float(world.flight_reward),
    }
    for option in _members(policy.options[heading, ring, direction]):
        q = float(snapshot.selection_q[heading, ring, direction, option])
        for move in _members(policy.moves[option, ring, direction]):
            after, outcome = hunts.stepped(world, U(cell), U(heading), U(move))
            cell_t, future = int(after), 0.0
            if outcome == ONGOING:
                future = float(snapshot.value[(heading, *_sensed(snapshot, cell_t))])
            gamma = snapshot.spec.learner.gamma
            link = Link(x, y, names[option], move, reward_of[outcome], gamma, future, q)
            yield _Step(link, cell_t, outcome)


def _members(bits: np.integer) -> list[int]:
    return [member for member in range(int(bits).bit_length()) if int(bits) >> member & 1]


def action_text(link: Link) -> str:
    """What is done: option and move, or the move alone where it is itself the option."""
    move = ACTION_NAMES[link.move]
    return move if link.option == move else f"{link.option}, {move}"


def sum_text(link: Link) -> str:
    """The update of a link with its numbers filled in."""
    return (
        f"{in_hundredths(link.reward)} + {link.gamma:g} {_TIMES} {in_hundredths(link.future)}"
        f" = {in_hundredths(link.target)} (Q = {in_hundredths(link.q)})"
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


def _block(body: str) -> str:
    return f'<div style="padding:0 0.7em 0.4em;font-size:0.82em;line-height:1.4">{body}</div>'


def nothing_chosen_html() -> str:
    """What to do, while no cell is chosen."""
    return _block(
        "<b>Click a cell</b> to see what the learner knows about it. <b>Shift-click</b> to set the"
        " predator down there for one hunt, in which it neither explores nor learns."
    )


def reading_html(reading: CellReading) -> str:
    """A cell's reading: where it is, what is known of it, and the skills' roses."""
    facing = escape(HEADING_NAMES[reading.heading])
    sight = "in the prey's sight" if reading.seen else "out of the prey's sight"
    reach = (
        "It has never been worth more than 0."
        if reading.first_reach is None
        else f"First worth more than 0 in trial {reading.first_reach:,}."
    )
    return _block(
        f'<div style="font-size:1.15em"><b>Cell ({reading.x}, {reading.y})</b>, {sight}</div>'
        '<div title="Rings count from the prey outwards, directions from the east'
        f' counter-clockwise, all from 0">Ring {reading.ring}, direction {reading.direction},'
        f" prey facing {facing}: state {reading.state:,}.</div>"
        f"<div>{reach} Hunting greedily from here ends in"
        f" <b>{escape(OUTCOME_NAMES[reading.outcome])}</b>.</div>"
        f"{options_html(reading.options)}{_roses_html(reading)}"
    )


def options_html(options: Sequence[OptionReading]) -> str:
    """Table of the options' values and visits, the greedy ones marked and ties named."""
    cell = '<td style="text-align:right;padding:0 0 0 0.8em">'
    rows = "".join(
        f'<tr style="{"font-weight:700" if option.greedy else "opacity:0.8"}">'
        f'<td><span style="color:{_ACCENT}">{"&#9656;" if option.greedy else "&#8199;"}</span>'
        f" {escape(option.name)}</td>{cell}{escape(in_hundredths(option.q))}</td>"
        f"{cell}{option.visits:,}</td></tr>"
        for option in options
    )
    head = "".join(
        f'<th style="font-weight:400;text-align:{side};padding:{pad}">{name}</th>'
        for name, side, pad in [
            ("Option", "left", "0"),
            ("Q", "right", "0 0 0 0.8em"),
            ("Visits", "right", "0 0 0 0.8em"),
        ]
    )
    tied = [option.name for option in options if option.greedy]
    ties = ""
    if len(tied) > 1:
        names = "all of them" if len(tied) == len(options) else ", ".join(tied)
        ties = f'<div style="opacity:0.7">Tied, so that chance decides: {escape(names)}.</div>'
    return (
        '<table style="width:100%;border-collapse:collapse;margin-top:0.4em;'
        'font-variant-numeric:tabular-nums">'
        f'<tr style="opacity:0.6;font-size:0.9em">{head}</tr>{rows}</table>{ties}'
    )


def _roses_html(reading: CellReading) -> str:
    """A compass rose for each skill, or one for the nine moves where they are the options."""
    skills = reading.skills
    if not skills:
        q = tuple(option.q for option in reading.options)
        best = tuple(move for move, option in enumerate(reading.options) if option.greedy)
        skills = (SkillReading("moves", q, best),)
    figures = "".join(
        '<div style="width:5.9rem;text-align:center;line-height:1.15">'
        f'{rose_svg(skill.q, skill.greedy)}<div style="font-size:0.9em">{escape(skill.name)}</div>'
        "</div>"
        for skill in skills
    )
    return f'<div style="display:flex;flex-wrap:wrap;margin-top:0.5em">{figures}</div>'


def rose_svg(q: Sequence[float], best: Sequence[int]) -> str:
    """Nine values as a compass rose: a petal for each way, longer where it is worth more.

    North is up; the dot in the middle is staying. The greedy moves are marked.

    Args:
        q: value of each move.
        best: the greedy moves.
    """
    low, high = min(q), max(q)
    share = [(value - low) / (high - low) if high > low else 0.5 for value in q]
    parts = ['<circle r="42" fill="none" stroke="currentColor" stroke-opacity="0.18"/>']
    # The marked ones come last, so that they lie on top.
    for move in sorted(range(N_MOVES), key=lambda move: move in best):
        paint, opacity = (_ACCENT, "1") if move in best else ("currentColor", "0.4")
        title = f"<title>{escape(ACTION_NAMES[move])}: {escape(in_hundredths(q[move]))}</title>"
        if move == STAY:
            parts.append(
                f'<circle r="{2.5 + 4.5 * share[move]:.1f}" fill="{paint}"'
                f' fill-opacity="{opacity}">{title}</circle>'
            )
            continue
        east, north = geometry.MOVES[move] / math.hypot(*geometry.MOVES[move])
        inner, outer = 11.0, 14.0 + 26.0 * share[move]
        parts.append(
            f'<line x1="{inner * east:.1f}" y1="{-inner * north:.1f}" x2="{outer * east:.1f}"'
            f' y2="{-outer * north:.1f}" stroke="{paint}" stroke-opacity="{opacity}"'
            f' stroke-width="6" stroke-linecap="round">{title}</line>'
        )
    return (
        '<svg viewBox="-46 -46 92 92" width="84" height="84" role="img"'
        f' aria-label="values of the nine moves">{"".join(parts)}</svg>'
    )


def chain_html(chain: Chain) -> str:
    """A chain as a numbered list, its middle folded where it is long."""
    count = len(chain.links)
    shown = list(enumerate(chain.links, start=1))
    items = [_link_html(place, link) for place, link in shown]
    if count > LINKS_SHOWN:
        hidden = count - LINKS_SHOWN
        more = f'<li style="list-style:none;opacity:0.7">&hellip; {hidden} more &hellip;</li>'
        items[_FIRST_LINKS : _FIRST_LINKS + hidden] = [more]
    return _block(
        f'<ol style="margin:0.3em 0;padding-left:2.2em">{"".join(items)}</ol>'
        f"<div>{escape(ending_text(chain))}</div>"
    )


def _link_html(place: int, link: Link) -> str:
    return (
        f'<li value="{place}" title="from ({link.x}, {link.y})">{escape(action_text(link))}:'
        ' <span style="white-space:nowrap;font-variant-numeric:tabular-nums">'
        f"{escape(sum_text(link))}</span></li>"
    )


def hunts_html(hunts: Sequence[HuntShown], theme: Theme) -> str:
    """How hunts ended: one by one while they are few, counted when they are many."""
    if len(hunts) > _HUNTS_NAMED:
        by_outcome = {
            outcome: sum(shown.hunt.outcome == outcome for shown in hunts)
            for outcome in OUTCOME_NAMES
        }
        lines = [
            _outcome_html(
                css(theme.of_outcome(outcome)),
                f"{count} {(OUTCOME_NAMES if count == 1 else _PLURALS)[outcome]}",
            )
            for outcome, count in by_outcome.items()
            if count
        ]
        return _block(f"<b>{len(hunts)} hunts</b> {' '.join(lines)}")
    return _block(
        "".join(
            f"<div>{_outcome_html(css(theme.of_outcome(one.hunt.outcome)), _hunt_text(one))}</div>"
            for one in hunts
        )
    )


def _hunt_text(shown: HuntShown) -> str:
    steps = "1 step" if shown.hunt.steps == 1 else f"{shown.hunt.steps:,} steps"
    return (
        f"from ({shown.x}, {shown.y}), prey facing {HEADING_NAMES[shown.heading]}:"
        f" {OUTCOME_NAMES[shown.hunt.outcome]} after {steps}"
    )


def _outcome_html(colour: str, text: str) -> str:
    return (
        '<span style="display:inline-block"><span style="display:inline-block;width:0.7em;'
        f'height:0.7em;border-radius:50%;background:{escape(colour)};margin-right:0.35em"></span>'
        f"{escape(text)}</span>"
    )
