"""A session that was written down is made again as it was, whatever was done in it."""

import contextlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from app.live.journal import Journal
from app.live.lines import MadeAgain
from app.live.made_again import Renumbered, made_again
from app.live.past import Budget
from app.live.records import (
    Began,
    Branched,
    Deleted,
    Gave,
    Marked,
    NamedLine,
    Record,
    Stood,
    WentLive,
)
from app.live.replayed import replayed
from app.live.requests import Begin, StepOnce, TakeUp, TrialOnce
from app.live.session import Session
from app.live.worker import FULL_SPEED
from app.live.written import DamagedError, Written, read, whole
from learners.commands import FreezeSkills, SetParameter, Undo
from learners.kernel.state import digest
from learners.run import replay
from tests.support.journals import HEADER
from tests.support.lines import SEED, SPEC
from tests.support.sessions import Deed, deeds, do, seen, settle

BEGAN = Began(0, "timed", SPEC, SEED)
FREEZE, EPSILON = FreezeSkills(True), SetParameter("learner.epsilon", 0.3)


def name_of(*_: object) -> str:
    return "another way"


def session_of(journal: Journal | Renumbered | None, made: MadeAgain | None = None) -> Session:
    return Session(
        SPEC,
        "timed",
        SEED,
        FULL_SPEED,
        False,
        journal=journal,
        made_again=made,
        name_of=name_of,
    )


def written(*records: Record) -> Written:
    return Written(Path("one.pounce"), HEADER, records, False, 0, "")


@given(st.lists(deeds, max_size=14), st.lists(deeds, max_size=3))
@settings(max_examples=60, phases=[Phase.generate])
def test_whatever_was_done_is_there_again_and_can_be_gone_on_with(
    tmp_path_factory: pytest.TempPathFactory, first: Sequence[Deed], then: Sequence[Deed]
) -> None:
    path = tmp_path_factory.mktemp("sessions") / "one.pounce"
    journal = Journal(path, HEADER)
    session = session_of(journal)
    session.start()
    for some in (first, then):
        try:
            done = [do(session, deed) for deed in some]
        finally:
            session.stop()
            journal.close()
        left = session._tree
        if not path.exists():
            # Nothing has been learned or done in any of its runs.
            assert {deed[0] for deed, was in zip(some, done, strict=True) if was} <= {
                "again",
                "go back",
            }
            return
        found = read(path)
        assert replayed(found.records).is_same
        remade = made_again(found, Budget(), name_of)
        assert remade.differ == ()
        made = remade.made
        assert seen(made.family) == seen(left.family)
        assert seen(made.aside) == seen(left.aside)
        assert made.n_runs == left.n_runs
        assert made.stories == left.stories
        assert {name: seen(family) for name, family in made.of_lessons.items()} == {
            name: seen(family) for name, family in left._of_lessons.items()
        }
        # It is taken up, and what is done from there on goes into the same file.
        journal = Journal.going_on(found)
        session = session_of(journal, made)
        session.start()
    session.stop()
    journal.close()


def test_it_stands_where_it_was_last_written_down_and_is_not_set_going_by_a_page() -> None:
    run = replay(SPEC, SEED, [(300, FREEZE)], 700)
    stood = Stood(0, 700, run.trial, digest(run.state), 90)
    made = made_again(written(BEGAN, Gave(0, 300, FREEZE), stood), Budget(), name_of).made
    session = session_of(None, made)
    session.start()
    session.submit(Begin())
    settle(session)
    status = session.status
    session.stop()
    assert (status.snapshot.step, status.playing) == (700, False)
    held = session._tree.family.held
    assert (digest(held.run.state), held.until_trial) == (stood.digest, 90)


def test_what_a_branch_came_to_is_compared_and_told_at_once() -> None:
    run = replay(SPEC, SEED, [(300, FREEZE)], 700)
    stood = Stood(1, 700, run.trial, digest(run.state), run.trial)
    records = (BEGAN, Stood(0, 500, 0, "", 90), Branched(1, 0, 300, (FREEZE,)), stood)
    remade = made_again(written(*records), Budget(), name_of)
    known = remade.made.family.lines[1].known
    assert (known.step, known.digest) == (700, stood.digest)
    assert remade.differ == ("first run",)
    other = (*records[:-1], replace(stood, digest="0" * 64))
    assert made_again(written(*other), Budget(), name_of).differ == ("first run", "another way")


