"""Experiments: what a file asks for, and that every run of it is kept, once, whatever happens."""

import itertools
import json
import os
import select
import signal
import sqlite3
import subprocess
import sys
import textwrap
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.cli import main
from app.documents import axes, experiments, presets, variants
from app.documents.experiments import Experiment, ExperimentError, load, own_seed, parse
from app.documents.tree import MAX_BYTES, Node
from app.experiments import probes, runner, store, task
from app.experiments.crews import Switch, Threads
from app.experiments.record import Record, gist
from app.experiments.runner import Outcome, run_experiment
from app.experiments.seeds import run_seeds
from app.experiments.store import Folder, FolderError
from app.experiments.task import Limits, made_run
from app.metrics.course import Course
from learners import measures
from learners.kernel.state import digest
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.spec import RunSpec
from sim.rng import MAX_SEED
from sim.world import CAPTURE, FLIGHT
from tests.support.costs import try_for_a_moment
from tests.support.endless import ENDLESS
from tests.support.folders import rows
from tests.support.memory import peak_of

ROOT = Path(__file__).resolve().parents[2]
SMALL = """
presets: [timed, standard_q]
set: {world.size: 30, world.step_limit: 80, schedule: null}
grid:
  learner.epsilon: [0.1, 0.3]
trials: 600
seeds: 2
"""


def small(**changes: Any) -> Experiment:
    text = SMALL
    for key, value in changes.items():
        kept = [line for line in text.splitlines() if not line.startswith(f"{key}:")]
        text = "\n".join([*kept, f"{key}: {json.dumps(value)}"])
    return parse(text, "small.yaml")


def carried_out(
    experiment: Experiment, path: Path, resume: bool = False, force: bool = False, workers: int = 2
) -> Outcome:
    with Folder(path, experiment, resume, force) as folder:
        return run_experiment(experiment, folder, Threads(workers))


def lines_of(text: str) -> list[str]:
    with pytest.raises(ExperimentError) as error:
        parse(text, "my.yaml")
    return str(error.value).splitlines()


def values(text: str, key: str = "trials") -> list[Any]:
    experiment = parse(f"presets: [standard_q]\n{text}", "my.yaml")
    return [variant.overrides[key] for variant in experiment.variants]


# --- What a file asks for ------------------------------------------------------------------------


@pytest.mark.parametrize("name", experiments.shipped())
def test_every_shipped_experiment_is_sound(name: str) -> None:
    experiment = load(name)
    assert experiment.description
    assert len(experiment.seeds) >= 3
    assert len({variant.label for variant in experiment.variants}) == len(experiment.variants)


def test_figures_of_the_thesis_come_first() -> None:
    assert list(experiments.shipped())[:3] == ["figure_4_1", "figure_4_2", "figure_4_3"]
    # Three skills from the start have 120 seeds, as their runs differ most.
    assert load("figure_4_1").n_runs == 3 * 30 + 120
    sizes = {variant.spec.world.size for variant in load("figure_4_2").variants}
    assert sizes == {60, 120, 150}
    sensors = {
        (v.spec.world.n_directions, v.spec.world.n_distances) for v in load("figure_4_3").variants
    }
    assert sensors == {(24, 18), (16, 11), (8, 6)}
    of_skills = {
        (s.of_skills.n_directions, s.of_skills.n_distances)
        for s in (v.spec.world for v in load("figure_4_3").variants)
        if (s.n_directions, s.n_distances) == (8, 6)
    }
    assert of_skills == {(8, 6), (24, 18)}


@pytest.mark.parametrize("name", ["figure_4_1", "figure_4_2", "figure_4_3"])
def test_figures_of_the_thesis_have_seeds_enough_to_tell_learners_apart(name: str) -> None:
    assert len(load(name).seeds) == 30
    assert len(load(name, n_seeds=3).seeds) == 3


def test_the_thesis_is_a_point_of_the_timing_plane() -> None:
    specs = [variant.spec for variant in load("timing_plane").variants]
    assert presets.load("timed") in specs


def test_a_grid_is_every_combination() -> None:
    experiment = parse(
        "presets: [timed, standard_q]\n"
        "grid:\n  learner.epsilon: [0.1, 0.2]\n  world.size: [60, 90, 120]\n",
        "my.yaml",
    )
    found = [(v.preset, v.spec.learner.epsilon, v.spec.world.size) for v in experiment.variants]
    assert len(found) == len(set(found)) == 12
    assert experiment.variants[1].label == "timed, learner.epsilon=0.1, world.size=90"
    assert experiment.variants[1].overrides == {"learner.epsilon": 0.1, "world.size": 90}


def test_linked_values_move_together() -> None:
    experiment = parse(
        "presets: [timed]\nlinked:\n"
        "  - schedule.skills.circle_clockwise.at: [3000, 6000]\n"
        "    schedule.skills.avoid.at: {start: 5500, stop: 8500, step: 3000}\n",
        "my.yaml",
    )
    schedules = [variant.spec.schedule for variant in experiment.variants]
    found = [(s.introduced_at("circle_clockwise"), s.introduced_at("avoid")) for s in schedules]
    assert found == [(3000, 5500), (6000, 8500)]


def test_a_preset_has_settings_and_labels_of_its_own() -> None:
    experiment = parse(
        "presets:\n"
        "  - preset: timed\n"
        "    label: mine\n"
        "    set: {schedule.skills.avoid: {at: 20000}}\n"
        "    settings:\n"
        "      - {label: plain}\n"
        "      - {schedule.episodes: [], learner.alpha: 0.2}\n"
        "  - standard_q\n"
        "trials: 70\n",
        "my.yaml",
    )
    labels = [variant.label for variant in experiment.variants]
    assert labels == ["mine, plain", "mine, schedule.episodes=[], learner.alpha=0.2", "standard_q"]
    first, second, third = (variant.spec for variant in experiment.variants)
    assert {spec.trials for spec in (first, second, third)} == {70}
    assert first.schedule.skills["avoid"].at == 20000
    assert first.schedule.skills["avoid"].freeze == 300
    assert (len(first.schedule.episodes), len(second.schedule.episodes)) == (2, 0)


@pytest.mark.parametrize(
    ("values_text", "expected"),
    [
        ("{start: 10, stop: 30, step: 10}", [10, 20, 30]),
        ("{start: 10, stop: 35, step: 10}", [10, 20, 30]),
        ("{start: 7, stop: 7, step: 10}", [7]),
        ("{log_start: 10, log_stop: 1000, count: 3}", [10, 100, 1000]),
        ("{log_start: 1, log_stop: 3, count: 6}", [1, 2, 3]),
    ],
)
def test_ranges_of_whole_numbers(values_text: str, expected: list[int]) -> None:
    found = values(f"grid: {{trials: {values_text}}}")
    assert found == expected
    assert all(isinstance(value, int) for value in found)


