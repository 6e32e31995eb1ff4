"""What a lesson's player measures at a moment is what is measured of the live session there."""

from typing import Final

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.documents.lesson_cards import Card
from app.documents.lesson_grammar import MEASURE_NAMES, REGIONS, Check, Reading, Window
from app.documents.lessons import Lesson
from app.lessons import canon
from app.lessons.checks import Judge
from app.lessons.measures import (
    AT_START,
    Began,
    View,
    began_at,
    measured,
    view_of,
    view_of_run,
)
from app.lessons.referee import Line, Referee
from app.live.moments import moment_at
from app.live.past import Budget, Past
from app.live.places import Place
from app.live.requests import Branch, RunTo
from app.live.session import Session
from app.live.worker import FULL_SPEED
from learners.commands import Command, Explore, FollowSchedule, FreezeSkills, Introduce
from learners.run import Run, replay
from tests.support import lines
from tests.support.circling import circling

PATIENCE_S: Final = 60.0
SEED: Final = 5
READINGS: Final = (
    *(
        Reading(name, None)
        for name in MEASURE_NAMES
        if name
        in (
            "trial",
            "step",
            "value_states",
            "behind_share",
            "thinnest",
            "spread_direction",
            "shape",
            "captures",
            "success",
        )
    ),
    *(Reading("reach", region) for region in (*REGIONS, "octants")),
    Reading("present", "circle_clockwise"),
    Reading("reward", Window(200)),
    Reading("reward", Window(None, 100, 300)),
    Reading("change", (Window(None, 100, 300), Window(50))),
    Reading("command", "introduce"),
)


@pytest.fixture(scope="module")
def lesson() -> Lesson:
    return circling()


def live(lesson: Lesson) -> Session:
    """A session of a lesson's run, which stands at its start with the schedule as it says."""
    session = Session(
        lesson.run_spec, "timed", SEED, FULL_SPEED, playing=False, budget=Budget(3_000_000)
    )
    session.start()
    run_to(session, lesson.spec.setup.start)
    give(session, FollowSchedule(False))
    return session


def run_to(session: Session, trial: int) -> None:
    ticket = session.submit(RunTo(trial))
    session.wait_for(lambda status: status.answered >= ticket and not status.playing, PATIENCE_S)


def give(session: Session, *commands: Command) -> None:
    for command in commands:
        ticket = session.submit(command)
        session.wait_for(lambda status, t=ticket: status.answered >= t, PATIENCE_S)


def measured_of(view: View) -> list[object]:
    return [measured(reading, view) for reading in READINGS]


def test_a_live_session_measures_what_the_player_does(lesson: Lesson) -> None:
    seen: dict[str, list[object]] = {}

    def visit(card: Card, run: Run) -> None:
        seen[card.id] = measured_of(view_of_run(run, began=AT_START))

    played = canon.play(lesson, SEED, visit=visit)
    assert played.faults == {}
    session = live(lesson)
    referee = Referee()
    try:
        line = session.status.snapshot.generation
        past = session.past_of(line)
        assert past is not None
        snapshot = session.status.snapshot
        assert measured_of(view_of(snapshot, past)) == seen["spread"]
        began = Began(snapshot.trial, snapshot.step, len(snapshot.control.history))
        assert began == played.began["circle"]
        give(session, Introduce("circle_clockwise", 300), Explore("circle_clockwise", 500, 0.95))
        # At full speed, so that nobody draws on the way.
        run_to(session, 1_900)
        assert measured_of(view_of(session.status.snapshot, past)) == seen["step_5"]
        cards = {card.id: card for card in lesson.spec.steps}
        check = cards["circle"].check
        assert check is not None
        wanted = {"circle": check} | {key: cards[key] for key in ("spread", "moment", "drawn")}
        for key, of in wanted.items():
            referee.want(key, of, began, Line(line, past))
        assert referee.settle(PATIENCE_S)
        assert referee.verdict("circle") == played.verdicts["circle"]
        assert referee.answer("spread") == (True, played.answers["spread"])
        assert referee.answer("moment") == (True, played.answers["moment"])
        assert referee.answer("drawn") == (True, played.answers["drawn"])
    finally:
        referee.stop()
        session.stop()


