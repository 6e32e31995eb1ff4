"""A lesson played by nobody, in its canonical way: from its setup, card by card, as each card asks.

What is done. A card that asks is read, and what it asks is answered by the run as that goes on. On
a card that has something done it is done, and the run then learns until its check is decided. Where
a card says how far to learn, the run learns so far before the next one. Where a card asks to say
what was seen, the run goes on to where that can be seen. All of it hangs on the lesson and the seed
alone.

What costs. Where the run is the preset's own, with nothing done to it, its moments are shared by
all that begin there (:class:`Shared`): cards, lessons, and runs of races and experiments.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

from app.documents.lesson_cards import Card, Do, Transfer
from app.documents.lesson_grammar import Check, Opened
from app.documents.lessons import Lesson
from app.lessons.beside import deeds_beside
from app.lessons.checks import Judge, Verdict
from app.lessons.doing import commands_of, swapped
from app.lessons.measures import (
    AT_START,
    NO_DEEDS,
    Began,
    Done,
    Looked,
    View,
    began_at,
    view_of_run,
)
from app.lessons.reveals import Answer, Watch, varies
from app.lessons.shared import Shared, advance
from learners.checkpoints import Checkpoint, Logs, logs_of
from learners.commands import Command, CommandError, FollowSchedule
from learners.names import MAX_TRIALS
from learners.run import Run
from learners.spec import RunSpec


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


Visit = Callable[[Card, Run], object]
"""Called where a card is entered, with the run as it stands."""


def play(
    lesson: Lesson,
    seed: int,
    shared: Shared | None = None,
    visit: Visit = lambda card, run: None,
    every_answer: bool = True,
) -> Played:
    """Play a lesson with one seed.

    Args:
        lesson: the lesson.
        seed: of all its runs, whatever its setup says.
        shared: what other plays have made, of any lesson.
        visit: called where each card is entered.
        every_answer: whether also questions are answered of which nothing is proved.

    Raises:
        GivenUpError: it is not wanted any more.
    """
    return _Playing(lesson, seed, shared or Shared(), visit, every_answer).play()


class _Playing:
    def __init__(
        self, lesson: Lesson, seed: int, shared: Shared, visit: Visit, every_answer: bool
    ) -> None:
        self._lesson, self._spec = lesson, lesson.spec
        self._shared, self._visit = shared, visit
        self._found = Played(seed)
        self._every_answer = every_answer
        self._asking: list[_Asking] = []
        self._given: dict[str, tuple[Checkpoint, Logs, tuple[Command, ...]]] = {}
        """Where a card gave commands to the learner: the moment before, and these."""
        self._entered: list[tuple[Checkpoint, Logs]] = []
        """Moments that can be gone back to."""
        # Before what is made of the same run to its end: then it is passed by on the way there.
        self._run = self._begun(lesson.run_spec, seed)
        self._beside = deeds_beside(lesson, seed, shared, every_answer)
        """What stands beside the run all the time."""
        self._deeds = self._beside

    def play(self) -> Played:
        for card in self._spec.steps:
            self._enter(card)
            self._take(card)
            self._leave(card)
        for asking in [*self._asking]:
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
        if question is not None and varies(question) and not self._every_answer:
            return
        if card.transfer is not None:
            self._found.answers[card.id] = self._transferred(card, card.transfer)
        elif question is not None and question.reveal is not None:
            until = card.run.after(began.trial) if card.run and not _catches(card) else None
            watch = Watch(question, began, until)
            watch.look(self._view(began))
            self._asking.append(_Asking(card, watch))
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
            self._end(asking)

    def _end(self, asking: _Asking) -> None:
        """Have a question answered: by its own moment, or where the run stands if it has none."""
        watch = asking.watch
        if not watch.is_open:
            until = max(self._length, watch.trial or 0)
            self._go(until, watch=watch)
        watch.end(self._view(self._found.began[asking.card.id]))
        self._found.answers[asking.card.id] = watch.answer
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

    def _go(
        self,
        until: int,
        judge: Judge | None = None,
        began: Began = AT_START,
        watch: Watch | None = None,
    ) -> None:
        """Learn up to the start of a trial, or until a check is decided or a question answered, and
        look on the way."""
        while self._run.trial < until and not (
            (judge and judge.is_over) or (watch and watch.is_over)
        ):
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
        if self._is_too_early(do, check, began):
            self._found.too_early.add(card.id)
        judge = Judge(check, began)
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

    def _is_too_early(self, do: Do, check: Check, began: Began) -> bool:
        """Whether a check holds before anything is done."""
        deeds = NO_DEEDS if do.command in ("race", "experiment") else self._deeds
        view = view_of_run(self._run, deeds, began)
        return Judge(check, began).look(view).state == "yes"

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
                self._run = self._shared.run_at(self._lesson.starts[card.id], seed, 0)
                self._entered.clear()
            case "inspect" if do.region:
                self._open(Opened("why"), Opened("cell", region=do.region))
            case "show":
                self._open(Opened("layer", layer=do.layer))
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
        """Go on another way from an earlier moment."""
        self._go_back(trial)
        for given in do.then or ():
            for command in commands_of(given, self._run.control):
                self._run.apply(command)
        self._deeds = replace(self._deeds, divergence=trial)

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


_OTHER_RUNS: Final = ("rewind", "fork", "start_again")


def _catches(card: Card) -> bool:
    return card.run is not None and card.run.captures is not None
