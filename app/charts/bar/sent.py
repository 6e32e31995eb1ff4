"""The bar as it is sent to the scripts that draw it (``app/web/time/``): plain data for JSON.

Blocks and bands are told in trials, so that a hand can move them along; curves, marks and labels
have their places already, as shares of the axis. What each field is called, and what it means,
stands in ``app/web/time/state.js``.
"""

from collections.abc import Iterable, Sequence
from typing import Any, Final, NamedTuple, cast

from app.analysis.estimates import Axis
from app.charts.bar.axis import TimeAxis
from app.charts.bar.lanes import Lane, Piece
from app.charts.bar.marks import Mark
from app.charts.bar.model import Band, Bar, Points
from app.charts.bar.rule import Rule
from app.charts.bar.tree import in_rows
from app.explain.happenings import Happening
from app.live.places import LineSeen
from app.live.places import Mark as Note
from app.picture.colours import css
from app.picture.theme import DARK, LIGHT, Theme
from app.schedule.blocks import Block, described
from app.util.texts import written
from app.words.glossary import TERMS
from app.words.numbers import counted, labelled_ticks, shown_number
from app.words.plain import named, plain

Sent = dict[str, Any]
"""What JSON calls an object."""

_MOST_REWARDS: Final = 3
_DIGEST_CHARACTERS: Final = 6
"""Of a digest in the tree; the whole of it is in the hint."""
_UNITS: Final[tuple[tuple[Axis, str, str], ...]] = (
    ("trials", "trial", "Curve and schedule against trials, in which the schedule is told"),
    ("steps", "steps", "Both against steps: a trial takes many at first, and few later on"),
)
"""What an axis is of, what it is called, and what it is for."""


class Around(NamedTuple):
    """What a bar shows besides one run: the tree that this is a line of, and where one can go."""

    line: int
    """Number of the line whose bar it is."""
    lines: Sequence[LineSeen] = ()
    """All of the tree."""
    notes: Sequence[Note] = ()
    """Marks with a text, of those that lie on this line."""
    happenings: Sequence[Happening] = ()
    """What happened in it, by step."""
    ahead: Sequence[Block] | None = None
    """The plan at the moment that is looked at, by which blocks can be edited there; None if that
    is the newest moment of the line."""
    recorded: bool = False
    """Whether all of it has happened, and nothing can be changed."""
    alone: bool = False
    """Whether the other lines are not to be seen."""


def bar_sent(bar: Bar, around: Around) -> Sent:
    """All that is drawn of a bar. It can be written as JSON whatever people called their things."""
    own = next((line for line in around.lines if line.number == around.line), None)
    has_tree = len(around.lines) > 1 and not around.alone
    sent: Sent = {
        "line": around.line,
        "live": own is None or own.is_live,
        "recorded": around.recorded,
        "axis": _axis(bar.axis),
        "end": {"step": bar.axis.step, "trial": bar.axis.trial},
        "legend": [_item(*item) for item in _legend(bar)],
        "rewards": list(bar.rewards),
        "levels": [list(tick) for tick in labelled_ticks(*bar.rewards, _MOST_REWARDS)],
        "learned": _points(bar.learned),
        "greedy": _points(bar.greedy),
        "gaps": list(bar.greedy_gaps),
        "ghost": None if bar.ghost is None else _points(bar.ghost),
        "rules": [_rule(rule) for rule in bar.rules],
        "bands": [_band(band) for band in bar.bands],
        "marks": [_mark(mark) for mark in bar.marks],
        "lanes": [_lane(lane, around.ahead) for lane in bar.lanes],
        "happenings": [happening._asdict() for happening in around.happenings],
        "notes": [_note(note) for note in around.notes],
        "lines": [_line(line) for line in in_rows(around.lines)] if has_tree else [],
        "units": [{"unit": unit, "name": name, "hint": hint} for unit, name, hint in _UNITS],
        "colours": {"light": _colours(LIGHT), "dark": _colours(DARK)},
    }
    return _written(sent)


