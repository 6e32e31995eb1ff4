"""Lessons: what is shipped, what is read, what is refused in which words, and other languages."""

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from app.documents import lessons, presets
from app.documents.faults import faults_of
from app.documents.lesson_cards import CONTROLS, VERBS, Card, DoIt
from app.documents.lesson_grammar import (
    DEEDS,
    LAYERS,
    SHAPES,
    Check,
    Moment,
    OfExperiment,
    Reading,
    Window,
)
from app.documents.lesson_questions import MAX_WORDS
from app.documents.lessons import Lesson, LessonError, parse, shipped
from app.documents.tree import PresetProblem
from app.explain.shape import Shape
from app.picture.layers import LAYERS as PAINTED
from learners.names import MAX_TRIALS
from tests.support.hostile_lessons import mutation

LESSON = """
title: Small
minutes: 3
setup: {preset: timed, start: 3000}
show: [play]
steps:
"""
SAID = "  - say: A word.\n"
ASKED = "  - {ask: number, id: it, text: How many, low: 0, high: 9, reveal: {measure: captures}}\n"
DONE = (
    "  - {do: {command: play}, text: Play., check: {measure: trial, above: 9},"
    " hints: [H, {do: true}]}\n"
)


def lesson(*cards: str, after: str = "") -> Lesson:
    return parse(LESSON + "".join(cards) + after, "mine.yaml")


def complaints(text: bytes | str) -> list[str]:
    """What is wrong with a text, without the name of the file."""
    with pytest.raises(LessonError) as caught:
        parse(text, "mine.yaml")
    error = caught.value
    assert error.problems
    assert str(error).splitlines() == [str(problem) for problem in error.problems]
    assert "Input should" not in str(error)
    assert all(str(problem).isprintable() for problem in error.problems)
    return [line.removeprefix("mine.yaml:") for line in str(error).splitlines()]


def problems_of(text: bytes) -> Sequence[PresetProblem]:
    """What is wrong with a text, if anything is."""
    try:
        parse(text, "mine.yaml")
    except LessonError as error:
        return error.problems
    return ()


def of_cards(*cards: str, after: str = "") -> list[str]:
    return complaints(LESSON + "".join(cards) + after)


# --- What is shipped -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_lesson_is_sound_in_english_and_german(name: str) -> None:
    found = lessons.load(name)
    assert (found.name, found.source) == (name, name)
    assert found.spec.languages == ("en", "de")
    assert set(found.spec.needs) <= set(shipped()) - {name}
    assert parse(found.text, f"{name}.yaml").digest == found.digest


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_lesson_ends_with_everything_and_hides_it_before(name: str) -> None:
    spec = lessons.load(name).spec
    assert [card.kind for card in spec.steps].count("free") == 1
    assert spec.steps[-1].kind == "free"
    assert "all" not in {*spec.show, *(control for card in spec.steps for control in card.unlock)}


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_lesson_asks_the_same_in_each_language(name: str) -> None:
    spec = lessons.load(name).spec
    german = spec.in_language("de")
    assert german.title != spec.title
    for card, other in zip(spec.steps, german.steps, strict=True):
        assert (card.id, card.kind, card.does_it) == (other.id, other.kind, other.does_it)
        assert len(card.hints) == len(other.hints)
        asked, likewise = spec.question_of(card), german.question_of(other)
        if asked is not None and likewise is not None:
            assert [value for value, _ in asked.choices] == [v for v, _ in likewise.choices]
            assert (asked.reveal, asked.key) == (likewise.reveal, likewise.key)
        if card.words:
            assert card.words != other.words


# --- What is read --------------------------------------------------------------------------------


def test_cards_know_their_kind_their_words_and_their_ids() -> None:
    spec = lesson(
        SAID,
        ASKED,
        DONE,
        "  - see: {same_as: it}\n",
        "  - why: {inspect: behind, text: Because.}\n",
        "  - {free: {show: all}, text: Go on.}\n",
    ).spec
    assert [card.kind for card in spec.steps] == ["say", "ask", "do", "see", "why", "free"]
    assert spec.ids == ("step_1", "it", "step_3", "step_4", "step_5", "step_6")
    words = ["A word.", "How many", "Play.", "", "Because.", "Go on."]
    assert [card.words for card in spec.steps] == words
    assert spec.question_of(spec.steps[3]) is spec.card_of("it")
    assert spec.question_of(spec.steps[2]) is None
    assert (spec.steps[2].hints, spec.steps[2].does_it) == (("H",), True)


