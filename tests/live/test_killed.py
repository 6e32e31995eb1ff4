"""Nothing is lost: labs that are killed at any moment, and disks that take nothing."""

import json
import os
import random
import resource
import signal
from pathlib import Path
from typing import Any

import pytest

from app.live.journal import Journal, is_in_use
from app.live.made_again import made_again
from app.live.past import Budget
from app.live.places import Place
from app.live.records import Branched, Gave, Stood
from app.live.replayed import replayed
from app.live.requests import Branch, MakeLive, NameLine, Pause, Play, TrialOnce
from app.live.session import Session
from app.live.status import Status
from app.live.written import read
from learners.commands import (
    Command,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Remove,
    SetParameter,
)
from learners.kernel.state import digest
from learners.run import Run
from learners.spec import RunSpec
from tests.support.copies import in_a_process_of_its_own
from tests.support.journals import HEADER
from tests.support.lines import SPEC

KILLS = 50
SEED = 11
SPEED = 500_000.0
"""Steps/s: so few that what was learned until the kill is soon learned again, four times."""
LONG: RunSpec = SPEC.model_copy(update={"trials": 1_000_000})
"""One that is not over before it is killed."""
FREEZE, THAW = FreezeSkills(True), FreezeSkills(False)


def name_of(*_: object) -> str:
    return "another way"


def wish(chance: random.Random) -> Command:
    return chance.choice(
        [
            FreezeSkills(chance.random() < 0.5),
            FreezeSelection(chance.random() < 0.5),
            FollowSchedule(chance.random() < 0.5),
            SetParameter("learner.epsilon", chance.choice([0.05, 0.2, 0.4])),
            SetParameter("world.capture_reward", chance.choice([50.0, 80.0])),
            Explore("approach", chance.choice([10, 300]), 0.5),
            Remove("circle_clockwise"),
        ]
    )


def live(path: Path, answers: int, seed: int) -> None:
    """Use a lab until somebody kills it; each answer is told to whoever looks."""
    chance = random.Random(seed)
    session = Session(
        LONG, "timed", SEED, SPEED, True, journal=Journal(path, HEADER), name_of=name_of
    )
    session.start()
    session.wait_for(lambda status: status.snapshot.step > 0, 60.0)
    while True:
        refusals: list[str] = []
        kind, status = chance.random(), session.status
        request: Any = wish(chance)
        if kind < 0.1:
            request = chance.choice([Pause(), Play()])
        elif kind < 0.25:
            line = chance.choice(status.lines)
            place = Place(line.number, chance.randint(0, line.until_step))
            request = Branch(place, request)
        elif kind < 0.3:
            request = MakeLive(chance.choice(status.lines).number)
        elif kind < 0.35:
            request = NameLine(chance.choice(status.lines).number, f"name {chance.random()}")
        ticket = session.submit(request, refusals.append)
        session.wait_for(lambda status, t=ticket: status.answered >= t, 60.0)
        if not refusals and isinstance(request, Command):
            # Seen by whoever asked, so that it must be there.
            os.write(answers, json.dumps(repr(request)).encode() + b"\n")


def used_and_killed(path: Path, seed: int) -> list[str]:
    """Let a lab be used in a process of its own until that is killed; returns what it answered."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(reading)
            live(path, writing, seed)
        finally:
            os._exit(1)
    os.close(writing)
    chance = random.Random(-seed)
    seen = b""
    # So many answers, and then somewhere within the next one.
    for _ in range(chance.randint(1, 6)):
        data = os.read(reading, 4_096)
        assert data, "the lab has ended by itself"
        seen += data
    for _ in range(chance.randint(0, 20_000)):
        pass
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    while data := os.read(reading, 4_096):
        seen += data
    os.close(reading)
    # What was cut off in the pipe nobody saw.
    return [json.loads(line) for line in seen.split(b"\n")[:-1]]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked")
def test_a_lab_that_is_killed_at_any_moment_is_there_again_digest_for_digest(
    tmp_path: Path,
) -> None:
    Run(LONG, SEED).advance(max_steps=2_000)  # What is compiled is there for all that are forked.
    n_commands = n_branches = 0
    for kill in range(KILLS):
        path = tmp_path / f"{kill}.pounce"
        seen = used_and_killed(path, kill)
        assert not is_in_use(path)
        found = read(path)
        given = [repr(record.command) for record in found.records if isinstance(record, Gave)]
        assert given[: len(seen)] == seen
        # No more than the one that was not answered yet.
        assert len(given) <= len(seen) + 1
        alone = replayed(found.records)
        assert alone.is_same
        remade = made_again(found, Budget(), name_of)
        assert remade.differ == ()
        family = remade.made.family
        assert family.live.number == alone.live
        for number, line in family.lines.items():
            run = line.past.run_at(alone.lines[number].run.step)
            assert run is not None
            assert digest(run.state) == alone.lines[number].digest
        assert digest(family.held.run.state) == alone.lines[family.live.number].digest
        n_commands += len(given)
        n_branches += sum(isinstance(record, Branched) for record in found.records)
    assert n_commands > KILLS
    assert n_branches > KILLS / 8


def stands(session: Session, request: Any) -> Status:
    """The status in which a request has been answered."""
    ticket = session.submit(request)
    return session.wait_for(lambda status: status.answered >= ticket, 60.0)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked")
def test_a_lab_goes_on_while_the_disk_is_full_and_nothing_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "full.pounce"

    def use() -> None:
        session = Session(SPEC, "timed", SEED, 1.0, False, journal=Journal(path, HEADER))
        session.start()
        assert stands(session, FREEZE).journal is None
        before = read(path).records
        room = path.stat().st_size + 60
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, resource.RLIM_INFINITY))
        for request in (TrialOnce(), THAW, TrialOnce()):
            told = stands(session, request)
        assert told.snapshot.trial == 2
        assert told.journal is not None
        assert told.journal.startswith("This session is not kept: ")
        assert read(path).records == before
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)
        assert stands(session, FREEZE).journal is None
        session.stop()

    assert in_a_process_of_its_own(use) == 0
    found = read(path).records
    assert [record.command for record in found if isinstance(record, Gave)] == [
        FREEZE,
        THAW,
        FREEZE,
    ]
    assert replayed(found).is_same
    assert any(isinstance(record, Stood) and record.trial == 2 for record in found)


def test_a_lab_goes_on_where_nothing_can_be_written(tmp_path: Path) -> None:
    there = tmp_path / "there"
    there.write_text("no folder")
    journal = Journal(there / "one.pounce", HEADER)
    session = Session(SPEC, "timed", SEED, 1.0, False, journal=journal)
    session.start()
    told = stands(session, TrialOnce())
    assert (told.snapshot.trial, told.error) == (1, None)
    assert told.journal is not None
    assert told.journal.startswith("This session is not kept: ")
    session.stop()
