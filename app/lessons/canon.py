"""A lesson played by nobody, in its canonical way: from its setup, card by card, as each card asks.

What is done. A card that asks is read, and what it asks is answered by the run as that goes on. On
a card that has something done it is done, and the run then learns until its check is decided. Where
a card says how far to learn, the run learns so far before the next one. Where a card asks to say
what was seen, the run goes on to where that can be seen. All of it hangs on the lesson and the seed
alone.

What costs. Where the run is the preset's own, with nothing done to it, its moments are shared by
all that begin there (:class:`Shared`): cards, lessons, and runs of races and experiments.
"""

from bisect import bisect_right, insort
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from app.documents import experiments, presets
from app.documents.lesson_cards import Card, Do, Transfer
from app.documents.lesson_grammar import Check, OfExperiment, Opened, Reading
from app.documents.lessons import Lesson
from app.lessons.checks import Judge, Verdict
from app.lessons.doing import commands_of, started_again, swapped
from app.lessons.measures import (
    AT_START,
    Began,
    Columns,
    Deeds,
    Done,
    Looked,
    Racing,
    View,
    began_at,
    view_of_run,
)
from app.lessons.reveals import Answer, Watch
from app.live.race import THESIS_FOUR
from app.metrics import measured as metrics_of
from app.metrics.course import Course
from learners.checkpoints import Checkpoint, Logs, logs_of
from learners.commands import Command, CommandError, FollowSchedule
from learners.run import Run
from learners.spec import MAX_TRIALS, RunSpec

SLICE_STEPS: Final = 200_000
"""After which it is asked whether it is still wanted: some milliseconds."""
_MOST_RUNS: Final = 12
_MOST_MOMENTS: Final = 16


class GivenUpError(Exception):
    """What was being played is not wanted any more."""


def _always() -> bool:
    return True


# --- What is shared ------------------------------------------------------------------------------


class _Straight:
    """A run of a preset with which nothing is done, and checkpoints on its way."""

    def __init__(self, spec: RunSpec, seed: int) -> None:
        self.farthest = Run(spec, seed)
        self._checkpoints: list[tuple[int, Checkpoint]] = []

    def at(self, trial: int, wanted: Callable[[], bool]) -> Run:
        """An independent run that is about to start a trial."""
        if self.farthest.trial <= trial:
            advance(self.farthest, trial, wanted)
            self._keep()
            return self.farthest.copy()
        place = bisect_right(self._checkpoints, trial, key=_trial_of) - 1
        if place < 0:
            run = Run(self.farthest.preset, self.farthest.seed)
        else:
            run = Run.restored(self._checkpoints[place][1], logs_of(self.farthest.state))
        advance(run, trial, wanted)
        return run

    def _keep(self) -> None:
        trial = self.farthest.trial
        if len(self._checkpoints) < _MOST_MOMENTS and all(
            at != trial for at, _ in self._checkpoints
        ):
            insort(self._checkpoints, (trial, self.farthest.checkpoint()), key=_trial_of)


def _trial_of(kept: tuple[int, Checkpoint]) -> int:
    return kept[0]


class Shared:
    """Runs that several cards and lessons begin with, or are about. For one thread at a time."""

    def __init__(self, wanted: Callable[[], bool] = _always) -> None:
        """Share nothing yet; ``wanted`` is asked every few milliseconds while a run is made."""
        self.wanted = wanted
        self._runs: OrderedDict[tuple[str, int], _Straight] = OrderedDict()

    def run_at(self, spec: RunSpec, seed: int, trial: int) -> Run:
        """An independent run of a preset that is about to start a trial.

        Raises:
            GivenUpError: it is not wanted any more.
        """
        return self._straight(spec, seed).at(trial, self.wanted)

    def finished(self, spec: RunSpec, seed: int, steps: int | None = None) -> Run:
        """A run of a preset after its trials, or after some steps if these are made before; it is
        not to be advanced."""
        run = self._straight(spec, seed).farthest
        while run.trial < spec.trials and (steps is None or run.step < steps):
            # In whole trials, so that the way there is anybody's.
            advance(run, min(run.trial + 500, spec.trials), self.wanted)
        return run

    def _straight(self, spec: RunSpec, seed: int) -> _Straight:
        key = spec.model_dump_json(), seed
        if key not in self._runs:
            self._runs[key] = _Straight(spec, seed)
            while len(self._runs) > _MOST_RUNS:
                self._runs.popitem(last=False)
        self._runs.move_to_end(key)
        return self._runs[key]