@pytest.mark.parametrize(
    ("written", "meant", "from_300"),
    [
        ("5000", Moment(5_000, False), 5_000),
        ("+50", Moment(50, True), 350),
        ('"+50"', Moment(50, True), 350),
        ("{captures: 5}", Moment(0, True, 5), 305),
    ],
)
def test_moments_are_trials_or_lie_ahead(written: str, meant: Moment, from_300: int) -> None:
    card = lesson(f"  - {{say: A word., run: {written}}}\n").spec.steps[0]
    assert card.run == meant
    assert meant.after(300) == from_300


@pytest.mark.parametrize(
    ("written", "reading"),
    [
        ("measure: value_states, above: 1", Reading("value_states", None)),
        ("present: avoid", Reading("present", "avoid")),
        ("reach: right_flank, between: [0.2, 1]", Reading("reach", "right_flank")),
        ("reward: 500, below: 3", Reading("reward", Window(500))),
        (
            "change: [[0, 500], 500], above: 30",
            Reading("change", (Window(None, 0, 500), Window(500))),
        ),
        ("leader: 1000000, is: timed", Reading("leader", 1_000_000)),
        ("command: introduce", Reading("command", "introduce")),
        (
            "experiment: {name: ablation, quantity: final_reward, variant: timed}, below: 9",
            Reading(
                "experiment",
                OfExperiment(name="ablation", quantity="final_reward", variant="timed"),
            ),
        ),
    ],
)
def test_a_check_is_of_one_measure(written: str, reading: Reading) -> None:
    check = lesson(DONE.replace("measure: trial, above: 9", written)).spec.steps[0].check
    assert check is not None
    assert check.reading == reading


def test_checks_are_made_of_checks() -> None:
    text = "all: [{present: avoid}, {not: {measure: success, below: 0.5, for: 20}}], by: +90"
    check = lesson(DONE.replace("measure: trial, above: 9", text)).spec.steps[0].check
    assert isinstance(check, Check)
    assert (check.reading, check.by) == (None, Moment(90, True))
    assert check.all_of is not None
    first, second = check.all_of
    assert first.reading == Reading("present", "avoid")
    assert second.not_so is not None
    assert (second.not_so.operators, second.not_so.holds_for) == ({"below": 0.5}, 20)


def test_what_is_opened_is_why_a_layer_or_a_place() -> None:
    for written in ("why", "{layer: flow}", "{cell: behind}"):
        text = DONE.replace("measure: trial, above: 9", f"opened: {written}")
        check = lesson(text).spec.steps[0].check
        assert check is not None
        assert check.opened is not None
        assert written == str(check.opened.what) or f"{check.opened.what}: " in written


def test_the_setup_may_change_the_preset_and_a_new_start_may_as_well() -> None:
    again = (
        "  - {do: {command: start_again, set: {learner.epsilon: 0.3}}, text: Again.,"
        " unlock: [start_again], check: {command: start_again}}\n"
    )
    text = (LESSON + again).replace("start: 3000}", "start: 3000, set: {trials: 9000}}")
    found = parse(text, "mine.yaml")
    assert found.run_spec.trials == 9_000
    assert found.starts["step_1"].trials == 9_000
    assert found.starts["step_1"].learner.epsilon == 0.3
    assert found.run_spec.learner.epsilon != 0.3


def test_the_digest_is_of_what_is_said_and_not_of_how_it_is_laid_out() -> None:
    as_it_is = lesson(SAID)
    evidence = "evidence: {seeds: 20, pass: 19}\n"
    other_layout = parse(f"# A comment\n{evidence}{LESSON}\n{SAID}", "other.yaml")
    assert other_layout.digest == as_it_is.digest
    assert other_layout.spec.evidence is not None
    assert (other_layout.spec.evidence.seeds, other_layout.spec.evidence.passed) == (20, 19)
    assert lesson(SAID.replace("word", "world")).digest != as_it_is.digest
    assert (
        parse((LESSON + SAID).replace("timed,", "hierarchical_3,"), "m").digest != as_it_is.digest
    )


