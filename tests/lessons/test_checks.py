"""What a check comes to: never a wrong verdict, and none that is taken back."""

from dataclasses import replace
from itertools import pairwise
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.documents import presets
from app.documents.lesson_grammar import Check, Opened
from app.lessons.checks import (
    CLOSE_LOOKS,
    FAR,
    FAR_LOOKS_EVERY,
    LOOKS_EVERY,
    Judge,
    Verdict,
    judge,
)
from app.lessons.measures import Began, Deeds, Done, Looked, View, view_of_run
from app.lessons.words import IN_ENGLISH
from learners.commands import Explore, Introduce, Undo
from learners.run import Run
from sim.world import CAPTURE, FLIGHT

SPEC: Final = presets.load("timed", ["world.size=40", "trials=2000"])
BLANK: Final = view_of_run(Run(SPEC, 0))
BEGAN: Final = Began(100, 5_000)


def check(**stated: Any) -> Check:
    return Check.model_validate(stated)


def at(trial: int, known: int = 0, trial_step: int = 0, captures: int = 0) -> View:
    """A moment of a run in which so many states have a value, and so many were caught at last."""
    value = np.zeros(BLANK.value.size, np.float32)
    value[:known] = 1.0
    outcome = np.full(trial, FLIGHT, np.int8)
    outcome[trial - captures :] = CAPTURE
    logs = BLANK.logs._replace(log_outcome=outcome, log_reward=np.zeros(trial))
    return replace(
        BLANK,
        trial=trial,
        step=50 * trial + trial_step,
        trial_step=trial_step,
        value=value.reshape(BLANK.value.shape),
        logs=logs,
        since=BEGAN.trial,
        since_step=BEGAN.step,
    )


def judged(asked: Check, *views: View) -> list[str]:
    """The verdict after each moment."""
    judging = Judge(asked, BEGAN)
    return [judging.look(view).state for view in views]


KNOWN: Final = {"measure": "value_states"}


@pytest.mark.parametrize(
    ("stated", "views", "states"),
    [
        # What was so once stays so.
        ({**KNOWN, "above": 3}, [at(100), at(120, 4), at(130, 2)], ["not yet", "yes", "yes"]),
        ({**KNOWN, "is": 5}, [at(100, 4), at(101, 6), at(102, 5)], ["not yet", "not yet", "yes"]),
        ({**KNOWN, "between": [2, 4]}, [at(100, 1), at(101, 4)], ["not yet", "yes"]),
        # The deadline's own moment is in time, and no later one.
        ({**KNOWN, "above": 3, "by": "+50"}, [at(149), at(150, 4)], ["not yet", "yes"]),
        ({**KNOWN, "above": 3, "by": "+50"}, [at(149), at(150)], ["not yet", "never"]),
        ({**KNOWN, "above": 3, "by": "+50"}, [at(149), at(150, 4, trial_step=1)],
         ["not yet", "never"]),
        ({**KNOWN, "above": 3, "by": 150}, [at(149), at(151, 9)], ["not yet", "never"]),
        # What only grows cannot come back.
        ({"measure": "trial", "below": 110}, [at(110)], ["never"]),
        ({"measure": "trial", "is": 120}, [at(119), at(121)], ["not yet", "never"]),
        ({"measure": "trial", "above": 120}, [at(120), at(121)], ["not yet", "yes"]),
        ({"measure": "captures", "is": 2}, [at(110, captures=1), at(120, captures=3)],
         ["not yet", "never"]),
        # A value can come back, so nothing is lost.
        ({**KNOWN, "below": 2}, [at(110, 5), at(111, 1)], ["not yet", "yes"]),
        # So many catches are a deadline as well.
        ({**KNOWN, "above": 3, "by": {"captures": 2}},
         [at(110, captures=2), at(111, 9, captures=3)], ["not yet", "never"]),
        ({**KNOWN, "above": 3, "by": {"captures": 2}}, [at(110, 4, captures=2)], ["yes"]),
        # For so many trials in a row.
        ({**KNOWN, "above": 3, "for": 10}, [at(100, 4), at(105, 4), at(110, 4)],
         ["not yet", "not yet", "yes"]),
        ({**KNOWN, "above": 3, "for": 10}, [at(100, 4), at(105), at(110, 4), at(120, 4)],
         ["not yet", "not yet", "not yet", "yes"]),
        ({**KNOWN, "above": 3, "for": 10, "by": "+20"}, [at(105), at(111)], ["not yet", "never"]),
        ({**KNOWN, "above": 3, "for": 10, "by": "+20"}, [at(108, 4), at(118, 4)],
         ["not yet", "yes"]),
        # All at one moment, but for what has to be so by some trial: that has happened, or has not.
        ({"all": [{**KNOWN, "above": 3}, {"measure": "trial", "above": 110}]},
         [at(105, 4), at(111), at(112, 4)], ["not yet", "not yet", "yes"]),
        ({"all": [{**KNOWN, "above": 3, "by": "+10"}, {"measure": "trial", "above": 110}]},
         [at(105, 4), at(111)], ["not yet", "yes"]),
        ({"all": [{**KNOWN, "above": 3, "by": "+10"}, {"measure": "trial", "above": 500}]},
         [at(110)], ["never"]),
        ({"any": [{**KNOWN, "above": 3, "by": "+10"}, {"measure": "trial", "above": 150}]},
         [at(111), at(151)], ["not yet", "yes"]),
        ({"any": [{**KNOWN, "above": 3, "by": "+10"}, {"measure": "trial", "below": 90}]},
         [at(110)], ["never"]),
        ({"not": {**KNOWN, "above": 3, "by": "+10"}}, [at(110)], ["yes"]),
        ({"not": {"measure": "trial", "above": 110}}, [at(111)], ["never"]),
        # A window that is past is what it is.
        ({"reward": [50, 90], "above": 10}, [at(100)], ["never"]),
        ({"reward": [50, 120], "above": 10}, [at(110), at(120)], ["not yet", "never"]),
    ],
)  # fmt: skip
def test_a_verdict(stated: dict[str, Any], views: list[View], states: list[str]) -> None:
    assert judged(check(**stated), *views)[-len(states) :] == states