def test_ranges_of_numbers_are_as_one_would_write_them() -> None:
    text = "grid: {learner.epsilon: {start: 0.1, stop: 0.7, step: 0.1}}"
    assert values(text, "learner.epsilon") == [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]
    text = "grid: {learner.epsilon: {log_start: 0.001, log_stop: 0.1, count: 3}}"
    assert values(text, "learner.epsilon") == [0.001, 0.01, 0.1]


def test_a_preset_is_looked_for_beside_the_experiment(tmp_path: Path) -> None:
    folder = tmp_path / "a folder with ümlauts"
    folder.mkdir()
    (folder / "mein Räuber.yaml").write_text("extends: timed\ntrials: 30\n", encoding="utf-8")
    file = folder / "größe 1.yaml"
    file.write_text("presets: [mein Räuber.yaml]\n", encoding="utf-8")
    experiment = load(str(file))
    assert experiment.name == "größe 1"
    assert [(v.label, v.spec.trials) for v in experiment.variants] == [("mein Räuber", 30)]


def test_a_whole_preset_may_be_written_in_an_experiment() -> None:
    mine = presets.load("timed", ["schedule.skills.avoid.at=20000", "trials=30000"])
    written = textwrap.indent(presets.dump(mine), "      ")
    text = (
        f"presets:\n  - preset:\n{written}    label: mine\n"
        "  - preset: {extends: timed, trials: 90}\n    label: short\n"
        "grid: {learner.epsilon: [0.1, 0.2]}\n"
    )
    first, second, third, _ = parse(text, "my.yaml").variants
    assert first.spec == mine
    assert (first.label, first.preset) == ("mine, learner.epsilon=0.1", "mine")
    assert second.spec.learner.epsilon == 0.2
    assert third.spec == presets.load("timed", ["trials=90"])


def test_the_example_of_the_reference_is_sound() -> None:
    page = (ROOT / "presets" / "experiments" / "README.md").read_text(encoding="utf-8")
    experiment = parse(page.split("```yaml\n")[1].split("```")[0], "README.md")
    assert len(experiment.variants) == 1 + 3 * 4 * 3 * 2 + 20 + 1


def test_the_reference_lists_every_shipped_experiment_with_its_size() -> None:
    page = (ROOT / "presets" / "experiments" / "README.md").read_text(encoding="utf-8")
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| `")]
    listed = {row[0].strip("`"): (int(row[2]), int(row[3])) for row in rows if row[-1].isdigit()}
    found = {name: load(name) for name in experiments.shipped()}
    assert listed == {name: (len(e.variants), len(e.seeds)) for name, e in found.items()}
    assert list(listed) == list(found)


# --- Wrong files ---------------------------------------------------------------------------------


def test_all_errors_come_at_once_each_with_its_line() -> None:
    text = """
presets:
  - timd
  - preset: timed
    lable: x
    grid:
      schedule.skills.avoid.at: [1, x, 3000000]
      world.sise: [60]
    linked:
      - world.size: [60, 120]
        world.n_distances: {start: 2, stop: 6, step: 2}
seeds: [1, 1, -4]
common_starts: maybe
stop: {success: 70}
trails: 4
"""
    lines = lines_of(text)
    expected = [
        "my.yaml:3: presets.0: value 'timd': is neither a shipped preset nor a file (did you mean"
        " timed?); allowed:",
        "my.yaml:5: presets.1.lable: value 'x': is not a known key (did you mean label?); allowed:",
        "my.yaml:7: schedule.skills.avoid.at: value 'x': must be a whole number; allowed:",
        "my.yaml:7: schedule.skills.avoid.at: value 3000000: must be at most 2000000; allowed:",
        "my.yaml:8: world.sise: value 60: is not a known key (did you mean size?); allowed:",
        "my.yaml:10: presets.1.linked.0: has values that cannot move together (world.size: 2,"
        " world.n_distances: 3); allowed:",
        "my.yaml:12: seeds.1: value 1: is there twice; allowed:",
        "my.yaml:12: seeds.2: value -4: must be at least 0; allowed:",
        "my.yaml:13: common_starts: value 'maybe': must be true or false; allowed:",
        "my.yaml:14: stop.success: value 70: must be a share of captures; allowed:",
        "my.yaml:15: trails: value 4: is not a known key (did you mean trials?); allowed:",
    ]
    assert [line[: len(start)] for line, start in zip(lines, expected, strict=True)] == expected


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("", "my.yaml: is empty; allowed: a mapping of keys"),
        ("- a", "my.yaml:1: value ['a']: must be a mapping; allowed: a mapping of keys"),
        ("seeds: 3", "my.yaml:1: has no presets; allowed: a list of presets"),
        ("presets: timed", "my.yaml:1: presets: value 'timed': must be a list; allowed:"),
        ("presets: [3]", "my.yaml:1: presets.0: value 3: must be a text; allowed:"),
        ("presets: [{preset: {extends: timed}}]", "my.yaml:1: presets.0: value {'preset': {"),
        (
            "presets: [{preset: {extends: timd}, label: a}]",
            "my.yaml:1: presets.0.preset: value {'extends': 'timd'}: is neither a shipped preset",
        ),
        (
            "presets:\n  - label: a\n    preset:\n      extends: timed\n      learner: {alpha: 7}",
            "my.yaml:5: learner.alpha: value 7: must be at most 1; allowed: 0 to 1",
        ),
        ("presets: [{label: x}]", "my.yaml:1: presets.0: value {'label': 'x'}: names no preset;"),
        ("presets: [timed]\nset: 3", "my.yaml:2: set: value 3: must be a mapping; allowed:"),
        ("presets: [timed]\nset: {extends: standard_q}", "my.yaml:2: set.extends: value"),
        ("presets: [timed]\nset: {a..b: 1}", "my.yaml:2: set.'a..b': value 1: is not a key;"),
        ("presets: [timed]\ngrid: {trials: 7}", "my.yaml:2: grid.trials: value 7: has no values;"),
        (
            "presets: [timed]\nmetrics: [aria]",
            "my.yaml:2: metrics.0: value 'aria': is not measured",
        ),
        ("presets: [timed]\nmetrics: [area, area]", "my.yaml:2: metrics.1: value 'area': is there"),
        (
            "presets: [timed]\nmetrics: [steps_to_50]",
            "my.yaml:2: metrics: value ['steps_to_50']: has",
        ),
        (
            "presets: [timed]\ngrid: {trials: {start: 9, stop: 1, step: 1}}",
            "my.yaml:2: grid.trials: value",
        ),
        (
            "presets: [timed]\ngrid: {trials: [1]}\nsettings: [{trials: 2}]",
            "my.yaml:1: trials is varied twice; allowed:",
        ),
    ],
)
def test_wrong_files(text: str, line: str) -> None:
    first = lines_of(text)[0]
    assert first.startswith(line) or first.replace(":1:", ":", 1).startswith(line)