def test_a_preset_lies_beside_the_lesson_where_there_is_a_folder(tmp_path: Path) -> None:
    (tmp_path / "own.yaml").write_text("extends: timed\ntrials: 5000\n")
    text = (LESSON + SAID).replace("preset: timed", "preset: own.yaml")
    (tmp_path / "mine.yaml").write_text(text)
    found = lessons.load(str(tmp_path / "mine.yaml"))
    assert (found.run_spec.trials, found.source) == (5_000, str(tmp_path / "mine.yaml"))
    assert "is not a shipped preset" in complaints(text)[0]


# --- Other languages -----------------------------------------------------------------------------

CHOICE = (
    "  - {ask: direction, id: which, text: Which way, options: [clockwise, not at all],"
    " key: clockwise, reveal: {measure: spread_direction}}\n"
)
GERMAN = """
texts:
  de:
    title: Klein
    cards:
      - {text: Ein Wort.}
      - {text: Wohin, options: [im Uhrzeigersinn, gar nicht]}
      - {text: Spiele., hints: [Hinweis]}
      - {}
"""


def test_in_another_language_words_change_and_what_they_stand_for_does_not() -> None:
    found = lesson(SAID, CHOICE, DONE, "  - see: {same_as: which}\n", after=GERMAN)
    german = found.spec.in_language("de")
    assert german.title == "Klein"
    assert [card.words for card in german.steps] == ["Ein Wort.", "Wohin", "Spiele.", ""]
    asked = german.question_of(german.steps[3])
    assert asked is not None
    assert asked.choices == (("clockwise", "im Uhrzeigersinn"), ("not at all", "gar nicht"))
    assert asked.key == "clockwise"
    assert german.steps[2].steps_of_help == ("Hinweis", DoIt(do=True))
    assert found.spec.in_language("en") is found.spec.in_language("fr") is found.spec


def test_a_translation_has_the_shape_of_the_lesson() -> None:
    wrong = (
        GERMAN.replace("{text: Ein Wort.}", "{text: Ein Wort., notes: Mehr.}")
        .replace(", gar nicht]", "]")
        .replace("{text: Spiele., hints: [Hinweis]}", "{text: Spiele.}")
        .replace("      - {}\n", "")
    )
    said = of_cards(SAID, CHOICE, DONE, "  - see: {same_as: which}\n", after=wrong)
    key = "texts.de.cards"
    shown = said[0].partition(f"{key}: ")[2].partition(": has")[0]
    assert shown.startswith("value [{'text': 'Ein Wort.', 'notes': 'Mehr.'}, ")
    assert [line.partition(": ")[2] for line in said] == [
        f"{key}: {shown}: has 3 cards; allowed: one for each of the 4",
        f"{key}.0.notes: value 'Mehr.': is not in the lesson itself; allowed: what step_1 has",
        f"{key}.1.options: value ['im Uhrzeigersinn']: has 1 items; allowed: 2 as in which",
        f"{key}.2.hints: is missing; allowed: hints as in step_3",
    ]


@pytest.mark.parametrize("where", ["say", "text"])
def test_no_card_has_more_words_than_are_read_in_any_language(where: str) -> None:
    def said(n: int) -> str:
        return " – ".join(["Wort"] * n)

    def text(n: int) -> str:
        own, german = (n, 1) if where == "say" else (1, n)
        texts = f"texts: {{de: {{title: Klein, cards: [{{text: {said(german)}}}]}}}}"
        return f"{LESSON}  - say: {said(own)}\n{texts}\n"

    assert parse(text(MAX_WORDS), "mine.yaml")
    (line,) = complaints(text(MAX_WORDS + 1))
    assert f"has {MAX_WORDS + 1} words; allowed: up to {MAX_WORDS} on a card" in line


# --- What is refused -----------------------------------------------------------------------------


