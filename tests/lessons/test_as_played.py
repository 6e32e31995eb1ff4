"""What a lesson's player measures at a moment is what is measured of the live session there."""

from typing import Final

import pytest

from app.documents.lesson_cards import Card
from app.documents.lesson_grammar import MEASURE_NAMES, REGIONS, Reading, Window
from app.documents.lessons import Lesson
from app.lessons import canon
from app.lessons.measures import AT_START, Began, View, measured, view_of, view_of_run
from app.lessons.referee import Line, Referee
from app.live.past import Budget
from app.live.requests import RunTo
from app.live.session import Session
from app.live.worker import FULL_SPEED
from learners.commands import Command, Explore, FollowSchedule, Introduce
from learners.run import Run
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
        wanted = {"circle": check, "spread": cards["spread"], "moment": cards["moment"]}
        for key, of in wanted.items():
            referee.want(key, of, began, Line(line, past))
        assert referee.settle(PATIENCE_S)
        assert referee.verdict("circle") == played.verdicts["circle"]
        assert referee.answer("spread") == (True, played.answers["spread"])
        assert referee.answer("moment") == (True, played.answers["moment"])
    finally:
        referee.stop()
        session.stop()
