"""The controls that all browsers share: they change the learner.

What a person does here is one request. A widget shows the state and never is the state: once all
requests have been answered, the render loop sets every widget to what is true.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import zip_longest
from typing import Any

import viser

from app.explain import sentence
from app.live.session import (
    GoBack,
    Pause,
    Play,
    Request,
    Session,
    SetSpeed,
    StartAgain,
    Status,
    StepOnce,
    TrialOnce,
)
from app.live.snapshot import Snapshot
from app.live.worker import FULL_SPEED
from app.page import keys
from app.page.inbox import Ask, Intent
from app.page.keys import Key
from app.page.number_field import DIALS_HTML, Dial, Limits, NumberField
from app.page.panels.steering import Steering, introduction_of
from app.page.widgets import Choice, Input, add_buttons, assign
from app.server.callbacks import RefusedError
from app.util.html import escaped
from app.words.numbers import counted, speed_in_words
from app.words.plain import by_plain_name, plain
from learners.commands import (
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    StopExploring,
)
from learners.spec import MAX_TRIALS, RunSpec
from sim.rng import MAX_SEED

MOST_LOADED = 16
"""Presets besides the shipped ones that the list keeps; of more, those used least lately go."""

_FULL = 7.0
"""Where the speed slider means as fast as it goes."""
_SPEED_MARKS = (
    (0.0, "1"),
    (1.0, "10"),
    (2.0, "100"),
    (3.0, "1 k"),
    (4.0, "10 k"),
    (5.0, "100 k"),
    (6.0, "1 M"),
    (_FULL, "max"),
)
_NO_SKILL = "(no skill yet)"


def speed_of(slider: float) -> float:
    """Steps per second at a place of the speed slider."""
    return FULL_SPEED if slider >= _FULL else 10.0**slider


def slider_of(speed: float) -> float:
    """Place of the speed slider for a speed."""
    return _FULL if speed == FULL_SPEED else round(min(max(math.log10(speed), 0.0), _FULL - 0.1), 1)


def speed_label(speed: float) -> str:
    """A speed in words short enough for the slider."""
    return "Full speed" if speed == FULL_SPEED else speed_in_words(speed)


def skill_state(status: Status, skill: str) -> str:
    """How a skill stands, in a few words."""
    snapshot = status.snapshot
    if skill not in snapshot.present:
        planned = snapshot.spec.schedule.introduced_at(skill)
        if snapshot.control.schedule_on and snapshot.trial < planned < MAX_TRIALS:
            return f"not yet, joins at trial {planned:,}"
        return "not yet"
    index = snapshot.spec.learner.skills.index(skill)
    total = int(snapshot.option_visits.sum())
    share = f", {snapshot.option_visits[index] / total:.0%} of all choices" if total else ""
    newest = snapshot.control.introductions[-1].skill == skill
    if newest and snapshot.trial < snapshot.control.frozen_until:
        return f"new, selection frozen until trial {snapshot.control.frozen_until:,}{share}"
    return f"active{share}"


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
        session: Session,
        presets: Mapping[str, RunSpec],
        ask: Ask,
    ) -> None:
        self._gui = gui
        self._session = session
        self._ask = ask
        self._presets = dict(presets)
        self._loaded: dict[str, RunSpec] = {}
        """Presets of runs besides those, the latest last."""
        self._shown: int | None = None
        """Generation of the run whose preset and seed are offered to be started again."""
        self._rows: list[_SkillRow] = []
        status = session.status
        self.tabs = gui.add_tab_group()
        """Where other tabs go."""
        with self.tabs.add_tab("Run", icon=viser.Icon.PLAYER_PLAY):
            self._build_way_back()
            self._build_transport(status)
            self._skills = gui.add_folder("Skills")
            self._build_explore()
            self._build_learning()
            self._build_start(status)
        with self.tabs.add_tab("Steer", icon=viser.Icon.ADJUSTMENTS):
            self._steering = Steering(gui, session, ask)
        self._build_hotkeys()
        self.update(status)

    def settle(self, now_s: float) -> None:
        """Ask for what was set and has come to rest."""
        self._steering.settle(now_s)

    def update(self, status: Status) -> None:
        """Show what is true; not to be called before all requests have been answered."""
        snapshot = status.snapshot
        self._show_way_back(status)
        self._name_rows(snapshot.spec.learner.skills)
        if self._shown != snapshot.generation:
            self._shown = snapshot.generation
            self._take_preset(snapshot.preset, snapshot.preset_spec)
            self._preset.offer(self._offered())
            self._preset.choose(snapshot.preset)
            self._seed.put(snapshot.seed)
        self._show_transport(status)
        self._show_skills(status)
        self._show_explore(status)
        self._show_learning(status)
        self._steering.update(status)

    def _asking(self, request: Callable[[], Request]) -> Intent:
        """To ask for something, whatever the value of the widget."""
        return Intent(lambda client, _: self._ask(client, request()))

    def _input(self, handle: Any, request: Callable[[Any], Request]) -> Input:
        """A widget that asks for something whenever a person changes it."""
        return Input(handle, lambda client, value: self._ask(client, request(value)))

    def _build_way_back(self) -> None:
        self._whose = self._gui.add_html("", visible=False)
        self._back = self._gui.add_button("Back", icon=viser.Icon.ARROW_BACK_UP, visible=False)
        self._back.on_click(self._asking(GoBack))

    def _show_way_back(self, status: Status) -> None:
        """Say which run was opened, and offer what was set aside for it, as long as there is."""
        for handle in (self._whose, self._back):
            assign(handle, "visible", status.aside is not None)
        assign(self._back, "label", f"Back to {status.aside}")
        opened = escaped(sentence.opened_run(status.snapshot))
        assign(
            self._whose,
            "content",
            '<div style="padding:0 0.6em 0.5em;font-size:0.85em;overflow-wrap:anywhere">'
            f"On the board: <b>{opened}</b>, a run of an experiment.</div>",
        )

    def _build_transport(self, status: Status) -> None:
        gui = self._gui
        self._play = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, hint="Key: space")
        self._play.on_click(self._asking(self._play_or_pause))
        add_buttons(gui, "Go on by", {"One step": StepOnce(), "One trial": TrialOnce()}, self._ask)
        speed = gui.add_slider(
            speed_label(status.speed),
            min=0.0,
            max=_FULL,
            step=0.1,
            initial_value=slider_of(status.speed),
            marks=_SPEED_MARKS,
            hint="Learning steps per second; max is as fast as it goes",
        )
        self._speed = self._input(speed, lambda place: SetSpeed(speed_of(place)))

    def _build_hotkeys(self) -> None:
        commands: list[tuple[str, Key, Callable[[], Request]]] = [
            ("Pause or play", keys.PLAY, self._play_or_pause),
            ("One step", keys.STEP, StepOnce),
            ("One trial", keys.TRIAL, TrialOnce),
            ("Slower", keys.SLOWER, lambda: SetSpeed(self._faster(-0.5))),
            ("Faster", keys.FASTER, lambda: SetSpeed(self._faster(0.5))),
            ("Add the next skill", keys.NEXT_SKILL, self._next_skill),
            ("Explore the chosen skill", keys.EXPLORE, self._exploration),
            ("Freeze the selection, or let it learn", keys.FREEZE, self._toggle_freeze),
        ]
        for label, key, request in commands:
            command = self._gui.add_command(label, hotkey=key.hotkey)
            command.on_trigger(self._asking(request))

    def _faster(self, by: float) -> float:
        return speed_of(min(max(slider_of(self._session.status.speed) + by, 0.0), _FULL))

    def _next_skill(self) -> Request:
        snapshot = self._session.status.snapshot
        absent = [s for s in snapshot.spec.learner.skills if s not in snapshot.present]
        if not absent:
            raise RefusedError("all skills of this learner have joined")
        return introduction_of(snapshot, absent[0])

    def _toggle_freeze(self) -> Request:
        return FreezeSelection(not self._session.status.snapshot.control.selection_frozen)

    def _play_or_pause(self) -> Request:
        return Pause() if self._session.status.playing else Play()

    def _show_transport(self, status: Status) -> None:
        label, icon = "Pause", viser.Icon.PLAYER_PAUSE
        if not status.playing:
            label, icon = "Play", viser.Icon.PLAYER_PLAY
            if status.finished:
                label = f"Go on for {counted(status.snapshot.spec.trials, 'trial')} more"
        if status.exhausted:
            label = "This run has had all its trials"
        if status.error is not None:
            label = "Stopped by an error: start again"
        if self._play.label != label:
            self._play.label = label
            self._play.icon = icon
        stuck = status.exhausted or status.error is not None
        assign(self._play, "disabled", stuck)
        self._speed.show(slider_of(status.speed))
        assign(self._speed.handle, "label", speed_label(status.speed))

    def _name_rows(self, skills: tuple[str, ...]) -> None:
        """Give each skill a row.

        Rows are kept and named anew, and none is removed: a page that takes an update and a removal
        at once carries out the removal first, and complains of the update.
        """
        while len(self._rows) < len(skills):
            with self._skills:
                text = self._gui.add_html("")
                row = _SkillRow(None, text, self._gui.add_button("Add", icon=viser.Icon.PLUS))
            row.add.on_click(self._asking(partial(self._introduction_by, row)))
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

    def _introduction_by(self, row: _SkillRow) -> Request:
        if row.skill is None:
            raise RefusedError("this learner has no such skill")
        return introduction_of(self._session.status.snapshot, row.skill)

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
                f'<div style="padding:0 0.6em;font-size:0.85em">{dot}'
                f" <b>{escaped(plain(row.skill))}</b>: {state}</div>",
            )
            assign(row.add, "visible", not present)

    def _build_explore(self) -> None:
        gui = self._gui
        self._explore = gui.add_folder("Explore a skill")
        with self._explore:
            self._explored: Choice[str | None] = Choice(gui, "Skill", {}, nothing=_NO_SKILL)
            gui.add_html(DIALS_HTML)
            self._chance = Dial(
                gui, "Probability", 0.5, Limits(0.0, 1.0, whole=False, share=True), 0.05
            )
            self._duration = NumberField(gui, "Trials", 2_000, Limits(1, 100_000))
            self._begin = gui.add_button("Start exploring", icon=viser.Icon.COMPASS)
            self._left = gui.add_html("")
            self._end = gui.add_button("Stop exploring", icon=viser.Icon.PLAYER_STOP)
        self._begin.on_click(self._asking(self._exploration))
        self._end.on_click(self._asking(self._end_of_exploration))

    def _end_of_exploration(self) -> Request:
        ending = self._ending(self._session.status.snapshot)
        if ending is None:
            raise RefusedError("nothing is being explored")
        return StopExploring(ending)

    def _ending(self, snapshot: Snapshot) -> str | None:
        """The exploration that a click would end: the chosen skill's, or else the newest."""
        running = [episode.skill for episode in snapshot.control.episodes]
        chosen = self._explored.chosen
        return chosen if chosen in running else next(iter(running), None)

    def _exploration(self) -> Request:
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
            f"{escaped(plain(e.skill))} at {e.probability:.0%}:"
            f" {counted(e.until_trial - snapshot.trial, 'trial')} left"
            for e in snapshot.control.episodes
            if e.until_trial > snapshot.trial
        ]
        if nothing:
            lines = ["A skill must have joined before it can be explored."]
        elif not lines:
            lines = ["Nothing is being explored."]
        body = "<br>".join(lines)
        assign(self._left, "content", f'<div style="padding:0 0.6em;font-size:0.85em">{body}</div>')

    def _build_learning(self) -> None:
        gui = self._gui
        with gui.add_folder("Learning"):
            self._freeze_selection = self._input(
                gui.add_checkbox("Freeze selection", False), FreezeSelection
            )
            self._freeze_skills = self._input(
                gui.add_checkbox("Freeze skills", False), FreezeSkills
            )
            self._follow = self._input(gui.add_checkbox("Follow schedule", True), FollowSchedule)
            self._why_not = gui.add_html(
                '<div style="padding:0 0.6em;font-size:0.85em">The options are moves: there are no'
                " skills to freeze and nothing to schedule.</div>",
                visible=False,
            )

    def _show_learning(self, status: Status) -> None:
        control = status.snapshot.control
        has_skills = bool(status.snapshot.spec.learner.skills)
        self._freeze_selection.show(control.selection_frozen)
        self._freeze_skills.show(control.skills_frozen)
        self._follow.show(control.schedule_on)
        assign(self._freeze_skills.handle, "disabled", not has_skills)
        assign(self._follow.handle, "disabled", not has_skills)
        assign(self._why_not, "visible", not has_skills)

    def _build_start(self, status: Status) -> None:
        gui = self._gui
        with gui.add_folder("Start again"):
            self._take_preset(status.snapshot.preset, status.snapshot.preset_spec)
            self._preset: Choice[str] = Choice(gui, "Preset", self._offered())
            self._preset.choose(status.snapshot.preset)
            self._seed = NumberField(
                gui,
                "Seed",
                status.snapshot.seed,
                Limits(0, MAX_SEED, grouped=False),
                f"A whole number, 0 to {MAX_SEED}",
            )
            again = gui.add_button("Start again", icon=viser.Icon.REFRESH)
        again.on_click(self._asking(self._start_again))

    def _start_again(self) -> Request:
        preset = self._preset.chosen
        spec = self._presets.get(preset) or self._loaded[preset]
        return StartAgain(spec, preset, int(self._seed.read()))

    def _offered(self) -> dict[str, str]:
        return {name: name for name in (*self._presets, *self._loaded)}

    def _take_preset(self, name: str, spec: RunSpec) -> None:
        """Let the preset of a run be started again."""
        if name in self._presets:
            self._presets[name] = spec
            return
        self._loaded.pop(name, None)
        self._loaded[name] = spec
        while len(self._loaded) > MOST_LOADED:
            del self._loaded[next(iter(self._loaded))]