def test_all_that_is_wrong_with_values_is_said_at_once() -> None:
    text = (
        "title: 5\nminutes: 90\nsetup: {preset: timd, start: -1}\nshow: [play, laier.value]\n"
        "steps:\n  - {sya: A word.}\n  - {say: A word., look: {layer: valu, mark: behnd}}\n"
    )
    assert complaints(text) == [
        "1: title: value 5: must be a text; allowed: a text of up to 80 characters",
        "2: minutes: value 90: must be at most 60; allowed: 1 to 60",
        "3: setup.start: value -1: must be at least 0; allowed: 0 to 2000000",
        "3: setup.preset: value 'timd': is not a shipped preset (did you mean timed?); allowed:"
        f" {', '.join(presets.shipped())}",
        "4: show.1: value 'laier.value': is no control (did you mean layer.value?); allowed:"
        f" {', '.join(CONTROLS)}",
        "6: steps.0.sya: value 'A word.': is not a known key (did you mean say?); allowed:"
        f" {', '.join(KEYS_OF_CARDS)}",
        "7: steps.1.look.layer: value 'valu': is no layer (did you mean value?); allowed:"
        f" {', '.join(LAYERS)}",
        "7: steps.1.look.mark: value 'behnd': is no region (did you mean behind?); allowed: behind,"
        " ahead, left_flank, right_flank, visual_field, near, far, e, ne, n, nw, w, sw, s, se",
    ]


KEYS_OF_CARDS = [field.alias or name for name, field in Card.model_fields.items()]


def of_experiment(name: str, quantity: str) -> str:
    reveal = f"{{experiment: {{name: {name}, quantity: {quantity}}}}}"
    return f"{{ask: number, text: A, low: 1, high: 2, reveal: {reveal}}}"


