"""Bars of lines as they are sent to those who look at them, made once for all who see the same.

A bar is that of a whole line, as far as it is known, whichever moment of it somebody looks at. What
can be edited is the plan of that moment.
"""

from collections.abc import Hashable
from typing import Final, NamedTuple

import msgspec

from app.analysis.estimates import Axis
from app.charts.bar.model import Ghost, Moment, View, bar_of
from app.charts.bar.sent import Around, bar_sent
from app.charts.bar.tree import marks_on
from app.live.places import Place
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.ghost import GhostWatch, ghost_of_line
from app.page.greedy import EVERY_TRIALS, GreedyWatch
from app.page.time.grounds import Grounds
from app.page.time.outlook import Makes, Wish
from app.page.time.walk import Ground
from app.schedule.blocks import Block, Past

_REDRAW_S: Final = 0.4
"""How often one is made anew when nothing but the run has gone on: as often as its curve."""
_KEPT_S: Final = 5.0
_MOST_KEPT: Final = 64
"""Bars that are kept for those who come next."""


class _Line(NamedTuple):
    """A line as it is drawn."""

    moment: Moment
    around: Around
    answers: tuple[object, ...]
    """What changes when somebody has done something."""
    taken_s: float


class _Made(NamedTuple):
    """A bar, and what it was made of: kept, so that it is told by what that is."""

    line: _Line
    history: object
    bar: msgspec.Raw


