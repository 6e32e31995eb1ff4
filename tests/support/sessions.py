"""Sessions to which something is done at random, and what is to be there again afterwards."""

import threading
from dataclasses import replace
from typing import Any, Final

from hypothesis import strategies as st

from app.live.lines import Family
from app.live.places import Place
from app.live.requests import (
    AddMark,
    Branch,
    BringBack,
    DeleteLine,
    GoBack,
    LeaveLesson,
    MakeLive,
    NameLine,
    OpenRun,
    RemoveMark,
    Request,
    SkipOpening,
    StartAgain,
    StepOnce,
    TakeLesson,
    Tell,
    TrialOnce,
)
from app.live.session import Session
from app.live.story import (
    Act,
    Answered,
    Committed,
    Hinted,
    LongText,
    Passed,
    Revealed,
    Spoke,
    WentToCard,
)
from learners.commands import Command, Undo
from learners.kernel.state import digest
from tests.support.lines import SEED, SPEC, commands

PATIENCE_S: Final = 60.0
"""How long to wait for what must happen; reaching it is a failure."""

ACTS: Final[tuple[Act, ...]] = (
    *(WentToCard(card) for card in (0, 1, 2, 1, 7)),
    WentToCard(1, is_again=True),
    Answered("where", '["w"]'),
    Answered("where", '["e"]'),
    Committed("where", 70),
    Committed("why", None),
    Revealed("where", LongText('["nw"]'), False),
    *(Passed(1), Passed(9), Hinted(0), Hinted(1), Spoke("de")),
)
"""What may be done in a lesson, whether or not it makes sense there."""

Deed = tuple[str, int, int, Command]
"""What is done: its kind, two numbers that choose among what there is, and a command."""
KINDS: Final = (
    *("trial", "step", "give", "give", "undo", "branch", "branch", "amend", "live", "name"),
    *("delete", "back", "mark", "unmark", "again", "open", "go back"),
    *("lesson", "lesson anew", "leave", "tell", "tell"),
)
deeds: st.SearchStrategy[Deed] = st.tuples(
    st.sampled_from(KINDS), st.integers(0, 99), st.integers(0, 99), commands
)


def request_of(session: Session, deed: Deed) -> Request:
    """What a deed asks of a session as it is now; it may be refused."""
    kind, one, other, command = deed
    tree = session.status.lines
    line = tree[one % len(tree)]
    place = Place(line.number, line.until_step * other // 99)
    match kind:
        case "step":
            return StepOnce()
        case "give":
            return command
        case "undo":
            return Undo(one % 9)
        case "branch":
            return Branch(place, command, viewer=1)
        case "amend":
            return Branch(Place(line.number, line.fork_step), command)
        case "live":
            return MakeLive(line.number, None if other % 2 else place.step)
        case "name":
            return NameLine(line.number, f"name {other}")
        case "delete":
            return DeleteLine(line.number)
        case "back":
            return BringBack(one % 12)
        case "mark":
            return AddMark(place, f"mark {other}")
        case "unmark":
            return RemoveMark(one % 5)
        case "again":
            return StartAgain(SPEC, f"again {other}", SEED + other, paused=True)
        case "open":
            return OpenRun(SPEC, f"opened {other}", SEED, 2_000 + other, "", "of an experiment")
        case "go back":
            return GoBack()
        case "lesson" | "lesson anew":
            taken = taking(f"lesson {one % 3}", SEED + one % 3, other % 4, kind == "lesson anew")
            return replace(taken, runs_anew=other % 5 == 0)
        case "leave":
            return LeaveLesson()
        case "tell":
            story = session.status.story
            return Tell(ACTS[other % len(ACTS)], "none" if story is None else story.name)
        case _:
            return TrialOnce()


def taking(name: str, seed: int, start: int, is_anew: bool = False) -> TakeLesson:
    """What has a lesson be on that begins so many trials after the beginning of its run."""
    begin = StartAgain(SPEC, "timed", seed, paused=True)
    text = LongText(f"title: {name}\n")
    return TakeLesson(name, f"{name}.yaml", "ab" * 8, text, "en", begin, start, is_anew=is_anew)


def do(session: Session, deed: Deed) -> bool:
    """Do it, and wait until all that comes of it is there; returns whether it was carried out."""
    refusals: list[str] = []
    session.submit(request_of(session, deed), refusals.append)
    settle(session)
    return not refusals


def settle(session: Session) -> None:
    """Wait until all that was asked for has been answered, and what the past was asked for."""
    for _ in range(2):
        ticket = session.submit(SkipOpening())
        session.wait_for(lambda status, t=ticket: status.answered >= t, PATIENCE_S)
        _await_moments(session)
    session.wait_for(lambda status: not status.playing, PATIENCE_S)


def _await_moments(session: Session) -> None:
    done = threading.Event()
    session.moments.ask(lambda: None, lambda _: done.set(), lambda _: done.set())
    assert done.wait(PATIENCE_S)


def seen(family: Family | None) -> Any:
    """All that is to be there again of a family; how far branches are known is no part of it."""
    if family is None:
        return None
    lines = {
        line.number: (
            line.parent,
            line.fork_step,
            line.fork_trial,
            line.name,
            line.commands,
            None if line.held is None else (line.held.run.step, digest(line.held.run.state)),
        )
        for line in family.lines.values()
    }
    held = family.held
    return (
        lines,
        list(family.deleted),
        family.marks,
        family.live.number,
        (held.until_trial, held.run.control.history, family.is_own, family.preset, held.run.seed),
    )
