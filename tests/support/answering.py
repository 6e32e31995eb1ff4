"""Right answers and wrong ones to what a shipped lesson asks, as JSON has them."""

from typing import Any, Final

from app.documents.lesson_grammar import OCTANTS
from app.documents.lesson_questions import Asked
from app.documents.lessons import Lesson
from app.lessons.kept import default_folder
from app.lessons.reveals import Answer
from app.lessons.spread import points_of
from app.lessons.twenty import Spreads, Twenty

PATIENCE_S: Final = 180.0
"""For twenty runs of a lesson, where nobody has made them before."""


def found_for(lesson: Lesson) -> Spreads:
    """What the lesson's own run and twenty others answer; kept where the lab finds it, too."""
    twenty = Twenty(folder=default_folder())
    try:
        twenty.want(lesson)
        assert twenty.settle(PATIENCE_S)
        found = twenty.found(lesson)
    finally:
        twenty.stop()
    assert found is not None
    return found


def right_answer(asked: Asked, own: Answer) -> Any:
    """What the lesson's own run answers, or the key, as somebody would give it."""
    if asked.key is not None:
        return asked.key
    if asked.ask == "sketch":
        first, end, curve = asked.first or 0, asked.end or 0, points_of(own)
        trials = [round(first + (end - first) * at / 5) for at in range(6)]
        nearest = [min(curve, key=lambda point: abs(point[0] - trial)) for trial in trials]
        return [[trial, round(reward)] for trial, (_, reward) in zip(trials, nearest, strict=True)]
    return list(own) if isinstance(own, tuple) else own


def wrong_answer(asked: Asked, right: Any) -> Any:
    """One as far from that as there is."""
    match asked.ask:
        case "choice" | "direction":
            return next(value for value, _ in asked.choices if value != right)
        case "sectors":
            return [octant for octant in OCTANTS if octant not in right]
        case "order":
            return right[::-1]
        case "sketch":
            return [[trial, asked.low] for trial, _ in right]
        case "moment":
            ends = (asked.first or 0, asked.end or 0)
            return max(ends, key=lambda trial: abs(trial - right))
        case _:
            return max((asked.low or 0.0, asked.high or 0.0), key=lambda end: abs(end - right))
