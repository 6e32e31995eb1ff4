"""What came of a guess, as a card's frame, the board and the bar are told it."""

from typing import Any, Final

from app.documents.lesson_questions import Asked
from app.lessons.kept import answer_from
from app.lessons.reveals import Answer
from app.lessons.spread import Spread, points_of
from app.page.lesson.board import OctantsAsked
from app.page.time.asked import Asked as OnBar
from app.page.time.asked import Band, MomentAsked, SketchAsked

_RUNS: Final = 20
"""That there will be."""


def sent_spread(asked: Asked, spread: Spread) -> dict[str, Any] | None:
    """What several runs answer, as the card's frame draws it; None while it is not known."""
    if not spread.n:
        return None
    found: dict[str, Any] = {"n": spread.n}
    match asked.ask:
        case "number" | "moment":
            return found | {"values": list(spread.numbers)}
        case "sketch":
            curve = spread.curve
            if curve is None:
                return None
            names = ("at", "low", "middle", "high")
            return found | {name: list(part) for name, part in zip(names, curve, strict=True)}
        case "order":
            values = [value for value, _ in asked.choices]
            orders = [one for one in map(_order, spread.answers) if len(one) == len(values)]
            counts = {
                value: [
                    sum(order[place] == value for order in orders) for place in range(len(values))
                ]
                for value in values
            }
            return found | {"counts": counts}
        case _:
            return found | {"counts": dict(spread.counts)}


def _order(answer: Answer) -> tuple[Any, ...]:
    return answer if isinstance(answer, tuple) else ()


def octants_asked(
    guess: Any,
    locked: bool,
    own: Any,
    spread: Spread,
    others: dict[str, float] | None,
    language: str,
) -> OctantsAsked:
    """What the board is asked, and shows.

    Args:
        guess: the answer as JSON has it; None if there is none.
        locked: whether it stands.
        own: what this run answers, where that is to be seen.
        spread: what several do, where that is to be seen; of none where it is not.
        others: what share of a class chose each.
        language: in which it is told.
    """
    return OctantsAsked(
        guess=frozenset(guess or ()),
        locked=locked,
        run=None if own is None else frozenset(own),
        twenty=dict(spread.counts) if spread.n else None,
        runs=spread.n or _RUNS,
        others=others,
        language=language,
    )


def bar_asked(
    asked: Asked,
    question: str,
    guess: Any,
    locked: bool,
    own: Any,
    spread: Spread,
    language: str,
) -> OnBar | None:
    """What the time bar is asked, and shows; None of a question that is not answered there."""
    if asked.ask == "moment":
        return MomentAsked(
            question,
            None if guess is None else int(guess),
            locked,
            None if own is None else int(own),
            tuple(map(int, spread.numbers)),
            spread.n or _RUNS,
            asked.first or 0,
            asked.end,
            language,
        )
    if asked.ask != "sketch":
        return None
    curve = spread.curve
    return SketchAsked(
        question,
        asked.first or 0,
        asked.end or 0,
        None if guess is None else tuple((int(trial), float(reward)) for trial, reward in guess),
        locked,
        () if own is None else tuple((int(t), float(r)) for t, r in points_of(answer_from(own))),
        None if curve is None else Band(tuple(map(int, curve.at)), curve.low, curve.high),
        language,
    )
