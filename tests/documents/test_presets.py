"""Presets: what is shipped, what is read, what is refused in which words, what is written."""

import difflib
import itertools
import os
import re
import shlex
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import get_args, get_origin

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from app.documents import experiments, presets
from app.documents.presets import dump, load, parse, shipped
from app.documents.tree import PresetError
from learners.kernel.rows import MAX_ACTIONS
from learners.learner_spec import LearnerSpec
from learners.names import MAX_TRIALS, SkillName
from learners.schedule_spec import EpisodeSpec, ScheduleSpec, SkillTimer
from learners.skill_spec import SkillWeights
from learners.skills import SKILLS, SPIRAL_PENALTY, LocalReward
from learners.spec import RunSpec
from sim.spec import WorldSpec
from tests.support.memory import peak_of

PAGE = Path(presets.__file__).parents[2] / "presets" / "README.md"

SOUND = "learner: {options: moves, alpha: 0.6}\ntrials: 10\n"
"""The least that a preset can say; on two lines, to which tests add."""


def refusal(text: bytes | str) -> PresetError:
    with pytest.raises(PresetError) as caught:
        parse(text, "mine.yaml")
    error = caught.value
    assert error.problems
    assert str(error).splitlines() == [str(problem) for problem in error.problems]
    assert "Input should" not in str(error)
    return error


def complaints(text: bytes | str) -> list[str]:
    """What is wrong with a text, without the name of the file."""
    return [line.removeprefix("mine.yaml:") for line in str(refusal(text)).splitlines()]


def wrong_places(text: bytes | str) -> list[tuple[int | None, str]]:
    return [(problem.line, problem.key) for problem in refusal(text).problems]


def load_refusal(name: str | Path, *settings_: str) -> list[str]:
    with pytest.raises(PresetError) as caught:
        load(str(name), settings_)
    return str(caught.value).splitlines()


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


# --- What is shipped -----------------------------------------------------------------------------

THREE = ("approach", "circle_clockwise", "avoid")

THE_THESIS = {
    "standard_q": ("moves", 0.6, 24_000),
    "hierarchical_2": (("approach", "circle_clockwise"), 0.1, 48_000),
    "hierarchical_3": (THREE, 0.1, 24_000),
    "timed": (THREE, 0.1, 48_000),
}


def test_the_thesis_comes_first() -> None:
    assert list(shipped())[:4] == list(THE_THESIS)
    assert list(shipped())[4:] == sorted(list(shipped())[4:])


@pytest.mark.parametrize("name", THE_THESIS)
def test_shipped_presets_are_the_learners_of_the_thesis(name: str) -> None:
    spec = load(name)
    assert (spec.learner.options, spec.learner.alpha, spec.trials) == THE_THESIS[name]
    assert spec.world == WorldSpec()
    assert spec.learner == LearnerSpec(
        options=spec.learner.options,
        alpha=spec.learner.alpha,
        skill_alpha=0.6,
        gamma=0.9,
        epsilon=0.1,
        initial_q=0.0,
        custom_skills={},
    )
    if name != "timed":
        assert spec.schedule == ScheduleSpec()


def test_the_world_is_that_of_the_thesis() -> None:
    assert WorldSpec() == WorldSpec(
        size=120,
        n_directions=24,
        n_distances=18,
        skill_n_directions=None,
        skill_n_distances=None,
        ring_exponent=1.5,
        vision_radius=27.0,
        start_radius=(10.0, 60.0),
        step_limit=500,
        capture_reward=100.0,
        flight_reward=-50.0,
    )


def test_the_timed_schedule_is_that_of_section_4_3_1() -> None:
    assert load("timed").schedule == ScheduleSpec(
        safe_introduction=True,
        skills={
            "approach": SkillTimer(at=0, freeze=300),
            "circle_clockwise": SkillTimer(at=12_000, freeze=300),
            "avoid": SkillTimer(at=14_500, freeze=300),
        },
        episodes=(
            EpisodeSpec(skill="circle_clockwise", duration=2_000, probability=0.95),
            EpisodeSpec(skill="avoid", duration=2_000, probability=0.30),
        ),
    )


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_preset_is_sound_and_says_what_it_is(name: str) -> None:
    assert load(name).description
    assert parse(dump(load(name)), "dumped") == load(name)


# --- Wrong values: file, line, key, value, and what is allowed -----------------------------------

WRONG_VALUES = [
    ("world: {size: 12}", "3: world.size: value 12: must be at least 20; allowed: 20 to 400"),
    (
        "world: {size: 12.5}",
        "3: world.size: value 12.5: must be a whole number; allowed: 20 to 400",
    ),
    (
        "world: {size: true}",
        "3: world.size: value true: must be a whole number; allowed: 20 to 400",
    ),
    (
        "world: {size: 1e2}",
        "3: world.size: value 100.0: must be a whole number; allowed: 20 to 400",
    ),
    (
        "world: {n_directions: 12}",
        "3: world.n_directions: value 12: must be a multiple of 8; allowed: 8 to 48, multiples of",
    ),
    (
        "world:\n  vision_radius: -27",
        "4: world.vision_radius: value -27: must be at least 0; allowed: 0 to 1000",
    ),
    (
        "world:\n  capture_reward: .nan",
        "4: world.capture_reward: value nan: must be finite; allowed: -1000000 to 1000000",
    ),
    (
        "world:\n  capture_reward: 1e999",
        "4: world.capture_reward: value inf: must be finite; allowed: -1000000 to 1000000",
    ),
    (
        "world:\n  flight_reward: -.inf",
        "4: world.flight_reward: value -inf: must be finite; allowed: -1000000 to 1000000",
    ),
    (
        "world:\n  start_radius: [10]",
        "4: world.start_radius.1: is missing; allowed: [nearest, farthest]",
    ),
    (
        "world:\n  start_radius:\n    - ten\n    - 60",
        "5: world.start_radius.0: value 'ten': must be a number; allowed: [nearest, farthest]",
    ),
    (
        "world:\n  start_radius: 10",
        "4: world.start_radius: value 10: must be a list; allowed: [nearest, farthest]",
    ),
    (
        "world:\n  start_radius: [10, 20, 30]",
        "4: world.start_radius: value [10, 20, 30]: has more than 2 items;"
        " allowed: [nearest, farthest]",
    ),
    (
        "world:\n  start_radius: [10, 80]",
        "4: world.start_radius: value [10, 80]: the farthest start, 80, lies outside the grid;"
        " allowed: up to 60 (half the grid, whatever its size)",
    ),
    ("description: 3", "3: description: value 3: must be a text; allowed: a text of up to 400"),
    (
        f"description: {'x' * 401}",
        f"3: description: value '{'x' * 78}…: is too long; allowed: a text of up to 400 characters",
    ),
    (
        "world: 3",
        "3: world: value 3: must be a mapping; allowed: the keys size, n_directions, n_distances,",
    ),
    (
        "schedule: {skills: [avoid]}",
        "3: schedule.skills: value ['avoid']: must be a mapping; allowed: a mapping, each key a"
        " name of up to 32 characters from a-z, 0-9 and _ that starts with a letter, each value"
        " the keys at, introduce, freeze",
    ),
    (
        "schedule: {safe_introduction: no}",
        "3: schedule.safe_introduction: value 'no': must be true or false; allowed: true, false",
    ),
    (
        "schedule: {safe_introduction: 0}",
        "3: schedule.safe_introduction: value 0: must be true or false; allowed: true, false",
    ),
    (
        "schedule: {episodes: 3}",
        "3: schedule.episodes: value 3: must be a list; allowed: a list, each item the keys skill,"
        " at, duration, probability",
    ),
    (
        "schedule: {episodes: [null]}",
        "3: schedule.episodes.0: value null: must be a mapping; allowed: the keys skill, at,",
    ),
    (
        "schedule:\n  skills: {avoid: {at: 5}}",
        "4: schedule.skills.avoid: value {'at': 5}: is not among the learner's options;"
        " allowed: none, because the options are moves",
    ),
    (
        "world:\n  sise: 60",
        "4: world.sise: value 60: is not a known key (did you mean size?); allowed: size, n_dir",
    ),
    (
        "wrld: {size: 60}",
        "3: wrld: value {'size': 60}: is not a known key (did you mean world?);"
        " allowed: extends, description, world, learner, schedule, trials",
    ),
    (
        "schedule:\n  skills:\n    avod: {at: 5}",
        "5: schedule.skills.avod: value {'at': 5}: is not among the learner's options (did you"
        " mean avoid?); allowed: none, because the options are moves",
    ),
    (
        "schedule:\n  skills:\n    avod: null",
        "5: schedule.skills.avod: value null: is not a known key (did you mean avoid?);"
        " allowed: approach, avoid, circle_clockwise, circle_counterclockwise",
    ),
    (
        "schedule:\n  skills:\n    circle-clockwise: {at: 5}",
        "5: schedule.skills.circle-clockwise: value {'at': 5}: is not a possible key (did you mean"
        " circle_clockwise?); allowed: a name of up to 32 characters from a-z, 0-9 and _ that",
    ),
    (
        "schedule:\n  skills:\n    '[key]': {at: 5}",
        "5: schedule.skills.'[key]': value {'at': 5}: is not a possible key; allowed: a name of up",
    ),
    (
        "schedule:\n  episodes:\n  - {skill: Avoid, duration: 5, probability: 1}",
        "5: schedule.episodes.0.skill: value 'Avoid': is not a plain name (did you mean avoid?);"
        " allowed: a name of up to 32 characters from a-z, 0-9 and _ that starts with a letter",
    ),
    (
        f"schedule:\n  episodes:\n  - {{skill: {'x' * 33}, duration: 5, probability: 1}}",
        f"5: schedule.episodes.0.skill: value '{'x' * 33}': is too long; allowed: a name of up to",
    ),
    (
        "schedule:\n  episodes:\n  - {skill: 3, duration: 5, probability: 1}",
        "5: schedule.episodes.0.skill: value 3: must be a text; allowed: a name of up to 32",
    ),
    ("world:\n  sise: null", "4: world.sise: value null: is not a known key (did you mean size?)"),
    ("1: 2", "3: 1: value 2: is not a known key; allowed: extends,"),
    ("true: 2", "3: true: value 2: is not a known key; allowed: extends,"),
    ("? [a, b]\n: 3", "3: '?': value ['a', 'b']: is no key; allowed: a text"),
    ('"a\\e[31m\\nb": 2', "3: 'a\\x1b[31m\\nb': value 2: is not a known key; allowed: extends,"),
    ("trials: 20", "3: trials: value 20: is given twice, first on line 2; allowed: once"),
    ("world: &w {size: 60}", "3: world: value &w: anchors are not read; allowed: the value alone"),
    ("world: *w", "3: world: value *w: aliases are not read; allowed: the value itself, written"),
    ("world: !!map {}", "3: world: value !!map: tags are not read; allowed: the value alone"),
    ("world: ! {}", "3: world: value !: tags are not read; allowed: the value alone"),
    ("&k world: {}", "3: '?': value &k: anchors are not read; allowed: the value alone"),
    ("<<: {trials: 5}", "3: '<<': merges are not read; allowed: extends"),
    ("---\ntrials: 5", "3: a second document starts; allowed: one document"),
    (
        f"world: {{size: {'9' * 5000}}}",
        f"3: world.size: value {'9' * 79}…: has too many digits; allowed: at most 19",
    ),
    ('description: "\\ud800"', "3: description: value '\\ud800': has half a character; allowed:"),
]


