"""All experiments of the replication, run one after the other."""

from pathlib import Path

import pytest

from app.documents import experiments
from app.experiments.crews import Threads
from app.replication.run import Made, make_all
from app.results.read import read_folder

TEXT = """
presets:
  - {preset: timed, label: small, set: {world.size: 20}}
trials: 3
steps: 100
seeds: 4
"""


@pytest.fixture
def names(monkeypatch: pytest.MonkeyPatch) -> tuple[str, ...]:
    """Two experiments that take no time, shipped under these names."""

    def load(name: str, n_seeds: int | None = None) -> experiments.Experiment:
        return experiments.parse(TEXT, name, None, n_seeds)

    monkeypatch.setattr("app.replication.run.experiments.load", load)
    return "first", "second"


def made(
    names: tuple[str, ...], out: Path, n_seeds: int | None = None, force: bool = False
) -> Made:
    return make_all(names, out, lambda: Threads(1), n_seeds, force)


def digests(folder: Path) -> list[str]:
    return [run.digest for run in read_folder(folder).rows]


def test_each_experiment_has_a_folder_with_all_its_runs(names: tuple[str, ...], tmp_path: Path):
    found = made(names, tmp_path)
    assert (found.runs, found.failed) == (8, 0)
    assert [len(digests(tmp_path / name)) for name in names] == [4, 4]


def test_what_is_there_is_not_made_again(names: tuple[str, ...], tmp_path: Path):
    made(names[:1], tmp_path)
    before = digests(tmp_path / "first")
    found = made(names, tmp_path)
    assert (found.runs, found.steps) == (8, made(names[:1], tmp_path / "again").steps)
    assert digests(tmp_path / "first") == before


def test_with_force_it_is_made_again(names: tuple[str, ...], tmp_path: Path):
    first = made(names, tmp_path)
    assert made(names, tmp_path).steps == 0
    assert made(names, tmp_path, force=True).steps == first.steps > 0
