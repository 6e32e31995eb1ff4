"""People walk in the past of a session that learns: it learns what it would have learned."""

from collections.abc import Iterator

import numpy as np
import pytest

from app.documents import presets
from app.live.past import Budget
from app.live.places import Place
from app.live.requests import AddMark, Branch, Pause, Play, SetSpeed
from app.live.session import Session
from app.live.worker import FULL_SPEED
from learners.commands import Command, Explore, FreezeSelection, SetParameter
from learners.kernel.state import digest
from learners.run import replay

PATIENCE_S = 60.0
SEED = 4
SPEC = presets.load("timed", ["world.size=40", "trials=20000"])
MOST_BYTES = 3_200_000
"""Room for one checkpoint of each of seven lines, and for little more."""
COMMANDS: tuple[Command, ...] = (
    SetParameter("learner.epsilon", 0.2),
    FreezeSelection(True),
    Explore("approach", 300, 0.5),
    FreezeSelection(False),
)


@pytest.fixture
def session() -> Iterator[Session]:
    made = Session(SPEC, "timed", SEED, FULL_SPEED, playing=False, budget=Budget(MOST_BYTES))
    made.start()
    yield made
    made.stop()


def test_what_is_learned_is_the_same_whoever_looks_at_what(session: Session) -> None:
    rng = np.random.default_rng(0)
    # So fast that it is over soon, and so slow that there is time to look.
    session.submit(SetSpeed(2_000_000.0))
    session.submit(Play())
    given = 0
    while not session.status.finished:
        status = session.status
        line = status.lines[int(rng.integers(len(status.lines)))]
        place = Place(line.number, int(rng.integers(line.until_step + 1)))
        session.moments.want(int(rng.integers(3)), place)
        if rng.random() < 0.02:
            session.submit(Branch(place, COMMANDS[int(rng.integers(len(COMMANDS)))]))
            session.submit(AddMark(place, "here"))
        elif rng.random() < 0.02:
            ticket = session.submit(COMMANDS[given % len(COMMANDS)])
            given += 1
            session.wait_for(lambda status, t=ticket: status.answered >= t, PATIENCE_S)
        assert session.budget.nbytes <= session.budget.most_bytes
    session.submit(Pause())
    done = session.wait_for(lambda status: status.finished, PATIENCE_S)
    snapshot = done.snapshot
    hand = [(e.step, e.command) for e in snapshot.control.history if e.author == "hand"]
    alone = replay(SPEC, SEED, hand, snapshot.step)
    past = session.past_of(snapshot.generation)
    assert past is not None
    now = past.run_at(snapshot.step)
    assert now is not None
    assert digest(now.state) == digest(alone.state)
    assert np.array_equal(now.state.log_reward[: now.trial], alone.state.log_reward[: now.trial])
    # What the session shows is copied from the run itself.
    assert np.array_equal(snapshot.visits.ravel(), alone.state.visits)
    assert np.array_equal(snapshot.first_reach.ravel(), alone.state.first_reach)


def test_all_lines_of_a_session_share_its_memory(session: Session) -> None:
    session.submit(Play())
    session.wait_for(lambda status: status.finished, PATIENCE_S)
    live = session.status.snapshot
    for share in range(6):
        place = Place(live.generation, share * live.step // 6)
        session.submit(Branch(place, SetParameter("learner.alpha", 0.3)))
    grown = session.wait_for(
        lambda status: len(status.lines) == 7 and not any(line.is_growing for line in status.lines),
        PATIENCE_S,
    )
    held = [session.past_of(line.number) for line in grown.lines]
    assert all(past is not None and past.nbytes > 0 for past in held)
    assert session.budget.nbytes <= MOST_BYTES
