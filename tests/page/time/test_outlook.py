"""The status that is true for one browser: the session's own, or that of a moment it looks at."""

import dataclasses

import pytest

from app.live.places import Behind, LineSeen, Place
from app.page.time.outlook import Outlook
from learners.kernel.state import digest
from learners.run import Run
from tests.page.time.walks import BRANCH, LIVE, Even, Makes, ground, status_at
from tests.support.schedules import small_run, to

ANNA, BERT = 1, 2


def at(step: int) -> Run:
    run = small_run()
    run.advance(max_steps=step)
    return run


@pytest.fixture(scope="module")
def run() -> Run:
    return to(small_run(), 400)


def grounds(run: Run, branch: int | None = None) -> dict[int, Even]:
    lines = {LIVE: Even(run.step)}
    return lines if branch is None else {**lines, BRANCH: Even(branch)}


def test_what_is_live_is_the_status_of_the_session_itself(run: Run) -> None:
    live, makes = status_at(run), Makes()
    outlook = Outlook(ANNA, makes)
    assert outlook.status(live, 0.0, ground(grounds(run))) is live
    assert outlook.is_there
    assert makes.wishes == {}


def test_a_moment_is_shown_as_soon_as_it_is_made_and_what_was_before_until_then(run: Run) -> None:
    live, makes, known = status_at(run), Makes(), ground(grounds(run))
    outlook = Outlook(ANNA, makes)
    outlook.walk.seek(500, 0.0, known)
    assert outlook.status(live, 0.0, known) is live
    assert not outlook.is_there
    assert makes.wishes == {ANNA: Place(LIVE, 500)}
    first = makes.make(ANNA, at(500))
    seen = outlook.status(live, 0.1, known)
    assert seen.snapshot is first
    assert outlook.is_there
    # As long as nothing changes it is the same.
    assert outlook.status(live, 0.2, known) is seen
    outlook.walk.seek(700, 0.3, known)
    assert outlook.status(live, 0.3, known).snapshot is first
    assert not outlook.is_there
    second = makes.make(ANNA, at(700))
    assert outlook.status(live, 0.4, known).snapshot is second


def test_a_moment_says_how_far_it_is_behind_and_nothing_of_how_the_live_run_ended(run: Run) -> None:
    opened = dataclasses.replace(
        status_at(run), playing=False, finished=True, exhausted=True, error="full"
    )
    makes, known = Makes(), ground(grounds(run))
    outlook = Outlook(ANNA, makes)
    outlook.walk.seek(500, 0.0, known)
    outlook.status(opened, 0.0, known)
    shot = makes.make(ANNA, at(500))
    seen = outlook.status(opened, 0.1, known)
    assert seen.behind == Behind("", run.trial - shot.trial, run.step - 500)
    assert (seen.finished, seen.exhausted, seen.error, seen.opened) == (False, False, None, None)
    assert seen.answered == opened.answered
    assert not seen.playing
    outlook.walk.play(1, 0.2, known)
    assert outlook.status(opened, 0.2, known).playing


def test_a_moment_of_a_branch_says_which(run: Run) -> None:
    lines = (
        LineSeen(LIVE, None, 0, 0, "", run.step, run.trial, 0.0, "", is_live=True),
        LineSeen(BRANCH, LIVE, 300, 3, "no avoid", 900, 9, 0.0, "", is_live=False),
    )
    live, makes = status_at(run, lines=lines), Makes()
    known, outlook = ground(grounds(run, 900)), Outlook(ANNA, makes)
    outlook.walk.look(BRANCH, 600, 0.0, known)
    outlook.status(live, 0.0, known)
    makes.make(ANNA, at(600))
    behind = outlook.status(live, 0.1, known).behind
    assert behind is not None
    assert behind.branch == "no avoid"


def test_back_to_live_nothing_more_is_made_and_nothing_of_the_past_is_shown(run: Run) -> None:
    live, makes, known = status_at(run), Makes(), ground(grounds(run))
    outlook = Outlook(ANNA, makes)
    outlook.walk.seek(500, 0.0, known)
    outlook.status(live, 0.0, known)
    makes.make(ANNA, at(500))
    outlook.walk.go_live()
    assert outlook.status(live, 0.1, known) is live
    assert makes.wishes == {}
    outlook.walk.seek(700, 0.2, known)
    assert outlook.status(live, 0.2, known) is live


def test_two_browsers_look_at_two_moments_of_one_session(run: Run) -> None:
    live, makes, known = status_at(run), Makes(), ground(grounds(run))
    anna, bert, carl = (Outlook(viewer, makes) for viewer in (ANNA, BERT, 3))
    for outlook, step in ((anna, 500), (bert, 900)):
        outlook.walk.seek(step, 0.0, known)
        outlook.status(live, 0.0, known)
        makes.make(outlook.viewer, at(step))
    steps = [outlook.status(live, 0.1, known).snapshot.step for outlook in (anna, bert, carl)]
    assert steps == [500, 900, run.step]


def test_a_is_made_beside_the_moment_and_stays_when_that_goes_on(run: Run) -> None:
    live, makes, known = status_at(run), Makes(), ground(grounds(run))
    outlook = Outlook(ANNA, makes)
    outlook.walk.seek(500, 0.0, known)
    outlook.walk.set_a(0.0, known)
    outlook.walk.seek(900, 0.0, known)
    outlook.status(live, 0.0, known)
    assert outlook.since is None
    of_a = next(viewer for viewer in makes.wishes if viewer != ANNA)
    shot = makes.make(of_a, at(500))
    outlook.walk.go_live()
    outlook.status(live, 0.1, known)
    assert outlook.since is shot
    outlook.leave()
    assert makes.wishes == {}


def test_looking_changes_nothing_of_the_live_run(run: Run) -> None:
    before, known = digest(run.state), ground(grounds(run))
    live, outlook = status_at(run), Outlook(ANNA, Makes())
    for step in range(0, run.step, 97):
        outlook.walk.seek(step, 0.0, known)
        outlook.status(live, 0.0, known)
    assert digest(run.state) == before