@pytest.mark.parametrize(
    ("card", "complaint"),
    [
        ("{id: it}", "steps.0: value {'id': 'it'}: has nothing to do; allowed: one of"),
        ("{say: A, see: {same_as: b}}", "has say and see; allowed: one of say, ask,"),
        ("{say: A, options: [a, b]}", "steps.0.options: value ['a', 'b']: does not belong to say"),
        (
            "{say: A, hints: [a]}",
            "steps.0.hints: value ['a']: does not belong to say; allowed: in do",
        ),
        ("{say: A, low: 3}", "steps.0.low: value 3: does not belong to say; allowed: in ask"),
        ("{ask: number, text: A}", "steps.0.low: is missing; allowed: a number"),
        ("{ask: choice, text: A}", "steps.0.options: is missing; allowed: 2 to 8 texts"),
        ("{ask: choice, options: [a, b]}", "steps.0.text: is missing; allowed: a text"),
        (
            "{ask: choice, text: A, options: [a, b]}",
            "has nothing to reveal; allowed: reveal, or key",
        ),
        (
            "{ask: choice, text: A, options: [a, a], key: a}",
            "steps.0.options.1: value 'a': is there twice",
        ),
        (
            "{ask: choice, text: A, options: [a, bc], key: bd}",
            "is not among the answers; allowed: a, bc",
        ),
        (
            "{ask: choice, text: A, options: [a, b], values: [a, b, c], key: a}",
            "value ['a', 'b', 'c']: has 3 items; allowed: one for each of the options",
        ),
        (
            "{ask: choice, text: A, options: [a, b], from: 3, key: a}",
            "steps.0.from: value 3: does not belong",
        ),
        (
            "{ask: number, text: A, low: 3, high: 3, key: 3}",
            "steps.0.high: value 3: must be more than low, 3",
        ),
        (
            "{ask: number, text: A, low: 3, high: 5, key: 6}",
            "steps.0.key: value 6: is not among the answers",
        ),
        (
            "{ask: sectors, text: A, key: [n, m]}",
            "steps.0.key: value ['n', 'm']: is not among the answers",
        ),
        ("{ask: order, text: A, options: [a, b], key: [a, a]}", "allowed: a list of all of a, b"),
        (
            "{ask: sketch, text: A, from: 5, to: 9, reveal: {reward: 9}}",
            "steps.0.to: value 9: leaves no trial for each handle; allowed: from 10 on",
        ),
        (
            "{ask: sketch, text: A, from: 5, to: 10, key: 3}",
            "steps.0.key: value 3: is not among the answers",
        ),
        (
            "{ask: moment, text: A, key: {a: 1}}",
            "is no answer; allowed: a text, a number, or a list of texts",
        ),
        (
            "{ask: number, text: A, low: 1, high: 2, reveal: {measure: shape}}",
            "value {'measure': 'shape'}: does not answer number; allowed: a measure that",
        ),
        (
            "{ask: moment, text: A, reveal: {measure: thinnest}}",
            "allowed: a measure with an operator",
        ),
        (
            "{ask: moment, text: A, reveal: {reach: octants, above: 1}}",
            "steps.0.reveal.reach: value 'octants'",
        ),
        (
            "{ask: sectors, text: A, reveal: {reach: behind, above: 1}}",
            "allowed: reach: octants, with an operator",
        ),
        (
            "{ask: choice, text: A, options: [a, b], reveal: {measure: spread_direction}}",
            "steps.0.options.0: value 'a': is nothing that spread_direction says; allowed:",
        ),
        ("{ask: choice, text: A, options: [a, b], reveal: {present: avoid}}", "allowed: yes, no"),
        (
            "{ask: choice, text: A, options: [a, b], reveal: {leader: 5}}",
            f"allowed: {', '.join(presets.shipped())}",
        ),
        (
            of_experiment("ablatoin", "final_reward"),
            "experiment.name: value 'ablatoin': is no shipped experiment (did you mean ablation?)",
        ),
        (
            of_experiment("ablation", "rewrd"),
            "steps.0.reveal.experiment.quantity: value 'rewrd': is not measured",
        ),
        ("{do: {command: play}}", "steps.0.text: is missing, which do needs; allowed: a text"),
        (
            "{do: {command: play}, text: A}",
            "steps.0.check: is missing, which do needs; allowed: a check",
        ),
        (
            "{do: {command: introduce}}",
            "steps.0.do.skill: is missing, which introduce needs; allowed: a skill",
        ),
        ("{do: {command: play, skill: avoid}}", "does not belong to play; allowed: nothing else"),
        (
            "{do: {command: plai}}",
            "is no command (did you mean play?); allowed: introduce, explore,",
        ),
        (
            "{transfer: {text: A, run: {swap: avoid}}}",
            "steps.0.transfer.ask: is missing; allowed: choice,",
        ),
        (
            "{say: A, run: +0}",
            "steps.0.run: value '+0': is no moment; allowed: a trial from 0 to 2000000, +1",
        ),
        ("{say: A, run: {captures: true}}", "steps.0.run: value {'captures': True}: is no moment"),
        (
            "{say: A, run: 3000}",
            "is not ahead of the card, which is at trial 3000; allowed: a later one",
        ),
        ("{say: A, run: +48000}", "lies beyond the preset's trials; allowed: up to 48000"),
        ('{say: "a\\u202eb"}', "contains the control character U+202E; allowed: what can be read"),
        ('{say: " "}', "is empty; allowed: a text"),
        (
            "{say: A, unlock: [step, step]}",
            "steps.0.unlock.1: value 'step': is there twice; allowed: each once",
        ),
        ("{say: A, unlock: [play]}", "steps.0.unlock.0: value 'play': is there already"),
        ("{see: {same_as: it}}", "steps.0.see.same_as: value 'it': is no card before it that asks"),
    ],
)
def test_a_card_that_makes_no_sense_is_refused(card: str, complaint: str) -> None:
    found = of_cards(f"  - {card}\n")
    assert any(complaint in line for line in found), found
    assert all(line.startswith(("7:", "8:")) for line in found)


