"""A session made again by runs alone: what it comes to, and how a difference is found."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest

from app.live.records import (
    Began,
    Branched,
    Deleted,
    Gave,
    NamedLine,
    Record,
    Stood,
    WentLive,
)
from app.live.replayed import Given, ReplayError, replayed
from learners.commands import (
    Command,
    Explore,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    SetParameter,
    Undo,
)
from learners.kernel.state import digest
from learners.names import MAX_TRIALS
from learners.run import Run, replay
from tests.support.schedules import small_spec

SPEC, SEED = small_spec(), 5
BEGAN = Began(0, "timed", SPEC, SEED)
FREEZE, THAW = FreezeSkills(True), FreezeSkills(False)
AVOID = Introduce("avoid", 20)
EPSILON = SetParameter("learner.epsilon", 0.3)


def run_of(step: int, *journal: tuple[int, Command]) -> Run:
    return replay(SPEC, SEED, list(journal), step)


def stood(run: Run, number: int = 0) -> Stood:
    return Stood(number, run.step, run.trial, digest(run.state), 500)


def test_a_run_is_made_again_with_its_commands() -> None:
    run = run_of(900, (300, FREEZE), (700, THAW))
    made = replayed([BEGAN, Gave(0, 300, FREEZE), Gave(0, 700, THAW), stood(run)])
    (line,) = made.lines.values()
    assert (line.run.step, line.digest, line.n_stands) == (900, digest(run.state), 1)
    assert (line.is_same, made.is_same, made.live) == (True, True, 0)


def test_commands_that_make_others_void_are_counted_as_in_the_session() -> None:
    run = Run(SPEC, SEED)
    records: list[Record] = [BEGAN]

    def give(command: Command) -> None:
        records.append(Gave(0, run.step, command))
        run.apply(command, replacing=True)

    run.advance(max_steps=200)
    for probability in (0.1, 0.2, 0.3):
        give(Explore("approach", 400, probability))
    give(FREEZE)
    give(THAW)
    give(FreezeSelection(True))
    run.advance(max_steps=200)
    numbers = [event.number for event in run.control.history if event.author == "hand"]
    assert len(numbers) == 2
    give(Undo(numbers[0]))
    run.advance(max_steps=200, until_trial=MAX_TRIALS)
    assert replayed([*records, stood(run)]).is_same


def test_a_branch_is_its_parent_up_to_where_it_begins_and_then_its_own() -> None:
    records = [
        BEGAN,
        Gave(0, 300, FREEZE),
        Gave(0, 800, THAW),
        stood(run_of(1_000, (300, FREEZE), (800, THAW))),
        Branched(1, 0, 500, (AVOID, EPSILON)),
        stood(run_of(900, (300, FREEZE), (500, AVOID), (500, EPSILON)), 1),
        # A branch of the branch, at the moment at which that begins.
        Branched(2, 1, 500, (THAW,)),
        stood(run_of(700, (300, FREEZE), (500, AVOID), (500, EPSILON), (500, THAW)), 2),
        # The live run has gone on meanwhile, also at the step of a branch that came before.
        Gave(0, 1_000, FREEZE),
        Branched(3, 0, 1_000, (EPSILON,)),
        NamedLine(3, "mine"),
        Deleted(2),
    ]
    made = replayed(records)
    assert made.is_same
    assert [line.is_same for line in made.lines.values()] == [True, True, True, None]
    last = [(300, FREEZE), (800, THAW), (1_000, FREEZE), (1_000, EPSILON)]
    assert made.lines[3].digest == digest(run_of(1_000, *last).state)
    assert made.lines[3].given == [Given(*given) for given in last]
    assert (made.lines[3].parent, made.lines[3].fork_step) == (0, 1_000)


def test_what_the_parent_was_given_later_at_the_same_step_is_not_the_branchs() -> None:
    records = [BEGAN, stood(run_of(500)), Branched(1, 0, 500, (EPSILON,)), Gave(0, 500, FREEZE)]
    own = run_of(800, (500, EPSILON))
    assert replayed([*records, stood(own, 1), stood(run_of(800, (500, FREEZE)))]).is_same


def test_a_line_that_goes_live_goes_on_from_where_it_is_told() -> None:
    journal = [(500, EPSILON)]
    records: list[Record] = [
        BEGAN,
        stood(run_of(600)),
        Branched(1, 0, 500, (EPSILON,)),
        WentLive(1, 700),
        Gave(1, 800, FREEZE),
        stood(run_of(1_000, *journal, (800, FREEZE)), 1),
    ]
    assert replayed(records).is_same
    assert replayed(records).live == 1
    # Back to an earlier moment of it: what came later there is not any more.
    records += [WentLive(0), stood(run_of(650)), WentLive(1, 750), Gave(1, 760, AVOID)]
    records += [stood(run_of(900, *journal, (760, AVOID)), 1)]
    made = replayed(records)
    assert (made.is_same, made.live) == (True, 1)
    assert made.lines[0].run.step == 650


def test_runs_that_began_one_after_the_other_are_made_each() -> None:
    other = Run(SPEC, 6)
    other.advance(max_steps=300)
    records = [BEGAN, stood(run_of(400)), Began(1, "again", SPEC, 6), stood(other, 1), WentLive(0)]
    made = replayed(records)
    assert made.is_same
    assert [(line.preset, line.seed, line.run.step) for line in made.lines.values()] == [
        ("timed", 5, 400),
        ("again", 6, 300),
    ]
    assert made.live == 0


@pytest.mark.parametrize("until", [0, 299, 300, 450, 500, 700, 5_000])
def test_each_line_is_made_up_to_what_is_asked_for_and_no_farther(until: int) -> None:
    records = [
        BEGAN,
        Gave(0, 300, FREEZE),
        stood(run_of(600, (300, FREEZE))),
        Branched(1, 0, 500, (EPSILON,)),
        WentLive(1, 600),
        stood(run_of(700, (300, FREEZE), (500, EPSILON)), 1),
    ]
    made = replayed(records, until)
    assert made.is_same
    assert list(made.lines) == ([0, 1] if until >= 500 else [0])
    for line in made.lines.values():
        assert line.run.step == min(until, 600 + 100 * line.number)
        assert line.n_stands == (until >= 600 + 100 * line.number)


def test_a_difference_lies_between_two_moments_and_names_what_was_given_there() -> None:
    stands = [run_of(step, (300, FREEZE), (700, THAW)) for step in (200, 500, 800, 900)]
    good: list[Record] = [
        BEGAN,
        stood(stands[0]),
        Gave(0, 300, FREEZE),
        Gave(0, 500, FREEZE),
        stood(stands[1]),
        Gave(0, 700, THAW),
        stood(stands[2]),
        stood(stands[3]),
    ]
    assert replayed(good).is_same
    without_thaw = [*good[:5], Gave(0, 700, EPSILON), *good[6:]]
    made = replayed(without_thaw)
    found = made.lines[0].difference
    assert found is not None
    assert not made.is_same
    assert (found.same_step, found.stood) == (500, good[6])
    assert found.given == (Given(700, EPSILON),)
    assert (found.step, found.digest) == (
        800,
        digest(run_of(800, (300, FREEZE), (700, EPSILON)).state),
    )
    # Nothing was given: it is the program that learns otherwise.
    wrong = replace(stood(stands[0]), digest="0" * 64)
    found = replayed([BEGAN, wrong, *good[2:]]).lines[0].difference
    assert found is not None
    assert (found.same_step, found.given) == (0, ())


@pytest.mark.parametrize(
    ("records", "message"),
    [
        ([Gave(0, 1, FREEZE)], "record 1 does not go with those before: there is no line 0"),
        ([BEGAN, BEGAN], "record 2 does not go with those before: there is a line 0 already"),
        ([BEGAN, Gave(0, 9, THAW), Gave(0, 8, THAW)], "record 3 .*: line 0 is past step 8"),
        ([BEGAN, Branched(1, 3, 9, ())], "record 2 .*: there is no line 3"),
        ([BEGAN, WentLive(7)], "record 2 .*: there is no line 7"),
        ([BEGAN, Gave(0, 9, Undo(55))], "record 2: the command is refused now: nothing was done"),
    ],
)
def test_records_that_do_not_go_together_are_refused(
    records: Sequence[Record], message: str
) -> None:
    with pytest.raises(ReplayError, match=message):
        replayed(records)


def test_a_step_that_no_run_comes_to_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.live.replayed.MAX_TRIALS", 10)
    with pytest.raises(ReplayError, match=r"record 2 .*: line 0 ends before step 100,000"):
        replayed([BEGAN, Gave(0, 100_000, FREEZE)])


def test_it_is_told_how_far_it_has_come(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.live.replayed._SLICE", 100)
    told: list[tuple[int, int]] = []

    def tell(line: int, step: int) -> None:
        told.append((line, step))

    note: Callable[[int, int], object] = tell
    replayed([BEGAN, Gave(0, 250, FREEZE)], on_step=note)
    assert told == [(0, 0), (0, 100), (0, 200)]


def test_lines_are_called_as_they_were_in_their_tree() -> None:
    def named(before: object, trial: int, commands: Sequence[Command]) -> str:
        return f"{len(commands)} given"

    made = replayed(
        [
            BEGAN,
            stood(run_of(900)),
            Branched(1, 0, 500, (AVOID,)),
            Branched(2, 0, 600, (AVOID,)),
            NamedLine(2, "mine"),
            Branched(3, 0, 600, (AVOID, EPSILON), instead_of=2),
            Branched(4, 0, 700, (FREEZE,)),
            Deleted(1),
            Branched(5, 0, 800, (FREEZE,)),
            # Another tree has names of its own.
            Began(6, "timed", SPEC, SEED),
            Branched(7, 6, 0, (FREEZE,)),
        ],
        name_of=named,
    )
    names = {line.number: (line.name, line.is_there) for line in made.lines.values()}
    assert names == {
        0: ("first run", True),
        1: ("1 given", False),
        2: ("mine", False),
        3: ("mine", True),
        4: ("1 given (2)", True),
        5: ("1 given", True),
        6: ("first run", True),
        7: ("1 given", True),
    }


def test_the_line_that_was_live_is_told_even_if_it_begins_later_than_is_asked_for() -> None:
    records = [BEGAN, stood(run_of(900)), Branched(1, 0, 500, (FREEZE,)), WentLive(1, 600)]
    made = replayed(records, until_step=400)
    assert (list(made.lines), made.live) == ([0], 1)