def test_it_says_when_it_came_true_and_until_when_it_may() -> None:
    asked = check(**KNOWN, above=3, by="+50")
    assert judge(asked, [at(110)], BEGAN) == Verdict("not yet", None, 150)
    assert judge(asked, [at(110), at(120, 4), at(149, 4)], BEGAN) == Verdict("yes", 120)
    assert "150" in judge(asked, [], BEGAN).in_words(IN_ENGLISH)
    assert "no longer" in judge(asked, [at(150)], BEGAN).in_words(IN_ENGLISH)


def test_what_was_done_counts_from_its_moment_on() -> None:
    asked = check(command="race")
    later = Deeds(done=(Done("race", 50 * 120),))
    looked = Deeds(opened=(Looked(Opened("why"), 50 * 120),))
    for stated, deeds in ((asked, later), (check(opened="why"), looked)):
        before, after = (replace(at(trial), deeds=deeds) for trial in (119, 120))
        assert judged(stated, before, after) == ["not yet", "yes"]
    assert judged(check(**{"not": {"command": "race"}}), replace(at(120), deeds=later)) == ["never"]


def test_a_command_counts_where_it_was_given_by_hand_and_stands() -> None:
    run = Run(SPEC, 0)
    run.advance(until_trial=50)
    began = Began(run.trial, run.step, len(run.control.history))
    asked = check(command="introduce")

    def state() -> str:
        return judge(asked, [view_of_run(run, began=began)], began).state

    # The schedule has given one, before the card was entered.
    assert state() == "not yet"
    run.apply(Explore("approach", 10, 0.5))
    assert state() == "not yet"
    run.apply(Introduce("avoid", 0))
    assert state() == "yes"
    given = next(e for e in run.control.history if e.command == Introduce("avoid", 0))
    run.apply(Undo(given.number))
    assert state() == "not yet"
    taken_back = check(**{"not": {"command": "introduce"}})
    assert judge(taken_back, [view_of_run(run, began=began)], began).state == "yes"


