"""The controls that all browsers share: they change the learner.

What a person does here is one request. A widget shows the state and never is the state: once all
requests have been answered, the render loop sets every widget to what is true.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import zip_longest
from typing import Any

import viser

from app.charts.bar.rule import outlook_in_words
from app.explain.called import run_on_board
from app.live.requests import Request, StepOnce, TrialOnce
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page import keys
from app.page.inbox import Act, Ask, Intent, StatusOf
from app.page.keys import Key
from app.page.number_field import DIALS_HTML, Dial, Limits, NumberField
from app.page.panels.said import Said
from app.page.panels.start_again import StartingAgain
from app.page.panels.steering import Steering, introduction_of
from app.page.panels.transport import Transport, faster, play_or_pause
from app.page.widgets import CALM, Choice, Input, add_hints, assign
from app.schedule.forced import where_in_short
from app.server.callbacks import RefusedError
from app.util.html import escaped
from app.words.glossary import term
from app.words.numbers import counted
from app.words.plain import by_plain_name, plain
from learners.commands import (
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    StopExploring,
)
from learners.learner_spec import LearnerSpec
from learners.names import COMMANDS, MAX_TRIALS, MOVES
from learners.spec import RunSpec

_NO_SKILL = "(no skill yet)"
_OF_RESULTS = "a run of an experiment."
_WITHOUT_SKILLS = {
    MOVES: "The options are moves: there are no skills to freeze, and no schedule.",
    COMMANDS: "The options are commands: no skill joins, so there is no schedule.",
}


def _note(html: str) -> str:
    """A few words below a widget."""
    return f'<div class="pounce-note">{html}</div>'


def _without_skills(learner: LearnerSpec) -> str:
    """Why there is nothing to freeze or to follow; empty where there is."""
    return "" if isinstance(learner.options, tuple) else _WITHOUT_SKILLS[learner.options]


def _of_past(status: Status) -> str:
    """What these controls do while the only browser looks at a moment that is not now."""
    behind = status.behind
    where = term("the past") if behind is None or not behind.branch else escaped(behind.branch)
    return (
        f"These controls show <b>{where}</b>, trial {status.snapshot.trial:,}. What is changed here"
        f" makes a {term('branch')} there; the {term('live')} run stays as it is. End goes back to"
        " it."
    )


def _of_live(elsewhere: int) -> str:
    """What they do for browsers that do not look at what they show."""
    looks = "1 browser looks" if elsewhere == 1 else f"{elsewhere} browsers look"
    return (
        f"These controls show the <b>{term('live')}</b> run. {looks} at another moment; there, Play"
        f" plays what is looked at, and a change makes a {term('branch')}."
    )


def skill_state(status: Status, skill: str) -> str:
    """How a skill stands, in a few words."""
    snapshot = status.snapshot
    control = snapshot.control
    if skill not in snapshot.present:
        planned = snapshot.spec.schedule.introduced_at(skill)
        by_rule = snapshot.spec.schedule.rule_of(skill) is not None
        if not by_rule and not snapshot.trial < planned < MAX_TRIALS:
            return "not yet"
        if not control.schedule_on:
            return "not yet: the schedule is not followed"
        return _by_rule(status, skill) if by_rule else f"joins at trial {planned:,}"
    index = snapshot.spec.learner.skills.index(skill)
    total = int(snapshot.option_visits.sum())
    parts = ["active"]
    is_newest = control.introductions[-1].skill == skill
    if is_newest and snapshot.trial < control.frozen_until and not control.selection_frozen:
        parts = [f"new, practised until trial {control.frozen_until:,}"]
    if total:
        parts.append(f"{snapshot.option_visits[index] / total:.0%} of all choices")
    if control.skills_frozen:
        parts.append("frozen by hand")
    return ", ".join(parts)


def _by_rule(status: Status, skill: str) -> str:
    """What is to be said of a skill that joins by its rule."""
    waited = next((one for one in status.snapshot.watched if one.until is None), None)
    if waited is None:
        return "joins by its rule"
    if waited.skill != skill:
        return f"joins by its rule, after {plain(waited.skill)}"
    outlook = outlook_in_words(waited, status.behind is None)
    return f"joins by its rule, below {waited.rule.below:g}: {outlook}"


@dataclass
class _SkillRow:
    skill: str | None
    """None while the learner has fewer skills than there are rows."""
    text: viser.GuiHtmlHandle
    add: viser.GuiButtonHandle


class Controls:
    """The shared control panel."""

    def __init__(
        self,
        gui: viser.GuiApi,
        presets: Mapping[str, RunSpec],
        ask: Ask,
        status_of: StatusOf,
        status: Status,
    ) -> None:
        """Build it for how things stand; ``status_of`` a browser is asked later."""
        self._gui = gui
        self._ask = ask
        self._status_of = status_of
        self._rows: list[_SkillRow] = []
        self._said = Said(gui, status)
        self.tabs = gui.add_tab_group()
        """Where other tabs go."""
        self.run_tab = self.tabs.add_tab("Run", icon=viser.Icon.PLAYER_PLAY)
        """Where what begins other runs goes, below what is there."""
        with self.run_tab:
            self._whose = gui.add_html("", visible=False)
            self._transport = Transport(gui, ask, status_of, status)
            self._skills = gui.add_folder("Skills")
            self._build_explore()
            self._build_learning()
            self._starting = StartingAgain(gui, presets, ask, status_of, status)
        with self.tabs.add_tab("Steer", icon=viser.Icon.ADJUSTMENTS):
            self._steering = Steering(gui, ask, status_of, status)
        self._build_hotkeys()
        self.update(status)

    def settle(self, now_s: float) -> None:
        """Ask for what was set and has come to rest."""
        self._steering.settle(now_s)

    @property
    def presets(self) -> Mapping[str, RunSpec]:
        """Those there are to start again with, by name."""
        return self._starting.presets

    def offer_preset(self, name: str, spec: RunSpec) -> None:
        """Have a preset in the list of those to start again with."""
        self._starting.offer(name, spec)

    def update(self, status: Status, elsewhere: int = 0) -> None:
        """Show what is true; not to be called before all requests have been answered.

        Args:
            status: what is true at the moment that these controls show.
            elsewhere: browsers that look at another moment.
        """
        snapshot = status.snapshot
        self._show_whose(status, elsewhere)
        self._name_rows(snapshot.spec.learner.skills)
        self._transport.update(status)
        self._show_skills(status)
        self._show_explore(status)
        self._show_learning(status)
        self._starting.update(status)
        self._steering.update(status)
        self._said.update(status, time.monotonic())

    def _asking(self, request: Callable[[Status], Request]) -> Act:
        """To ask for something by what is true for the browser, whatever the widget's value."""
        return lambda client, _: self._ask(client, request(self._status_of(client)))

    def _input(self, handle: Any, request: Callable[[Any], Request]) -> Input:
        """A widget that asks for something whenever a person changes it."""
        return Input(handle, lambda client, value: self._ask(client, request(value)))

    def _show_whose(self, status: Status, elsewhere: int) -> None:
        """Say which moment, and of which run, where that is not the live run like any other."""
        note = _of_past(status) if status.behind is not None else ""
        if elsewhere:
            note = _of_live(elsewhere)
        elif not note and status.opened is not None:
            note = f"On the board: <b>{escaped(run_on_board(status))}</b>, {_OF_RESULTS}"
        assign(self._whose, "visible", bool(note))
        assign(self._whose, "content", _note(note))

    def _build_hotkeys(self) -> None:
        commands: list[tuple[str, Key, Callable[[Status], Request]]] = [
            ("Pause or play", keys.PLAY, play_or_pause),
            ("One step", keys.STEP, lambda _: StepOnce()),
            ("One trial", keys.TRIAL, lambda _: TrialOnce()),
            ("Slower", keys.SLOWER, partial(faster, -0.5)),
            ("Faster", keys.FASTER, partial(faster, 0.5)),
            ("Add the next skill", keys.NEXT_SKILL, self._next_skill),
            ("Explore the chosen skill", keys.EXPLORE, self._exploration),
            ("Freeze the selection, or let it learn", keys.FREEZE, self._toggle_freeze),
            ("Undo what was just done by hand", keys.UNDO, self._said.undo),
        ]
        for label, key, request in commands:
            command = self._gui.add_command(label, hotkey=key.hotkey)
            command.on_trigger(Intent(self._asking(request)))

    def _next_skill(self, status: Status) -> Request:
        snapshot = status.snapshot
        absent = [s for s in snapshot.spec.learner.skills if s not in snapshot.present]
        if not absent:
            raise RefusedError("all skills of this learner have joined")
        return introduction_of(snapshot, absent[0])

    def _toggle_freeze(self, status: Status) -> Request:
        return FreezeSelection(not status.snapshot.control.selection_frozen)

    def _name_rows(self, skills: tuple[str, ...]) -> None:
        """Give each skill a row.

        Rows are kept and named anew, and none is removed: a page that takes an update and a removal
        at once carries out the removal first, and complains of the update.
        """
        while len(self._rows) < len(skills):
            with self._skills:
                text = self._gui.add_html("")
                add = self._gui.add_button(
                    "Add",
                    icon=viser.Icon.PLUS,
                    color=CALM,
                    hint="The skill joins now: the learner may choose it from the next step on. How"
                    " skills are chosen is frozen meanwhile, for as long as the schedule has it, so"
                    " that the new skill can be learned.",
                )
                add_hints(self._gui, add)
            row = _SkillRow(None, text, add)
            add.on_click(Intent(self._asking(partial(self._introduction_by, row))))
            self._rows.append(row)
        for row, skill in zip_longest(self._rows, skills):
            row.skill = skill
            assign(row.text, "visible", skill is not None)
            if skill is None:
                assign(row.add, "visible", False)
            else:
                assign(row.add, "label", f"Add {plain(skill)} now")
        assign(self._skills, "visible", bool(skills))
        assign(self._explore, "visible", bool(skills))

    def _introduction_by(self, row: _SkillRow, status: Status) -> Request:
        if row.skill is None:
            raise RefusedError("this learner has no such skill")
        return introduction_of(status.snapshot, row.skill)

    def _show_skills(self, status: Status) -> None:
        for row in self._rows:
            if row.skill is None:
                continue
            present = row.skill in status.snapshot.present
            state = escaped(skill_state(status, row.skill))
            dot = "&#9679;" if present else "&#9675;"
            assign(
                row.text,
                "content",
                _note(f"{dot} <b>{escaped(plain(row.skill))}</b>: {state}"),
            )
            assign(row.add, "visible", not present)

    def _build_explore(self) -> None:
        gui = self._gui
        self._explore = gui.add_folder("Explore a skill")
        with self._explore:
            self._explored: Choice[str | None] = Choice(
                gui,
                "Skill",
                {},
                nothing=_NO_SKILL,
                hint="The skill that the learner is made to try.",
            )
            gui.add_html(DIALS_HTML)
            self._chance = Dial(
                gui,
                "Probability",
                0.5,
                Limits(0.0, 1.0, whole=False, share=True),
                0.05,
                "How often the skill is taken whatever the learner would choose: at 0.5 in half of"
                " all steps.",
            )
            self._duration = NumberField(
                gui,
                "Trials",
                2_000,
                Limits(1, 100_000),
                "For how many trials, that is hunts, from now on.",
            )
            self._begin = gui.add_button(
                "Start exploring",
                icon=viser.Icon.COMPASS,
                color=CALM,
                hint="Make the learner take the skill so often, whether it is good or not, so that"
                " it finds out (E). Rewards may fall meanwhile.",
            )
            self._left = gui.add_html("")
            self._end = gui.add_button(
                "Stop exploring",
                icon=viser.Icon.PLAYER_STOP,
                color=CALM,
                hint="From now on the learner chooses for itself again.",
            )
            add_hints(gui, self._begin, self._end)
        self._begin.on_click(Intent(self._asking(self._exploration)))
        self._end.on_click(Intent(self._asking(self._end_of_exploration)))

    def _end_of_exploration(self, status: Status) -> Request:
        ending = self._ending(status.snapshot)
        if ending is None:
            raise RefusedError("nothing is being explored")
        return StopExploring(ending)

    def _ending(self, snapshot: Snapshot) -> str | None:
        """The exploration that a click would end: the chosen skill's, or else the newest."""
        running = [episode.skill for episode in snapshot.control.running(snapshot.trial)]
        chosen = self._explored.chosen
        return chosen if chosen in running else next(iter(running), None)

    def _exploration(self, _: Status) -> Request:
        chosen = self._explored.chosen
        if chosen is None:
            raise RefusedError("a skill must have joined before it can be explored")
        return Explore(chosen, int(self._duration.read()), self._chance.read())

    def _show_explore(self, status: Status) -> None:
        snapshot = status.snapshot
        self._explored.offer(by_plain_name(snapshot.present))
        ending = self._ending(snapshot)
        nothing = not snapshot.present
        assign(self._begin, "disabled", nothing)
        assign(self._end, "visible", ending is not None)
        label = "Stop exploring" if ending is None else f"Stop exploring {plain(ending)}"
        assign(self._end, "label", label)
        lines = [
            f"{escaped(plain(e.skill))} at {e.probability:.0%}{where_in_short(e.value_at_most)}:"
            f" {counted(e.until_trial - snapshot.trial, 'trial')} left"
            for e in snapshot.control.running(snapshot.trial)
        ]
        if nothing:
            lines = ["A skill must have joined before it can be explored."]
        body = "<br>".join(lines)
        assign(self._left, "content", _note(body))

    def _build_learning(self) -> None:
        gui = self._gui
        with gui.add_folder("Learning"):
            gui.add_html('<div class="pounce-boxes"></div>')
            self._freeze_selection = self._input(
                gui.add_checkbox(
                    "Freeze selection",
                    False,
                    hint="While ticked, what the learner knows of which skill to choose where is"
                    " not changed (F).",
                ),
                FreezeSelection,
            )
            self._freeze_skills = self._input(
                gui.add_checkbox(
                    "Freeze skills",
                    False,
                    hint="While ticked, the skills themselves are not changed: no skill learns to"
                    " move better.",
                ),
                FreezeSkills,
            )
            self._follow = self._input(
                gui.add_checkbox(
                    "Follow schedule",
                    True,
                    hint="While ticked, skills join and are explored when the schedule says so."
                    " What it would have done meanwhile is not made up for.",
                ),
                FollowSchedule,
            )
            self._why_not = gui.add_html(_note(""), visible=False)

    def _show_learning(self, status: Status) -> None:
        control = status.snapshot.control
        learner = status.snapshot.spec.learner
        has_skills = bool(learner.skills)
        self._freeze_selection.show(control.selection_frozen)
        self._freeze_skills.show(control.skills_frozen)
        self._follow.show(control.schedule_on)
        assign(self._freeze_skills.handle, "disabled", not learner.sub_policies)
        assign(self._follow.handle, "disabled", not has_skills)
        assign(self._why_not, "content", _note(_without_skills(learner)))
        assign(self._why_not, "visible", not has_skills)
