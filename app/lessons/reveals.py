"""What a prediction is held against: a measure at a moment, found while a run goes on.

A :class:`Watch` looks at the starts of some trials, in their order (:meth:`Watch.next_look`), and
has found its answer once it has seen enough (:attr:`Watch.is_over`). Whoever leads a run past these
moments finds the same: the lesson's own player, and a page that follows a line.

An answer is what people's answers are compared with, by the kind of the question:

- ``choice`` and ``direction``: the value of an option; of a measure that is so or not so, ``yes``
  or ``no``;
- ``number``: a number, of a share so many of a hundred;
- ``sectors``: the octants in which the measure is what it is held against;
- ``moment``: the first trial, of those that are looked at, at whose start it was so;
- ``sketch``: points of trial and mean reward;
- ``order``: values of options, the largest first.

It is None where there is nothing to find: a ring that never closed, a race that was never run.
"""

from collections.abc import Mapping, Sequence
from typing import Final, TypeAlias

from app.documents.lesson_grammar import OCTANTS, Moment
from app.documents.lesson_questions import Asked
from app.lessons.checks import Deadline, holds
from app.lessons.measures import MEASURES, Began, Found, View, measured
from app.words.numbers import tick_step

Answer: TypeAlias = "str | float | tuple[str, ...] | tuple[tuple[float, float], ...] | None"
"""An answer as plain values."""

MOMENT_LOOKS: Final = 200
"""Looks that a moment is found by, at most."""
FAR_LOOKS_EVERY: Final = 200
"""Trials from one to the next where it is not known until when it will be looked for."""
SKETCH_POINTS: Final = 60
"""Points of a curve, at most."""


class Watch:
    """One question, and what a run answers."""

    def __init__(self, asked: Asked, began: Began, until: int | None = None) -> None:
        """Begin where a card was entered.

        Args:
            asked: the question.
            began: where the card was entered.
            until: trial at whose start it is answered where the question names no moment; None for
                where the card was entered, or, of a moment that is predicted, whenever that comes.
        """
        self._asked, self._began = asked, began
        reveal = asked.reveal
        moment = None if reveal is None else reveal.at
        if moment is None:
            last = asked.end if asked.ask in ("sketch", "moment") else None
            last = until if last is None else last
            if last is None and asked.ask != "moment":
                last = began.trial
            moment = None if last is None else Moment(last, is_ahead=False)
        self._end = None if moment is None else Deadline(moment, began)
        self._operators = dict(reveal.operators) if reveal else {}
        self._every = FAR_LOOKS_EVERY
        if self.trial is not None:
            self._every = round(tick_step(began.trial, self.trial, MOMENT_LOOKS, least=1))
        is_share = reveal is not None and MEASURES[reveal.reading.name].unit == "%"
        self._scale = 100.0 if is_share else 1.0
        self.answer: Answer = None
        self.is_over = reveal is None

    @property
    def is_open(self) -> bool:
        """Whether nothing says by when it is answered."""
        return self._end is None

    @property
    def trial(self) -> int | None:
        """Trial at whose start it is answered at the latest; None if no trial says that."""
        return None if self._end is None else self._end.trial

    def next_look(self, trial: int) -> int | None:
        """The trial after one whose start has to be looked at; None if any will do."""
        if self.is_over:
            return None
        if self._asked.ask == "moment":
            step = (trial // self._every + 1) * self._every
            return step if self.trial is None else min(step, max(self.trial, trial + 1))
        if self._end is None:
            return None
        # So many catches may have been made in any trial.
        return trial + 1 if self._end.trial is None else max(self._end.trial, trial + 1)

    def look(self, view: View) -> None:
        """Take in a moment."""
        if self.is_over:
            return
        if self._asked.ask == "moment" and self._is_so(view):
            self.answer, self.is_over = float(view.trial), True
        elif self._end is not None and self._end.has_come(view):
            self.end(view)

    def end(self, view: View) -> None:
        """Answer by a moment, whatever moment the question names."""
        if self.is_over:
            return
        self.is_over = True
        reveal = self._asked.reveal
        assert reveal is not None
        if self._asked.ask == "sketch":
            self.answer = self._curve(view)
        elif self._asked.ask != "moment":
            self.answer = self._answer_of(measured(reveal.reading, view))
        elif self._is_so(view):
            self.answer = float(view.trial)

    def _is_so(self, view: View) -> bool:
        reveal = self._asked.reveal
        assert reveal is not None
        found = measured(reveal.reading, view)
        return holds(found, self._operators) if self._operators else found is True

    def _answer_of(self, found: Found) -> Answer:
        if found is None:
            return None
        if isinstance(found, Mapping):
            return self._by_name(found)
        if self._asked.ask == "number":
            return float(found) * self._scale
        if self._operators:
            found = holds(found, self._operators)
        if isinstance(found, bool):
            return "yes" if found else "no"
        return str(found)

    def _by_name(self, found: Mapping[str, float]) -> tuple[str, ...]:
        if self._asked.ask == "sectors":
            return tuple(o for o in OCTANTS if o in found and holds(found[o], self._operators))
        values = [value for value, _ in self._asked.choices if value in found]
        return tuple(sorted(values, key=lambda value: -found[value]))

    def _curve(self, view: View) -> tuple[tuple[float, float], ...]:
        """Mean rewards of the last trials, at trials of the axis that lie equally far apart."""
        reveal = self._asked.reveal
        assert reveal is not None
        last = reveal.reading.args.last
        points: list[tuple[float, float]] = []
        for trial in sketch_trials(self._asked):
            window = view.reward[max(trial - last, 0) : trial]
            if trial <= view.trial and window.size:
                points.append((float(trial), float(window.mean())))
        return tuple(points)


def varies(asked: Asked) -> bool:
    """Whether the answer hangs on the seed: then nothing is proved of it, and its band is told."""
    return asked.varies or asked.ask == "sketch"


def sketch_trials(asked: Asked) -> Sequence[int]:
    """Trials at which a curve that is to be sketched is known, from the first to the last."""
    first, end = asked.first or 0, asked.end or 0
    every = round(tick_step(first, end, SKETCH_POINTS, least=1))
    return [*range(first, end, every), end]