@pytest.mark.parametrize(("text", "expected"), WRONG_VALUES)
def test_a_wrong_value_is_reported_where_it_stands(text: str, expected: str) -> None:
    (line,) = complaints(SOUND + text)
    assert line.startswith(expected)


def test_two_timers_of_one_skill_are_no_silent_choice() -> None:
    assert complaints(
        "learner: {options: [avoid], alpha: 0.1}\ntrials: 10\nschedule:\n  skills:\n"
        "    avoid: {at: 0}\n    avoid: {at: 5}"
    ) == [
        "6: schedule.skills.avoid: value {'at': 5}: is given twice, first on line 5; allowed: once"
    ]


MISSING = "is missing; allowed:"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("trials: 10", f"1: learner: {MISSING} the keys options, alpha, skill_alpha,"),
        ("trials: 10\n\nlearner:\n  options: moves", f"3: learner.alpha: {MISSING} 0 to 1"),
        (
            "trials: 10\nlearner:\n  alpha: 0.1",
            f"2: learner.options: {MISSING} moves, commands, or a list",
        ),
        ("\n# a comment\nlearner: {options: moves, alpha: 0.1}", f"3: trials: {MISSING} 1 to 2000"),
        (
            "trials: 10\nlearner: {options: [avoid], alpha: 0.1}\nschedule:\n  skills:\n"
            "    avoid:\n      introduce: {window: 300}",
            f"6: schedule.skills.avoid.introduce.by: {MISSING} novelty, reach, change",
        ),
        (
            "trials: 10\nlearner: {options: [avoid], alpha: 0.1}\nschedule:\n  episodes:\n"
            "    - {skill: avoid, duration: 5, probability: 1}\n"
            "    - {skill: avoid, at: 5, probability: 1}",
            f"6: schedule.episodes.1.duration: {MISSING} 1 to 2000000",
        ),
    ],
)
def test_a_missing_key_is_reported_where_it_belongs(text: str, expected: str) -> None:
    (line,) = complaints(text)
    assert line.startswith(expected)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ("steps", "1: learner.options: value 'steps': "),
        ("[]", "1: learner.options: value []: "),
        (
            "[approch]",
            "1: learner.options: value ['approch']: names no skill with 'approch' (did you mean"
            " approach?); allowed: moves, commands, or a list of skills from approach, avoid,",
        ),
        (
            "[Avoid, avoid, nothing]",
            "1: learner.options: value ['Avoid', 'avoid', 'nothing']: names no skill with 'Avoid'"
            " (did you mean avoid?), 'nothing'; allowed: ",
        ),
        (
            '["a\\a"]',
            "1: learner.options: value ['a\\x07']: names no skill with 'a\\x07'; allowed: ",
        ),
        (f"[{'x' * 99}]", "1: learner.options: value ['xxx"),
        ("[true]", "1: learner.options: value [True]: names no skills; allowed: "),
        ("[avoid, avoid]", "1: learner.options: value ['avoid', 'avoid']: names a skill twice;"),
        ("[[avoid]]", "1: learner.options: value [['avoid']]: "),
        ("{avoid: 1}", "1: learner.options: value {'avoid': 1}: "),
        ("[avoid, *more]", "1: learner.options.1: value *more: aliases are not read;"),
        ("[*more]", "1: learner.options.0: value *more: aliases are not read;"),
    ],
)
def test_options_are_moves_or_skills(options: str, expected: str) -> None:
    (line,) = complaints(f"learner: {{options: {options}, alpha: 0.1}}\ntrials: 10")
    assert line.startswith(expected)
    assert "; allowed: " in line


@pytest.mark.parametrize("at", ["1:30", "-1", "1.5", "soon", "2000001", "true", "12_000"])
def test_an_episode_starts_at_a_trial_or_the_introduction(at: str) -> None:
    (line,) = complaints(
        "learner: {options: [avoid], alpha: 0.1}\ntrials: 10\nschedule:\n  episodes:\n"
        f"  - {{skill: avoid, at: {at}, duration: 5, probability: 1}}"
    )
    assert line.startswith("5: schedule.episodes.0.at: value ")
    assert line.endswith("; allowed: introduction, or a trial from 0 to 2000000")


def test_a_comma_for_thousands_is_not_a_small_number() -> None:
    text = "learner: {options: [avoid], alpha: 0.1}\nschedule: {skills: {avoid: {at: 12,000}}}\n"
    assert (2, "schedule.skills.avoid.000") in wrong_places(text)


# --- Skills of one's own -------------------------------------------------------------------------


def with_custom_skills(skills: str, options: str = "moves", schedule: str = "{}") -> str:
    """A preset that is sound but for what is given: skills on line 3, options on line 4."""
    return (
        f"trials: 10\nlearner:\n  custom_skills: {skills}\n  options: {options}\n  alpha: 0.1\n"
        f"schedule: {schedule}\n"
    )


def test_a_skill_of_ones_own_is_a_weighted_sum() -> None:
    spec = parse(
        with_custom_skills(
            "{spiral_in: {approach: 0.5, circle_clockwise: 1}, nothing: {}, x2: {avoid: -10}}",
            "[x2, approach, spiral_in]",
            "{skills: {spiral_in: {at: 5}},"
            " episodes: [{skill: spiral_in, duration: 5, probability: 1}]}",
        ),
        "mine.yaml",
    )
    assert spec.learner == LearnerSpec(
        options=("x2", "approach", "spiral_in"),
        alpha=0.1,
        custom_skills={
            "spiral_in": SkillWeights(approach=0.5, circle_clockwise=1.0),
            "nothing": SkillWeights(),
            "x2": SkillWeights(avoid=-10.0),
        },
    )
    assert spec.learner.reward_of("spiral_in") == LocalReward(0.5, -1.0, -SPIRAL_PENALTY)
    assert spec.learner.reward_of("approach") == LocalReward(gain=1.0, arc=0.0, inward=0.0)
    assert spec.schedule.introduced_at("spiral_in") == 5