def _written(sent: Any) -> Any:
    """The same without characters that no document may have."""
    if isinstance(sent, str):
        return written(sent)
    if isinstance(sent, dict):
        return {key: _written(each) for key, each in cast("Sent", sent).items()}
    if isinstance(sent, list):
        return [_written(each) for each in cast("list[Any]", sent)]
    return sent


def _axis(axis: TimeAxis) -> Sent:
    return {
        "unit": axis.unit,
        "start": axis.start,
        "end": axis.end,
        "trials": axis.progress.trials.tolist(),
        "steps": axis.progress.steps.tolist(),
        "pace": max(axis.pace, 1.0),
        "ticks": [{"at": _share(tick.at), "text": tick.text} for tick in axis.ticks],
    }


def _share(share: float) -> float:
    return round(float(share), 5)


def _points(points: Points) -> Sent:
    return {
        "at": [_share(at) for at in points.at.tolist()],
        "reward": [round(reward, 2) for reward in points.reward.tolist()],
    }


def _colours(theme: Theme) -> dict[str, str]:
    """Colours that have a meaning, by what they are for."""
    return {
        "forced": css(theme.forced),
        "frozen": css(theme.frozen),
        "line": css(theme.lines),
        "capture": css(theme.capture),
    }


# --- What is what --------------------------------------------------------------------------------


def _item(kind: str, text: str, hint: str) -> Sent:
    return {"kind": kind, "text": text, "hint": hint}


def _legend(bar: Bar) -> Iterable[tuple[str, str, str]]:
    yield "learned", "as it learns", _learned_hint(bar)
    yield "greedy", "greedy", _greedy_hint(bar)
    if bar.ghost is not None:
        yield "ghost", bar.ghost_name, bar.ghost_hint
    kinds = {band.kind for band in bar.bands}
    if "forced" in kinds:
        yield "forced", "forced exploration", TERMS["forced exploration"]
    if "taught" in kinds:
        yield "taught", "taught", TERMS["teaching"]
    if "frozen" in kinds:
        yield "frozen", "frozen", TERMS["freeze"]
    blocks = [piece.block for lane in bar.lanes for piece in lane.pieces]
    if any(_is_ahead(block, bar.axis) for block in blocks):
        yield "planned", "planned", "Outlined: what the schedule has ahead."
    if any(block.by_hand for block in blocks):
        yield "hand", "by hand", "Begun by hand, or not as the preset has it."
    if bar.left_out:
        yield "more", f"{counted(bar.left_out, 'earlier change')} not drawn", ""


def _is_ahead(block: Block, axis: TimeAxis) -> bool:
    """Whether something of it is to come."""
    if block.until == block.first:
        return False
    return block.state == "idle" or (block.until or 0) > axis.trial


def _learned_hint(bar: Bar) -> str:
    return (
        "Mean reward of the trials that are learned from, random moves, explorations and all. Each"
        f" point is the mean over {bar.window}, where they ended."
    )


def _greedy_hint(bar: Bar) -> str:
    return (
        f"Mean reward of {bar.n_hunts:,} hunts with what was known at a moment: no random moves,"
        " nothing explored, nothing learned. Measured at the dots; dashed where they are far apart."
    )


# --- Bands, marks and lanes ----------------------------------------------------------------------


def _band(band: Band) -> Sent:
    block = band.block
    return {"key": block.id, "first": block.first, "until": block.until, "kind": band.kind}


def _rule(rule: Rule) -> Sent:
    return {
        "skill": rule.skill,
        "first": rule.first,
        "known": rule.known,
        "until": rule.until,
        "met": rule.met,
        "below": rule.below,
        "trials": rule.trials.tolist(),
        "values": [float(f"{value:.3g}") for value in rule.values.tolist()],
        "fires": rule.fires.tolist(),
        "ends": list(rule.ends),
        "what": list(rule.what),
        "short": list(rule.short),
        "long": rule.long,
    }


