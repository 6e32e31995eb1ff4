"""Damaged results: what is read is what was written, or less with a word, or nothing."""

import contextlib
import io
import shutil
import sqlite3
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.cli import main
from app.documents.experiments import Experiment, parse
from app.experiments import archive, table
from app.experiments.archive import ArchiveError
from app.experiments.crews import Threads
from app.experiments.record import Record
from app.experiments.runner import run_experiment
from app.experiments.store import Folder, FolderError, finished_in, goes_on
from app.results import read, thesis
from app.results.gather import Curve
from app.results.read import DamagedError, Reader, ResultsError
from app.results.service import Service, Standing
from tests.support.folders import seal
from tests.support.reports import without_pictures

TEXT = """
presets: [timed, standard_q]
set: {world.size: 30, world.step_limit: 80}
trials: 300
seeds: 2
"""
N_RUNS = 4
PATIENCE_S = 60.0


def small() -> Experiment:
    return parse(TEXT, "small.yaml")


def resumed(path: Path, salvage: bool = False) -> None:
    with Folder(path, small(), not salvage, False, salvage) as folder:
        run_experiment(small(), folder, Threads(2))


def rows(path: Path) -> dict[str, dict[str, Any]]:
    """The runs of a folder by key, without what differs from one time to the next."""
    with contextlib.closing(table.reader(path)) as database:
        found = table.read(database).rows
    apart = {"rowid", "seconds", "ended_at", "seal"}
    return {row["key"]: {k: v for k, v in row.items() if k not in apart} for row in found}


class Report(NamedTuple):
    """What a report is made of."""

    runs: dict[str, tuple[Record, list[list[float]]]]
    """By key: the row and the curves."""
    n_lost: int


def report_on(path: Path) -> Report:
    folder = read.read_folder(path)
    reader = Reader(read.Widths(10_000, 50), thesis.quantities_of)
    runs = {}
    for run in folder.rows:
        (trace,) = reader.traces([run])
        curves = [np.nan_to_num(curve, nan=-1.0).tolist() for curve in trace.curves.values()]
        # What was not measured is not equal to itself.
        values = {name: -1.0 if value != value else value for name, value in run.values.items()}
        origin = run.origin._replace(folder=Path())
        record = replace(run, values=values, origin=origin, seconds=0.0, ended_at="")
        runs[run.key] = record, curves
    return Report(runs, len(folder.lost))


def page_of(root: Path) -> Standing:
    """How the experiment stands that the page has gone on with, or begun."""
    service = Service(root)
    service.start(small(), workers=2)
    service.wait(PATIENCE_S)
    standing = service.standing
    assert standing is not None
    assert not standing.running
    return standing


Shown = tuple[int, int, str, str, dict[str, float]]
"""What the page shows of a run: place, seed, error, digest and values."""


def rounded(values: Mapping[str, float]) -> dict[str, float]:
    """Values that can be compared: what was not measured is not equal to itself."""
    return {name: -1.0 if value != value else round(value, 9) for name, value in values.items()}


def shown_by(standing: Standing) -> tuple[dict[str, Shown], list[Curve]]:
    runs = {
        run.key: (place, run.seed, run.gist, run.digest, rounded(run.values))
        for place, run in standing.gatherer.gathering().runs
    }
    return runs, [standing.gatherer.curve(variant, "trials") for variant in (0, 1)]


class Whole(NamedTuple):
    path: Path
    rows: dict[str, dict[str, Any]]
    report: Report
    page: tuple[dict[str, Shown], list[Curve]]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Whole:
    """Results that nothing has happened to, and what everybody says of them."""
    path = tmp_path_factory.mktemp("whole") / "small"
    with Folder(path, small(), False, False) as folder:
        run_experiment(small(), folder, Threads(2))
    found = Whole(path, rows(path), report_on(path), shown_by(page_of(path.parent)))
    assert len(found.rows) == len(found.report.runs) == len(found.page[0]) == N_RUNS
    return found


@pytest.fixture
def copy(whole: Whole, tmp_path: Path) -> Path:
    return shutil.copytree(whole.path, tmp_path / "small")


def flipped(data: bytes, place: int, bit: int, _: bytes) -> bytes:
    changed = bytearray(data)
    changed[place] ^= 1 << bit
    return bytes(changed)


def cut(data: bytes, place: int, _: int, __: bytes) -> bytes:
    return data[:place]


def zeroed(data: bytes, place: int, bit: int, _: bytes) -> bytes:
    n = min(len(data) - place, 16 << bit)
    return data[:place] + bytes(n) + data[place + n :]