def test_a_command_after_the_last_moment_that_was_written_down_is_there() -> None:
    made = made_again(written(BEGAN, Gave(0, 300, FREEZE)), Budget(), name_of).made
    reference = replay(SPEC, SEED, [(300, FREEZE)], 300)
    assert digest(made.family.held.run.state) == digest(reference.state)
    assert made.family.held.run.journal == [(300, FREEZE)]


def test_lines_whose_tables_are_not_those_written_down_are_named() -> None:
    wrong = Stood(0, 500, 3, "ab" * 32, 100)
    records = (BEGAN, wrong, Branched(1, 0, 200, (EPSILON,)), Stood(1, 300, 0, "", 100))
    assert made_again(written(*records), Budget(), name_of).differ == ("first run", "another way")


def test_it_can_be_taken_up_by_a_session_that_has_had_runs(tmp_path: Path) -> None:
    path = tmp_path / "one.pounce"
    records = (BEGAN, Gave(0, 300, FREEZE), Branched(1, 0, 200, (EPSILON,)), WentLive(1, 250))
    path.write_bytes(whole(HEADER, records))
    found = read(path)
    mine = tmp_path / "mine.pounce"
    with (
        contextlib.closing(Journal(mine, HEADER)) as former,
        contextlib.closing(Journal.going_on(found)) as journal,
    ):
        session = session_of(former)
        session.start()
        session.submit(TrialOnce())
        settle(session)
        here = session.status.snapshot
        by = session.n_runs
        made = made_again(found, session.budget, name_of, by).made
        session.submit(TakeUp(made, Renumbered(journal, by)))
        session.submit(StepOnce())
        session.submit(FREEZE)
        settle(session)
        status = session.status
        session.stop()
    assert (status.snapshot.step, status.snapshot.generation, status.journal) == (251, by + 1, None)
    more = read(path).records[len(records) :]
    assert more[-1] == Gave(1, 251, FREEZE) or Gave(1, 251, FREEZE) in more
    made_now = made_again(read(path), Budget(), name_of).made
    assert digest(made_now.family.held.run.state) == digest(made.family.held.run.state)
    # What was there before stands in a file of its own.
    before = made_again(read(mine), Budget(), name_of).made.family.held.run
    assert before.step == here.step


@pytest.mark.parametrize(
    ("records", "message", "n_good"),
    [
        ((Gave(0, 1, FREEZE),), "line 2: run 0 is not live", 0),
        ((), "no run has begun in it", None),
        ((WentLive(0),), "line 2: no run has begun", 0),
        ((Began(0, "timed", SPEC, 2**63),), "line 2: seed", 0),
        ((BEGAN, BEGAN), "line 3: there has been a run 0", 1),
        ((BEGAN, Gave(0, 9, FREEZE), Gave(0, 8, FREEZE)), "line 4: first run is past step 8", 2),
        ((BEGAN, Gave(0, 9, Undo(5))), "line 3: nothing was done by hand", 1),
        ((BEGAN, Branched(1, 4, 9, ())), "line 3: that line is not in the tree", 1),
        ((BEGAN, Branched(1, 0, 9, (), instead_of=4)), "line 3: that line is not in", 1),
        ((BEGAN, WentLive(4)), "line 3: there is no run 4 to go on with", 1),
        ((BEGAN, Deleted(0)), "line 3: first run is live", 1),
        ((BEGAN, NamedLine(0, "a\x1b[31m")), "line 3: a name is one line of characters", 1),
        ((BEGAN, Marked(1, 3, 0, 0, "a")), "line 3: that line is not in the tree", 1),
    ],
)
def test_records_that_do_not_go_together_are_refused_with_those_that_do(
    records: Sequence[Record], message: str, n_good: int | None
) -> None:
    with pytest.raises(DamagedError, match=message) as refused:
        made_again(written(*records), Budget(), name_of)
    saved = refused.value.saved
    assert (None if saved is None else len(saved.records)) == n_good
    if saved is not None:
        assert saved.records == records[:n_good]


def test_a_step_that_no_run_comes_to_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.live.made_again.MAX_TRIALS", 10)
    with pytest.raises(DamagedError, match="line 3: first run ends before step 1,000,000"):
        made_again(written(BEGAN, Gave(0, 1_000_000, FREEZE)), Budget(), name_of)


def test_it_is_told_how_far_it_has_come(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.live.made_again._SLICE", 100)
    told: list[float] = []
    made_again(written(BEGAN, Gave(0, 250, FREEZE)), Budget(), name_of, on_step=told.append)
    assert told == [0.5, 0.5, 0.5]
