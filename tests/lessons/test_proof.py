"""Whether a lesson holds, and what is written into its file of that."""

import json
from pathlib import Path
from typing import Final

import pytest

from app.documents import lessons
from app.documents.lessons import Lesson
from app.lessons import proof as proofs_module
from app.lessons.canon import Played
from app.lessons.checks import Verdict
from app.lessons.proof import (
    COLUMNS,
    SEEDS,
    Proof,
    ProofError,
    as_json,
    headline_of,
    proof_of,
    proofs,
    rows_of,
    with_evidence,
    write_evidence,
)
from app.lessons.reveals import Answer
from tests.support.circling import LESSON, circling

CCW: Final = "counter-clockwise"
PROVED: Final = "evidence: {seeds: 20, pass: 19}\n"


@pytest.fixture(scope="module")
def lesson() -> Lesson:
    return circling()


def played(
    seed: int, spread: str = CCW, trial: int | None = 900, other: str = "clockwise"
) -> Played:
    """How a lesson went, with what is otherwise than it should be."""
    verdict = Verdict("never", 1_900) if trial is None else Verdict("yes", trial)
    answers: dict[str, Answer] = {
        "spread": spread,
        "moment": 800.0 + 10 * seed,
        "drawn": ((500.0, 1.0),),
        "other": other,
    }
    return Played(seed, answers=answers, verdicts={"circle": verdict})


@pytest.mark.parametrize(
    ("wrong", "holds", "n_passed"),
    [
        ({}, True, 20),
        # Nineteen of twenty are nearly all.
        ({"spread": "both ways"}, True, 19),
        ({"trial": None}, True, 19),
        ({"other": "not at all"}, True, 19),
    ],
)
def test_one_seed_of_twenty_may_be_otherwise(
    wrong: dict[str, object], holds: bool, n_passed: int, lesson: Lesson
) -> None:
    runs = [played(seed, **(wrong if seed == 7 else {})) for seed in range(20)]  # type: ignore[arg-type]
    found = proof_of(lesson, runs)
    assert (found.holds, found.n_passed, found.n_seeds) == (holds, n_passed, 20)
    runs = [played(seed, **(wrong if seed in (7, 9) else {})) for seed in range(20)]  # type: ignore[arg-type]
    found = proof_of(lesson, runs)
    assert found.holds is not bool(wrong)
    assert all("18 of 20" in problem and "seed 7" in problem for problem in found.problems)


def test_what_varies_is_told_and_not_proved(lesson: Lesson) -> None:
    found = proof_of(lesson, [played(seed) for seed in range(20)])
    (moment,) = (answer for answer in found.answers if answer.card == "moment")
    assert moment.varies
    assert moment.said == "895 (800 to 990)"
    # The same spread, and nothing said of it.
    sure = circling(("    varies: true\n", "    to: 1900\n    from: 1800\n"))
    assert not proof_of(sure, [played(seed) for seed in range(20)]).holds


def test_a_check_that_holds_before_anything_is_done_is_a_problem(lesson: Lesson) -> None:
    runs = [played(seed) for seed in range(20)]
    runs[3].too_early.add("circle")
    runs[4].faults["circle"] = "it is there already"
    problems = proof_of(lesson, runs).problems
    assert len(problems) == 2
    assert "before anything is done (1 of 20" in problems[1]
    assert "it is there already" in problems[0]


def test_a_lesson_is_played_with_each_seed_once(lesson: Lesson) -> None:
    told: list[tuple[int, int]] = []
    (found,) = proofs([lesson], 2, lambda done, of: told.append((done, of)))
    assert told == [(1, 2), (2, 2)]
    assert found.n_seeds == 2
    assert {answer.card for answer in found.answers} == {"spread", "moment", "drawn", "other"}
    rows = rows_of(found)
    assert all(len(row) <= len(COLUMNS) for row in rows)
    assert [row[0] for row in rows] == ["spread", "moment", "drawn", "circle", "other"]
    said = json.loads(json.dumps(as_json(found)))
    assert said["seeds"] == 2
    assert said["holds"] is found.holds
    assert found.lesson.name in headline_of(found)


def proved(lesson: Lesson, seeds: int = 20, passed: int = 19) -> Proof:
    return Proof(lesson, seeds, passed, (), (), ())


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (LESSON, LESSON + PROVED),
        (LESSON.rstrip("\n"), LESSON + PROVED),
        (LESSON.replace("\n", "\r\n"),
         (LESSON + PROVED).replace("\n", "\r\n")),
        ("evidence: {seeds: 3, pass: 3}\n" + LESSON, PROVED + LESSON),
        ("evidence:  {pass: 3, seeds: 3}   # by the checker\n" + LESSON,
         f"{PROVED.rstrip()} # by the checker\n" + LESSON),
        ("evidence:\n  seeds: 3\n  pass: 3\n" + LESSON, PROVED + LESSON),
        (LESSON + "evidence: {seeds: 3,\n  pass: 3}\n# The end.\n",
         LESSON + "evidence: {seeds: 20, pass: 19}\n# The end.\n"),
        # What only looks like it, in a text, stays.
        (LESSON.replace("Which way?", "|\n      evidence: none"),
         LESSON.replace("Which way?", "|\n      evidence: none") + PROVED),
    ],
)  # fmt: skip
def test_evidence_is_written_and_all_else_stays(before: str, after: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_bytes(before.encode())
    lesson = lessons.load(str(path))
    assert write_evidence(path, proved(lesson)) is True
    assert path.read_bytes() == after.encode()
    again = lessons.load(str(path))
    assert again.digest == lesson.digest
    assert write_evidence(path, proved(again)) is False


def test_evidence_is_not_written_where_it_would_change_the_lesson(tmp_path: Path) -> None:
    flow = "{title: A, minutes: 1, setup: {preset: timed}, steps: [{say: Look.}]}"
    with pytest.raises(ProofError, match="cannot be written"):
        with_evidence(proved(lessons.parse(flow, "flow.yaml")))
    quoted = '"evidence": {seeds: 3, pass: 3}\n' + LESSON
    with pytest.raises(ProofError, match="cannot be written"):
        with_evidence(proved(lessons.parse(quoted, "quoted.yaml")))
    path = tmp_path / "mine.yaml"
    path.write_text(LESSON)
    lesson = lessons.load(str(path))
    path.write_text(LESSON + "# Another hand.\n")
    with pytest.raises(ProofError, match="changed meanwhile"):
        write_evidence(path, proved(lesson))
    assert path.read_text() == LESSON + "# Another hand.\n"


def test_the_shipped_lessons_hold() -> None:
    """With every seed that they are proved with, but for what they say varies."""
    shipped = [lessons.load(name) for name in lessons.shipped()]
    found = proofs(shipped, SEEDS, every_answer=False)
    assert [problem for proof in found for problem in proof.problems] == []
    for proof in found:
        evidence = proof.lesson.spec.evidence
        assert evidence is not None, proof.lesson.name
        assert evidence.passed >= proofs_module.NEARLY_ALL * evidence.seeds
        if evidence.seeds == SEEDS:
            assert evidence.passed == proof.n_passed, proof.lesson.name