NAME = "allowed: a name of up to 32 characters from a-z, 0-9 and _ that starts with a letter"
WEIGHTS = "allowed: the keys approach, avoid, circle_clockwise, circle_counterclockwise"


@pytest.mark.parametrize(
    ("skills", "expected"),
    [
        ("3", f": value 3: must be a mapping; allowed: a mapping, each key {NAME[9:]}, each value"),
        ("[orbit]", ": value ['orbit']: must be a mapping; allowed: a mapping, each key a name"),
        ("{orbit: 3}", f".orbit: value 3: must be a mapping; {WEIGHTS}"),
        ("{orbit: {avoid: 10.5}}", ".orbit.avoid: value 10.5: must be at most 10; allowed: -10 to"),
        ("{orbit: {avoid: -11}}", ".orbit.avoid: value -11: must be at least -10; allowed: -10 to"),
        ("{orbit: {avoid: .inf}}", ".orbit.avoid: value inf: must be finite; allowed: -10 to 10"),
        ("{orbit: {avoid: much}}", ".orbit.avoid: value 'much': must be a number; allowed: -10 to"),
        ("{orbit: {avoid: true}}", ".orbit.avoid: value true: must be a number; allowed: -10 to"),
        (
            "{orbit: {avod: 1}}",
            f".orbit.avod: value 1: is not a known key (did you mean avoid?); {WEIGHTS[:9]}",
        ),
        ("{orbit: {avod: null}}", ".orbit.avod: value null: is not a known key (did you mean"),
        ("{Orbit: {}}", f".Orbit: value {{}}: is not a possible key; {NAME}"),
        ("{2_orbits: {}}", f".2_orbits: value {{}}: is not a possible key; {NAME}"),
        ("{orbit-2: {}}", f".orbit-2: value {{}}: is not a possible key; {NAME}"),
        ('{"orbit\\n": {}}', f".'orbit\\n': value {{}}: is not a possible key; {NAME}"),
        ('{"": {}}', f".'': value {{}}: is not a possible key; {NAME}"),
        ("{orbité: {}}", f".orbité: value {{}}: is not a possible key; {NAME}"),
        (f"{{{'x' * 33}: {{}}}}", f".{'x' * 33}: value {{}}: is not a possible key; {NAME}"),
        ("{avoid: {}}", ".avoid: value {}: is the name of a built-in skill; allowed: another"),
        ("{orbit: {}, orbit: 1}", ".orbit: value 1: is given twice, first on line 3; allowed: "),
        ("*mine", ": value *mine: aliases are not read; allowed: the value itself, written out"),
        ("{orbit: *mine}", ".orbit: value *mine: aliases are not read; allowed: the value itself"),
    ],
)
def test_a_wrong_skill_of_ones_own_is_reported_where_it_stands(skills: str, expected: str) -> None:
    (line,) = complaints(with_custom_skills(skills))
    assert line.startswith(f"3: learner.custom_skills{expected}")


def test_the_longest_name_and_the_largest_weights_are_read() -> None:
    text = with_custom_skills(f"{{{'x' * 32}: {{approach: 10, avoid: -10}}}}", f"[{'x' * 32}]")
    assert parse(text, "mine.yaml").learner.skills == ("x" * 32,)


def test_there_are_as_many_options_as_a_row_holds() -> None:
    names = [f"s{index}" for index in range(MAX_ACTIONS + 1)]
    skills = f"{{{', '.join(f'{name}: {{}}' for name in names)}}}"
    assert parse(with_custom_skills(skills, f"[{', '.join(names[1:])}]"), "mine.yaml")
    (line,) = complaints(with_custom_skills(skills, f"[{', '.join(names)}]"))
    assert line.startswith("4: learner.options: value ['s0', ")
    assert line.endswith(": names 13 skills; allowed: up to 12")


@pytest.mark.parametrize(
    "skills", ["3", "[orbit]", "*mine", "!!map {}", "{orbit: 3}", "{orbit: *mine}", "{orbit: [1]}"]
)
def test_a_wrong_skill_is_still_one(skills: str) -> None:
    text = with_custom_skills(
        skills,
        "[orbit, avoid]",
        "{skills: {orbit: {at: 5}}, episodes: [{skill: orbit, duration: 5, probability: 1}]}",
    )
    ((line, key),) = wrong_places(text)
    assert line == 3
    assert key.startswith("learner.custom_skills")


@pytest.mark.parametrize("options", ["3", "[]", "[orbt]", "*mine", "[*mine]", "[approach, *mine]"])
def test_a_schedule_is_compared_with_options_that_are_sound(options: str) -> None:
    names = ["orbit", *(f"s{index}" for index in range(MAX_ACTIONS + 5))]
    timed = ["orbit", *names[6:16]]
    parts = (
        f"{{{', '.join(f'{name}: {{}}' for name in names)}}}",
        options,
        f"{{skills: {{{', '.join(f'{name}: {{at: 5}}' for name in timed)}, orbti: {{at: 5}}}},"
        " episodes: [{skill: avoid, duration: 5, probability: 1},"
        " {skill: avod, duration: 5, probability: 1}]}",
    )
    ((line, key),) = wrong_places(with_custom_skills(*parts))
    assert line == 4
    assert key.startswith("learner.options")
    sound = f"[{', '.join(['avoid', *timed])}]"
    first, second = complaints(with_custom_skills(parts[0], sound, parts[2]))
    assert first.startswith(
        "6: schedule.skills.orbti: value {'at': 5}: is not among the learner's options"
        " (did you mean orbit?); allowed: "
    )
    assert second.startswith(
        "6: schedule.episodes.1.skill: value 'avod': is not among the learner's options"
        " (did you mean avoid?); allowed: "
    )


@pytest.mark.parametrize("learner", ["3", "null", "[orbit]", "*mine"])
def test_any_skill_may_have_been_lost_with_the_learner(learner: str) -> None:
    text = f"learner: {learner}\ntrials: 10\nschedule:\n  skills: {{orbit: {{at: 5}}, other: null}}"
    assert wrong_places(text) == [(1, "learner")]


@pytest.mark.parametrize(
    "learner",
    ["", "learner: {options: [orbit]}", "learner: {custom_skills: {mine: {}}}"],
)
def test_any_skill_may_have_been_lost_with_a_base(learner: str) -> None:
    text = (
        f"extends: nowhere\n{learner}\nschedule:\n  skills: {{orbit: {{at: 0}}, other: null}}\n"
        "  episodes: [{skill: orbit, duration: 0, probability: 1}]"
    )
    assert wrong_places(text) == [(1, "extends"), (5, "schedule.episodes.0.duration")]


def test_a_skill_is_taken_away_with_its_timer(tmp_path: Path) -> None:
    base = with_custom_skills("{orbit: {}}", "[avoid, orbit]", "{skills: {orbit: {at: 5}}}")
    written(tmp_path, "base.yaml", base)
    for skills in ("{orbit: null}", "null"):
        path = written(
            tmp_path,
            "mine.yaml",
            f"extends: base.yaml\nlearner: {{custom_skills: {skills}, options: [avoid]}}\n"
            "schedule: {skills: {orbit: null}}",
        )
        assert load(str(path)) == parse(with_custom_skills("{}", "[avoid]"), "mine.yaml")


def test_a_skill_that_a_base_defines_is_changed_weight_by_weight(tmp_path: Path) -> None:
    base = with_custom_skills("{orbit: {approach: 2, avoid: 3}}", "[orbit]")
    written(tmp_path, "base.yaml", base)
    mine = "extends: base.yaml\nlearner: {custom_skills: {orbit: {avoid: null}, other: {}}}"
    path = written(tmp_path, "mine.yaml", mine)
    settings_ = ["learner.custom_skills.orbit.circle_clockwise=-1", "learner.options.0=other"]
    spec = load(str(path), settings_)
    assert spec.learner.options == ("other",)
    assert spec.learner.custom_skills == {
        "orbit": SkillWeights(approach=2.0, circle_clockwise=-1.0),
        "other": SkillWeights(),
    }


