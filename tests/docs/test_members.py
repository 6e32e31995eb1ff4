"""Whatever a person can set, see, ask for or press is documented, and nothing else is.

Each test goes over all members of a registry in the code, so that a new one without a row fails.
"""

import dataclasses
import inspect
import re
from collections.abc import Iterator
from typing import Any, get_args, get_type_hints

import pytest

from app import metrics
from app.cli import main
from app.documents import experiments
from app.documents.tree import PresetError
from app.explain.commands import command_in_words
from app.page import keys
from app.picture.layers import LAYERS
from app.util.html import escaped
from app.util.logs import LEVELS
from app.words.plain import PARAMETER_NAMES
from learners.commands import (
    Command,
    DefineSkill,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
    SetSchedule,
    StopExploring,
    StopTeaching,
    Teach,
    Undo,
)
from learners.parameters import PARAMETERS
from learners.schedule_spec import ScheduleSpec
from learners.skill_spec import SkillWeights
from tests.support.pages import ROOT, rows_of

EXAMPLES: tuple[Command, ...] = (
    Introduce("avoid", 300),
    Explore("avoid", 2_000, 0.3),
    StopExploring("avoid"),
    Teach("flank", 300),
    StopTeaching(),
    FreezeSelection(True),
    FreezeSkills(True),
    FollowSchedule(False),
    DefineSkill("spiral_in", SkillWeights(approach=0.5)),
    Remove("avoid"),
    SetParameter("learner.epsilon", 0.2),
    SetSchedule(ScheduleSpec()),
    Undo(3),
)


def quoted(row: list[str]) -> str:
    """The name in the first cell of a row."""
    return row[0].strip("`")


# --- The command line ----------------------------------------------------------------------------


def options_of(kind: type[Any]) -> Iterator[tuple[str, str]]:
    """How each option of a command is written, and its default as far as it is said by a type."""
    hints = get_type_hints(kind, include_extras=True)
    for field in dataclasses.fields(kind):
        marks = getattr(hints[field.name], "__metadata__", ())
        metavar = next((mark.metavar for mark in marks if getattr(mark, "metavar", None)), "")
        is_positional = any("POSITIONAL" in repr(mark).upper() for mark in marks)
        option = f"--{field.name.removesuffix('_').replace('_', '-')}"
        written = metavar if is_positional else " ".join(filter(None, [option, metavar]))
        default = field.default if isinstance(field.default, str) else ""
        yield written, f"`{default}`" if default else ""


@pytest.mark.parametrize("name", main.COMMANDS)
def test_every_command_has_each_of_its_options_and_no_other(name: str) -> None:
    kind = main.COMMANDS[name]
    heading = f"## `pounce {name}`"
    options = dict(options_of(kind))
    rows = rows_of("docs/commands.md", heading) if options else []
    assert [quoted(row) for row in rows[1:]] == list(options)
    for row in rows[1:]:
        default = options[quoted(row)]
        assert not default or row[1] == default, row
        assert row[2].endswith("."), row


def test_every_command_is_described_there() -> None:
    text = (ROOT / "docs" / "commands.md").read_text("utf-8")
    assert re.findall(r"^## `pounce (\w+)`$", text, re.MULTILINE) == list(main.COMMANDS)
    assert all(f"`{level}`" in text for level in LEVELS)


def test_every_command_and_option_says_in_its_help_what_it_does() -> None:
    for kind in main.COMMANDS.values():
        assert (inspect.getdoc(kind) or "").endswith(".")
        source = inspect.getsource(kind)
        for field in dataclasses.fields(kind):
            assert re.search(
                rf'^    {field.name}: .*?\n    """\S', source, re.DOTALL | re.MULTILINE
            )


def test_every_variable_of_the_environment_that_is_ours_is_documented() -> None:
    code = "".join(file.read_text("utf-8") for file in (ROOT / "app").rglob("*.py"))
    asked_for = set(re.findall(r"POUNCE_[A-Z_]+", code))
    listed = {quoted(row) for row in rows_of("docs/commands.md", "## What the environment says")}
    assert asked_for
    assert asked_for <= listed


# --- Experiments and their results ---------------------------------------------------------------


