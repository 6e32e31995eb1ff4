"""Twenty runs are played while cards are read, kept on disk, and given up where one leaves."""

import json
import threading
from pathlib import Path
from typing import Final

import pytest

from app.documents.lessons import Lesson
from app.lessons import canon, kept, twenty
from app.lessons.kept import Folder
from app.lessons.reveals import Answer
from app.lessons.shared import Shared
from app.lessons.spread import Spread
from app.lessons.twenty import SEEDS, Twenty
from tests.support.circling import circling

PATIENCE_S: Final = 60.0
OTHER_SEED: Final = ("preset: timed, start", "preset: timed, seed: 77, start")


@pytest.fixture(scope="module")
def lesson() -> Lesson:
    return circling()


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> tuple[int, ...]:
    """Few seeds, so that it does not take long."""
    seeds = SEEDS[:3]
    monkeypatch.setattr(twenty, "SEEDS", seeds)
    return seeds


@pytest.fixture
def plays(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Seeds with which lessons were played; which takes no time, and comes to something like it."""
    played: list[int] = []

    def noted(lesson: Lesson, seed: int, shared: Shared | None = None) -> canon.Played:
        played.append(seed)
        answers: dict[str, Answer] = {
            "spread": "clockwise",
            "moment": seed + 0.5,
            "drawn": ((1.0, 2.0), (2.0, 3.0)),
        }
        return canon.Played(seed, answers=answers)

    monkeypatch.setattr(canon, "play", noted)
    return played


def found_by(lesson: Lesson, folder: Path | None = None) -> twenty.Spreads:
    """What is found of a lesson by somebody who knows nothing yet."""
    finder = Twenty(folder=folder)
    try:
        finder.want(lesson)
        assert finder.settle(PATIENCE_S)
        found = finder.found(lesson)
        assert found is not None
        return found
    finally:
        finder.stop()


def test_they_answer_what_each_run_answers(lesson: Lesson, few: tuple[int, ...]) -> None:
    found = found_by(lesson)
    played = [canon.play(lesson, seed) for seed in few]
    assert found.n == len(few)
    assert found.is_whole
    for card in ("spread", "moment", "drawn", "other"):
        assert found.of(card) == Spread(tuple(one.answers[card] for one in played))
        assert found.own[card] == played[0].answers[card]
    assert found.of("circle") == Spread(())


def test_the_lessons_own_seed_is_played_as_well(few: tuple[int, ...]) -> None:
    lesson = circling(OTHER_SEED)
    found = found_by(lesson)
    assert found.own["spread"] == canon.play(lesson, 77).answers["spread"]
    assert found.of("spread").n == len(few)


def test_what_was_found_is_kept(
    lesson: Lesson, few: tuple[int, ...], plays: list[int], tmp_path: Path
) -> None:
    first = found_by(lesson, tmp_path)
    assert plays == [*few]
    assert found_by(lesson, tmp_path) == first
    assert plays == [*few]
    # Another lesson is another thing.
    found_by(circling(("above: 0.2, at", "above: 0.3, at")), tmp_path)
    assert plays == [*few, *few]


@pytest.mark.parametrize("damage", ["cut", "other", "empty", "shape", "huge", "folder"])
def test_what_is_damaged_is_found_anew(
    damage: str,
    lesson: Lesson,
    few: tuple[int, ...],
    plays: list[int],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first = found_by(lesson, tmp_path)
    (path,) = tmp_path.iterdir()
    data = path.read_bytes()
    match damage:
        case "cut":
            path.write_bytes(data[: len(data) // 2])
        case "other":
            path.write_bytes(data.replace(b"clockwise", b"anti-clock"))
        case "empty":
            path.write_bytes(b"")
        case "shape":
            path.write_bytes(json.dumps({"spread": [1, {"a": []}, []]}).encode())
        case "huge":
            monkeypatch.setattr(kept, "MOST_BYTES", len(data) - 1)
        case _:
            path.unlink()
            path.mkdir()
    assert found_by(lesson, tmp_path) == first
    assert plays == [*few, *few]


def test_a_folder_that_cannot_be_written_to_is_done_without(
    lesson: Lesson, few: tuple[int, ...], plays: list[int], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("no folder")
    assert found_by(lesson, tmp_path / "file" / "within").n == len(few) == len(plays)


def test_few_files_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kept, "MOST_FILES", 3)
    folder = Folder(tmp_path)
    answers = {"card": (1.0, "yes", ("w",), ((1.0, 2.0),), None)}
    for name in "012345":
        folder.write(name * 64, answers)
    assert len([*tmp_path.iterdir()]) == 3
    assert folder.read("5" * 64, 5) == answers
    assert folder.read("5" * 64, 6) is None
    # A file that is called otherwise than it was written is of something else.
    last = tmp_path / f"{'5' * 32}.answers.json"
    (tmp_path / f"{'f' * 32}.answers.json").write_bytes(last.read_bytes())
    assert folder.read("f" * 64, 5) is None


def test_the_newest_wish_wins_and_what_is_left_is_given_up(
    few: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    long, short = circling(("trials: 3000", "trials: 3001")), circling()
    begun, may_go_on = threading.Event(), threading.Event()

    def held(lesson: Lesson, seed: int, shared: Shared | None = None) -> canon.Played:
        if lesson is long:
            begun.set()
            assert may_go_on.wait(PATIENCE_S)
            assert shared is not None
            shared.run_at(lesson.run_spec, seed, 100)
        return canon.Played(seed, answers={"spread": "clockwise"})

    monkeypatch.setattr(canon, "play", held)
    finder = Twenty()
    try:
        finder.want(long)
        assert begun.wait(PATIENCE_S)
        finder.want(short)
        may_go_on.set()
        assert finder.settle(PATIENCE_S)
        found = finder.found(short)
        assert found is not None
        assert found.is_whole
        assert found.n == len(few)
        assert finder.found(long) is None
        finder.leave()
        assert finder.found(short) == found
    finally:
        finder.stop()


def test_what_cannot_be_played_is_not_tried_for_ever(
    lesson: Lesson, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[int] = []

    def failing(lesson: Lesson, seed: int, shared: Shared | None = None) -> canon.Played:
        tried.append(seed)
        raise RuntimeError("broken")

    monkeypatch.setattr(canon, "play", failing)
    finder = Twenty()
    try:
        finder.want(lesson)
        assert finder.settle(PATIENCE_S)
        finder.want(lesson)
        assert finder.settle(PATIENCE_S)
        assert finder.found(lesson) is None
        assert tried == [0]
    finally:
        finder.stop()