def test_many_skills_that_are_not_known_are_compared_with_a_few_names_each(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    compared = []
    close_matches = difflib.get_close_matches

    def count(word: str, names: Sequence[str], n: int) -> list[str]:
        compared.append(len(names))
        return close_matches(word, names, n)

    monkeypatch.setattr(difflib, "get_close_matches", count)
    skills = ", ".join(f"s{index:04}_of_my_own: {{}}" for index in range(600))
    for options, value, n_timers, n_problems in (
        ("[s_of]", "{at: 5}", 650, 1),
        ("[avoid]", "{at: 5}", 650, 650),
        ("[s_of]", "null", 1_200, 1 + 1_200),
    ):
        timers = ", ".join(f"t{index:04}_of_my_own: {value}" for index in range(n_timers))
        error = refusal(with_custom_skills(f"{{{skills}}}", options, f"{{skills: {{{timers}}}}}"))
        assert len(error.problems) == n_problems
        assert max(map(len, str(error).splitlines())) < 2_000
    # Each name that is not known is compared with a few of the 600, not with all of them.
    assert 0 < max(compared) < 100


# --- Several at once -----------------------------------------------------------------------------

FULL_OF_ERRORS = """\
description: [what]
world:
  size: 12
  n_direction: 24
  vision_radius: -1
  start_radius: [70, 80]
learner:
  options: [approach, avoid]
  alpha: 2
  gamma: 1
  custom_skills:
    orbit: {avoid: 11, aproach: 1}
    Orbit: {}
    avoid: {}
schedule:
  skills:
    approach: {at: 100, freeze: -3}
    avoid: {at: 200}
    circle_clockwise: {at: 300}
    avoid: {at: 300}
  episodes:
    - {skill: avoid, at: 300, duration: 100, probability: 1}
    - {skill: avoid, at: 350, duration: 0, probability: 1}
    - {skill: avoid, at: 399, duration: 100, probability: 1}
    - {skill: avoid, at: 150, duration: 10, probability: 1}
    - {skill: circle_clockwise, at: 399, duration: 100, probability: 1}
trials: many
"""


def test_every_wrong_value_is_reported_at_once() -> None:
    assert wrong_places(FULL_OF_ERRORS) == [
        (1, "description"),
        (3, "world.size"),
        (4, "world.n_direction"),
        (5, "world.vision_radius"),
        (9, "learner.alpha"),
        (10, "learner.gamma"),
        (12, "learner.custom_skills.orbit.avoid"),
        (12, "learner.custom_skills.orbit.aproach"),
        (13, "learner.custom_skills.Orbit"),  # a capital
        (17, "schedule.skills.approach.freeze"),
        (20, "schedule.skills.avoid"),  # twice
        (23, "schedule.episodes.1.duration"),
        (27, "trials"),
    ]


NO_WRONG_VALUE = """\
world:
  size: 20
  start_radius: [70, 80]
learner:
  options: [approach, avoid]
  alpha: 1
schedule:
  skills:
    approach: {at: 100}
    avoid: {at: 200}
    circle_clockwise: {at: 300}
  episodes:
    - {skill: avoid, at: 300, duration: 100, probability: 1}
    - {skill: avoid, at: 399, duration: 100, probability: 1}
    - {skill: avoid, at: 150, duration: 10, probability: 1}
    - {skill: circle_clockwise, at: 399, duration: 100, probability: 1}
"""


@pytest.mark.parametrize(
    ("trials", "more"),
    [
        ("trials: 10", []),
        ("trials: many", [(17, "trials")]),  # has no part in what is compared
        ("", [(1, "trials")]),
    ],
)
def test_all_that_does_not_go_together_is_reported_at_once(
    trials: str, more: list[tuple[int, str]]
) -> None:
    assert wrong_places(NO_WRONG_VALUE + trials) == sorted(
        [
            *more,
            (3, "world.start_radius"),
            (9, "schedule.skills.approach.at"),  # nothing to do before trial 100
            (11, "schedule.skills.circle_clockwise"),  # not an option
            (14, "schedule.episodes.1.at"),  # overlaps the first
            (15, "schedule.episodes.2.at"),  # before avoid joins
            (16, "schedule.episodes.3.skill"),  # not an option
        ]
    )


def test_a_skill_named_like_a_built_in_one_is_a_wrong_value() -> None:
    text = with_custom_skills("{avoid: {}, Orbit: {}}", "3")
    assert wrong_places(text) == [
        (3, "learner.custom_skills.Orbit"),
        (4, "learner.options"),
    ]
    text = with_custom_skills("{avoid: {}}", "3")
    assert wrong_places(text) == [(3, "learner.custom_skills.avoid"), (4, "learner.options")]


@pytest.mark.parametrize("wrong", ["options: 3, alpha: 0.1", "options: [avoid]", "alpha: 0.1", ""])
def test_a_schedule_is_compared_with_a_learner_that_is_sound(wrong: str) -> None:
    schedule = (
        "trials: 10\nschedule:\n  episodes:\n"
        "  - {skill: avoid, at: 5, duration: 5, probability: 1}\n"
        "  - {skill: avoid, at: 7, duration: 5, probability: 1}\n"
    )
    assert {line for line, _ in wrong_places(f"learner: {{{wrong}}}\n{schedule}")} == {1}
    text = f"learner: {{options: [avoid], alpha: 0.1}}\n{schedule}"
    assert wrong_places(text) == [(6, "schedule.episodes.1.at")]


def test_a_wrong_timer_does_not_make_its_episodes_wrong() -> None:
    text = (
        "learner: {options: [approach, avoid], alpha: 0.1}\ntrials: 10\nschedule:\n"
        "  skills: {avoid: {at: 12_000}}\n  episodes:\n"
        "  - {skill: avoid, duration: 500, probability: 1}\n"
        "  - {skill: avoid, at: 100, duration: 500, probability: 1}\n"
    )
    assert wrong_places(text) == [(4, "schedule.skills.avoid.at")]


def test_a_wrong_size_does_not_make_starts_wrong() -> None:
    text = SOUND + "world: {size: 500, start_radius: [0.5, 60]}"
    assert wrong_places(text) == [(3, "world.size")]


def fields(model: type[BaseModel], above: str = "") -> Iterator[tuple[str, FieldInfo]]:
    """Dotted keys and fields of a model and of all models within it."""
    for name, field in model.model_fields.items():
        key = above + name
        yield key, field
        origin = get_origin(field.annotation)
        inner = ".SKILL." if origin is dict else ".N." if origin is tuple else "."
        for kind in (field.annotation, *get_args(field.annotation)):
            if isinstance(kind, type) and issubclass(kind, BaseModel):
                yield from fields(kind, key + inner)


KEYS = dict(fields(RunSpec))


def test_the_keys_of_this_test_are_those_of_a_preset() -> None:
    assert len(KEYS) == 5 + 11 + 17 + 5 + 9 + 3 + 6 + 2 * 3 + 3 + 5 + 1 + 2
    assert {"world.size", "schedule.skills.SKILL.at", "schedule.episodes.N.skill"} <= KEYS.keys()
    assert "learner.custom_skills.SKILL.approach" in KEYS


BESIDE = {
    "learner.templates.N.": "learner.templates=[{table: selection, prefer: avoid, value: 0}]",
    "learner.held.": "learner.held.until=steps",
    "schedule.introduce.": "schedule.introduce.by=novelty",
    "schedule.skills.SKILL.introduce.": "schedule.skills.avoid={at: null, introduce: {by: reach}}",
    "schedule.teach.": "schedule.teach.trials=3",
}
"""What is missing beside a key, if it is within something that a preset need not have."""


@pytest.mark.parametrize("key", KEYS)
@pytest.mark.parametrize("value", ["!!float 3", "{odd: [1, {two: 3}]}", "[1]", ".nan"])
def test_a_wrong_type_is_reported_for_every_key_in_plain_words(key: str, value: str) -> None:
    path = key.replace("custom_skills.SKILL", "custom_skills.orbit")
    path = path.replace("SKILL", "avoid").replace(".N.", ".0.")
    setting = f"{path}={value}"
    beside = [other for above, other in BESIDE.items() if key.startswith(above)]
    for line in load_refusal("timed", *beside, setting):
        assert line.startswith(f"--set {setting}: {path}")
        assert "Input should" not in line
        assert "; allowed: " in line


# --- Texts that are no presets -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "1: is empty; allowed: a mapping of keys"),
        ("# nothing\n", "1: is empty; allowed: a mapping of keys"),
        ("---\n...\n", "1: is empty; allowed: a mapping of keys"),
        ("null", "1: is empty; allowed: a mapping of keys"),
        ("\n- 1\n- 2", "2: value [1, 2]: must be a mapping; allowed: a mapping of keys"),
        ("a text", "1: value 'a text': must be a mapping; allowed: a mapping of keys"),
        ("learner:\n\talpha: 1", "2: is not YAML: found character '\\t'"),
        ("learner: {alpha: 1\ntrials: 3", "2: is not YAML: expected ',' or '}', but got ':'"),
        ("a: 1\nb: [", "2: is not YAML: expected the node content, but found '<stream end>'"),
        ("a: \x07", "1: is not YAML: it contains the control character U+0007"),
        ('a: "\\UFFFFFFFF"', " is not YAML: an escape or a version is out of range"),
        ("%YAML 1." + "9" * 5000 + "\n---\n{}", " is not YAML: an escape or a version is out of"),
        (b"trials: 1\nworld: \xff", "2: is not a text; allowed: UTF-8"),
        (b"trials: 1\0", " is not a text: it contains a NUL byte; allowed: UTF-8"),
        ("trials: 1\0", "1: is not YAML: it contains the control character U+0000"),
        ("trials: \ud800", "1: is not YAML: it contains the control character U+D800"),
        (
            "trials: 10\n".encode("utf-16"),
            " is not a text: it contains a NUL byte; allowed: UTF-8; this is UTF-16, to be",
        ),
        ("€".encode("utf-16"), "1: is not a text; allowed: UTF-8; this is UTF-16, to be saved as"),
        (b"a: 1\r\nb: 2\rc: \xff", "3: is not a text; allowed: UTF-8"),
        ("a: 1\r\nb: 2\rc: \x07", "3: is not YAML: it contains the control character U+0007"),
        ("learner: {}\rtrials: [1,\r", "3: is not YAML: expected the node content"),
        ("x" * 65_537, " is too large; allowed: at most 65536 bytes"),
        ("ä" * 40_000, " is too large; allowed: at most 65536 bytes"),
        ("[" * 60_000, "1: is nested too deeply; allowed: 20 levels"),
        ("- " * 30_000, "1: is nested too deeply; allowed: 20 levels"),
        ("? " * 30_000, "1: is nested too deeply; allowed: 20 levels"),
        ("- 1\n" * 2_001, "2000: has too many values; allowed: 2000"),
    ],
)
def test_a_text_that_is_no_preset(text: bytes | str, expected: str) -> None:
    (line,) = complaints(text)
    assert line.startswith(expected)