@pytest.mark.parametrize(
    ("value", "wrong"),
    [
        ("0", "must be at least 1"),
        ("2000001", "must be at most 2000000"),
        ("x", "must be a whole number"),
        ("true", "must be a whole number"),
        ("1.5", "must be a whole number"),
    ],
)
def test_wrong_trials_are_one_error(value: str, wrong: str) -> None:
    (line,) = lines_of(f"presets: [timed, standard_q]\ntrials: {value}")
    quoted = "'x'" if value == "x" else value
    assert line == f"my.yaml:2: trials: value {quoted}: {wrong}; allowed: 1 to 2000000"


OTHER_LABEL = "makes a variant named like one of another preset; allowed: a label each"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "grid: {learner.epsilon: [0.1, 0.2, 0.1, 0.1]}",
            ["2: learner.epsilon: value 0.1: is there twice; allowed: each once"],
        ),
        (
            "grid:\n  learner.epsilon:\n    - 0.1\n    - 0.1\n  world.size: [60, 90,\n    60]",
            [
                "5: learner.epsilon: value 0.1: is there twice; allowed: each once",
                "7: world.size: value 60: is there twice; allowed: each once",
            ],
        ),
        (
            "grid: {learner.epsilon: {log_start: 0.1, log_stop: 0.1000001, count: 4}}",
            ["2: learner.epsilon: value 0.1: is there twice; allowed: each once"],
        ),
        (
            "linked:\n  - learner.epsilon: [0.1, 0.1, 0.1]\n    world.size: [60, 90, 60]",
            [
                "3: learner.epsilon: value 0.1: is there twice, with all that moves with it;"
                " allowed: each once"
            ],
        ),
        (
            "settings:\n  - {label: a, trials: 5}\n  - trials: 6\n    label: a",
            ["5: settings.1.label: value 'a': is there twice; allowed: a label each"],
        ),
        (
            "settings:\n  - {trials: 5}\n  - {trials: 5}",
            ["4: settings.1: value {'trials': 5}: is there twice; allowed: each once"],
        ),
        (
            "settings:\n  - {trials: 5}\n  - {label: trials=5, trials: 6}",
            [
                "4: settings.1.label: value 'trials=5': makes a variant named like another;"
                " allowed: settings with a label each"
            ],
        ),
        (
            "grid: {description: [null, 'null']}",
            [
                "2: description: value 'null': makes a variant named like another;"
                " allowed: settings with a label each"
            ],
        ),
    ],
)
def test_a_choice_that_is_there_twice_is_refused_where_it_stands(
    text: str, expected: list[str]
) -> None:
    assert lines_of(f"presets: [timed]\n{text}") == [f"my.yaml:{line}" for line in expected]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("  - timed\n  - timed", "3: presets.1: value 'timed': "),
        (
            "  - timed\n  - preset: timed\ngrid: {learner.epsilon: [0.1, 0.2]}",
            "3: presets.1.preset: value 'timed': ",
        ),
        (
            "  - timed\n  - preset: standard_q\n    label: timed",
            "4: presets.1.label: value 'timed': ",
        ),
        (
            "  - {preset: timed, settings: [{label: 'b, c'}]}\n"
            "  - {preset: timed, label: 'timed, b', settings: [{label: c}]}",
            "3: presets.1.label: value 'timed, b': ",
        ),
    ],
)
def test_a_preset_named_like_another_is_refused_where_it_stands(text: str, expected: str) -> None:
    assert lines_of(f"presets:\n{text}") == [f"my.yaml:{expected}{OTHER_LABEL}"]


LATE = (
    "comes after the last of {0} trials, as another value does, so that both make the same runs;"
    " allowed: 0 to {1}, and one later"
)
CIRCLE = "schedule.skills.circle_clockwise"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"trials: 100\ngrid:\n  {CIRCLE}.at: [3000, 60000]", (f"4: {CIRCLE}.at", 60000, 100)),
        (f"trials: 100\ngrid:\n  {CIRCLE}.at: [100, 101]", (f"4: {CIRCLE}.at", 101, 100)),
        (
            f"grid: {{{CIRCLE}.at: {{start: 0, stop: 90000, step: 6000}}}}",
            (f"2: {CIRCLE}.at", 54000, 48000),
        ),
        (
            f"grid:\n  world.size: [60, 90]\n  {CIRCLE}.at: [50000, 60000, 70000]",
            (f"4: {CIRCLE}.at", 60000, 48000),
        ),
        (
            f"grid:\n  trials: [100, 70000]\n  {CIRCLE}.at: [50000, 60000]",
            (f"4: {CIRCLE}.at", 60000, 100),
        ),
        (
            f"trials: 200\nsteps: 9000\ngrid: {{{CIRCLE}.at: [300, 400]}}",
            (f"4: {CIRCLE}.at", 400, 200),
        ),
        (
            "linked:\n  - schedule.skills.avoid.at: [50000, 60000]\n"
            "    schedule.episodes.1.at: [50000, 60000]",
            ("3: schedule.skills.avoid.at", 60000, 48000),
        ),
        (
            "grid: {schedule.episodes.1.at: [50000, 60000]}",
            ("2: schedule.episodes.1.at", 60000, 48000),
        ),
        (
            f"settings:\n  - {{label: a, {CIRCLE}: {{at: 50000, freeze: 9}}}}\n"
            f"  - label: b\n    {CIRCLE}:\n      freeze: 9\n      at: 60000",
            (f"7: {CIRCLE}.at", 60000, 48000),
        ),
    ],
)
def test_variants_that_differ_only_after_the_last_trial_are_refused(
    text: str, expected: tuple[str, int, int]
) -> None:
    lines = lines_of(f"presets: [timed]\n{text}")
    place, value, n_trials = expected
    said = LATE.format(n_trials, n_trials - 1)
    assert lines == [f"my.yaml:{place}: value {value}: {said}"]


@pytest.mark.parametrize(
    ("text", "n_variants"),
    [
        (f"trials: 100\ngrid: {{{CIRCLE}.at: [50, 99, 60000]}}", 3),  # the last is never
        (f"trials: 70000\ngrid: {{{CIRCLE}.at: [50000, 60000]}}", 2),
        (f"steps: 100\ngrid: {{{CIRCLE}.at: [50000, 60000]}}", 2),  # steps alone count
        (f"trials: 100\nset: {{{CIRCLE}.at: 60000}}\ngrid: {{world.size: [60, 90]}}", 2),
        ("trials: 100\ngrid: {world.size: [60, 90]}", 2),  # the preset's own timers are late
        (
            f"trials: 100\nsettings: [{{label: a}}, {{label: b}}]\ngrid: {{{CIRCLE}.at: [9, 900]}}",
            4,
        ),
        (
            f"linked: [{{{CIRCLE}.at: [50000, 60000], schedule.skills.avoid.at: [100, 200]}}]",
            2,
        ),
    ],
)
def test_what_is_late_and_makes_no_two_runs_the_same_is_allowed(text: str, n_variants: int) -> None:
    assert len(parse(f"presets: [timed]\n{text}", "my.yaml").variants) == n_variants