def swapped(_: bytes, __: int, ___: int, other: bytes) -> bytes:
    return other


DAMAGES: list[Callable[[bytes, int, int, bytes], bytes]] = [flipped, flipped, cut, zeroed, swapped]


class Damage(NamedTuple):
    """A way in which a file of a folder may be damaged."""

    file: int
    other: int
    kind: int
    place: float
    bit: int

    def do(self, path: Path) -> None:
        files = sorted(found for found in path.rglob("*") if found.is_file())
        # The table is most of what there is to be damaged, and one file of seven.
        file = path / "results.sqlite" if self.file < 0 else files[self.file % len(files)]
        if self.kind == len(DAMAGES):
            file.unlink()
            return
        data, other = file.read_bytes(), files[self.other % len(files)].read_bytes()
        place = min(int(self.place * len(data)), max(len(data) - 1, 0))
        if data:
            file.write_bytes(DAMAGES[self.kind](data, place, self.bit, other))


damages = st.builds(
    Damage,
    file=st.integers(-4, 6),
    other=st.integers(0, 6),
    kind=st.integers(0, len(DAMAGES)),
    place=st.floats(0, 1),
    bit=st.integers(0, 7),
)


@contextlib.contextmanager
def damaged(whole: Whole, damage: Damage) -> Any:
    """A copy of the results, damaged."""
    root = whole.path.parent.parent / "damaged"
    path = shutil.copytree(whole.path, root / "small")
    try:
        damage.do(path)
        yield path
    finally:
        shutil.rmtree(root)


@given(damage=damages)
def test_a_report_says_what_was_written_or_that_it_is_not_there(
    whole: Whole, damage: Damage
) -> None:
    with damaged(whole, damage) as path:
        try:
            found = report_on(path)
        except ResultsError:
            return
    assert len(found.runs) + found.n_lost == N_RUNS
    assert found.runs == {key: whole.report.runs[key] for key in found.runs}


@given(damage=damages)
@settings(max_examples=30)
def test_what_is_gone_on_with_comes_to_what_was_written(whole: Whole, damage: Damage) -> None:
    with damaged(whole, damage) as path:
        with contextlib.suppress(FolderError):
            resumed(path)
            assert rows(path) == whole.rows
        # Whatever is the matter, what is whole can be saved, unless there is nothing.
        with contextlib.suppress(FolderError):
            resumed(path, salvage=True)
            assert rows(path) == whole.rows


@given(damage=damages)
@settings(max_examples=15)
def test_the_page_shows_what_was_written(whole: Whole, damage: Damage) -> None:
    with damaged(whole, damage) as path:
        standing = page_of(path.parent)
        runs, curves = shown_by(standing)
    assert standing.error == ""
    assert runs == whole.page[0]
    # Averages do not depend on the order in which runs came but for the last bit.
    for found, expected in zip(curves, whole.page[1], strict=True):
        np.testing.assert_allclose(found.band.mean, expected.band.mean)


# --- The arrays of runs --------------------------------------------------------------------------


def first_archive(path: Path) -> Path:
    return min((path / "arrays").iterdir())


def another_run(file: Path) -> bytes:
    return max(file.parent.iterdir()).read_bytes()


SPOILT: dict[str, Callable[[Path], object]] = {
    "flipped": lambda file: file.write_bytes(flipped(file.read_bytes(), 700, 3, b"")),
    "cut": lambda file: file.write_bytes(file.read_bytes()[:-100]),
    "empty": lambda file: file.write_bytes(b""),
    "another run's": lambda file: file.write_bytes(another_run(file)),
    "gone": lambda file: file.unlink(),
}


@pytest.mark.parametrize("spoil", SPOILT)
def test_a_run_whose_arrays_are_damaged_is_missing_until_it_is_made_again(
    copy: Path,
    whole: Whole,
    spoil: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    counted: list[str],
) -> None:
    monkeypatch.chdir(copy.parent)
    file = first_archive(copy)
    SPOILT[spoil](file)
    assert finished_in(copy) == whole.rows.keys() - {file.stem}
    assert report_on(copy).n_lost == 1
    counted.clear()
    Path("small.yaml").write_text(TEXT)
    assert main.main(["experiment", "small.yaml", "--out", "small", "--resume"]) == 0
    said = "the arrays of 1 run in small are damaged or gone: made again\n"
    assert capsys.readouterr().err == said
    assert counted == [file.stem]
    assert rows(copy) == whole.rows
    assert file.read_bytes() == (whole.path / "arrays" / file.name).read_bytes()


