"""What stands beside a lesson's run: the runs of its race, and the runs of its experiments.

They are made as far as anything in the lesson asks for them, with the seed of the run itself.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from app.documents import experiments, presets
from app.documents.lesson_cards import Card
from app.documents.lesson_grammar import Check, OfExperiment, Reading
from app.documents.lessons import Lesson
from app.lessons.measures import Columns, Deeds, Racing
from app.lessons.reveals import varies
from app.lessons.shared import Shared
from app.live.race import THESIS_FOUR
from app.metrics import measured as metrics_of
from app.metrics import wants_coherence, wants_greedy
from app.metrics.course import Course, coherence_of, greedy_of
from learners.checkpoints import logs_of
from learners.run import Run
from learners.spec import RunSpec


class Measuring(NamedTuple):
    """Something that a card measures."""

    reading: Reading
    values: tuple[str, ...]
    """The options that it is to tell apart, where there are any."""


def deeds_beside(lesson: Lesson, seed: int, shared: Shared, every_answer: bool = True) -> Deeds:
    """All of it, for one seed.

    Args:
        lesson: the lesson.
        seed: of all runs.
        shared: where they are made.
        every_answer: whether also for questions of which nothing is proved.
    """
    readings = list(readings_of(lesson.spec.steps, every_answer))
    return Deeds(
        race=_race(lesson, readings, seed, shared),
        experiments=_experiments(readings, seed, shared),
    )


def _race(
    lesson: Lesson, readings: Sequence[Measuring], seed: int, shared: Shared
) -> tuple[Racing, ...]:
    steps = _leads(readings)
    if not steps:
        return ()
    return tuple(
        racing_of(name, shared.finished(_preset(name), seed, max(steps)))
        for name in _racers(lesson)
    )


def _experiments(
    readings: Sequence[Measuring], seed: int, shared: Shared
) -> Mapping[str, Mapping[str, Columns]]:
    """One run of each variant."""
    found: dict[str, dict[str, dict[str, list[float]]]] = {}
    for reading, values in readings:
        of = reading.args
        if not isinstance(of, OfExperiment):
            continue
        asked = values if of.variant is None else (of.variant, of.against)
        for label, spec in _variants(of.name).items():
            if label not in asked:
                continue
            columns = found.setdefault(of.name, {}).setdefault(label, {})
            if of.quantity not in columns:
                value = _quantity(shared.finished(spec, seed), of.quantity)
                columns[of.quantity] = [] if value is None else [value]
    return found


def _quantity(run: Run, name: str) -> float | None:
    """A column of the table of results, of a run that has had its trials."""
    greedy = greedy_of(run) if wants_greedy((name,)) else None
    coherence = coherence_of(run) if wants_coherence((name,)) else None
    course = Course(run, run.preset.trials, greedy=greedy, coherence=coherence)
    value = metrics_of(course, (name,))[name]
    return None if value is None else float(value)


def racing_of(name: str, run: Run) -> Racing:
    """A run as one of several side by side."""
    logs, trial = logs_of(run.state), run.trial
    ends = np.cumsum(logs.log_steps[:trial], dtype=np.int64)
    is_over = trial >= run.spec.trials
    return Racing(name, logs.log_reward[:trial], ends, run.step, is_over)


def specs_beside(lesson: Lesson) -> list[RunSpec]:
    """The presets and variants of what stands beside a lesson's run, as far as it asks for any."""
    readings = [*readings_of(lesson.spec.steps)]
    found = [_preset(name) for name in _racers(lesson)] if _leads(readings) else []
    for reading, _ in readings:
        if isinstance(reading.args, OfExperiment):
            found += _variants(reading.args.name).values()
    return found


def _racers(lesson: Lesson) -> tuple[str, ...]:
    """Presets of a lesson's race."""
    asked = [card.do for card in lesson.spec.steps if card.do and card.do.command == "race"]
    return next((do.presets for do in asked if do.presets), None) or THESIS_FOUR


def _leads(readings: Iterable[Measuring]) -> list[int]:
    """Steps at which it is asked who leads a race."""
    return [reading.args for reading, _ in readings if reading.name == "leader"]


@lru_cache(maxsize=8)
def _preset(name: str) -> RunSpec:
    return presets.load(name)


@lru_cache(maxsize=8)
def _variants(name: str) -> Mapping[str, RunSpec]:
    """The variants of a shipped experiment, by their labels."""
    return {variant.label: variant.spec for variant in experiments.load(name).variants}


def readings_of(cards: Iterable[Card], every_answer: bool = True) -> Iterator[Measuring]:
    """All that is measured in some cards; if not for every answer, for those that are proved."""
    for card in cards:
        if card.check is not None:
            for reading in _readings_in(card.check):
                yield Measuring(reading, ())
        question = card.question
        if question is None or (varies(question) and not every_answer):
            continue
        if question.reveal is not None:
            values = tuple(value for value, _ in question.choices)
            yield Measuring(question.reveal.reading, values)


def _readings_in(check: Check) -> Iterator[Reading]:
    if check.reading is not None:
        yield check.reading
    for part in (*(check.all_of or ()), *(check.any_of or ()), *filter(None, [check.not_so])):
        yield from _readings_in(part)