def test_too_many_runs_are_refused_before_any_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    made = variants_made(monkeypatch)
    axis = "{start: 1, stop: 9000, step: 1}"
    grid = "\n".join(
        f"  {key}: {axis}" for key in ("trials", "world.step_limit", "schedule.skills.avoid.at")
    )
    (line,) = lines_of(f"presets: [timed]\ngrid:\n{grid}")
    assert "asks for 729000000000 variants" in line
    (line,) = lines_of(f"presets: [timed]\ngrid: {{trials: {axis}}}\nseeds: 12")
    assert "108000 runs; allowed: up to 10000 variants and 100000 runs" in line
    assert made == []


def variants_made(monkeypatch: pytest.MonkeyPatch) -> list[None]:
    """Grows by one with every variant that is looked at here, whatever other threads do."""
    made: list[None] = []
    completed, here = presets.completed, threading.get_ident()

    def counted(*args: Any) -> RunSpec:
        if threading.get_ident() == here:
            made.append(None)
        return completed(*args)

    monkeypatch.setattr(presets, "completed", counted)
    return made


def entries(n: int, entry: str) -> str:
    return ", ".join(entry.replace("#", str(index)) for index in range(n))


RANGE = "{start: 0, stop: 9998, step: 1}"
LOG_RANGE = "{log_start: 1, log_stop: 1000000, count: 9999}"
SKILLS = "learner.custom_skills"
TOO_MANY_RUNS = "more than 1000000000000000000 runs; allowed: up to 10000 variants and 100000 runs"
TOO_MANY_VALUES = "values in all; allowed: up to 400000 values"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (f"presets: [timed]\ngrid: {{{entries(490, f'k#: {RANGE}')}}}", TOO_MANY_RUNS),
        (f"presets: [timed]\ngrid: {{{entries(60, f'k#: {LOG_RANGE}')}}}", TOO_MANY_RUNS),
        (f"presets: [timed]\ngrid: {{{entries(600, 'k#: [1, 2]')}}}", TOO_MANY_RUNS),
        (
            f"presets: [timed]\nlinked: [{{{entries(490, f'k#: {RANGE}')}}}]",
            f"asks for 9999 variants with 5209479 {TOO_MANY_VALUES}",
        ),
        (
            f"presets: [{entries(200, f'{{preset: timed, label: l#, grid: {{k#: {RANGE}}}}}')}]",
            "asks for 1999800 variants with 1 seeds each, 1999800 runs; allowed:",
        ),
        (
            f"presets: [{entries(900, 'timed')}]\nsettings: [{entries(500, '{trials: #}')}]",
            "asks for 450000 variants with 1 seeds each, 450000 runs; allowed:",
        ),
        (
            f"presets: [timed]\nset: {{{SKILLS}: {{{entries(1900, 's#: {}')}}}}}\n"
            "grid: {trials: {start: 1, stop: 9000, step: 1}}",
            TOO_MANY_VALUES,
        ),
        (
            f"presets: [timed]\nset: {{{SKILLS}: [{entries(1900, '#')}]}}\n"
            f"settings: [{{label: a}}, {{label: b}}]\ngrid: {{trials: {RANGE}}}",
            "asks for 19998 variants",
        ),
    ],
    ids=["grid", "log_grid", "lists", "linked", "own", "settings", "base", "refused"],
)
def test_what_a_small_file_asks_for_is_counted_before_it_is_made(
    text: str, complaint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert len(text) <= MAX_BYTES
    made = variants_made(monkeypatch)
    assert [complaint in line for line in lines_of(text)] == [True]
    assert made == []
    assert peak_of(lines_of, text) < 24e6


@pytest.mark.parametrize(
    "values_text",
    [
        "{start: 1, stop: 1.0e+300, step: 1}",
        "{start: 0, stop: 1.0e+300, step: 1.0e-300}",
        "{start: -1.7e+308, stop: 1.7e+308, step: 5.0e-324}",
        "{start: 0, stop: 999999999999999999, step: 1}",
        "{log_start: 1, log_stop: 2, count: 999999999999999999}",
        "{log_start: 1.0e-300, log_stop: 1.0e+300, count: 10000}",
    ],
)
def test_endless_ranges_are_refused_at_their_line(values_text: str) -> None:
    (line,) = lines_of(f"presets: [timed]\ngrid:\n  trials: {values_text}")
    assert line.startswith("my.yaml:3: grid.trials: value {")
    assert line.endswith(": has too many values; allowed: fewer than 10000")


def test_every_seed_can_be_written() -> None:
    experiment = parse(f"presets: [timed]\nseeds: [0, {MAX_SEED}]", "my.yaml")
    assert experiment.seeds == (0, MAX_SEED)


def test_a_number_of_thousands_of_digits_is_refused() -> None:
    (line,) = lines_of(
        f"presets: [timed]\ngrid: {{trials: {{start: 0, stop: {'9' * 5000}, step: 1}}}}"
    )
    assert "has too many digits; allowed: at most 19" in line


@given(
    n_presets=st.integers(1, 3),
    shared=st.lists(st.integers(1, 60), max_size=3),
    linked=st.tuples(st.integers(0, 30), st.integers(1, 60)),
    n_settings=st.integers(0, 12),
    own=st.integers(0, 60),
    n_seeds=st.integers(1, 40),
)
def test_whatever_is_asked_for_no_more_is_made_than_is_allowed(
    n_presets: int,
    shared: list[int],
    linked: tuple[int, int],
    n_settings: int,
    own: int,
    n_seeds: int,
) -> None:
    keys = ("trials", "world.step_limit", "learner.initial_q")
    lines = [f"seeds: {n_seeds}", "presets:"]
    for index in range(n_presets):
        lines.append(f"  - preset: standard_q\n    label: l{index}")
        if own:
            lines.append(
                f"    grid: {{world.size: {{start: 60, stop: {59 + own}, step: 1}},"
                f" learner.epsilon: {{start: 0, stop: {own / 100}, step: 0.01}}}}"
            )
    if shared:
        lines.append("grid:")
        lines += [
            f"  {key}: {{start: 1, stop: {n}, step: 1}}"
            for key, n in zip(keys, shared, strict=False)
        ]
    if linked[0]:
        column = f"{{log_start: 0.1, log_stop: 1, count: {1 + linked[1]}}}"
        lines.append(f"linked: [{{{entries(linked[0], f'{SKILLS}.s#.avoid: {column}')}}}]")
    if n_settings:
        lines.append(f"settings: [{entries(n_settings, '{label: c#, learner.alpha: 0.#}')}]")
    n_made = 0
    iterated = axes.Range.__iter__

    def counted(values: axes.Range) -> Iterator[Node]:
        nonlocal n_made
        for node in iterated(values):
            n_made += 1
            yield node

    with pytest.MonkeyPatch.context() as patch:
        for name, limit in (("MAX_VARIANTS", 99), ("MAX_RUNS", 990), ("MAX_VALUES", 3_000)):
            patch.setattr(variants, name, limit)
        patch.setattr(axes.Range, "__iter__", counted)
        made = variants_made(patch)
        try:
            experiment = parse("\n".join(lines), "my.yaml")
        except ExperimentError as error:
            refusals = [p for p in error.problems if p.message.startswith("asks for ")]
            assert len(refusals) == 1 - bool(made)
        else:
            assert len(made) == len(experiment.variants)
            assert experiment.n_runs <= 990
    assert len(made) <= 99
    assert n_made <= (3_000 if made else 0)


def test_what_is_wrong_with_every_variant_is_not_looked_for_in_all_of_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made = variants_made(monkeypatch)
    (line,) = lines_of(
        "presets: [timed]\nset: {learner.alpha: 7}\ngrid: {trials: {start: 1, stop: 9000, step: 1}}"
    )
    assert line.startswith("my.yaml:2: learner.alpha: value 7: must be at most 1; allowed:")
    assert 100 < len(made) < 5000


def test_a_label_is_bounded() -> None:
    text = f"presets: [timed]\ngrid:\n  ? {SKILLS}.{'a' * 60_000}\n  : [null]\n"
    (line,) = lines_of(text)
    assert line == (
        "my.yaml:1: has a variant whose label is 60026 characters long; allowed: up to 2000,"
        " or settings with a label"
    )


def test_however_it_is_named_a_preset_is_read_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[str] = []
    document_of = presets.document_of

    def counted(data: bytes | str, source: str, problems: list[Any]) -> Node | None:
        read.append(source)
        return document_of(data, source, problems)

    monkeypatch.setattr(presets, "document_of", counted)
    presets._document.cache_clear()  # of what other tests have read
    (tmp_path / "below.yaml").write_text("extends: timed\ntrials: 30\n")
    (tmp_path / "mine.yaml").write_text("extends: below.yaml\nworld: {size: 30}\n")
    names = entries(50, "{preset: ./mine.yaml, label: a#}, {preset: mine.yaml, label: b#}")
    written = entries(50, "{preset: {extends: below.yaml, world: {size: 40}}, label: c#}")
    experiment = parse(f"presets: [{names}]", "my.yaml", tmp_path)
    assert len(experiment.variants) == 100
    assert {(v.spec.trials, v.spec.world.size) for v in experiment.variants} == {(30, 30)}
    assert len(read) == len(set(read)) == 4
    read.clear()
    presets._document.cache_clear()
    experiment = parse(f"presets: [{written}]", "my.yaml", tmp_path)
    assert {v.spec.trials for v in experiment.variants} == {30}
    assert len(read) == len(set(read)) == 3


def test_presets_are_bounded_in_all(tmp_path: Path) -> None:
    for index in range(14):
        padding = "#" * (MAX_BYTES - 100)
        (tmp_path / f"p{index}.yaml").write_text(f"extends: timed\n{padding}\n")
    with pytest.raises(ExperimentError) as error:
        parse(f"presets: [{entries(14, 'p#.yaml')}]", "my.yaml", tmp_path)
    (first, *_), n_refused = str(error.value).splitlines(), len(error.value.problems)
    assert first == (
        "my.yaml:1: presets.10: value 'p10.yaml': is one preset too many; allowed: 655360 bytes"
        " in all of them"
    )
    assert n_refused == 4


def test_an_experiment_knows_how_it_was_named(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("presets: [timed]\n")
    assert load("figure_4_1").source == "figure_4_1"
    assert load(str(file), n_seeds=2).source == str(file)
    assert parse("presets: [timed]", "my.yaml").source == ""


def test_a_name_that_nothing_has() -> None:
    with pytest.raises(ExperimentError, match=r"did you mean figure_4_1\?\); allowed: figure_4_1"):
        load("figure_41")


# --- Seeds and starts ----------------------------------------------------------------------------


def test_variants_share_their_starts() -> None:
    experiment = small()
    assert {tuple(experiment.seeds_of(v)) for v in experiment.variants} == {(0, 1)}
    starts = {
        tuple(Run(variant.spec, 1).start_of(trial) for trial in range(50))
        for variant in experiment.variants
    }
    assert len(starts) == 1


def test_where_starts_are_not_shared_no_two_runs_have_the_same_seed() -> None:
    experiment = small(common_starts=False, seeds=500)
    seeds = [seed for _, seed in experiment.runs()]
    assert len(seeds) == len(set(seeds)) == experiment.n_runs == 2000
    assert set(seeds).isdisjoint(range(500))
    assert all(0 <= seed < 2**63 for seed in seeds)
    starts = {
        tuple(Run(v.spec, s).start_of(t) for t in range(20)) for v, s in list(experiment.runs())[:8]
    }
    assert len(starts) == 8


def test_seeds_may_be_a_range_with_both_ends() -> None:
    assert list(small(seeds={"start": 5, "stop": 8}).seeds) == [5, 6, 7, 8]
    assert list(small(seeds={"start": 5, "stop": 11, "step": 3}).seeds) == [5, 8, 11]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("seeds: {start: 9, stop: 8}", "is no range; allowed: start up to stop"),
        ("seeds: {start: 0, stop: 200000}", "has 200001 seeds; allowed: up to 100000"),
        ("seeds: {start: 1}", "my.yaml:2: seeds"),
        ("seeds: {start: 1, stop: 2, step: 0}", "my.yaml:2: seeds"),
        ("steps: 50\nhorizon: 60", "horizon: value 60: lies beyond the end of all runs;"),
        ("horizon: 0", "my.yaml:2: horizon: value 0"),
        ("greedy_every: -1", "my.yaml:2: greedy_every: value -1"),
    ],
)
def test_seeds_and_horizons_that_cannot_be_are_refused(text: str, said: str) -> None:
    with pytest.raises(ExperimentError) as refused:
        parse(f"presets: [timed]\n{text}\n", "my.yaml")
    assert said in str(refused.value)


