"""The files of ``pounce run``: whole, or not there."""

import csv
import errno
import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from app.documents import presets
from app.experiments import output as files
from app.experiments.archive import packed
from app.experiments.crews import Threads
from app.experiments.output import Output, OutputError
from app.experiments.seeds import curves_csv, run_seeds, summary
from learners.kernel.state import tables
from learners.run import Run
from learners.spec import RunSpec


@pytest.fixture(scope="module")
def spec() -> RunSpec:
    return presets.load("hierarchical_3", ("world.size=30", "world.step_limit=80", "trials=150"))


def write(spec: RunSpec, folder: Path, seeds: Sequence[int], overwrite: bool = False) -> dict:
    with Output(folder, "mine", seeds, overwrite) as output:
        results = run_seeds(spec, seeds, Threads(2), on_tables=output.save_tables)
        document = summary("mine", spec, results)
        output.commit(document, curves_csv(results))
    return json.loads(document)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


RESULTS = ["mine-seed3.npz", "mine-seed7.npz", "mine.csv", "mine.json"]


def test_results_are_written(spec: RunSpec, tmp_path: Path) -> None:
    folder = tmp_path / "with blanks" / "ünd Zeichen"
    document = write(spec, folder, [7, 3])
    assert names(folder) == RESULTS
    assert json.loads((folder / "mine.json").read_text(encoding="utf-8")) == document

    rows = list(csv.reader((folder / "mine.csv").open(encoding="utf-8", newline="")))
    assert rows[0] == ["seed", "steps", "reward"]
    expected = [
        [run["seed"], steps, reward]
        for run in document["runs"]
        for steps, reward in zip(run["curve"]["steps"], run["curve"]["reward"], strict=True)
    ]
    assert [[int(row[0]), int(row[1]), float(row[2])] for row in rows[1:]] == expected

    for seed in (7, 3):
        run = Run(spec, seed)
        run.advance()
        with np.load(folder / f"mine-seed{seed}.npz", allow_pickle=False) as kept:
            known = tables(spec, run.state)
            assert set(kept.files) == set(known)
            for name, table in known.items():
                np.testing.assert_array_equal(kept[name], table)


def test_results_are_not_overwritten_unless_told_to(spec: RunSpec, tmp_path: Path) -> None:
    write(spec, tmp_path, [3, 7])
    before = {name: (tmp_path / name).read_bytes() for name in RESULTS}
    for seeds in ([3, 7], [9]):
        with pytest.raises(OutputError, match="has results of that name already: mine"):
            Output(tmp_path, "mine", seeds, overwrite=False)
    assert {name: (tmp_path / name).read_bytes() for name in names(tmp_path)} == before

    write(presets.load("hierarchical_2", ["trials=20"]), tmp_path, [3, 7], overwrite=True)
    assert names(tmp_path) == RESULTS
    assert all((tmp_path / name).read_bytes() != before[name] for name in RESULTS)


def test_other_files_are_let_be(spec: RunSpec, tmp_path: Path) -> None:
    (tmp_path / "theirs.json").write_text("theirs", encoding="utf-8")
    write(spec, tmp_path, [3, 7])
    assert names(tmp_path) == [*RESULTS, "theirs.json"]
    assert (tmp_path / "theirs.json").read_text(encoding="utf-8") == "theirs"


def tables_of(run: Run) -> bytes:
    return packed(tables(run.spec, run.state))


def fail_to_write(output: Output, spec: RunSpec) -> None:
    output.save_tables(3, tables_of(Run(spec, 3)))
    assert output.files[0].parent.is_dir()
    raise KeyboardInterrupt


def test_what_was_interrupted_leaves_nothing(spec: RunSpec, tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    with pytest.raises(KeyboardInterrupt), Output(folder, "mine", [3], False) as output:
        fail_to_write(output, spec)
    assert names(tmp_path) == []


def test_what_was_interrupted_leaves_what_was_there(spec: RunSpec, tmp_path: Path) -> None:
    write(spec, tmp_path, [3, 7])
    before = {name: (tmp_path / name).read_bytes() for name in RESULTS}
    with pytest.raises(KeyboardInterrupt), Output(tmp_path, "mine", [3], True) as output:
        fail_to_write(output, spec)
    assert {name: (tmp_path / name).read_bytes() for name in names(tmp_path)} == before


def test_a_file_appears_only_when_it_is_complete(
    spec: RunSpec, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    moved: list[str] = []
    replace = os.replace

    def watched(source: Path, target: Path) -> None:
        if not moved:
            assert [name for name in names(tmp_path) if not name.startswith(".")] == []
        assert source.stat().st_size > 0
        assert source.stat().st_dev == target.parent.stat().st_dev
        moved.append(target.name)
        replace(source, target)

    monkeypatch.setattr(os, "replace", watched)
    write(spec, tmp_path, [3, 7])
    assert sorted(moved) == RESULTS
    assert moved[-1] == "mine.json"


def a_file_in_the_way(folder: Path) -> None:
    folder.write_text("", encoding="utf-8")


def a_result_that_is_a_folder(folder: Path) -> None:
    (folder / "mine.json").mkdir(parents=True)


@pytest.mark.parametrize(
    ("prepare", "overwrite", "message"),
    [
        (a_file_in_the_way, False, "cannot be written to: File exists"),
        (a_result_that_is_a_folder, False, "has results of that name already: mine.json"),
        (a_result_that_is_a_folder, True, "holds a folder where a result belongs: mine.json"),
    ],
)
def test_a_folder_that_cannot_take_results_is_refused_before_any_work(
    prepare: Callable[[Path], None], overwrite: bool, message: str, tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    prepare(folder)
    with pytest.raises(OutputError, match=message):
        Output(folder, "mine", [3], overwrite)


def test_an_unwritable_folder_is_refused_and_not_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def denied(*args: object, **kwargs: object) -> str:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(files.tempfile, "mkdtemp", denied)
    with pytest.raises(OutputError, match="cannot be written to: Permission denied"):
        Output(tmp_path / "a" / "b", "mine", [3], overwrite=False)
    assert names(tmp_path) == []


def test_a_name_that_is_too_long_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot be written to: File name too long"):
        Output(tmp_path / "new", "x" * 250, [3], overwrite=False)
    assert names(tmp_path) == []


def test_a_full_disk_is_reported_and_leaves_nothing(
    spec: RunSpec, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*args: object, **kwargs: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    for way in ("write_text", "write_bytes"):
        with monkeypatch.context() as patch:
            patch.setattr(Path, way, full)
            with pytest.raises(OutputError, match="cannot be written to: No space left on device"):
                write(spec, tmp_path / "new", [3, 4])
        assert names(tmp_path) == []