def test_a_byte_order_mark_is_no_part_of_the_first_key() -> None:
    assert parse(SOUND.encode("utf-8-sig"), "mine.yaml") == parse("\ufeff" + SOUND, "mine.yaml")


def test_an_alias_bomb_is_refused_before_anything_is_expanded() -> None:
    names = "abcdefghij"
    rows = ["a: &a [x, x, x, x, x, x, x, x, x, x]"]
    rows += [
        f"{name}: &{name} [{', '.join(['*' + before] * 10)}]"
        for before, name in itertools.pairwise(names)
    ]
    text = "\n".join(rows)
    assert peak_of(wrong_places, text) < 4 * 2**20
    assert {"a", "b", "b.0", "j.9"} <= {key for _, key in wrong_places(text)}


def test_a_value_within_itself_is_refused() -> None:
    first, second, *_ = complaints("a: &a [*a]")
    assert first == "1: a: value &a: anchors are not read; allowed: the value alone"
    assert second.startswith("1: a.0: value *a: aliases are not read;")


HUGE = "9" * 5_000
HOSTILE = {
    "an alias within itself": "a: &a [*a]",
    "a mapping within itself": "a: &a {b: *a}",
    "an anchored document": "&a {a: *a, b: [*a, *a]}",
    "a list for a document": "[*a, {b: *a}]",
    "an alias for a document": "*a",
    "an alias in a text": "description: [*a]",
    "an alias in a number": "trials: {a: *a}",
    "an alias in a mapping": "world: [*a]\nset: [*a]\ngrid: [*a]\nstop: [*a]",
    "an alias as a base": "extends: *a",
    "an alias in a base": "extends: [*a]\npresets: [[*a], {preset: [*a]}, {label: [*a]}]",
    "an alias in a preset within": (
        "presets:\n  - {label: b, preset: {extends: *a, world: {size: *a}}}\n"
        "  - {label: c, preset: {extends: [*a], world: {size: [*a]}}}"
    ),
    "an alias in options": "learner: {options: [*a], alpha: [*a]}\npresets: [timed, *a]",
    "aliases for the same": "presets: [timed]\ngrid: {learner.epsilon: [*a, *a, [*a], [*a]]}",
    "an alias for a key": "presets: [timed]\n*a : 1\n? [*a]\n: 2\n? {b: *a}\n: 3",
    "an alias in a key": "presets: [timed]\nset: {a..b: [*a], extends: [*a]}",
    "a merge": "<<: {a: *a}\nworld: {<<: [*a]}",
    "merges": "<<: [{size: 1}, *a]\n<<: *a",
    "a tag": "description: [!!python/name:os.mkdir x, !!set {a}, !<x> y, !\u202e z]",
    "a tagged document": "!!python/object/apply:os.mkdir {a: [*a]}",
    "a tagged key": "!!binary aGVsbG8=: 1\n!!null ? : [*a]",
    "a huge number": f"trials: {HUGE}\nseeds: [{HUGE}]\nb: [-{HUGE}]",
    "a huge number for a key": f"{HUGE}: [*a]\nworld: {{{HUGE}: {HUGE}}}",
    "half a character": 'b: ["\\uD800"]\n"\\uDFFF": [*a]',
    "keys that are given twice": "b: 1\nb: [*a]\nworld: {size: 1, size: [!!set {a}]}",
    "keys that are no texts": "1: [*a]\n1.5: x\nnull: x\n2001-01-01: x\n? \n: x\n? []\n: x",
    "keys within keys": "? ? ? [*a]\n    : b\n  : c\n: d",
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
@pytest.mark.parametrize("read", [parse, experiments.parse], ids=["preset", "experiment"])
def test_whatever_is_in_a_text_a_problem_shows_it_as_written(
    read: Callable[[str, str], object], text: str
) -> None:
    with pytest.raises(PresetError) as caught:
        read(text, "mine.yaml")
    lines = str(caught.value).splitlines()
    assert len(lines) == len(caught.value.problems) == len(set(lines))
    for line in lines:
        assert re.match(r"mine\.yaml:\d+: ", line)
        assert line.isprintable()
        assert len(line) < 1_000
        assert " object at " not in line
        assert "Refused" not in line


def test_a_value_that_was_not_read_is_shown_as_written_also_within_another() -> None:
    complaints_of_b = [line for line in complaints("b: [1]\nb: [*a, !mine x]") if "2: b" in line]
    first, second, third = complaints_of_b
    assert first.startswith("2: b.0: value *a: aliases are not read;")
    assert second.startswith("2: b.1: value !mine: tags are not read;")
    assert third.startswith("2: b: value [*a, !mine]: is given twice, first on line 1;")


@pytest.mark.parametrize(
    "tag",
    [
        "!!python/object/apply:os.mkdir [{path}]",
        "!!python/object/new:os.mkdir [{path}]",
        "!!python/name:os.mkdir",
        "!<tag:yaml.org,2002:python/object/apply:os.mkdir> [{path}]",
        "!!timestamp 2001-01-01",
        "!!binary aGVsbG8=",
        "!!set {{a}}",
        "!mine x",
    ],
)
def test_a_tag_is_refused_and_nothing_is_run(tag: str, tmp_path: Path) -> None:
    made = tmp_path / "made"
    value = tag.format(path=made)
    (line,) = complaints(SOUND + f"description: {value}")
    assert line.startswith("3: description: value !")
    assert line.endswith("tags are not read; allowed: the value alone")
    assert wrong_places(f"{value}\n") == [(1, "")]
    assert not made.exists()


def test_a_problem_is_one_printable_line_however_long_the_value() -> None:
    noise = "\\e]0;\\a" * 100
    error = refusal(SOUND + f'"{noise}": "{noise}"\nworld: {{size: "{noise}"}}')
    assert len(error.problems) == 2
    assert len(error.problems[0].key) <= 80
    assert all(len(problem.value or "") <= 80 for problem in error.problems)
    assert all(line.isprintable() for line in str(error).splitlines())


def test_the_name_of_an_upload_is_shown_safely() -> None:
    with pytest.raises(PresetError) as caught:
        parse("", "\x1b[31m\n.yaml")
    assert str(caught.value).isprintable()


# --- Numbers and words ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("written_as", "value"),
    [
        ("1", 1.0),
        ("-5", -5.0),
        ("+5", 5.0),
        ("0.5", 0.5),
        (".5", 0.5),
        ("5.", 5.0),
        ("1e5", 1e5),
        ("1E5", 1e5),
        ("1e+5", 1e5),
        ("1e-3", 1e-3),
        ("-1.5e2", -150.0),
        ("-0", 0.0),
    ],
)
def test_numbers(written_as: str, value: float) -> None:
    spec = parse(SOUND + f"world: {{capture_reward: {written_as}}}", "mine.yaml")
    assert spec.world.capture_reward == value


@pytest.mark.parametrize(
    "word",
    [
        *("yes", "No", "on", "OFF", "y", "1:30", "1:30:00", "1_000", "010", "0x10", "0o7", "0b1"),
        *("2001-01-01", "1e", "e5", ".", "1.2.3", "nan", "inf", "=", "٣"),
    ],
)
def test_words_that_are_no_numbers(word: str) -> None:
    text = SOUND + f"description: {word}\n"
    assert parse(text, "mine.yaml").description == word
    assert wrong_places(text + f"world: {{size: {word}}}") == [(4, "world.size")]