@given(st.integers(0, 20_000), st.integers(1, 10_000))
def test_looks_are_at_fixed_trials_and_pass_no_deadline(trial: int, ahead: int) -> None:
    judging = Judge(check(**KNOWN, above=3, by=f"+{ahead}"), BEGAN)
    trial += BEGAN.trial
    deadline = BEGAN.trial + ahead
    after = judging.next_look(trial)
    assert trial < after
    assert not trial < deadline < after
    if after != deadline:
        since = trial - BEGAN.trial
        every = 1 if since < CLOSE_LOOKS else LOOKS_EVERY if since < FAR else FAR_LOOKS_EVERY
        assert after % every == 0
        assert after - trial <= every


numbers = st.integers(0, 6)
leaves = st.fixed_dictionaries(
    {"measure": st.sampled_from(["value_states", "trial", "captures"])},
    optional={
        "above": numbers | st.integers(100, 140),
        "below": numbers | st.integers(100, 140),
        "by": st.integers(1, 40).map("+{}".format) | numbers.map(lambda n: {"captures": n + 1}),
        "for": st.integers(1, 10),
    },
).filter(lambda leaf: "above" in leaf or "below" in leaf)
trees = st.recursive(
    leaves,
    lambda parts: (
        st.lists(parts, min_size=1, max_size=3).map(lambda several: {"all": several})
        | st.lists(parts, min_size=1, max_size=3).map(lambda several: {"any": several})
        | parts.map(lambda part: {"not": part})
    ),
    max_leaves=5,
)


@given(
    trees, st.lists(st.tuples(st.integers(0, 6), st.booleans()), min_size=2, max_size=60), st.data()
)
def test_no_verdict_is_ever_wrong(
    stated: dict[str, Any], course: list[tuple[int, bool]], data: st.DataObject
) -> None:
    """It is not *never* where another future would have made it true, nor *yes* and then *no*."""
    views: list[View] = []
    caught = 0
    for place, (known, catch) in enumerate(course):
        caught += catch
        views.append(at(BEGAN.trial + place, known, captures=min(caught, place)))
    asked = check(**stated)
    states = judged(asked, *views)
    for before, after in pairwise(states):
        assert before == after or before == "not yet"
    if "never" in states:
        # Whatever had come from the moment before on, it would not have come true.
        first = states.index("never")
        kept = views[: first + 1]
        future = data.draw(st.lists(st.tuples(st.integers(0, 6), st.booleans()), max_size=60))
        caught = int((kept[-1].outcome[BEGAN.trial :] == CAPTURE).sum())
        last = kept[-1].trial
        for place, (known, catch) in enumerate(future, start=1):
            caught += catch
            kept.append(at(last + place, known, captures=min(caught, last + place - BEGAN.trial)))
        assert _comes_true(asked, kept) is None


def _comes_true(asked: Check, views: list[View]) -> int | None:
    """The first moment at which a check holds, by what its words say and without any short cut."""
    return next((n for n in range(len(views)) if _holds(asked, views[: n + 1])), None)


def _holds(asked: Check, views: list[View]) -> bool:
    """Whether it holds at the last of some moments."""
    if asked.by is None and asked.holds_for is None:
        return _now(asked, views)
    length, streak = asked.holds_for or 0, None
    for n, view in enumerate(views):
        so = _now(asked, views[: n + 1])
        streak = (view.trial if streak is None else streak) if so else None
        in_time = asked.by is None or (
            view.trial <= asked.by.after(BEGAN.trial)
            if asked.by.captures is None
            else int((view.outcome[BEGAN.trial :] == CAPTURE).sum()) <= asked.by.captures
        )
        if so and in_time and streak is not None and view.trial - streak >= length:
            return True
    return False


def _now(asked: Check, views: list[View]) -> bool:
    if asked.all_of:
        return all(_holds(part, views) for part in asked.all_of)
    if asked.any_of:
        return any(_holds(part, views) for part in asked.any_of)
    if asked.not_so:
        return not _holds(asked.not_so, views)
    view = views[-1]
    found = {
        "value_states": int((view.value > 0).sum()),
        "trial": view.trial,
        "captures": int((view.outcome[BEGAN.trial :] == CAPTURE).sum()),
    }[asked.measure or ""]
    above = asked.above is None or found > asked.above
    return above and (asked.below is None or found < asked.below)