OWN_SEEDS = """
presets: [timed, {preset: hierarchical_3, seeds: {start: 100, stop: 104}}]
seeds: [7, 3]
trials: 300
"""


def test_a_preset_may_have_seeds_of_its_own() -> None:
    experiment = parse(OWN_SEEDS, "my.yaml")
    runs = [(variant.label, seed) for variant, seed in experiment.runs()]
    assert len(runs) == experiment.n_runs == 7
    assert runs[:3] == [("timed", 7), ("hierarchical_3", 100), ("timed", 3)]
    assert experiment.seeds_in_words == "2 to 5 seeds"


def test_a_number_of_seeds_counts_up_from_the_first_of_each() -> None:
    experiment = parse(OWN_SEEDS, "my.yaml", n_seeds=3)
    assert [list(experiment.seeds_of(v)) for v in experiment.variants] == [
        [7, 8, 9],
        [100, 101, 102],
    ]
    with pytest.raises(ExperimentError, match=f"allowed: up to {MAX_SEED}"):
        parse(f"presets: [timed]\nseeds: [{MAX_SEED}]\n", "my.yaml", n_seeds=2)


@pytest.mark.parametrize(
    ("text", "horizon"),
    [("", None), ("horizon: 70", 70), ("steps: 90", 90), ("steps: 90\nhorizon: 70", 70)],
)
def test_where_steps_alone_count_they_are_the_horizon(text: str, horizon: int | None) -> None:
    assert parse(f"presets: [timed]\n{text}\n", "my.yaml").horizon_steps == horizon
    with_trials = parse(f"presets: [timed]\ntrials: 50\n{text}\n", "my.yaml").horizon_steps
    assert with_trials == (70 if "horizon" in text else None)