def test_a_report_says_how_many_runs_are_damaged(
    copy: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    without_pictures(monkeypatch)
    SPOILT["flipped"](first_archive(copy))
    assert main.main(["report", str(copy)]) == 0
    err = capsys.readouterr().err
    assert "Unfinished: 3 of 4 runs.\n" in err
    assert "Damaged: the arrays of 1 run in" in err
    assert "--resume makes them again" in err
    page = (copy / "report.html").read_text(encoding="utf-8")
    assert "its arrays are damaged or gone" in page
    assert "standard_q, seed 0" in page


def test_the_page_says_how_many_runs_are_made_again(copy: Path, whole: Whole) -> None:
    from app.page.panels.experiments import progress_html

    SPOILT["cut"](first_archive(copy))
    standing = page_of(copy.parent)
    assert standing.folder == copy
    assert standing.damaged == 1
    assert "the arrays of 1 run were damaged or gone: made again" in progress_html(standing)
    assert shown_by(standing)[0] == whole.page[0]


def test_arrays_that_cannot_be_read_though_they_are_as_they_were_written_are_made_again(
    copy: Path, whole: Whole
) -> None:
    """As somebody may make them up who makes up their checksum as well."""
    first_archive(copy).write_bytes(b"no archive")
    seal(copy)
    assert len(finished_in(copy)) == N_RUNS
    assert shown_by(page_of(copy.parent))[0] == whole.page[0]
    assert rows(copy) == whole.rows


def packed_anew(sound: bytes, **changed: bytes | np.ndarray) -> bytes:
    """An archive with other arrays, or with other bytes for one."""
    out = io.BytesIO()
    with np.load(io.BytesIO(sound)) as found, zipfile.ZipFile(out, "w") as parts:
        for name in found.files:
            data = changed.get(name, found[name])
            if isinstance(data, np.ndarray):
                file = io.BytesIO()
                np.lib.format.write_array(file, data, allow_pickle=True)
                data = file.getvalue()
            parts.writestr(f"{name}.npy", data)
    return out.getvalue()


def header(shape: str, kind: str) -> bytes:
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


@pytest.mark.parametrize(
    "changed",
    [
        {"outcome": header("(1099511627776,)", "|i1")},
        {"introduced": header("(1099511627776,)", "<U0")},
        {"steps": header("(-4,)", "<i4")},
        {"outcome": np.full(300, 7, np.int8)},
        {"outcome": np.ones(299, np.int8)},
        {"outcome": np.ones((300, 1), np.int8)},
        {"outcome": np.array([{}] * 300)},
        {"steps": np.full(300, 2**40)},
        {"steps": np.full(300, -1)},
        {"introduced": np.array(["a", "b", "c", "d", "e"])},
        {"moments": np.zeros(7, np.int64)},
        {"value_share": np.zeros(3)},
    ],
)
def test_arrays_that_no_run_can_have_are_refused(whole: Whole, changed: Any) -> None:
    sound = first_archive(whole.path).read_bytes()
    row = whole.rows[first_archive(whole.path).stem]
    length = row["trials"], row["steps"]
    archive.unpacked(packed_anew(sound), *length)
    with pytest.raises(ArchiveError):
        archive.unpacked(packed_anew(sound, **changed), *length)


def test_arrays_that_would_take_all_memory_are_not_unpacked(whole: Whole) -> None:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as parts:
        parts.writestr("outcome.npy", bytes(archive.LARGEST_BYTES + 1))
    with pytest.raises(ArchiveError, match="too large"):
        archive.unpacked(out.getvalue(), 1, 1)


# --- The table -----------------------------------------------------------------------------------


def changed(path: Path, query: str) -> None:
    with contextlib.closing(sqlite3.connect(path / "results.sqlite")) as database, database:
        database.execute(query)


@pytest.mark.parametrize(
    "query",
    [
        "UPDATE runs SET final_reward = final_reward + 1 WHERE seed = 1 AND preset = 'timed'",
        "UPDATE runs SET steps = 'many' WHERE seed = 1 AND preset = 'timed'",
        "UPDATE runs SET final_reward = 9e999 WHERE seed = 1 AND preset = 'timed'",
        "UPDATE runs SET trials = 9223372036854775807 WHERE seed = 1 AND preset = 'timed'",
        "UPDATE runs SET variant = x'ff' WHERE seed = 1 AND preset = 'timed'",
        "DELETE FROM runs WHERE seed = 1 AND preset = 'timed'",
    ],
)
def test_a_table_that_was_changed_is_refused_and_what_is_whole_is_saved(
    copy: Path,
    whole: Whole,
    query: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    counted: list[str],
) -> None:
    monkeypatch.chdir(copy.parent)
    Path("small.yaml").write_text(TEXT)
    changed(copy, query)
    before = (copy / "results.sqlite").read_bytes()
    experiment = ["experiment", "small.yaml", "--out", "small"]
    refused = (
        ["report", "small"],
        [*experiment, "--resume"],
        [*experiment, "--resume", "--dry-run"],
    )
    for command in refused:
        assert main.main(command) == 2
        said = " ".join(capsys.readouterr().err.split())
        assert "damaged results.sqlite" in said
        assert "3 of 4 rows are whole" in said
        assert "--salvage" in said
    assert not goes_on(copy, small())
    assert (copy / "results.sqlite").read_bytes() == before
    assert main.main([*experiment, "--salvage", "--dry-run", "--json"]) == 0
    assert '"done": 3' in capsys.readouterr().out
    counted.clear()
    assert main.main([*experiment, "--salvage"]) == 0
    assert len(counted) == 1
    assert rows(copy) == whole.rows
    assert (copy / "damaged.sqlite").read_bytes() == before
    assert report_on(copy) == whole.report
    # There is nothing more to be saved, so it goes on like --resume.
    counted.clear()
    assert main.main([*experiment, "--salvage"]) == 0
    assert counted == []
    assert not (copy / "damaged-2.sqlite").exists()


def test_a_table_with_a_flipped_bit_is_never_read_as_another_one(copy: Path) -> None:
    """All over the table, also in digits of numbers and in texts that stay readable."""
    file = copy / "results.sqlite"
    sound, before = file.read_bytes(), str(read.read_folder(copy))
    refused = 0
    for number, place in enumerate(range(0, len(sound), 97)):
        file.write_bytes(flipped(sound, place, number % 3, b""))
        try:
            assert str(read.read_folder(copy)) == before, place
        except ResultsError:
            refused += 1
    assert refused


@pytest.mark.parametrize("key", ["seeds", "variants", "stop", "metrics", "runs"])
def test_what_a_table_says_of_its_experiment_is_sealed_too(
    copy: Path, whole: Whole, key: str
) -> None:
    changed(copy, f"UPDATE meta SET value = '[0]' WHERE key = '{key}'")
    with pytest.raises(DamagedError, match="4 rows are whole"):
        read.read_folder(copy)
    with pytest.raises(FolderError, match="--salvage to go on with these"):
        resumed(copy)
    resumed(copy, salvage=True)
    assert rows(copy) == whole.rows


def test_a_record_that_is_damaged_is_written_anew_by_salvaging(copy: Path, whole: Whole) -> None:
    (copy / "experiment.yaml").write_text(TEXT.replace("300", "301"))
    with pytest.raises(FolderError, match="another experiment"):
        resumed(copy)
    resumed(copy, salvage=True)
    assert (copy / "experiment.yaml").read_text() == TEXT
    assert rows(copy) == whole.rows


def test_rows_of_another_experiment_are_not_salvaged(copy: Path) -> None:
    other = parse(TEXT.replace("300", "301"), "small.yaml")
    with pytest.raises(FolderError, match="other settings"):
        Folder(copy, other, False, False, True)
    assert not (copy / "damaged.sqlite").exists()


def test_of_a_table_that_is_none_nothing_is_salvaged(copy: Path) -> None:
    (copy / "results.sqlite").write_text("no table, but a longer text" * 100)
    with pytest.raises(FolderError, match="no row that is whole"):
        resumed(copy, salvage=True)
    with pytest.raises(FolderError, match="0 rows are whole; allowed: another folder"):
        resumed(copy)


def test_what_numbers_the_table_keeps_are_those_it_gives_back(tmp_path: Path) -> None:
    """A zero has no sign in SQLite, what is no number is nothing, and text may be no text."""
    row = {"key": "k", "variant": "\udcff\0ü", "preset": "p", "overrides": "{}", "settings": "{}"}
    row |= {"seed": np.int64(2**62), "status": "done", "version": "1", "area": -0.0}
    row |= {"final_reward": float("nan"), "greedy_success": 1, "seconds": float("inf")}
    (tmp_path / "results.sqlite").write_bytes(table.new({"seeds": "[]"}, [row]))
    with contextlib.closing(table.reader(tmp_path)) as database:
        (found,) = table.read(database).rows
    assert (found["variant"], found["seed"], found["final_reward"]) == ("\\udcff\0ü", 2**62, None)
    assert (found["area"], found["greedy_success"]) == (0.0, 1.0)