@pytest.mark.parametrize(
    ("check", "complaint"),
    [
        (
            "{}",
            "value {}: has nothing to look at; allowed: one measure, or all, any or not",
        ),
        (
            "{measure: trial}",
            "holds trial against nothing; allowed: one of above, below, between, is",
        ),
        (
            "{measure: trial, above: 3, reach: near}",
            "has trial and reach; allowed: one measure, or all",
        ),
        (
            "{present: avoid, above: 3}",
            "steps.0.check.above: value 3: does not fit present, which is so",
        ),
        ("{measure: shape, above: 3}", "does not fit shape, which finds a word; allowed: is"),
        (
            "{measure: trial, between: [3, 1]}",
            "steps.0.check.between: value [3, 1]: is no range",
        ),
        (
            "{measure: trial, is: true}",
            "steps.0.check.is: value true: is nothing that a measure finds",
        ),
        (
            "{measure: reach, above: 1}",
            "is a measure of something; allowed: reach: OF WHAT in its place",
        ),
        ("{reach: octants, above: 1}", "is of octants that are predicted; allowed: a region"),
        (
            "{reward: [5, 5], above: 1}",
            "is no window; allowed: so many of the last trials, or [first, end]",
        ),
        ("{all: [], above: 1}", "steps.0.check.all: value []: has too few items"),
        (
            "{not: {present: avoid}, is: 3}",
            "steps.0.check.is: value 3: belongs to a measure, not to not",
        ),
        (
            "{opened: {cell: hind}}",
            "is nothing to open (did you mean behind?); allowed: behind, ahead,",
        ),
        ("{opened: how}", "is nothing to open; allowed: why, {layer: KEY}, or {cell: REGION}"),
        (
            "{present: sneak}",
            "steps.0.check.present: value 'sneak': is no skill of the preset; allowed: approach",
        ),
        (
            "{measure: trial, above: 9, by: 2999}",
            "steps.0.check.by: value 2999: is not ahead of the card",
        ),
        (
            "{all: [{measure: trial, above: 9, by: +50000}]}",
            "steps.0.check.all.0.by: value '+50000': lies beyond",
        ),
        ("{measure: trial, above: .inf}", "steps.0.check.above: value inf: must be finite"),
    ],
)
def test_a_check_that_makes_no_sense_is_refused(check: str, complaint: str) -> None:
    found = of_cards(DONE.replace("{measure: trial, above: 9}", check))
    assert any(complaint in line for line in found), found


def test_what_does_not_go_together_in_a_lesson_is_said_at_once() -> None:
    skill = "{do: {command: introduce, skill: circling}, text: A, check: {command: play}}"
    race = "{do: {command: race, presets: [timed, mine]}, text: A, check: {command: race}}"
    swap = "{transfer: {ask: moment, text: A, key: 5, run: {swap: circle}}}"
    found = of_cards(
        ASKED,
        ASKED,
        f"  - {skill}\n",
        f"  - {swap}\n",
        f"  - {race}\n",
        "  - {do: {command: show, layer: flow}, text: A, check: {opened: {layer: flow}}}\n",
        after="texts: {en: {title: A, cards: []}}\n",
    )
    assert [line.partition("; allowed")[0] for line in found] == [
        "8: steps.1.id: value 'it': is the id of an earlier card",
        "9: steps.2.do.command: value 'introduce': cannot be done without add_skill",
        "9: steps.2.do.skill: value 'circling': is no skill of the preset",
        "10: steps.3.transfer.run.swap: value 'circle': is no skill",
        "11: steps.4.do.command: value 'race': cannot be done without side",
        "11: steps.4.do.presets.1: value 'mine': is no shipped preset",
        "12: steps.5.do.command: value 'show': cannot be done without layer.flow",
        "13: texts.en: value {'title': 'A', 'cards': []}: is the lesson's own language",
    ]


def test_a_swap_needs_a_skill_that_was_added() -> None:
    (line,) = of_cards("  - {transfer: {ask: moment, text: A, key: 5, run: {swap: avoid}}}\n")
    assert "has no skill that it could take the place of; allowed: after an introduce" in line


def test_only_the_last_hint_does_it() -> None:
    (line,) = of_cards(DONE.replace("[H, {do: true}]", "[{do: true}, H]"))
    assert line.endswith(
        "steps.0.hints.0: value {'do': True}: is not the last hint; allowed: as the last"
    )
    (line,) = of_cards(DONE.replace("{do: true}", "{do: false}"))
    assert "is no hint; allowed: a text, or {do: true} as the last" in line


@pytest.mark.parametrize("at", ["+50", "{captures: 2}", "48001"])
def test_what_is_gone_back_to_is_a_certain_trial(at: str) -> None:
    done = f"do: {{command: rewind, at: {at}}}, text: A, check: {{command: rewind}}"
    (line,) = of_cards(f"  - {{{done}, unlock: [scrub]}}\n")
    assert line.endswith("is no trial that can be gone back to; allowed: 0 to 48000")