def test_seeds_of_ones_own_stay_when_there_are_more() -> None:
    few, many = small(common_starts=False, seeds=2), small(common_starts=False, seeds=9)
    for variant in few.variants:
        assert tuple(few.seeds_of(variant)) == tuple(many.seeds_of(variant))[:2]


def test_a_seed_for_two_runs_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experiments, "own_seed", lambda label, seed: own_seed("", seed))
    with pytest.raises(ExperimentError, match="one seed for two runs"):
        small(common_starts=False)


def test_listed_seeds_and_other_ones_by_option() -> None:
    assert tuple(small(seeds=[7, 3]).seeds) == (7, 3)
    assert tuple(parse(SMALL, "small.yaml", n_seeds=3).seeds) == (0, 1, 2)


# --- Running -------------------------------------------------------------------------------------


def test_every_run_has_a_row_and_arrays(tmp_path: Path) -> None:
    experiment, path = small(), tmp_path / "new" / "größe 1"
    outcome = carried_out(experiment, path)
    assert (outcome.total, outcome.done, outcome.failed) == (8, 8, 0)
    assert (path / "experiment.yaml").read_text(encoding="utf-8") == experiment.text.decode()
    found = rows(path)
    assert list(found[0]) == list(store.COLUMNS)
    assert {(row["variant"], row["seed"]) for row in found} == {
        (variant.label, seed) for variant in experiment.variants for seed in (0, 1)
    }
    assert sorted(p.name for p in (path / "arrays").iterdir()) == [
        f"{row['key']}.npz" for row in found
    ]
    for row in found:
        assert (row["status"], row["error"], row["trials"]) == ("done", None, 600)
        assert row["captures"] + row["flights"] + row["timeouts"] == 600
        arrays = np.load(path / "arrays" / f"{row['key']}.npz")
        assert arrays["outcome"].dtype == np.int8
        assert arrays["steps"].dtype == np.int32
        assert int(arrays["steps"].sum()) == row["steps"]
        assert int((arrays["outcome"] == CAPTURE).sum()) == row["captures"]
        assert int((arrays["outcome"] == FLIGHT).sum()) == row["flights"]
        assert 0 <= row["greedy_success"] <= 1
        assert row["mean_hunt_length"] == pytest.approx(row["steps"] / 600)
    database = sqlite3.connect(path / "results.sqlite")
    meta = dict(database.execute("SELECT key, value FROM meta"))
    database.close()
    assert meta["schema_version"] == str(store.SCHEMA_VERSION)
    assert (meta["name"], meta["seeds"]) == ("small", "[0, 1]")


def test_digests_are_those_of_pounce_run(tmp_path: Path) -> None:
    experiment = small(common_starts=False)
    carried_out(experiment, tmp_path / "a")
    found = rows(tmp_path / "a")
    for variant in experiment.variants:
        seeds = list(experiment.seeds_of(variant))
        mine = {row["seed"]: row for row in found if row["variant"] == variant.label}
        for result in run_seeds(variant.spec, seeds, Threads(2)):
            row = mine[result.record.seed]
            assert row["digest"] == result.record.digest
            assert row["final_reward"] == result.record.values["final_reward"]


def test_the_number_of_workers_makes_no_difference(tmp_path: Path) -> None:
    for workers in (1, 4):
        carried_out(small(), tmp_path / str(workers), workers=workers)
    one, four = (
        [r | {"seconds": 0, "ended_at": ""} for r in rows(tmp_path / name)] for name in ("1", "4")
    )
    assert one == four


def test_introductions_are_kept(tmp_path: Path) -> None:
    text = (
        "presets: [timed]\ntrials: 60\nset: {world.size: 30, world.step_limit: 40,"
        " schedule: {skills: {circle_clockwise: {at: 20}, avoid: {at: 40}}}}\n"
    )
    carried_out(parse(text, "my.yaml"), tmp_path / "a")
    (row,) = rows(tmp_path / "a")
    arrays = np.load(tmp_path / "a" / "arrays" / f"{row['key']}.npz")
    assert arrays["introduced"].tolist() == ["approach", "circle_clockwise", "avoid"]
    trials, steps = arrays["introductions"].T
    assert trials.tolist() == [0, 20, 40]
    assert steps.tolist() == [int(arrays["steps"][:trial].sum()) for trial in trials]


def test_a_budget_of_steps_ends_a_run_whatever_its_trials(tmp_path: Path) -> None:
    text = "presets: [standard_q]\nset: {world.size: 30, trials: 5}\nsteps: 3000\n"
    experiment = parse(text, "my.yaml")
    carried_out(experiment, tmp_path / "a")
    (row,) = rows(tmp_path / "a")
    assert row["steps"] == 3000
    assert row["trials"] > 5
    run = Run(experiment.variants[0].spec, 0)
    run.advance(max_steps=3000, until_trial=MAX_TRIALS)
    assert row["digest"] == digest(run.state)


def test_a_run_stops_when_it_is_good_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    experiment = small(trials=3000, stop={"success": 0.2, "trials": 100, "every": 50})
    spec, stop = experiment.variants[3].spec, experiment.stop
    run = made_run(spec, 0, Limits(spec.trials, stop=stop))
    assert run is not None
    assert 100 <= run.trial < 3000
    assert run.trial % 50 == 0
    assert measures.endings(run.state, 100).captures >= 20
    whole = Run(spec, 0)
    for trial in range(100, run.trial, 50):
        whole.advance(until_trial=trial)
        assert measures.endings(whole.state, 100).captures < 20
    monkeypatch.setattr(task, "_SLICE_STEPS", 997)
    again = made_run(spec, 0, Limits(spec.trials, stop=stop))
    assert again is not None
    assert digest(again.state) == digest(run.state)


# --- Whatever happens ----------------------------------------------------------------------------


class Stopped(BaseException):
    """Ends a program at a place of one's choice, like a kill."""


def test_resume_after_a_crash_between_arrays_and_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    experiment, path = small(), tmp_path / "a"
    write, written = Folder.write, []

    def crash(self: Folder, record: Record) -> None:
        if len(written) == 3:
            raise Stopped
        written.append(record.key)
        write(self, record)

    monkeypatch.setattr(Folder, "write", crash)
    with pytest.raises(Stopped):
        carried_out(experiment, path)
    monkeypatch.undo()
    assert {row["key"] for row in rows(path)} == set(written)
    assert len(list((path / "arrays").glob("*.npz"))) > 3
    (path / "arrays" / ".half.tmp").write_bytes(b"half")
    before = {row["key"]: row for row in rows(path)}

    made: list[int] = []
    monkeypatch.setattr(task, "measured", counted(made, task.measured))
    outcome = carried_out(experiment, path, resume=True)
    assert (outcome.done, len(made)) == (8, 5)
    after = {row["key"]: row for row in rows(path)}
    assert after | before == after
    assert not list((path / "arrays").glob(".*"))
    carried_out(experiment, tmp_path / "whole")
    assert [r["digest"] for r in rows(path)] == [r["digest"] for r in rows(tmp_path / "whole")]