def keys_of_experiments(text: str) -> set[str]:
    """Keys that are allowed beside one that is not."""
    with pytest.raises(PresetError) as refused:
        experiments.parse(text, "experiment.yaml")
    line = next(line for line in str(refused.value).splitlines() if "not a known key" in line)
    return set(line.partition("allowed: ")[2].split(", "))


def test_every_key_of_an_experiment_is_documented_and_no_other() -> None:
    listed = set[str]()
    for row in rows_of("presets/experiments/README.md")[1:]:
        if row[0] == "name":
            break
        listed |= {name.strip("` ") for name in row[0].split(",")}
    assert listed == keys_of_experiments("nothing_known: 1\npresets: [timed]\n")


def test_every_key_of_a_preset_in_an_experiment_is_documented() -> None:
    (row,) = (row for row in rows_of("presets/experiments/README.md") if quoted(row) == "presets")
    allowed = keys_of_experiments("presets: [{preset: timed, nothing_known: 1}]\n")
    assert set(re.findall(r"`(\w+)`", row[3])) == allowed


def test_every_number_of_the_results_has_a_title_and_a_unit() -> None:
    rows = [row for row in rows_of("presets/experiments/README.md", "## Results") if len(row) == 4]
    assert [quoted(row) for row in rows[1:]] == list(metrics.BY_COLUMN)
    for (_, title, unit, meaning), metric in zip(rows[1:], metrics.BY_COLUMN.values(), strict=True):
        assert title == metric.title
        # What a page need not say of a count, a table of columns does.
        assert unit == (metric.unit or unit) != ""
        assert meaning.endswith(".")


# --- The page ------------------------------------------------------------------------------------


def test_every_layer_has_its_key_its_title_and_what_it_shows() -> None:
    rows = rows_of("docs/page.md", "## Layers")[1:]
    assert [row[1] for row in rows] == [layer.title for layer in LAYERS.values()]
    hotkeys = [str(key.hotkey) for key in keys.LAYERS]
    assert [row[0] for row in rows] == [*hotkeys, *[""] * (len(rows) - len(hotkeys))]
    assert all(row[2].endswith(".") for row in rows)


def documented_keys() -> dict[str, str]:
    """What each key does, by what is written on it."""
    pairs = [pair for row in rows_of("docs/page.md", "## Keys")[1:] for pair in (row[:2], row[2:])]
    return {label: does for keys, does in pairs for label in keys.split(", ")}


@pytest.mark.parametrize("key", keys.KEYS, ids=lambda key: key.name)
def test_every_key_is_documented_and_in_the_list_of_the_page(key: keys.Key) -> None:
    if key in keys.LAYERS[1:-2]:
        return  # between two that are there
    label = "1…9" if key == keys.LAYERS[0] or key == keys.LAYERS[-2] else str(key.hotkey)
    does = "the layers, in their order" if key in keys.LAYERS else key.does
    assert documented_keys()[label] == does
    shown = f'<kbd data-code="{key.name}">{escaped(key.hotkey)}</kbd>'
    row = next(row for row in keys.list_html().split("<tr>") if shown in row)
    assert does in row or len(re.findall("<kbd", row)) == 2


def test_keys_that_repeat_are_named() -> None:
    text = " ".join((ROOT / "docs" / "page.md").read_text("utf-8").split())
    repeating = [str(key.hotkey) for key in keys.KEYS if key.repeats and not key.of_time]
    assert f"but for {', '.join(repeating[:-1])} and {repeating[-1]}" in text


# --- What a learner can be asked for -------------------------------------------------------------


def test_every_command_of_the_learner_is_documented_with_its_sentence() -> None:
    assert [type(example) for example in EXAMPLES] == list(get_args(Command))
    rows = [
        row
        for row in rows_of("docs/page.md", "## What a learner can be asked for")[1:]
        if len(row) == 3
    ]
    assert [quoted(row) for row in rows] == [type(example).__name__ for example in EXAMPLES]
    for row, example in zip(rows, EXAMPLES, strict=True):
        assert row[1].endswith(".")
        assert row[2] == command_in_words(example)


def test_every_parameter_that_can_be_steered_has_its_name() -> None:
    rows = rows_of("docs/page.md", "## What a learner can be asked for")
    listed = {quoted(row): row[1] for row in rows if len(row) == 2 and row[0] != "key"}
    assert listed == {key: PARAMETER_NAMES[key] for key in PARAMETERS}