def _mark(mark: Mark) -> Sent:
    return {
        "at": _share(mark.at),
        "name": mark.name,
        "more": mark.more,
        "before": mark.is_before,
        "room": _share(mark.room),
        "hint": mark.hint,
        "note": mark.note,
    }


def _note(note: Note) -> Sent:
    return {
        "number": note.number,
        "step": note.place.step,
        "trial": note.trial,
        "text": note.text,
    }


def _lane(lane: Lane, ahead: Sequence[Block] | None) -> Sent:
    return {
        "name": lane.name,
        "skill": lane.skill,
        "presence": [
            {"first": stretch.first, "until": stretch.until, "ahead": stretch.is_ahead}
            for stretch in lane.presence
        ],
        "pieces": [_piece(piece, ahead) for piece in lane.pieces],
        "labels": [
            {
                "of": list(label.of),
                "before": label.before,
                "text": label.text,
                "after": label.after,
                "at": _share(label.at),
                "side": label.side,
                "room": _share(label.room),
            }
            for label in lane.labels
        ],
    }


def _piece(piece: Piece, ahead: Sequence[Block] | None) -> Sent:
    block = piece.block
    edited_by = _edited_by(block, ahead)
    return {
        "key": block.id,
        "id": edited_by or block.id,
        "kind": piece.kind,
        "half": piece.half,
        "first": block.first,
        "until": block.until,
        "probability": block.probability,
        "what": _what(block),
        "idle": piece.is_idle,
        "hand": block.by_hand,
        "editable": edited_by is not None,
        "chosen": piece.is_chosen,
        "hint": described(block),
    }


def _what(block: Block) -> str:
    """What a block is called by itself, without its numbers."""
    if block.kind == "introduction":
        return f"{named(block.skill)} joins"
    if block.kind == "exploration":
        return f"Forced exploration of {plain(block.skill)}"
    if block.kind == "teaching":
        return "Taught by a script"
    return "Frozen by hand"


def _edited_by(block: Block, ahead: Sequence[Block] | None) -> str | None:
    """By which id a block can be edited at the moment that is looked at; None if it cannot.

    What happened by the plan of that moment since has become another block, of the same content.
    """
    if ahead is None:
        return block.id if block.editable else None
    editable = [each for each in ahead if each.editable]
    alike = (each.id for each in editable if _are_alike(each, block))
    same = (each.id for each in editable if each.id == block.id)
    return next(alike, None) or next(same, None)


def _are_alike(one: Block, other: Block) -> bool:
    """Whether blocks are of the same content; a skill joins but once."""
    if one.kind == other.kind == "introduction":
        return one.skill == other.skill
    return _content(one) == _content(other)


def _content(block: Block) -> tuple[object, ...]:
    return block.kind, block.skill, block.first, block.until, block.probability


# --- The tree ------------------------------------------------------------------------------------


def _line(line: LineSeen) -> Sent:
    reward = shown_number(line.reward, ".1f")
    digest = line.digest[:_DIGEST_CHARACTERS]
    return {
        "line": line.number,
        "parent": line.parent,
        "name": line.name,
        "fork": {"step": line.fork_step, "trial": line.fork_trial},
        "until": {"step": line.until_step, "trial": line.until_trial},
        "reward": reward,
        "digest": digest,
        "live": line.is_live,
        "growing": line.is_growing,
        "hint": _line_hint(line, reward),
    }


def _line_hint(line: LineSeen, reward: str) -> str:
    parts = [f"{line.name}{' (live)' if line.is_live else ''}"]
    if line.parent is not None:
        parts.append(f"branched off at trial {line.fork_trial:,}")
    known = "being made, so far to" if line.is_growing else "known to"
    parts.append(f"{known} trial {line.until_trial:,}")
    parts.append(f"reward {reward} a trial at the end")
    if line.digest:
        parts.append(f"digest {line.digest}")
    return ", ".join(parts)