@pytest.mark.parametrize("quoted", ['"20"', "'20'", '"true"', '"null"'])
def test_what_is_quoted_is_a_text(quoted: str) -> None:
    assert parse(SOUND + f"description: {quoted}", "x").description == quoted[1:-1]
    assert wrong_places(SOUND + f"world: {{size: {quoted}}}") == [(3, "world.size")]


@pytest.mark.parametrize("null", ["null", "~", "Null", "NULL", ""])
def test_null_is_as_if_a_key_that_has_a_default_had_not_been_given(null: str) -> None:
    assert parse(SOUND + f"world: {null}\n", "x") == parse(SOUND, "x")
    assert parse(SOUND + f"world:\n  size: {null}\n", "x") == parse(SOUND, "x")
    (line,) = complaints(f"learner: {{options: moves, alpha: 1}}\ntrials: {null}\n")
    assert line == "2: trials: value null: must be a whole number; allowed: 1 to 2000000"


# --- Files ---------------------------------------------------------------------------------------


def test_a_file(tmp_path: Path) -> None:
    path = written(tmp_path, "mine.yaml", SOUND)
    assert load(str(path)) == parse(SOUND, "mine.yaml")


def test_a_shipped_name_is_never_a_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path, "timed", SOUND)
    monkeypatch.chdir(tmp_path)
    assert load("timed").trials == 48_000
    assert load("./timed").trials == 10


def test_problems_of_a_file_name_it(tmp_path: Path) -> None:
    path = written(tmp_path, "mine.yaml", SOUND + "world: {size: 1}")
    (line,) = load_refusal(path)
    assert line == f"{path}:3: world.size: value 1: must be at least 20; allowed: 20 to 400"


def test_an_unknown_name_is_told_the_known_ones() -> None:
    names = ", ".join(shipped())
    assert load_refusal("hierarchical3") == [
        "hierarchical3: is neither a shipped preset nor a file (did you mean hierarchical_3?);"
        f" allowed: {names}, or a path"
    ]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("nowhere/mine.yaml", "nowhere/mine.yaml: is neither a shipped preset nor a file"),
        ("mine.yaml/more", "mine.yaml/more: is neither a shipped preset nor a file"),
        (".", ".: is a directory; allowed: a file"),
        ("", "'': is a directory; allowed: a file"),
        ("a\0b", "a\ufffdb: is not a path: it contains a NUL character"),
        ("x" * 5_000, f"{'x' * 1_023}…: cannot be read: File name too long"),
    ],
)
def test_what_is_no_file(
    name: str, expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, "mine.yaml", SOUND)
    monkeypatch.chdir(tmp_path)
    (line,) = load_refusal(name)
    assert line.startswith(expected)


def test_a_huge_file_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path, "huge.yaml", "")
    os.truncate(path, 2**40)
    monkeypatch.setattr(Path, "open", lambda *_: pytest.fail("the file was opened"))
    assert load_refusal(path) == [
        f"{path}: is too large, {2**40} bytes; allowed: at most 65536 bytes"
    ]


def test_the_largest_file_is_read(tmp_path: Path) -> None:
    text = SOUND + "#" * (65_536 - len(SOUND))
    assert load(str(written(tmp_path, "large.yaml", text))).trials == 10
    path = written(tmp_path, "larger.yaml", text + "#")
    assert load_refusal(path)[0].startswith(f"{path}: is too large, 65537 bytes")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    assert load_refusal(path) == [f"{path}: is not a regular file; allowed: a file"]


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="needs a file it cannot read")
def test_a_file_that_may_not_be_read(tmp_path: Path) -> None:
    path = written(tmp_path, "mine.yaml", SOUND)
    path.chmod(0)
    assert load_refusal(path) == [f"{path}: cannot be read: Permission denied"]


# --- Starting from another preset ----------------------------------------------------------------


def test_mappings_are_merged_and_all_else_is_replaced() -> None:
    spec = parse(
        "extends: timed\nworld: {size: 60}\nlearner: {options: [approach, circle_clockwise]}\n"
        "schedule:\n  skills: {avoid: null, circle_clockwise: {at: 500}}\n"
        "  episodes: [{skill: circle_clockwise, duration: 5, probability: 1}]\n",
        "mine.yaml",
    )
    timed = load("timed")
    assert spec == RunSpec(
        description=timed.description,
        world=WorldSpec(size=60),
        learner=LearnerSpec(options=("approach", "circle_clockwise"), alpha=0.1),
        schedule=ScheduleSpec(
            skills={
                "approach": SkillTimer(at=0, freeze=300),
                "circle_clockwise": SkillTimer(at=500, freeze=300),
            },
            episodes=(EpisodeSpec(skill="circle_clockwise", duration=5, probability=1.0),),
        ),
        trials=48_000,
    )


def test_null_takes_away_what_is_inherited() -> None:
    spec = parse("extends: timed\nschedule: null\ndescription: ~\n", "mine.yaml")
    assert spec == load("hierarchical_3").model_copy(update={"description": "", "trials": 48_000})


def test_null_may_be_overridden_in_turn(tmp_path: Path) -> None:
    written(tmp_path, "base.yaml", "extends: timed\nschedule: null\n")
    path = written(
        tmp_path, "mine.yaml", "extends: base.yaml\nschedule: {skills: {avoid: {at: 7}}}\n"
    )
    assert load(str(path)).schedule == ScheduleSpec(skills={"avoid": SkillTimer(at=7)})


def test_extending_alone_is_enough() -> None:
    assert parse("extends: timed", "mine.yaml") == load("timed")


def test_paths_start_at_the_file_that_names_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, "base.yaml", SOUND + "description: the base")
    written(tmp_path, "deep/between.yaml", "extends: ../base.yaml\ntrials: 20")
    path = written(tmp_path, "mine.yaml", "extends: deep/between.yaml\nworld: {size: 60}")
    monkeypatch.chdir(tmp_path / "deep")
    spec = load(str(path))
    assert (spec.description, spec.trials, spec.world.size) == ("the base", 20, 60)


def test_every_problem_is_reported_in_the_file_it_stands_in(tmp_path: Path) -> None:
    base = written(
        tmp_path, "base.yaml", "trials: 0\nworld:\n  n_distances: 1\n  size: 1\nextends: timed\n"
    )
    path = written(
        tmp_path,
        "mine.yaml",
        "extends: base.yaml\nworld:\n  size: 2\nlearner: {options: [approach, avoid]}\n",
    )
    assert [line.split(": value")[0] for line in load_refusal(path, "world.n_distances=99")] == [
        f"{path}:3: world.size",
        "--set world.n_distances=99: world.n_distances",
        f"{base}:1: trials",
        "presets/timed.yaml:7: schedule.skills.circle_clockwise",
        "presets/timed.yaml:10: schedule.episodes.0.skill",
    ]


@pytest.mark.parametrize(
    ("base", "expected"),
    [
        (
            "timd",
            "1: extends: value 'timd': is not a shipped preset (did you mean timed?); allowed:",
        ),
        ("3", "1: extends: value 3: must be a text; allowed: standard_q,"),
        ("[timed]", "1: extends: value ['timed']: must be a text; allowed: standard_q,"),
        ("*x", "1: extends: value *x: aliases are not read;"),
        ("/etc/passwd", "1: extends: value '/etc/passwd': is not a shipped preset;"),
        ("../presets/timed.yaml", "1: extends: value '../presets/timed.yaml': is not a shipped"),
    ],
)
def test_a_base_that_cannot_be_had_hides_nothing_and_invents_nothing(
    base: str, expected: str
) -> None:
    first, second = complaints(f"extends: {base}\nworld: {{size: 1}}")
    assert first.startswith(expected)
    assert second.startswith("2: world.size: value 1:")


def test_an_upload_looks_at_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(tmp_path, "base.yaml", SOUND)
    monkeypatch.chdir(tmp_path)
    for base in ("base.yaml", "./base.yaml", str(path)):
        (line,) = complaints(f"extends: {base}")
        assert "is not a shipped preset" in line


def test_a_broken_base_is_reported_and_so_is_what_extends_it(tmp_path: Path) -> None:
    base = written(tmp_path, "base.yaml", "trials: [")
    path = written(tmp_path, "mine.yaml", "extends: base.yaml\nworld: {size: 1}")
    assert load_refusal(path) == [
        f"{base}:1: is not YAML: expected the node content, but found '<stream end>'",
        f"{path}:2: world.size: value 1: must be at least 20; allowed: 20 to 400",
    ]


