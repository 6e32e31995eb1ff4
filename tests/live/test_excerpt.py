"""What is shared of a session, whatever was done in it, is there again elsewhere."""

import contextlib
from collections.abc import Sequence
from pathlib import Path

from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from app.live.branching import run_at
from app.live.excerpt import Excerpt, excerpt
from app.live.lines import Family
from app.live.made_again import made_again
from app.live.past import Budget
from app.live.places import Place
from app.live.replayed import replayed
from app.live.requests import Branch, RunTo
from app.live.session import Session
from app.live.shared import MOST_STEPS, code_of, read_link, read_shared
from app.live.worker import FULL_SPEED
from app.live.written import SessionError
from learners.commands import Introduce
from learners.kernel.state import digest
from tests.support.lines import SEED, SPEC
from tests.support.schedules import ruled_spec
from tests.support.sessions import Deed, deeds, do


def name_of(*_: object) -> str:
    return "another way"


def done(some: Sequence[Deed]) -> Session:
    """A session in which some things were done, and which is over."""
    session = Session(SPEC, "timed", SEED, FULL_SPEED, False, name_of=name_of)
    session.start()
    try:
        for deed in some:
            do(session, deed)
    finally:
        session.stop()
    return session


def stands(family: Family) -> dict[str, tuple[int, str, object]]:
    """How each line of a tree ends: its step, its digest, and all that was done on it."""
    ends = {line.name: run_at(line.past, line.past.end_step) for line in family.lines.values()}
    return {name: (run.step, digest(run.state), run.control.history) for name, run in ends.items()}


@given(st.lists(deeds, max_size=16))
@settings(max_examples=60, phases=[Phase.generate])
def test_whatever_was_done_its_lines_are_the_same_elsewhere(some: Sequence[Deed]) -> None:
    family = done(some)._tree.family  # pyright: ignore[reportPrivateUsage]
    theirs = stands(family)
    whole: Excerpt | None = None
    # A line may go back behind a branch that is deleted then, and brought back.
    with contextlib.suppress(SessionError):
        whole = excerpt(family, None)
    if whole is not None:
        written = read_shared(Path(whole.file_name), whole.data)
        assert replayed(written.records).is_same
        remade = made_again(written, Budget(), name_of, most_steps=MOST_STEPS)
        assert (remade.differ, remade.n_compared) == ((), len(theirs))
        assert stands(remade.made.family) == theirs
        assert remade.made.family.live.name == family.live.name
        texts = [mark.text for mark in family.marks]
        assert [mark.text for mark in remade.made.family.marks] == texts
    for line in family.lines.values():
        alone = excerpt(family, line.number)
        written = read_link(code_of(alone.data))
        assert written.records == read_shared(Path("one"), alone.data).records
        remade = made_again(written, Budget(), name_of, most_steps=MOST_STEPS)
        assert remade.differ == ()
        (its,) = stands(remade.made.family).values()
        assert its == theirs[line.name]


def test_branches_keep_their_names_though_one_is_deleted_that_had_the_first_of_them() -> None:
    by_hand = Introduce("avoid", 20)
    branch: Deed = ("branch", 0, 99, by_hand)
    family = done(
        [
            ("step", 0, 0, by_hand),
            branch,
            ("step", 0, 0, by_hand),
            branch,
            ("delete", 1, 0, by_hand),
            ("step", 0, 0, by_hand),
            branch,
        ]
    )._tree.family  # pyright: ignore[reportPrivateUsage]
    names = ["first run", "another way (2)", "another way"]
    assert [line.name for line in family.lines.values()] == names
    shared = excerpt(family, None)
    written = read_shared(Path(shared.file_name), shared.data)
    remade = made_again(written, Budget(), name_of, most_steps=MOST_STEPS)
    assert [line.name for line in remade.made.family.lines.values()] == names


def test_a_session_whose_skills_join_by_a_rule_is_the_same_elsewhere() -> None:
    session = Session(ruled_spec(), "timed", 5, FULL_SPEED, False, name_of=name_of)
    session.start()
    try:
        session.submit(RunTo(480))
        session.wait_for(lambda status: status.snapshot.trial >= 480 and not status.playing, 60)
        # In a branch, circling joins by hand before its rule is met.
        place = Place(session.status.snapshot.generation, 900)
        session.submit(Branch(place, Introduce("circle_clockwise", 20)))
        session.wait_for(
            lambda status: len(status.lines) > 1 and not any(o.is_growing for o in status.lines), 60
        )
        family = session._tree.family  # pyright: ignore[reportPrivateUsage]
        theirs = stands(family)
        shared = excerpt(family, None)
    finally:
        session.stop()
    joined = [
        [event.author for event in history if isinstance(event.command, Introduce)]
        for _, _, history in theirs.values()
    ]
    assert ["schedule", "trigger"] in joined
    assert any("hand" in authors for authors in joined)
    written = read_shared(Path(shared.file_name), shared.data)
    assert replayed(written.records).is_same
    remade = made_again(written, Budget(), name_of, most_steps=MOST_STEPS)
    assert remade.differ == ()
    assert stands(remade.made.family) == theirs