def advance(run: Run, trial: int, wanted: Callable[[], bool] = _always) -> None:
    """Let a run learn up to the start of a trial.

    Raises:
        GivenUpError: it is not wanted any more.
    """
    while run.trial < trial:
        if not wanted():
            raise GivenUpError
        if run.advance(SLICE_STEPS, until_trial=trial) == 0:
            return


# --- What comes of it ----------------------------------------------------------------------------


@dataclass
class Played:
    """How a lesson went with one seed."""

    seed: int
    began: dict[str, Began] = field(default_factory=dict)
    """Where each card was entered, by its id."""
    answers: dict[str, Answer] = field(default_factory=dict)
    """What the run answers to each card that asks by itself."""
    verdicts: dict[str, Verdict] = field(default_factory=dict)
    """Of each card that has a check."""
    too_early: set[str] = field(default_factory=set)
    """Cards whose checks had come true before anything was done."""
    faults: dict[str, str] = field(default_factory=dict)
    """Why something could not be done, by card."""


class _Asking(NamedTuple):
    """A question that the run is still to answer."""

    card: Card
    watch: Watch
    is_open: bool
    """Whether it names no moment."""


Visit = Callable[[Card, Run], object]
"""Called where a card is entered, with the run as it stands."""


def play(
    lesson: Lesson,
    seed: int,
    shared: Shared | None = None,
    visit: Visit = lambda card, run: None,
) -> Played:
    """Play a lesson with one seed.

    Args:
        lesson: the lesson.
        seed: of all its runs, whatever its setup says.
        shared: what other plays have made, of any lesson.
        visit: called where each card is entered.

    Raises:
        GivenUpError: it is not wanted any more.
    """
    return _Playing(lesson, seed, shared or Shared(), visit).play()