@pytest.mark.parametrize("base", ["mine.yaml", "./mine.yaml", "other.yaml"])
def test_a_circle_is_reported(base: str, tmp_path: Path) -> None:
    path = written(tmp_path, "mine.yaml", f"extends: {base}\n")
    written(tmp_path, "other.yaml", "\nextends: mine.yaml\n")
    (line,) = load_refusal(path)
    assert "extends: value" in line
    assert line.endswith("starts from itself; allowed: a preset that does not lead back here")


@pytest.mark.parametrize("n_bases", [8, 9])
def test_eight_bases_are_enough(n_bases: int, tmp_path: Path) -> None:
    written(tmp_path, f"{n_bases}.yaml", SOUND)
    for index in range(n_bases):
        written(tmp_path, f"{index}.yaml", f"extends: {index + 1}.yaml")
    if n_bases == 8:
        assert load(str(tmp_path / "0.yaml")).trials == 10
    else:
        assert load_refusal(tmp_path / "0.yaml") == [
            f"{tmp_path / '8.yaml'}:1: extends: value '9.yaml': is one base too many;"
            " allowed: 8 below one another"
        ]


def test_extends_belongs_at_the_top() -> None:
    (line,) = complaints(SOUND + "world: {extends: timed}")
    assert line.startswith("3: world.extends: value 'timed': is not a known key; allowed: size,")


# --- Settings ------------------------------------------------------------------------------------


def test_settings_lie_over_the_preset_and_later_ones_over_earlier_ones() -> None:
    spec = load(
        "timed",
        [
            "world.size=60",
            "world.size=150",
            "learner.epsilon=5e-2",
            "schedule.skills.circle_clockwise.at=6000",
            "schedule.episodes.0.probability=0.5",
            "schedule.skills.avoid=null",
            "world.start_radius=[9, 99]",
            "world.start_radius.1=50",
            "world={n_distances: 11}",
            "description=",
            " trials = 1000 ",
        ],
    )
    timed = load("timed")
    circle, avoid = timed.schedule.episodes
    assert spec == timed.model_copy(
        update={
            "description": "",
            "world": WorldSpec(size=150, n_distances=11, start_radius=(9.0, 50.0)),
            "learner": timed.learner.model_copy(update={"epsilon": 0.05}),
            "schedule": ScheduleSpec(
                skills={
                    "approach": SkillTimer(at=0, freeze=300),
                    "circle_clockwise": SkillTimer(at=6_000, freeze=300),
                },
                episodes=(circle.model_copy(update={"probability": 0.5}), avoid),
            ),
            "trials": 1_000,
        }
    )


def test_a_setting_may_be_the_first_to_name_a_section() -> None:
    spec = load("hierarchical_2", ["schedule.skills.circle_clockwise.at=7", "schedule.episodes=[]"])
    assert spec.schedule == ScheduleSpec(skills={"circle_clockwise": SkillTimer(at=7)})


def test_options_are_set_as_a_list() -> None:
    spec = load("hierarchical_3", ["learner.options=[avoid, approach]"])
    assert spec.learner.options == ("avoid", "approach")


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("world.size=9", "world.size: value 9: must be at least 20; allowed: 20 to 400"),
        ("world.siz=60", "world.siz: value 60: is not a known key (did you mean size?); allowed:"),
        ("wrld.size=60", "wrld: value {'size': 60}: is not a known key (did you mean world?);"),
        ("trials=null", "trials: value null: must be a whole number; allowed: 1 to 2000000"),
        ("world.start_radius.1=9", "world.start_radius: value {'1': 9}: must be a list; allowed:"),
        ("trials=1e3", "trials: value 1000.0: must be a whole number; allowed: 1 to 2000000"),
        ("trials.x=1", "trials.x: trials is 48000, which has no keys"),
        ("schedule.episodes.2.at=1", "schedule.episodes.2.at: schedule.episodes has no item '2';"),
        ("schedule.episodes.x.at=1", "schedule.episodes.x.at: schedule.episodes has no item 'x';"),
        ("trials", "is not a setting; allowed: KEY=VALUE with a dotted KEY"),
        ("", "is not a setting; allowed: KEY=VALUE with a dotted KEY"),
        ("=3", "is not a setting; allowed: KEY=VALUE with a dotted KEY"),
        ("world..size=3", "is not a setting; allowed: KEY=VALUE with a dotted KEY"),
        ("extends=timed", "extends: cannot be set; allowed: in a preset's file"),
        ("trials=[1", "trials: is not YAML: expected ',' or ']', but got '<stream end>'"),
        ("trials=!!int 3", "trials: value !!int: tags are not read; allowed: the value alone"),
        ("trials=*x", "trials: value *x: aliases are not read;"),
        ("world={size: 60, size: 70}", "world.size: value 70: is given twice; allowed: once"),
        ("world.size=x\x1b[31m", "world.size: is not YAML: it contains the control character U+"),
        (".".join("a" * 21) + "=", "is not a setting; allowed: KEY=VALUE with a dotted KEY"),
        (".".join("a" * 15) + "=[[[[[[[]]]]]]]", ".".join("a" * 15) + ": is nested too deeply;"),
    ],
)
def test_a_wrong_setting_names_itself(setting: str, expected: str) -> None:
    (line,) = load_refusal("timed", setting)
    assert line.startswith(f"--set {setting}: {expected}".replace("\x1b", "\ufffd"))


def test_settings_are_looked_at_though_the_preset_is_not_there() -> None:
    lines = load_refusal("nowhere", "world.size=9", "trials")
    assert [line.partition(": ")[0] for line in lines] == [
        "nowhere",
        "--set trials",
        "--set world.size=9",
    ]


# --- Writing -------------------------------------------------------------------------------------

rates = st.floats(0, 1)
rewards = st.floats(-1e6, 1e6)


@st.composite
def worlds(draw: st.DrawFn) -> WorldSpec:
    size = draw(st.integers(20, 400))
    nearest = draw(st.floats(120 / size, 60))
    return WorldSpec(
        size=size,
        n_directions=draw(st.sampled_from(range(8, 49, 8))),
        n_distances=draw(st.integers(2, 64)),
        skill_n_directions=draw(st.none() | st.sampled_from(range(8, 49, 8))),
        skill_n_distances=draw(st.none() | st.integers(2, 64)),
        ring_exponent=draw(st.floats(1, 3)),
        vision_radius=draw(st.floats(0, 1000)),
        start_radius=(nearest, draw(st.floats(nearest, 60))),
        step_limit=draw(st.integers(1, 1_000_000)),
        capture_reward=draw(rewards),
        flight_reward=draw(rewards),
    )


@st.composite
def schedules(draw: st.DrawFn, skills: tuple[str, ...]) -> ScheduleSpec:
    joins = {skill: draw(st.integers(0, 10_000)) for skill in skills if draw(st.booleans())}
    if joins.keys() == set(skills):
        joins[draw(st.sampled_from(skills))] = 0
    episodes = []
    for skill in skills:
        end = first = joins.get(skill, 0)
        for gap, duration in draw(st.lists(st.tuples(st.integers(0, 9), st.integers(1, 99)))):
            start = end + gap
            end = start + duration
            episodes.append(
                {
                    "skill": skill,
                    "at": "introduction" if start == first and draw(st.booleans()) else start,
                    "duration": duration,
                    "probability": draw(rates),
                }
            )
    timers = {skill: {"at": at, "freeze": draw(st.integers(0, 9))} for skill, at in joins.items()}
    return ScheduleSpec.model_validate(
        {
            "safe_introduction": draw(st.booleans()),
            "skills": timers,
            "episodes": draw(st.permutations(episodes)),
        }
    )


weights = st.floats(-10, 10)
names = st.sampled_from(["true", "null", "e5", "nan", "on", "moves", "x" * 32]) | st.from_regex(
    r"[a-z][a-z0-9_]{0,31}", fullmatch=True
)
custom_skills = st.dictionaries(
    names.filter(lambda name: name not in SKILLS),
    st.builds(SkillWeights, **dict.fromkeys(SKILLS, weights)) | st.just(SkillWeights()),
    max_size=MAX_ACTIONS + 2,
)


@st.composite
def runs(draw: st.DrawFn) -> RunSpec:
    custom = draw(st.just({}) | custom_skills)
    known = st.sampled_from([*SKILLS, *custom])
    skills = tuple(draw(st.lists(known, unique=True, max_size=MAX_ACTIONS)))
    return RunSpec(
        description=draw(st.text(max_size=400)),
        world=draw(st.just(WorldSpec()) | worlds()),
        learner=LearnerSpec(
            options=skills or "moves",
            alpha=draw(rates),
            skill_alpha=draw(rates),
            gamma=draw(st.floats(0, 1, exclude_max=True)),
            epsilon=draw(rates),
            initial_q=draw(rewards),
            spiral_penalty=draw(rates),
            local_rewards=draw(st.sampled_from(["signed", "binary"])),
            skills_that_learn=draw(st.sampled_from(["chosen", "all"])),
            custom_skills=custom,
        ),
        schedule=draw(st.just(ScheduleSpec()) | schedules(skills)) if skills else ScheduleSpec(),
        trials=draw(st.integers(1, MAX_TRIALS)),
    )