class Bars:
    """Of one session. The render loop alone has to do with it."""

    def __init__(
        self, grounds: Grounds, makes: Makes, greedy: GreedyWatch, ghosts: GhostWatch
    ) -> None:
        self._grounds, self._makes = grounds, makes
        self._greedy, self._ghosts = greedy, ghosts
        self._lines: dict[int, _Line] = {}
        self._ends: dict[int, Wish] = {}
        """Of lines that are not live: their ends."""
        self._pasts: dict[Hashable, Past] = {}
        """Blocks of lines, and of the plans at moments that browsers look at."""
        self._made: dict[tuple[int, Axis, int | None, View | None], _Made] = {}
        """Of a line, along an axis, as all see it or as one browser does that looks at its past:
        the whole of it, or a part."""
        self._used_s: dict[Hashable, float] = {}
        """When each line, and each browser's plan, was asked for last."""

    def tidy(self, now_s: float) -> None:
        """Forget what nobody has looked at for a while."""
        for of in [of for of, used_s in self._used_s.items() if now_s - used_s > _KEPT_S]:
            del self._used_s[of]
            self._pasts.pop(of, None)
            if isinstance(of, int):
                self._lines.pop(of, None)
                if of in self._ends:
                    self._ends.pop(of).drop()
        for of in [of for of in self._made if of[0] not in self._lines]:
            del self._made[of]
        for of in list(self._made)[:-_MOST_KEPT]:
            del self._made[of]

    def sent(
        self,
        viewer: int,
        line: int,
        seen: Status,
        live: Status,
        ground: Ground,
        unit: Axis,
        chosen: str,
        now_s: float,
        view: View | None = None,
    ) -> msgspec.Raw | None:
        """The bar of a line for one browser, as JSON; None as long as there is none yet.

        It is the same object until it is another.

        Args:
            viewer: the browser.
            line: the line that it looks at.
            seen: what is true for the browser.
            live: how the live run stands.
            ground: what is known of the lines.
            unit: what the axis is of.
            chosen: id of the block that stands out.
            now_s: the time.
            view: the part of it that is seen; None for all of it.
        """
        drawn = self._line(line, live, ground, chosen, now_s)
        if drawn is None:
            return None
        is_past = seen.behind is not None and seen.snapshot.generation == line
        of = (line, unit, viewer if is_past else None, view)
        history = seen.snapshot.control.history if is_past else None
        made = self._made.get(of)
        if made is None or made.line is not drawn or made.history is not history:
            around = drawn.around
            if is_past:
                around = around._replace(ahead=self._ahead(viewer, seen.snapshot, now_s))
            if view is not None:
                around = _seen(around, view)
            bar = bar_of(drawn.moment, unit, EVERY_TRIALS, view)
            raw = msgspec.Raw(msgspec.json.encode(bar_sent(bar, around)))
            if made is not None and made.bar == raw:
                raw = made.bar
            # The one that was used last comes last.
            self._made.pop(of, None)
            self._made[of] = made = _Made(drawn, history, raw)
        return made.bar

    def _line(
        self, line: int, live: Status, ground: Ground, chosen: str, now_s: float
    ) -> _Line | None:
        """A line as it is to be drawn; what only went on is taken in now and then."""
        former = self._lines.get(line)
        end = self._end(line, live, ground, now_s)
        if end is None:
            return former
        tree = tuple((seen.number, seen.parent, seen.name, seen.is_live) for seen in live.lines)
        notes = marks_on(line, live.lines, live.marks)
        answers = (end.spec, len(end.control.history), chosen, tree, notes)
        if former is not None and now_s - former.taken_s < _REDRAW_S:
            is_answer = former.answers[0] is not answers[0] or former.answers[1:] != answers[1:]
            if not is_answer:
                return former
        past = self._pasts.setdefault(line, Past())
        blocks = past.blocks_of(end)
        greedy = self._greedy.until(end, live.lines)
        ghost = self._ghost(line, live, ground, now_s)
        moment = Moment(end, blocks, past.left_out, chosen, greedy, ghost, notes)
        around = Around(line, live.lines, notes, self._grounds.happened(line))
        if former is not None and _is_as(former, moment, around):
            self._lines[line] = former._replace(taken_s=now_s)
            return former
        self._lines[line] = drawn = _Line(moment, around, answers, now_s)
        return drawn

    def _end(self, line: int, live: Status, ground: Ground, now_s: float) -> Snapshot | None:
        """The newest moment of a line that there is."""
        self._used_s[line] = now_s
        if line == live.snapshot.generation:
            return live.snapshot
        course = ground.course_of(line)
        if course is None:
            return None
        wish = self._ends.setdefault(line, Wish(self._makes, ("end", line)))
        drawn = self._lines.get(line)
        if drawn is None or now_s - drawn.taken_s >= _REDRAW_S:
            wish.show(Place(line, course.end_step))
        return wish.found

    def _ghost(self, line: int, live: Status, ground: Ground, now_s: float) -> Ghost | None:
        """What a line is to be compared with: the one that it left, or what the watch knows of."""
        by_number = {seen.number: seen for seen in live.lines}
        own = by_number.get(line)
        parent = None if own is None or own.parent is None else by_number.get(own.parent)
        if parent is not None:
            end = self._end(parent.number, live, ground, now_s)
            return None if end is None else ghost_of_line(parent, end)
        return self._ghosts.latest if line == live.snapshot.generation else None

    def _ahead(self, viewer: int, snapshot: Snapshot, now_s: float) -> tuple[Block, ...]:
        """The plan at a moment that a browser looks at."""
        self._used_s["at", viewer] = now_s
        past = self._pasts.setdefault(("at", viewer), Past())
        return tuple(block for block in past.blocks_of(snapshot) if block.editable)


def _seen(around: Around, view: View) -> Around:
    """What is shown around a part of a line."""
    last = view.end if view.hides_after is None else view.hides_after
    happened = [one for one in around.happenings if view.first <= one.trial <= last]
    return around._replace(happenings=happened, alone=True)


def _is_as(former: _Line, moment: Moment, around: Around) -> bool:
    """Whether a line is drawn as before; of what is kept in it, the ids are enough."""
    was = former.moment
    return (
        was.snapshot is moment.snapshot
        and was.greedy is moment.greedy
        and was.ghost is moment.ghost
        and (was.chosen, was.blocks) == (moment.chosen, moment.blocks)
        and former.around == around
    )
