"""What people predict: any answer is taken in or refused, and nobody loses to luck."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.documents.lesson_cards import Card
from app.documents.lesson_grammar import DIRECTIONS, OCTANTS
from app.documents.lesson_questions import Asked
from app.lessons.predictions import HANDLES, answer_of, is_right, scored
from app.lessons.reveals import Answer
from app.lessons.spread import Spread

BEHIND = ("nw", "w", "sw")
PARTS = ("freeze", "timers", "exploring")
EXPERIMENT = {"experiment": {"name": "ablation", "quantity": "final_reward"}}
QUESTIONS: dict[str, dict[str, Any]] = {
    "choice": {"options": ["yes", "no"], "reveal": {"reward": 500, "above": 0}},
    "direction": {"options": [*DIRECTIONS], "reveal": {"measure": "spread_direction"}},
    "number": {"low": 0, "high": 100, "reveal": {"measure": "value_states"}},
    "sectors": {"reveal": {"reach": "octants", "above": 0.5}},
    "moment": {"from": 0, "to": 48_000, "reveal": {"measure": "thinnest", "above": 0.25}},
    "sketch": {"from": 0, "to": 5_000, "reveal": {"reward": 500}},
    "order": {"options": [*PARTS], "reveal": EXPERIMENT},
}


def asked(kind: str, **more: Any) -> Asked:
    return Card.model_validate({"ask": kind, "text": "What?", **QUESTIONS[kind], **more})


def sketch(*rewards: float) -> tuple[tuple[float, float], ...]:
    return tuple((1_000.0 * place, reward) for place, reward in enumerate(rewards))


LEVEL = [[1_000 * place, 10.0] for place in range(HANDLES)]


@pytest.mark.parametrize(
    ("kind", "value", "answer"),
    [
        ("choice", "yes", "yes"),
        ("direction", "both ways", "both ways"),
        ("number", 12, 12.0),
        ("sectors", ["w", "sw", "nw"], BEHIND),
        ("sectors", [], ()),
        ("moment", 24_000, 24_000.0),
        ("sketch", LEVEL, sketch(*[10.0] * HANDLES)),
        ("order", ["timers", "freeze", "exploring"], ("timers", "freeze", "exploring")),
    ],
)
def test_an_answer(kind: str, value: Any, answer: Answer) -> None:
    assert answer_of(asked(kind), value) == answer


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        *(("choice", value) for value in ("maybe", None, 1, True, ["yes"], {})),
        *(("number", value) for value in (-1, 101, True, "5", None, float("nan"), float("inf"))),
        *(("sectors", value) for value in ("w", ["w", "w"], ["up"], [["w"]], [1], {"w": 1})),
        *(("moment", value) for value in (-1, 48_001, "now", [1])),
        ("sketch", LEVEL[:5]),
        ("sketch", [*LEVEL, [6_000, 1]]),
        ("sketch", [*LEVEL[:5], LEVEL[0]]),
        ("sketch", [*LEVEL[:5], [5_001, 1]]),
        ("sketch", [*LEVEL[:5], [5_000, float("nan")]]),
        ("sketch", [*LEVEL[:5], [5_000]]),
        ("sketch", "drawn"),
        ("order", ["timers", "freeze"]),
        ("order", ["timers", "freeze", "timers"]),
        ("order", [["timers"], "freeze", "exploring"]),
    ],
)
def test_no_answer(kind: str, value: Any) -> None:
    with pytest.raises(ValueError, match=r"^is |^does |^has "):
        answer_of(asked(kind), value)


@given(
    st.sampled_from([*QUESTIONS]),
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
        | st.sampled_from([*OCTANTS, *PARTS, "yes"]),
        lambda parts: st.lists(parts, max_size=7) | st.dictionaries(st.text(max_size=3), parts),
        max_leaves=20,
    ),
)  # fmt: skip
def test_whatever_comes_is_an_answer_or_is_refused(kind: str, value: Any) -> None:
    question = asked(kind)
    try:
        answer = answer_of(question, value)
    except ValueError:
        return
    # What is an answer can be compared with anything that runs answer.
    assert scored(question, answer, None, Spread(())).within is None
    assert scored(question, answer, answer, Spread((answer,) * 20)).within is True


@pytest.mark.parametrize(
    ("kind", "answer", "own", "others", "within"),
    [
        # What this run did is right, however rare it is, and what some others did as well.
        ("choice", "no", "no", ["yes"] * 20, True),
        ("choice", "no", "yes", ["yes"] * 18 + ["no"] * 2, True),
        ("choice", "no", "yes", ["yes"] * 19 + ["no"], False),
        ("number", 40.0, 50.0, [41.0, 60.0, *[50.0] * 18], False),
        ("number", 41.0, 50.0, [41.0, 60.0, *[50.0] * 18], True),
        ("number", 70.0, 70.0, [41.0, 60.0, *[50.0] * 18], True),
        ("moment", 24_000.0, None, [23_000.0, 25_000.0, *[None] * 18], True),
        ("moment", 26_000.0, None, [23_000.0, 25_000.0, *[None] * 18], False),
        ("sectors", BEHIND, BEHIND, [BEHIND] * 20, True),
        ("sectors", ("w",), BEHIND, [BEHIND] * 20, False),
        ("sectors", (*BEHIND, "e"), BEHIND, [BEHIND] * 20, False),
        # Where runs differ, either is right.
        ("sectors", ("w", "sw"), BEHIND, [BEHIND] * 10 + [("w", "sw")] * 10, True),
        ("sketch", sketch(0, 0, 0, 50, 50, 50), sketch(1, 1, 1, 60, 60, 60),
         [sketch(-5, -5, -5, 40, 40, 40)] * 20, True),
        ("sketch", sketch(0, 0, 0, 0, 0, 0), sketch(1, 1, 1, 60, 60, 60),
         [sketch(-5, -5, -5, 40, 40, 40)] * 20, False),
        ("order", ("freeze", "timers", "exploring"), PARTS, [PARTS] * 20, True),
        ("order", ("exploring", "timers", "freeze"), PARTS, [PARTS] * 20, False),
        ("order", ("timers", "freeze", "exploring"), PARTS,
         [PARTS] * 10 + [("timers", "freeze", "exploring")] * 10, True),
    ],
)  # fmt: skip
def test_against_what_runs_do(
    kind: str, answer: Answer, own: Answer, others: list[Answer], within: bool
) -> None:
    found = scored(asked(kind), answer, own, Spread(tuple(others)))
    assert found.within is within
    assert found.words[0].isupper() or found.words[0].isdigit()
    assert found.words.endswith(".")
    # Nobody is given a mark.
    assert not {"wrong", "score", "points of", "%"} & set(found.words.lower().split())


def test_with_a_key_no_run_matters() -> None:
    number = asked("number", key=50)
    assert scored(number, 52.0, 90.0, Spread((90.0,) * 20)).within is True
    assert scored(number, 90.0, 90.0, Spread((90.0,) * 20)).within is False
    choice = asked("choice", options=["ja", "nein"], values=["yes", "no"], key="no")
    assert scored(choice, "no", None, Spread(())) == (True, "It is nein.")
    assert is_right(asked("sectors", key=["w", "sw"]), ("sw", "w"))


def test_what_several_runs_come_to() -> None:
    spread = Spread(("yes", "no", "yes", None))
    assert (spread.n, spread.n_answered, dict(spread.counts)) == (4, 3, {"yes": 2, "no": 1})
    assert Spread((BEHIND, ("w",))).counts["w"] == 2
    assert Spread((3.0, 1.0, None, 2.0)).band == (1.0, 2.0, 3.0)
    assert Spread((None,)).band is None
    curve = Spread((sketch(0, 5), sketch(2, 1), sketch(1, 3))).curve
    assert curve == ((0.0, 1_000.0), (0.0, 1.0), (1.0, 3.0), (2.0, 5.0))
    assert Spread((None,)).curve is None