def counted(made: list[int], function: Any) -> Any:
    def count(course: Course, *others: Any) -> Any:
        made.append(course.run.seed)
        return function(course, *others)

    return count


def test_resume_makes_no_run_twice_and_takes_more_seeds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    carried_out(small(), tmp_path / "a")
    made: list[int] = []
    monkeypatch.setattr(task, "measured", counted(made, task.measured))
    assert carried_out(small(), tmp_path / "a", resume=True).done == 8
    assert made == []
    more = parse(SMALL, "small.yaml", n_seeds=3)
    assert carried_out(more, tmp_path / "a", resume=True).done == 12
    assert made == [2, 2, 2, 2]


def test_a_run_that_fails_is_recorded_and_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = task.measured

    def fail(course: Course, metrics: Any) -> dict[str, Any]:
        if course.run.seed == 1 and course.run.spec.learner.skills:
            raise RuntimeError("no luck")
        return measured(course, metrics)

    monkeypatch.setattr(task, "measured", fail)
    outcome = carried_out(small(), tmp_path / "a")
    assert (outcome.done, outcome.failed) == (6, 2)
    failed = [row for row in rows(tmp_path / "a") if row["status"] == "failed"]
    assert len(failed) == 2
    assert all("RuntimeError: no luck" in row["error"] for row in failed)
    assert {row["preset"] for row in failed} == {"timed"}
    monkeypatch.undo()
    outcome = carried_out(small(), tmp_path / "a", resume=True)
    assert (outcome.done, outcome.failed) == (8, 0)
    assert {row["status"] for row in rows(tmp_path / "a")} == {"done"}