class _Playing:
    def __init__(self, lesson: Lesson, seed: int, shared: Shared, visit: Visit) -> None:
        self._lesson, self._spec = lesson, lesson.spec
        self._shared, self._visit = shared, visit
        self._found = Played(seed)
        self._asking: list[_Asking] = []
        self._given: dict[str, tuple[Checkpoint, Logs, tuple[Command, ...]]] = {}
        """Where a card gave commands to the learner: the moment before, and these."""
        self._entered: list[tuple[Checkpoint, Logs]] = []
        """Moments that can be gone back to."""
        readings = list(_readings_of(self._spec.steps))
        self._beside = Deeds(race=self._race(readings), experiments=self._experiments(readings))
        """What stands beside the run all the time."""
        self._deeds = self._beside
        self._run = self._begun(lesson.run_spec, seed)

    def play(self) -> Played:
        for card in self._spec.steps:
            self._enter(card)
            self._take(card)
            self._leave(card)
        for asking in self._asking:
            self._end(asking)
        return self._found

    # Cards

    def _enter(self, card: Card) -> None:
        if card.see is not None:
            self._go_to_seen(card.see.same_as)
        self._found.began[card.id] = began_at(self._run)
        self._entered.append(self._moment())
        self._deeds = self._beside
        self._visit(card, self._run)

    def _take(self, card: Card) -> None:
        question, began = card.question, self._found.began[card.id]
        if card.transfer is not None:
            self._found.answers[card.id] = self._transferred(card, card.transfer)
        elif question is not None and question.reveal is not None:
            until = card.run.after(began.trial) if card.run and not _catches(card) else None
            watch = Watch(question, began, until)
            self._asking.append(_Asking(card, watch, is_open=watch.trial is None))
        if card.do is not None and card.check is not None:
            self._do(card, card.do, card.check)

    def _leave(self, card: Card) -> None:
        if card.run is None:
            return
        began = self._found.began[card.id]
        if card.run.captures is None:
            self._go(card.run.after(began.trial))
        else:
            caught = Check.model_validate({"measure": "captures", "above": card.run.captures - 1})
            self._go(self._length, Judge(caught, began), began)
        for asking in [asking for asking in self._asking if asking.card is card]:
            self._end(asking)

    def _go_to_seen(self, card_id: str) -> None:
        for asking in [asking for asking in self._asking if asking.card.id == card_id]:
            if asking.watch.trial is not None:
                self._go(asking.watch.trial)
            elif not asking.is_open:
                self._go(self._length)
            self._end(asking)

    def _end(self, asking: _Asking) -> None:
        """Take what a question has been answered, by where the run stands if not before."""
        trial = asking.watch.trial
        if trial is not None:
            self._go(trial)
        asking.watch.end(self._view(self._found.began[asking.card.id]))
        self._found.answers[asking.card.id] = asking.watch.answer
        self._asking.remove(asking)

    # The run

    @property
    def _length(self) -> int:
        return self._run.spec.trials

    def _begun(self, spec: RunSpec, seed: int) -> Run:
        run = self._shared.run_at(spec, seed, self._spec.setup.start)
        if self._spec.setup.schedule == "off":
            run.apply(FollowSchedule(False))
        return run

    def _view(self, began: Began) -> View:
        return view_of_run(self._run, self._deeds, began)

    def _moment(self) -> tuple[Checkpoint, Logs]:
        return self._run.checkpoint(), logs_of(self._run.state)

    def _go(self, until: int, judge: Judge | None = None, began: Began = AT_START) -> None:
        """Learn up to the start of a trial, or until a check is decided, and look on the way."""
        while self._run.trial < until and not (judge and judge.is_over):
            trial = self._run.trial
            due = [(asking.watch.next_look(trial), asking) for asking in self._asking]
            judged = until if judge is None else judge.next_look(trial)
            stop = min([until, judged, *(look for look, _ in due if look is not None)])
            advance(self._run, stop, self._shared.wanted)
            if self._run.trial <= trial:
                return
            # Each looks at its own moments alone, so that none hangs on what else is asked.
            for look, asking in due:
                if look is not None and look <= self._run.trial:
                    asking.watch.look(self._view(self._found.began[asking.card.id]))
            if judge and judged <= self._run.trial:
                judge.look(self._view(began))

    # What is done

    def _do(self, card: Card, do: Do, check: Check) -> None:
        began = self._found.began[card.id]
        judge = Judge(check, began)
        if judge.look(self._view(began)).state == "yes":
            self._found.too_early.add(card.id)
        try:
            self._carry_out(card, do)
        except CommandError as error:
            self._found.faults[card.id] = str(error)
        if do.command in _OTHER_RUNS:
            # Another run, or another way from an earlier moment: it is judged from there on.
            began = self._found.began[card.id] = began_at(self._run)
            judge = Judge(check, began)
        judge.look(self._view(began))
        self._go(max(self._length, self._run.trial + 1), judge, began)
        self._found.verdicts[card.id] = judge.verdict

    def _carry_out(self, card: Card, do: Do) -> None:
        commands = commands_of(do, self._run.control)
        if commands:
            self._given[card.id] = (*self._moment(), commands)
        for command in commands:
            self._run.apply(command)
        match do.command:
            case "step":
                self._run.advance(1, MAX_TRIALS)
            case "trial":
                self._go(self._run.trial + 1)
            case "run_to" if do.at:
                self._go(do.at.after(self._found.began[card.id].trial))
            case "rewind" if do.at:
                self._go_back(do.at.after(self._found.began[card.id].trial))
            case "fork" if do.at:
                self._fork(do, do.at.after(self._found.began[card.id].trial))
            case "start_again":
                seed = self._found.seed
                spec = started_again(do, self._lesson.run_spec)
                self._run = self._shared.run_at(spec, seed, 0)
                self._entered.clear()
            case "inspect" if do.region:
                self._open(Opened.model_validate("why"), Opened.model_validate({"cell": do.region}))
            case "show":
                self._open(Opened.model_validate({"layer": do.layer}))
            case _:
                pass
        done = Done(do.command, self._run.step)
        self._deeds = replace(self._deeds, done=(*self._deeds.done, done))

    def _open(self, *opened: Opened) -> None:
        looked = (Looked(what, self._run.step) for what in opened)
        self._deeds = replace(self._deeds, opened=(*self._deeds.opened, *looked))

    def _go_back(self, trial: int) -> None:
        """Stand at an earlier moment of the run, all that was given by then done."""
        if trial > self._run.trial:
            raise CommandError(f"trial {trial:,} has not come yet")
        events = self._run.control.history
        before = [entered for entered in self._entered if entered[0].trial <= trial]
        run = Run.restored(*before[-1]) if before else Run(self._run.preset, self._found.seed)
        for event in events[len(run.control.history) :]:
            if event.author != "hand" or event.trial >= trial:
                continue
            while run.step < event.step:
                run.advance(event.step - run.step, MAX_TRIALS)
            run.apply(event.command)
        advance(run, trial, self._shared.wanted)
        self._run = run
        self._entered = before

    def _fork(self, do: Do, trial: int) -> None:
        """Let the run branch off at an earlier moment; it then goes on as far as it had come."""
        until = self._run.trial
        self._go_back(trial)
        for given in do.then or ():
            for command in commands_of(given, self._run.control):
                self._run.apply(command)
        self._deeds = replace(self._deeds, divergence=trial)
        advance(self._run, until, self._shared.wanted)

    def _transferred(self, card: Card, transfer: Transfer) -> Answer:
        """What a run answers in which another skill took the place of the one that was added."""
        cards = self._spec.steps[: self._spec.steps.index(card)]
        added = [
            before.id
            for before in cards
            if before.do and before.do.command == "introduce" and before.id in self._given
        ]
        if not added:
            self._found.faults[card.id] = "no card before it adds a skill"
            return None
        checkpoint, logs, commands = self._given[added[-1]]
        run = Run.restored(checkpoint, logs)
        began = began_at(run)
        for command in swapped(commands, transfer.run.swap):
            run.apply(command)
        until = self._run.trial
        watch = Watch(transfer, began, until)
        while not watch.is_over and run.trial < self._length:
            look = watch.next_look(run.trial)
            advance(run, until if look is None else look, self._shared.wanted)
            watch.look(view_of_run(run, self._deeds, began))
        return watch.answer

    # What stands beside the run

    def _race(self, readings: Sequence[Reading]) -> tuple[Racing, ...]:
        """The runs of a race, as far as anything in the lesson asks for it."""
        steps = _leads(readings)
        if not steps:
            return ()
        return tuple(
            racing_of(name, self._shared.finished(_preset(name), self._found.seed, max(steps)))
            for name in _racers(self._lesson)
        )

    def _experiments(self, readings: Sequence[Reading]) -> Mapping[str, Mapping[str, Columns]]:
        """One run of each variant that anything in the lesson asks for."""
        asked = [r.args for r in readings if isinstance(r.args, OfExperiment)]
        found: dict[str, dict[str, dict[str, list[float]]]] = {}
        for of in asked:
            for label, spec in _variants(of.name).items():
                if of.variant is not None and label not in (of.variant, of.against):
                    continue
                columns = found.setdefault(of.name, {}).setdefault(label, {})
                if of.quantity not in columns:
                    run = self._shared.finished(spec, self._found.seed)
                    value = metrics_of(Course(run, spec.trials), (of.quantity,))[of.quantity]
                    columns[of.quantity] = [] if value is None else [float(value)]
        return found