def test_a_line_that_goes_another_way_is_looked_at_anew(lesson: Lesson) -> None:
    """What was seen of a way that the run did not go in the end, is not kept."""
    session = live(lesson)
    referee = Referee()
    cards = {card.id: card for card in lesson.spec.steps}
    check = cards["circle"].check
    assert check is not None
    try:
        line = session.status.snapshot.generation
        past = session.past_of(line)
        assert past is not None
        snapshot = session.status.snapshot
        began = Began(snapshot.trial, snapshot.step, len(snapshot.control.history))

        def state() -> str:
            referee.want("circle", check, began, Line(line, past))
            assert referee.settle(PATIENCE_S)
            verdict = referee.verdict("circle")
            assert verdict is not None
            return verdict.state

        assert state() == "not yet"
        # Two of one kind in one moment: the second takes the place of the first.
        give(session, Explore("approach", 100, 0.5), Explore("approach", 100, 0.6))
        assert state() == "not yet"
        run_to(session, 1_000)
        assert state() == "not yet"
        run_to(session, 1_899)
        assert state() == "not yet"
        run_to(session, 1_900)
        assert state() == "never"
        # At a moment before, it is another line, and is judged from there.
        ticket = session.submit(
            Branch(Place(line, began.step), Introduce("circle_clockwise", 300), viewer=1)
        )
        session.wait_for(
            lambda status: status.answered >= ticket and len(status.lines) == 2, PATIENCE_S
        )
        (other,) = (seen.number for seen in session.status.lines if seen.number != line)
        session.wait_for(
            lambda status: not any(seen.is_growing for seen in status.lines), PATIENCE_S
        )
        branched = session.past_of(other)
        assert branched is not None
        referee.want("circle", check, began, Line(other, branched))
        assert referee.settle(PATIENCE_S)
        run = canon.play(lesson, SEED).verdicts["circle"]
        found = referee.verdict("circle")
        assert found is not None
        # Without being explored it spreads more slowly, but it is not over.
        assert run.state == "yes"
        assert found.state in ("yes", "never")
        assert found != run
        referee.keep(["circle"])
        assert referee.verdict("circle") == found
        referee.keep([])
        assert referee.verdict("circle") is None
    finally:
        referee.stop()
        session.stop()


def test_what_was_over_is_not_where_the_line_goes_another_way_from_before() -> None:
    run = Run(lines.SPEC, lines.SEED)
    past = Past(run, Budget(nearest_steps=100))
    run.advance(max_steps=60)
    past.note(run)
    began, before = began_at(run), run.copy()
    check = Check.model_validate({"command": "freeze_skills", "by": "+5"})
    referee = Referee()

    def state() -> str:
        referee.want("check", check, began, Line(0, past))
        assert referee.settle(PATIENCE_S)
        verdict = referee.verdict("check")
        assert verdict is not None
        return verdict.state

    try:
        run.advance(until_trial=began.trial + 9)
        past.note(run)
        assert state() == "never"
        before.apply(FreezeSkills(True))
        past.note(before)
        before.advance(until_trial=began.trial + 9)
        past.note(before)
        assert state() == "yes"
    finally:
        referee.stop()


@settings(max_examples=40)
@given(lines.scripts, st.integers(0, 2_000), st.sampled_from([0, 5, 60]))
def test_a_moment_of_the_past_measures_what_the_run_did(
    script: lines.Script, rest: int, entered: int
) -> None:
    """Whatever was done by hand: the player's view of a run, and a page's of its past."""
    run = Run(lines.SPEC, lines.SEED)
    past = Past(run, Budget(nearest_steps=100))
    run.advance(max_steps=entered)
    past.note(run)
    began, seen = began_at(run), dict[int, list[object]]()
    for steps, wish in [*script, (rest, 0)]:
        lines.play(run, past, [(steps, wish)])
        # At one step, the last that was given there is what holds.
        seen[run.step] = measured_of(view_of_run(run, began=began))
    for step, found in seen.items():
        moment = moment_at(past, Place(0, step), "timed")
        assert moment is not None
        assert measured_of(view_of(moment, past, began=began)) == found


@settings(max_examples=25)
@given(lines.scripts, st.integers(0, 2_000), st.integers(1, 60), st.integers(0, 80))
def test_a_verdict_is_that_of_the_run_looked_at_by_hand(
    script: lines.Script, rest: int, ahead: int, known: int
) -> None:
    """Whatever was done: each moment that is to be looked at, of the run made from its journal."""
    run = Run(lines.SPEC, lines.SEED)
    past = Past(run, Budget(nearest_steps=100))
    run.advance(max_steps=60)
    began = began_at(run)
    lines.play(run, past, script, rest)
    check = Check.model_validate(
        {"measure": "value_states", "above": known, "by": f"+{ahead}", "for": 2}
    )
    judging = Judge(check, began)
    trial, step = began.trial, began.step
    while True:
        again = replay(lines.SPEC, lines.SEED, run.journal, step)
        judging.look(view_of_run(again, began=began))
        trial = judging.next_look(again.trial)
        if step == run.step:
            break
        step = past.step_of_trial(trial) if trial <= run.trial else run.step
    referee = Referee()
    try:
        referee.want("check", check, began, Line(0, past))
        assert referee.settle(PATIENCE_S)
        assert referee.verdict("check") == judging.verdict
    finally:
        referee.stop()