def test_a_full_disk_stops_all_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write = store.write_whole

    def full(path: Path, data: bytes) -> None:
        with monkeypatch.context() as patch:
            if path.parent.name == "arrays":
                patch.setattr(os, "fsync", no_space)
            write(path, data)

    def no_space(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(store, "write_whole", full)
    with pytest.raises(FolderError, match="No space left"):
        carried_out(small(), tmp_path / "a")
    assert rows(tmp_path / "a") == []
    assert not list((tmp_path / "a" / "arrays").iterdir())


def test_stopping_ends_all_runs_within_a_moment(tmp_path: Path) -> None:
    before = set(threading.enumerate())
    experiment = parse(ENDLESS, "small.yaml")
    switch, seen = Switch(), []
    with Folder(tmp_path / "a", experiment, False, False) as folder:

        def look(progress: runner.Progress) -> None:
            seen.append(progress)
            if progress.steps and progress.running == 2:
                switch.end()

        outcome = run_experiment(experiment, folder, Threads(2, switch), look)
    assert outcome.done + outcome.failed < outcome.total
    assert (outcome.done, outcome.failed) == (0, 0)
    assert seen[-1].running == 0
    # Those of a lab that other tests share come and go.
    begun = set(threading.enumerate()) - before
    assert not [thread for thread in begun if thread.name.startswith("run")]


def test_progress_ends_with_everything(tmp_path: Path) -> None:
    seen: list[runner.Progress] = []
    experiment = small()
    with Folder(tmp_path / "a", experiment, False, False) as folder:
        run_experiment(experiment, folder, Threads(2), seen.append)
    last = seen[-1]
    assert (last.total, last.done, last.failed, last.running) == (8, 8, 0, 0)
    assert last.share == pytest.approx(1)
    assert last.steps == sum(row["steps"] for row in rows(tmp_path / "a"))


class PausedOnTheWay(Switch):
    """Pauses once, in a thread that makes a run: who looks on may look when all runs are over."""

    def __init__(self) -> None:
        super().__init__()
        self._asked = itertools.count(1)

    def wanted(self) -> bool:
        if next(self._asked) == 3:
            self.pause()
        return super().wanted()


def test_while_it_is_paused_nothing_is_learned(tmp_path: Path) -> None:
    experiment = small(trials=300_000, seeds=1)
    switch, seen, stood_at = PausedOnTheWay(), [], []
    with Folder(tmp_path / "a", experiment, False, False) as folder:

        def look(progress: runner.Progress) -> None:
            if not switch.paused:
                return
            seen.append(progress.steps)
            # A slice that had begun may still end; after that nothing moves.
            if seen[-6:] == 6 * [seen[-1]] or len(seen) > 300:
                stood_at.append(progress)
                switch.go_on()

        outcome = run_experiment(experiment, folder, Threads(2, switch), look)
    (stood,) = stood_at
    assert len(seen) <= 300
    assert stood.done < 4
    assert stood.steps < sum(row["steps"] for row in rows(tmp_path / "a"))
    assert (outcome.done, outcome.total) == (4, 4)
    carried_out(experiment, tmp_path / "b")
    assert [r["digest"] for r in rows(tmp_path / "a")] == [
        r["digest"] for r in rows(tmp_path / "b")
    ]


def test_an_experiment_ends_while_it_is_paused(tmp_path: Path) -> None:
    experiment = parse(ENDLESS, "small.yaml")
    switch = Switch()
    with Folder(tmp_path / "a", experiment, False, False) as folder:

        def look(progress: runner.Progress) -> None:
            (switch.end if switch.paused else switch.pause)()

        outcome = run_experiment(experiment, folder, Threads(2, switch), look)
    assert outcome.done + outcome.failed < outcome.total


def test_only_the_metrics_that_are_asked_for_are_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(probes, "greedy_of", lambda run: 1 / 0)
    experiment = small(metrics=["area", "steps_to_50"])
    assert experiment.metrics == ("area", "steps_to_50")
    carried_out(experiment, tmp_path / "a")
    for row in rows(tmp_path / "a"):
        assert row["status"] == "done"
        assert row["area"] is not None
        assert row["final_reward"] is row["greedy_success"] is row["captures"] is None
        assert row["digest"]
        assert row["steps"]


def test_the_value_is_pictured_when_skills_join_half_way_and_at_the_end(tmp_path: Path) -> None:
    text = (
        "presets: [timed]\nset: {world.size: 30, schedule.skills.circle_clockwise.at: 100,"
        " schedule.skills.avoid.at: 200}\ntrials: 1000\n"
    )
    carried_out(parse(text, "small.yaml"), tmp_path)
    (row,) = rows(tmp_path)
    with np.load(tmp_path / "arrays" / f"{row['key']}.npz") as arrays:
        assert arrays["moments"].tolist() == [100, 200, 500, 1000]
        share, distance = arrays["value_share"], arrays["value_distance"]
    assert share.shape == distance.shape == (4, 18, 24)
    assert np.array_equal(np.isnan(distance), share == 0)
    assert (np.diff((share > 0).sum(axis=(1, 2))) >= 0).all()


# --- Folders -------------------------------------------------------------------------------------


def test_results_are_not_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "a"
    carried_out(small(), path)
    before = rows(path)
    with pytest.raises(FolderError, match="--resume to go on, or --force to begin again"):
        carried_out(small(), path)
    other = small(seeds=1)
    with pytest.raises(FolderError, match="results of another experiment"):
        carried_out(other, path, resume=True)
    assert rows(path) == before
    assert carried_out(other, path, force=True).done == 4
    assert len(rows(path)) == len(list((path / "arrays").iterdir())) == 4


def test_force_spares_what_is_no_result(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    for resume, force in ((False, False), (True, False), (False, True)):
        with pytest.raises(FolderError):
            carried_out(small(), tmp_path, resume, force)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


@pytest.mark.parametrize("found", ["7", None])
def test_another_schema_is_refused(tmp_path: Path, found: str | None) -> None:
    path = tmp_path / "a"
    carried_out(small(), path)
    database = sqlite3.connect(path / "results.sqlite")
    with database:
        if found is None:
            database.execute("DROP TABLE meta")
        else:
            database.execute("UPDATE meta SET value = ? WHERE key = 'schema_version'", (found,))
    database.close()
    word = "without a version" if found is None else "of version 7"
    with pytest.raises(
        FolderError, match=f"{word}, and this pounce reads version {store.SCHEMA_VERSION}"
    ):
        carried_out(small(), path, resume=True)


def test_a_table_that_is_none(tmp_path: Path) -> None:
    carried_out(small(), tmp_path / "a")
    (tmp_path / "a" / "results.sqlite").write_text("no table, but a longer text" * 100)
    with pytest.raises(FolderError, match="not a database"):
        carried_out(small(), tmp_path / "a", resume=True)


def test_a_preset_that_has_changed_is_refused(tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    text = "extends: timed\ntrials: 20\nschedule: null\nworld: {size: 30}\n"
    mine.write_text(text)
    carried_out(parse("presets: [mine.yaml]", "my.yaml", tmp_path), tmp_path / "a")
    mine.write_text(text + "description: other\n")
    with pytest.raises(FolderError, match="of a preset that has changed"):
        carried_out(parse("presets: [mine.yaml]", "my.yaml", tmp_path), tmp_path / "a", resume=True)


# --- The command ---------------------------------------------------------------------------------


PATIENCE_S = 60.0
TELLING = """
import sys
from app.cli import main
from app.experiments import store

save = store.Folder.save


def told(folder, key, arrays):
    save(folder, key, arrays)
    print("a run is over", flush=True)


store.Folder.save = told
sys.exit(main.main(sys.argv[1:]))
"""


def process(*argv: str) -> "subprocess.Popen[str]":
    """The command in a process of its own, which says whenever a run is over."""
    return subprocess.Popen(
        [sys.executable, "-c", TELLING, *argv],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # Whoever runs the tests in the background has them ignore interrupts.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "größe 1.yaml").write_text(SMALL, encoding="utf-8")
    return "größe 1.yaml"


def test_the_command_says_what_it_did(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["experiment", file, "--json", "--seeds", "1"]) == 0
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert err == ""
    assert (document["runs"], document["done"], document["failed"]) == (4, 4, 0)
    assert document["folder"] == os.path.join("results", "größe 1")
    assert main.main(["experiment", file]) == 2
    assert "--resume" in capsys.readouterr().err
    assert main.main(["experiment", file, "--resume"]) == 0
    assert "8 of 8 runs done" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("message", "shown"),
    [
        ("no luck", "RuntimeError: no luck"),
        (
            "no luck:\n    with this\nnor with that",
            "RuntimeError: no luck: with this nor with that",
        ),
        ("", "RuntimeError"),
    ],
)
def test_a_failed_run_is_in_the_exit_code(
    file: str,
    message: str,
    shown: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(run: Run, metrics: Any) -> dict[str, Any]:
        raise RuntimeError(message)

    monkeypatch.setattr(task, "measured", fail)
    assert main.main(["experiment", file]) == 1
    said = capsys.readouterr().out
    assert "8 runs failed; the first: timed, learner.epsilon=" in said
    assert f"seed 0: {shown}\n" in said


def test_an_error_without_a_traceback_is_said_as_it_is() -> None:
    assert gist("its arrays could not be read: no such file\n") == (
        "its arrays could not be read: no such file"
    )


def test_a_dry_run_makes_nothing(
    file: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    try_for_a_moment(monkeypatch)
    assert main.main(["experiment", file, "--dry-run", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["runs"], document["variants"]) == (8, 4)
    assert document["steps"] > 0
    assert document["seconds"] > 0
    assert document["disk_bytes"] > 0
    assert not Path("results").exists()


def test_a_dry_run_says_how_many_variants_are_drawn_at_random(
    file: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    try_for_a_moment(monkeypatch)
    text = Path(file).read_text("utf-8")
    sample = "sample: {count: 2, keys: {learner.gamma: {start: 0.8, stop: 0.9}}}\n"
    Path(file).write_text(text + sample, "utf-8")
    assert main.main(["experiment", file, "--dry-run"]) == 0
    assert "16 runs (8 variants, 8 drawn at random, 2 seeds)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "EXPERIMENT is missing"),
        (["figure_4_1", "--seeds", "0"], "--seeds: '0' is not allowed"),
        (["figure_4_1", "--workers", "x"], "--workers: 'x' is not allowed"),
        (["figure_4_1", "--out", ""], "--out: '' is not allowed"),
        (["figure_4_1", "--resume", "--force"], "exclude each other"),
        (["nothing"], "is neither a shipped experiment nor a file"),
    ],
)
def test_wrong_words(words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["experiment", *words]) == 2
    assert complaint in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGKILL])
def test_whatever_ends_the_program_finished_runs_stay(
    file: str, ending: signal.Signals, tmp_path: Path
) -> None:
    text = SMALL.replace("trials: 600", "trials: 20000").replace("seeds: 2", "seeds: 200")
    Path(file).write_text(text, encoding="utf-8")
    program = process("experiment", file, "--out", "a b")
    table = tmp_path / "a b" / "results.sqlite"
    assert program.stdout is not None
    is_told, _, _ = select.select([program.stdout], [], [], PATIENCE_S)
    assert is_told
    assert program.stdout.readline() == "a run is over\n"
    program.send_signal(ending)
    program.communicate(timeout=PATIENCE_S)
    assert program.returncode == (130 if ending == signal.SIGINT else -signal.SIGKILL)
    assert table.exists()
    kept = rows(tmp_path / "a b")
    arrays = {path.stem for path in (tmp_path / "a b" / "arrays").glob("*.npz")}
    assert {row["key"] for row in kept} <= arrays
    assert len(arrays) - len(kept) <= len(os.sched_getaffinity(0)) + 1
    for key in arrays:
        assert np.load(tmp_path / "a b" / "arrays" / f"{key}.npz")["outcome"].size == 20000
