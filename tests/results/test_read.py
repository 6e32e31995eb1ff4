"""Results read back from disk."""

import contextlib
import json
import shutil
import sqlite3
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from app.documents import experiments
from app.experiments import store, task
from app.experiments.runner import record_of
from app.results import read, thesis
from tests.support.folders import TABLE, add_run, new_folder, pictures


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return new_folder(tmp_path / "results with blanks, ünicode # and ?")


def test_variants_are_in_the_order_of_the_experiment_whichever_ended_first(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "a", variants='["timed", "standard_q", "another"]')
    for preset, variant in (("timed", "another"), ("standard_q", ""), ("timed", "")):
        for seed in (1, 0):
            add_run(folder, seed, preset=preset, variant=variant)
    found = [(run.variant, run.seed) for run in read.read_folder(folder).rows]
    assert found == [(v, s) for v in ("timed", "standard_q", "another") for s in (0, 1)]


def test_variants_of_which_no_run_is_over_count_as_planned(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Presets named by their paths are beside the experiment, and not beside its results."""
    monkeypatch.chdir(tmp_path)
    for name in ("mine", "another"):
        Path(f"{name}.yaml").write_text(f"extends: timed\ndescription: {name}\n")
    Path("small.yaml").write_text("presets: [mine.yaml, another.yaml]\ntrials: 600\nseeds: 2\n")
    experiment = experiments.load("small.yaml")
    place = tmp_path / "results" / "small"
    with store.Folder(place, experiment, False, False) as kept:
        (*_, (variant, one)) = task.tasks_of(experiment)
        kept.write(record_of(variant, one, task.failed(one.key, OSError()), kept.origin))
    found = read.read_folder(place)
    assert (len(found.rows), found.planned) == (1, 4)


@pytest.mark.parametrize("wrong", ["1", "[1]", '{"timed": 1}'])
def test_variants_that_are_no_names_are_refused(tmp_path: Path, wrong: str) -> None:
    with pytest.raises(read.ResultsError, match="variants are not a list of names"):
        read.read_folder(new_folder(tmp_path / "a", variants=wrong))


def test_results_that_were_never_begun_are_no_results_of_another_version(tmp_path: Path) -> None:
    (tmp_path / TABLE).touch()
    with pytest.raises(read.ResultsError, match="no run is over in"):
        read.read_folder(tmp_path)


def test_unusable_folders_are_refused_in_clear_words(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / TABLE).write_text("nothing of the kind" * 100)
    new_folder(tmp_path / "later", version="99")
    with contextlib.closing(sqlite3.connect(new_folder(tmp_path / "part") / TABLE)) as database:
        database.execute("DELETE FROM meta WHERE key = 'seeds'")
        database.commit()
    for name, message in (
        ("missing", "is no folder"),
        ("empty", "no results.sqlite"),
        ("damaged", "damaged"),
        ("part", "damaged"),
        ("later", "version 99"),
    ):
        with pytest.raises(read.ResultsError, match=message):
            read.read_folder(tmp_path / name)


def test_settings_that_are_no_json_are_refused(folder: Path) -> None:
    add_run(folder, 0)
    with contextlib.closing(sqlite3.connect(folder / TABLE)) as database, database:
        database.execute("UPDATE runs SET settings = '{'")
    with pytest.raises(read.ResultsError, match="damaged"):
        read.read_folder(folder)


def test_folders_say_what_was_measured(tmp_path: Path) -> None:
    some = new_folder(tmp_path / "some", metrics=["area", "flights"])
    assert list(read.read_folder(some).metrics) == ["area", "flights"]
    for number, wrong in enumerate(({"area": 1}, [1], "area")):
        folder = new_folder(tmp_path / str(number), metrics=wrong)
        with pytest.raises(read.ResultsError, match="metrics are not a list of names"):
            read.read_folder(folder)


@pytest.mark.parametrize(
    ("name", "meta", "expected"),
    [
        ("figure_4_1", {}, "figure_4_1"),
        ("mine", {}, "DIR/experiment.yaml"),
        ("mine", {"source": "files/my mine.yaml"}, "'files/my mine.yaml'"),
        ("figure_4_1", {"source": "./figure_4_1.yaml"}, "./figure_4_1.yaml"),
        ("figure_4_1", {"source": "figure_4_1"}, "figure_4_1"),
    ],
)
def test_the_command_names_an_experiment_that_can_be_found(
    tmp_path: Path, name: str, meta: Mapping[str, str], expected: str
) -> None:
    place = new_folder(tmp_path / "results", name=name, **meta)
    expected = expected.replace("DIR", str(place))
    command = read.read_folder(place).command
    assert command == f"pounce experiment {expected} --seeds 3 --out {place}"


@pytest.mark.parametrize(
    ("meta", "expected"),
    [
        ({"stop": "null", "steps": "null"}, False),
        ({"stop": '{"success": 0.9, "trials": 500, "every": 100}', "steps": "null"}, True),
        ({"stop": "null", "steps": "5000000"}, True),
    ],
)
def test_runs_that_may_have_ended_early_are_known(
    tmp_path: Path, meta: Mapping[str, str], expected: bool
) -> None:
    place = new_folder(tmp_path / "results", **meta)
    add_run(place, 0)
    (run,) = read.read_folder(place).rows
    assert run.origin.limited is expected


def test_runs_that_may_have_ended_early_are_a_group_of_their_own(tmp_path: Path) -> None:
    limited = new_folder(tmp_path / "limited", steps="5000000")
    folders = [limited, *(new_folder(tmp_path / name) for name in "ab")]
    for seed, place in enumerate(folders):
        add_run(place, seed)
    groups = read.groups_of(run for place in folders for run in read.read_folder(place).rows)
    assert [[run.seed for run in group.runs] for group in groups] == [[0], [1, 2]]


def groups_in(*folders: Path) -> list[read.Group]:
    return read.groups_of(run for place in folders for run in read.read_folder(place).rows)


def test_labels_that_folders_share_get_their_names_where_settings_differ(tmp_path: Path) -> None:
    places = [tmp_path / name for name in ("a", "b", "c", "other/a")]
    for number, place in enumerate(places):
        new_folder(place)
        settings = {"trials": 20 if number == 2 else 10}
        add_run(place, number, settings=json.dumps(settings))
        add_run(place, number, preset="standard_q")
    labels = [[group.label for group in groups_in(*some)] for some in (places[:2], places[:3])]
    assert labels[0] == ["standard_q", "timed"]
    assert sorted(labels[1]) == ["a, b: timed", "c: timed", "standard_q"]
    found = {group.label for group in groups_in(*places[2:])}
    assert found == {"c: timed", "a: timed", "standard_q"}


def test_folders_of_the_same_name_go_by_their_paths(tmp_path: Path) -> None:
    places = [tmp_path / name for name in ("x/a", "y/a", "b")]
    names = read.folder_names(places)
    assert [names[place] for place in places] == [str(places[0]), str(places[1]), "b"]


def test_short_names_are_for_variants_that_nobody_has_named(folder: Path) -> None:
    for alpha, trials in ((0.1, 1), (0.2, 2)):
        sets = {"learner.alpha": alpha, "x": trials, "same": 0}
        label = f"timed, learner.alpha={alpha}, x={trials}, same=0"
        add_run(folder, 0, variant=label, overrides=sets)
    groups, naming = read.with_short_names(groups_in(folder))
    assert [group.label for group in groups] == ["0.1, 1", "0.2, 2"]
    assert naming == "Variants are named by their values of learner.alpha, x."
    add_run(folder, 0, variant="mine", overrides={"learner.alpha": 0.3, "x": 1, "same": 0})
    groups, naming = read.with_short_names(groups_in(folder))
    assert groups[0].label == "mine"
    assert groups[1].label == "timed, learner.alpha=0.1, x=1, same=0"
    assert naming == ""


def test_the_description_of_an_experiment_is_read(tmp_path: Path) -> None:
    assert read.read_folder(new_folder(tmp_path / "a")).description == ""
    told = new_folder(tmp_path / "b", description="what for")
    assert read.read_folder(told).description == "what for"


def test_what_was_killed_in_the_middle_of_a_row_can_be_read(tmp_path: Path, folder: Path) -> None:
    """The journal that a killed writer leaves is rolled back: its last row was never there."""
    add_run(folder, 0)
    killed = tmp_path / "killed"
    with contextlib.closing(sqlite3.connect(folder / TABLE)) as database:
        # So small a cache spills into the table before the end of the transaction.
        database.execute("PRAGMA cache_size = 1")
        for number in range(100):
            values = (str(number), "x" * 10_000)
            database.execute("INSERT INTO meta VALUES (?, ?)", values)
        shutil.copytree(folder, killed)
    assert (killed / "results.sqlite-journal").stat().st_size
    assert len(read.read_folder(killed).rows) == 1


def reader() -> read.Reader:
    return read.Reader(read.Widths(100, 50), thesis.quantities_of)


def test_pictures_of_the_value_are_found_by_their_trial(folder: Path) -> None:
    share = np.zeros((2, 18, 24))
    share[1, 3, 4] = 0.25
    add_run(folder, 0, arrays=pictures([100, 200], share, np.where(share > 0, 7, np.nan)))
    (found,) = reader().pictures(read.read_folder(folder).rows)
    value = found.at(200)
    assert value is not None
    assert value.share[3, 4] == 0.25
    assert value.distance[3, 4] == 7
    assert np.isfinite(value.distance).sum() == 1
    assert found.at(300) is None


def test_a_log_that_is_larger_than_any_can_be_is_not_read(folder: Path) -> None:
    nothing = np.zeros((10_000, 18, 24))
    add_run(folder, 0, arrays=pictures(range(10_000), nothing, nothing))
    reading = reader()
    assert reading.traces(read.read_folder(folder).rows) == []
    assert "they are too large" in reading.unreadable["timed, seed 0"]


def test_pictures_of_another_world_are_refused(folder: Path) -> None:
    nothing = np.zeros((1, 6, 8))
    add_run(folder, 0, arrays=pictures([100], nothing, nothing))
    reading = reader()
    assert reading.traces(read.read_folder(folder).rows) == []
    assert "do not fit its world" in reading.unreadable["timed, seed 0"]