@given(runs())
def test_what_is_written_reads_back_as_it_was(spec: RunSpec) -> None:
    text = dump(spec)
    assert parse(text, "dumped") == spec
    assert parse(text.encode(), "dumped") == spec


@given(st.text(max_size=60) | st.sampled_from(["1e5", "yes", "null", "~", "010", "a: b", "# c"]))
def test_a_description_reads_back_as_it_was(description: str) -> None:
    spec = load("standard_q").model_copy(update={"description": description})
    assert parse(dump(spec), "dumped").description == description


def test_what_is_written_is_short_and_in_order() -> None:
    spec = load("timed", ["world.size=60", "schedule.episodes.1.at=15000", "description="])
    assert dump(spec) == (
        "world:\n"
        "  size: 60\n"
        "learner:\n"
        "  options: [approach, circle_clockwise, avoid]\n"
        "  alpha: 0.1\n"
        "schedule:\n"
        "  skills:\n"
        "    approach: {at: 0, freeze: 300}\n"
        "    circle_clockwise: {at: 12000, freeze: 300}\n"
        "    avoid: {at: 14500, freeze: 300}\n"
        "  episodes:\n"
        "  - {skill: circle_clockwise, duration: 2000, probability: 0.95}\n"
        "  - {skill: avoid, at: 15000, duration: 2000, probability: 0.3}\n"
        "trials: 48000\n"
    )


def test_an_introduction_that_is_not_safe_is_written_first_in_its_schedule() -> None:
    spec = load("hierarchical_2", ["schedule.safe_introduction=false"])
    assert not spec.schedule.safe_introduction
    assert "schedule:\n  safe_introduction: false\ntrials: 48000\n" in dump(spec)
    timed = load("timed", ["schedule.safe_introduction=false"])
    assert "schedule:\n  safe_introduction: false\n  skills:\n" in dump(timed)
    assert "safe" not in dump(load("timed", ["schedule.safe_introduction=true"]))


def test_skills_of_ones_own_are_written_one_a_line() -> None:
    skills = "{x2: {avoid: -2, approach: 0}, nothing: {}, 'true': {approach: .5, avoid: 1e-5}}"
    spec = parse(with_custom_skills(skills, "['true', avoid]"), "mine.yaml")
    assert dump(spec) == (
        "learner:\n"
        '  options: ["true", avoid]\n'
        "  alpha: 0.1\n"
        "  custom_skills:\n"
        "    x2: {avoid: -2.0}\n"
        "    nothing: {}\n"
        '    "true": {approach: 0.5, avoid: 1.0e-05}\n'
        "trials: 10\n"
    )
    assert parse(dump(spec), "dumped") == spec


# --- Whatever comes ------------------------------------------------------------------------------

TIMED = shipped()["timed"].read_text(encoding="utf-8")
OWN = with_custom_skills(
    "{orbit: {approach: 0.5, avoid: -1}, x2: {}}",
    "[orbit, avoid]",
    "{skills: {orbit: {at: 5}}, episodes: [{skill: orbit, duration: 5, probability: 1}]}",
)
SPLINTERS = [
    *("[", "]", "{", "}", ": ", "- ", "\n", "\n  ", "&a ", "*a", "! ", "!!int ", "'", '"', "|\n"),
    *("? ", "~", "---\n", "...\n", "<<: ", "%YAML 9\n", '"\\ud800"', "\ud800", "\0", "\t", "1e9"),
]


def outcome(text: str, *settings_: str) -> RunSpec | PresetError:
    """A run or what is wrong with it: nothing else can become of a text."""
    try:
        return load(text, settings_) if settings_ else parse(text, "mine.yaml")
    except PresetError as error:
        return error


@pytest.mark.parametrize("preset", [TIMED, OWN], ids=["timed", "own"])
@given(
    st.lists(
        st.tuples(
            st.integers(0, max(len(TIMED), len(OWN))),
            st.integers(0, 9),
            st.text(max_size=4) | st.sampled_from(SPLINTERS),
        ),
        max_size=4,
    )
)
@settings(max_examples=5 * settings().max_examples)
def test_a_text_is_read_or_refused(preset: str, cuts: list[tuple[int, int, str]]) -> None:
    text = preset
    for start, length, splinter in cuts:
        text = text[:start] + splinter + text[start + length :]
    result = outcome(text)
    if isinstance(result, PresetError):
        assert all(str(problem).isprintable() for problem in result.problems)
    else:
        assert parse(dump(result), "dumped") == result


@given(st.binary(max_size=200))
def test_bytes_are_refused(data: bytes) -> None:
    with pytest.raises(PresetError):
        parse(data, "mine.yaml")


@given(st.text(max_size=40) | st.text("=.[]{}:0a, ", max_size=20))
def test_a_setting_is_read_or_refused(setting: str) -> None:
    result = outcome("timed", setting)
    if isinstance(result, PresetError):
        assert all(str(problem).isprintable() for problem in result.problems)


# --- The reference page --------------------------------------------------------------------------


def page_rows() -> dict[str, list[str]]:
    rows = re.findall(r"^\| `([^`]+)` \|(.*)\|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    return {key: [cell.strip() for cell in cells.split("|")] for key, cells in rows}


def test_the_page_has_every_key_and_no_other() -> None:
    assert page_rows().keys() - set(shipped()) - {"extends"} == KEYS.keys()


@pytest.mark.parametrize("key", KEYS)
def test_the_page_gives_the_default(key: str) -> None:
    field = KEYS[key]
    default = page_rows()[key][1]
    if field.is_required():
        assert default == "required"
        return
    expected = field.get_default(call_default_factory=True)
    if isinstance(expected, BaseModel):
        expected = expected.model_dump(exclude_defaults=True)
    if isinstance(expected, tuple):
        expected = list(expected)
    assert yaml.safe_load(default.strip("`")) == expected


@pytest.mark.parametrize("key", KEYS)
def test_the_page_gives_the_limits(key: str) -> None:
    limits = {
        float(value)
        for item in KEYS[key].metadata
        for name in ("ge", "gt", "le", "lt", "multiple_of", "max_length")
        if (value := getattr(item, name, None)) is not None
    }
    if not limits:
        return
    allowed = page_rows()[key][2]
    assert {float(number) for number in re.findall(r"-?[0-9]+", allowed)} == limits


def test_the_page_names_every_skill_and_every_thesis_preset() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert all(f"`{name}`" in text for name in [*SKILLS, *THE_THESIS])


def test_the_page_says_what_a_skill_may_be_called_and_how_many_options_there_are() -> None:
    longest, pattern = get_args(SkillName)[1].metadata
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    assert pattern.pattern == "^[a-z][a-z0-9_]*$"
    assert (
        f"The name of a skill has up to {longest.max_length} characters from `a` to `z`, `0` to"
        " `9` and `_`, and starts with a letter."
    ) in text
    assert re.findall("[0-9]+", page_rows()["learner.options"][2]) == [str(MAX_ACTIONS)]


def examples() -> list[str]:
    return re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def test_the_examples_of_the_page_are_sound() -> None:
    assert len(examples()) >= 5
    for text in examples():
        assert parse(text, "README.md")


def test_the_page_has_an_example_of_a_skill_of_ones_own() -> None:
    own = next(text for text in examples() if "options: [approach, spiral_in]" in text)
    learner = parse(own, "README.md").learner
    assert learner.reward_of("spiral_in") == LocalReward(0.5, -1.0, -SPIRAL_PENALTY)


def test_the_complete_example_is_timed_on_a_larger_grid_and_gives_every_key() -> None:
    complete = next(text for text in examples() if "Timed, on a grid of 150" in text)
    expected = load(
        "timed",
        [
            "world.size=150",
            "description=Timed, on a grid of 150.",
            "learner.custom_skills.spiral_in={approach: 0.5, circle_clockwise: 1}",
        ],
    )
    assert parse(complete, "README.md") == expected
    words = set(re.findall(r"[a-z_]+(?=:)", complete))
    assert {key.rpartition(".")[2] for key in KEYS} <= words


def test_the_settings_of_the_page_work() -> None:
    text = PAGE.read_text(encoding="utf-8")
    listed = [shlex.split(line)[1] for line in re.findall(r"^--set [^:\n]+$", text, re.MULTILINE)]
    assert len(listed) == 5
    for setting in listed:
        preset = "hierarchical_3" if "options" in setting else "timed"
        assert load(preset, [setting]) != load(preset)