def test_it_is_run_on_and_not_back() -> None:
    (line,) = of_cards("  - {do: {command: run_to, at: 3000}, text: A, check: {command: run_to}}\n")
    assert "steps.0.do.at: value 3000: is not ahead of the card, which is at trial 3000" in line


def test_a_lesson_begins_within_its_preset() -> None:
    text = (LESSON + SAID).replace("start: 3000", "start: 48000")
    (line,) = complaints(text)
    assert line.endswith("lies beyond the preset's trials; allowed: 0 to 47999")


def test_evidence_is_no_more_than_there_are_seeds() -> None:
    (line,) = of_cards(SAID, after="evidence: {seeds: 20, pass: 21}\n")
    assert line == "8: evidence.pass: value 21: is more than there are; allowed: up to seeds, 20"


def test_what_is_wrong_with_the_preset_is_said_of_the_lesson() -> None:
    text = (LESSON + SAID).replace("start: 3000", "set: {learner.epsilon: 2, extends: timed}")
    assert complaints(text) == [
        "4: setup.set.extends: value 'timed': cannot be varied; allowed: in a preset's file",
        "4: learner.epsilon: value 2: must be at most 1; allowed: 0 to 1",
    ]


# --- Closed lists --------------------------------------------------------------------------------


def test_lists_that_others_have_are_the_same() -> None:
    assert tuple(PAINTED) == LAYERS
    assert Shape.__args__ == SHAPES
    assert set(VERBS) <= set(KEYS_OF_CARDS)
    assert {name for name in CONTROLS if name.startswith("layer.")} == {
        f"layer.{key}" for key in PAINTED
    }


@pytest.mark.parametrize("command", DEEDS)
def test_every_command_can_be_asked_for(command: str) -> None:
    parts: dict[str, str] = {
        "introduce": "skill: avoid, freeze: 300, explore: {trials: 5, chance: 0.5}",
        "explore": "skill: approach, explore: {trials: 5, chance: 0.5}",
        "stop_exploring": "skill: approach",
        "freeze_selection": "on: true",
        "freeze_skills": "on: false",
        "follow_schedule": "on: false",
        "remove": "skill: approach",
        "run_to": "at: +50",
        "rewind": "at: 500",
        "fork": "at: 500, then: [{command: introduce, skill: avoid}]",
        "experiment": "name: ablation",
        "inspect": "region: behind",
        "show": "layer: value",
    }
    done = f"{{command: {command}, {parts.get(command, '')}}}"
    found = lesson(f"  - {{do: {done}, text: A, unlock: [all], check: {{command: {command}}}}}\n")
    done_there = found.spec.steps[0].do
    assert done_there is not None
    assert done_there.command == command


# --- Files from somewhere ------------------------------------------------------------------------


@pytest.mark.parametrize("part", range(6))
def test_a_file_that_means_ill_is_a_good_lesson_or_is_refused_in_words(part: int) -> None:
    texts = [file.read_bytes() for file in shipped().values()]
    found = [
        problems_of(mutation(texts[seed % len(texts)], seed))
        for seed in range(50 * part, 50 * part + 50)
    ]
    assert sum(map(bool, found)) > 25
    for problem in itertools.chain(*found):
        assert problem.source == "mine.yaml"
        assert problem.message
        assert str(problem).isprintable()
        assert "Input should" not in problem.message
        # A file that is no text, or no YAML, may have no line.
        assert problem.line is not None or problem.message.startswith(("is not ", "is too large"))


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.text(max_size=8),
        lambda inner: (
            st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
        ),
        max_leaves=8,
    ),
    st.sampled_from(KEYS_OF_CARDS),
)
@settings(max_examples=60, deadline=None)
def test_any_value_of_any_key_of_a_card_is_judged(value: Any, key: str) -> None:
    try:
        card = Card.model_validate({"say": "A word.", key: value})
    except ValidationError as error:
        faults = list(faults_of(error, Card))
        assert all(fault.message for fault in faults)
    else:
        assert card.kind == "say"


@given(
    st.integers(min_value=1, max_value=MAX_TRIALS), st.integers(min_value=0, max_value=MAX_TRIALS)
)
@settings(max_examples=30, deadline=None)
def test_a_moment_ahead_is_never_behind(trials: int, began: int) -> None:
    assert Moment(trials, True).after(began) == began + trials > began
