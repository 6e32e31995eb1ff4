"""The last hint: what a card asks for is done, in the way in which a hand would do it."""

from typing import Final, NamedTuple

from app.documents import experiments, presets
from app.documents.experiments import ExperimentError
from app.documents.lesson_cards import Card, Do
from app.documents.lesson_grammar import Check
from app.documents.lessons import Lesson
from app.experiments.claims import FolderError
from app.lessons.doing import commands_of
from app.live.places import Place
from app.live.race import THESIS_FOUR
from app.live.racer import Entry
from app.live.requests import AddMark, Play, Request, RunTo, StartRace, StepOnce, TrialOnce
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.live.worker import FULL_SPEED
from app.page.lesson.controls import (
    Layer,
    LookInto,
    OpenSide,
    RunExperiment,
    StartLessonAgain,
    Wanted,
    was_explored,
)
from app.results.service import BusyError, Service
from app.server.callbacks import RefusedError
from learners.commands import Command, Explore, Introduce

_SEEDS: Final = 10
_WORKERS: Final = 2
"""Of an experiment that a card has run."""
_BESIDE: Final = ("leader", "experiment", "first_divergence")
"""Measures of what stands beside the run."""
_MARK: Final = "here"
"""The text of a mark."""


class GoTo(NamedTuple):
    """This browser is to look at the beginning of a trial."""

    trial: int


Deed = Wanted | GoTo


def deeds_of(card: Card, do: Do, began: int, status: Status, lesson: Lesson) -> tuple[Deed, ...]:
    """What comes of doing what a card asks for, one after the other.

    Args:
        card: the card.
        do: what it asks for.
        began: trial in which it was entered.
        status: what is true for the browser.
        lesson: the lesson.

    Raises:
        PresetError: there is no such preset.
    """
    snapshot = status.snapshot
    at = None if do.at is None else do.at.after(began)
    match do.command:
        case "step":
            return (StepOnce(),)
        case "trial":
            return (TrialOnce(),)
        case "play":
            return (Play(),)
        case "run_to" if at is not None:
            return (RunTo(at),)
        case "rewind" if at is not None:
            return (GoTo(at),)
        case "fork" if at is not None:
            given = (part for one in do.then or () for part in commands_of(one, snapshot.control))
            return (GoTo(at), *given)
        case "mark":
            return (AddMark(Place(snapshot.generation, snapshot.step), _MARK),)
        case "start_again":
            seed = snapshot.seed if do.seed is None else do.seed
            return (StartLessonAgain(lesson.starts[card.id], do.preset, seed),)
        case "race":
            return (_race(do, snapshot.seed), OpenSide())
        case "experiment" if do.name is not None:
            return (RunExperiment(do.name),)
        case "inspect" if do.region is not None:
            return (LookInto(do.region),)
        case "show" if do.layer is not None:
            return (Layer(do.layer),)
        case _:
            missing = [
                command
                for command in commands_of(do, snapshot.control)
                if not _is_done(command, snapshot)
            ]
            learns = card.check is not None and _needs_learning(card.check)
            return (*missing, *([Play()] if learns and not status.playing else []))


def _is_done(command: Command, snapshot: Snapshot) -> bool:
    """Whether a command has been given already."""
    match command:
        case Introduce(skill=skill):
            return skill in snapshot.present
        case Explore(skill=skill):
            return was_explored(skill, snapshot)
        case _:
            return False


def _needs_learning(check: Check) -> bool:
    """Whether something is asked that comes with learning alone."""
    parts = (*(check.all_of or ()), *(check.any_of or ()), *filter(None, [check.not_so]))
    reading = check.reading
    is_of_run = reading is not None and reading.answers != "yes" and reading.name not in _BESIDE
    return is_of_run or any(map(_needs_learning, parts))


def run_shipped(service: Service, name: str) -> None:
    """Begin an experiment that comes with the lab, with few seeds. It takes a moment.

    Raises:
        RefusedError: it cannot be run now.
    """
    try:
        service.start(experiments.load(name, _SEEDS), _WORKERS)
    except (BusyError, ExperimentError, FolderError) as error:
        raise RefusedError(str(error)) from error


def _race(do: Do, seed: int) -> Request:
    names = do.presets or THESIS_FOUR
    entries = tuple(Entry(name, name, seed, presets.load(name)) for name in names)
    return StartRace(entries, speed=FULL_SPEED)