def specs_beside(lesson: Lesson) -> list[RunSpec]:
    """The presets and variants of what stands beside a lesson's run, as far as it asks for any."""
    readings = [*_readings_of(lesson.spec.steps)]
    found = [_preset(name) for name in _racers(lesson)] if _leads(readings) else []
    for reading in readings:
        if isinstance(reading.args, OfExperiment):
            found += _variants(reading.args.name).values()
    return found


def _racers(lesson: Lesson) -> tuple[str, ...]:
    """Presets of a lesson's race."""
    asked = [card.do for card in lesson.spec.steps if card.do and card.do.command == "race"]
    return next((do.presets for do in asked if do.presets), None) or THESIS_FOUR


def _leads(readings: Iterable[Reading]) -> list[int]:
    """Steps at which it is asked who leads a race."""
    return [reading.args for reading in readings if reading.name == "leader"]


_OTHER_RUNS: Final = ("rewind", "fork", "start_again")


def racing_of(name: str, run: Run) -> Racing:
    """A run as one of several side by side."""
    logs, trial = logs_of(run.state), run.trial
    ends = np.cumsum(logs.log_steps[:trial], dtype=np.int64)
    is_over = trial >= run.spec.trials
    return Racing(name, logs.log_reward[:trial], ends, run.step, is_over)


def _catches(card: Card) -> bool:
    return card.run is not None and card.run.captures is not None


@lru_cache(maxsize=8)
def _preset(name: str) -> RunSpec:
    return presets.load(name)


@lru_cache(maxsize=8)
def _variants(name: str) -> Mapping[str, RunSpec]:
    """The variants of a shipped experiment, by their labels."""
    return {variant.label: variant.spec for variant in experiments.load(name).variants}


def _readings_of(cards: Iterable[Card]) -> Iterator[Reading]:
    """All that is measured in some cards."""
    for card in cards:
        if card.check is not None:
            yield from _readings_in(card.check)
        if card.question is not None and card.question.reveal is not None:
            yield card.question.reveal.reading


def _readings_in(check: Check) -> Iterator[Reading]:
    if check.reading is not None:
        yield check.reading
    for part in (*(check.all_of or ()), *(check.any_of or ()), *filter(None, [check.not_so])):
        yield from _readings_in(part)
