"""The controls that all browsers share: they change the learner.

A callback builds one request and enqueues it. A widget shows the state and never is the state:
once a request has been answered, the render loop sets every widget to what is true.
"""

import math
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

import viser

from app.explain import sentence
from app.live.session import (
    FULL_SPEED,
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
from app.page import keys
from app.page.keys import Key
from app.page.number_field import DIALS_HTML, Dial, Limits, NumberField
from app.page.panels.steering import Steering, introduction_of
from app.page.widgets import assign, on_change, show
from app.server.callbacks import RefusedError, guarded
from app.server.notices import tell
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
_STEP, _TRIAL = "One step", "One trial"
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
    skill: str
    text: viser.GuiHtmlHandle
    add: viser.GuiButtonHandle


class Controls:
    """The shared control panel."""

    def __init__(
        self,
        gui: viser.GuiApi,
        session: Session,
        presets: Mapping[str, RunSpec],
    ) -> None:
        self._gui = gui
        self._session = session
        self._presets = dict(presets)
        self._loaded: dict[str, RunSpec] = {}
        """Presets of runs besides those, the latest last."""
        self._asking = threading.Lock()
        self._ticket = 0
        self._shown: tuple[int, tuple[str, ...]] | None = None
        self._rows: list[_SkillRow] = []
        self._explorable: dict[str, str] = {}
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
            self._steering = Steering(gui, session, self.ask)
        self._build_rows(status)
        self._build_hotkeys()
        self.update(status)

    def update(self, status: Status) -> None:
        """Show what is true; not before the last request made here has been answered."""
        self._steering.settle(time.perf_counter())
        if status.answered < self._ticket:
            return
        snapshot = status.snapshot
        self._show_way_back(status)
        if self._shown != (snapshot.generation, snapshot.spec.learner.skills):
            self._build_rows(status)
            self._take_preset(snapshot.preset, snapshot.preset_spec)
            assign(self._preset, "options", (*self._presets, *self._loaded))
            assign(self._preset, "value", snapshot.preset)
            self._seed.put(snapshot.seed)
        self._show_transport(status)
        self._show_skills(status)
        self._show_explore(status)
        self._show_learning(status)
        self._steering.update(status)

    def ask(self, event: Any, request: Request) -> int:
        """Enqueue a request of the browser of an event; as :meth:`ask_for`."""
        return self.ask_for(event.client, request)

    def ask_for(self, client: viser.ClientHandle | None, request: Request) -> int:
        """Enqueue a request; the browser that made it is told if it cannot be carried out.

        Returns:
            Its ticket.
        """

        def refused(reason: str) -> None:
            if client is not None:
                tell(client, "That cannot be done now", reason, auto_close_seconds=6)

        ticket = self._session.submit(request, refused)
        with self._asking:
            # Threads ask at the same time, and may get here in another order than their requests.
            self._ticket = max(self._ticket, ticket)
        return ticket

    def _on(self, handle: Any, request: Callable[[Any], Request]) -> None:
        """Enqueue a request whenever a person changes a widget."""
        on_change(handle, lambda event, value: self.ask(event, request(value)))

    def _build_way_back(self) -> None:
        self._whose = self._gui.add_html("", visible=False)
        self._back = self._gui.add_button("Back", icon=viser.Icon.ARROW_BACK_UP, visible=False)
        self._back.on_click(guarded(self._asker(GoBack)))

    def _show_way_back(self, status: Status) -> None:
        """Say which run was opened, and offer what was set aside for it, as long as there is."""
        for handle in (self._whose, self._back):
            assign(handle, "visible", status.aside is not None)
        assign(self._back, "label", f"Back to {status.aside}")
        opened = escape(sentence.opened_run(status.snapshot))
        assign(
            self._whose,
            "content",
            '<div style="padding:0 0.6em 0.5em;font-size:0.85em;overflow-wrap:anywhere">'
            f"On the board: <b>{opened}</b>, a run of an experiment.</div>",
        )

    def _build_transport(self, status: Status) -> None:
        gui = self._gui
        self._play = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, hint="Key: space")
        self._play.on_click(guarded(lambda event: self.ask(event, self._play_or_pause())))
        self._once = gui.add_button_group("Go on by", (_STEP, _TRIAL))
        self._once.on_click(
            guarded(
                lambda event: self.ask(
                    event, StepOnce() if self._once.value == _STEP else TrialOnce()
                )
            )
        )
        self._speed = gui.add_slider(
            speed_label(status.speed),
            min=0.0,
            max=_FULL,
            step=0.1,
            initial_value=slider_of(status.speed),
            marks=_SPEED_MARKS,
            hint="Learning steps per second; max is as fast as it goes",
        )
        self._on(self._speed, lambda place: SetSpeed(speed_of(place)))

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
            command.on_trigger(guarded(self._asker(request)))

    def _asker(self, request: Callable[[], Request]) -> Callable[[Any], Any]:
        return lambda event: self.ask(event, request())

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
        show(self._speed, slider_of(status.speed))
        assign(self._speed, "label", speed_label(status.speed))

    def _build_rows(self, status: Status) -> None:
        for row in self._rows:
            row.text.remove()
            row.add.remove()
        skills = status.snapshot.spec.learner.skills
        self._rows = []
        self._shown = (status.snapshot.generation, skills)
        with self._skills:
            for skill in skills:
                text = self._gui.add_html("")
                add = self._gui.add_button(f"Add {plain(skill)} now", icon=viser.Icon.PLUS)
                add.on_click(guarded(self._adder(skill)))
                self._rows.append(_SkillRow(skill, text, add))
        self._skills.visible = bool(skills)
        self._explore.visible = bool(skills)

    def _adder(self, skill: str) -> Callable[[viser.GuiEvent], Any]:
        return lambda event: self.ask(event, introduction_of(self._session.status.snapshot, skill))

    def _show_skills(self, status: Status) -> None:
        for row in self._rows:
            present = row.skill in status.snapshot.present
            state = escape(skill_state(status, row.skill))
            dot = "&#9679;" if present else "&#9675;"
            assign(
                row.text,
                "content",
                f'<div style="padding:0 0.6em;font-size:0.85em">{dot}'
                f" <b>{escape(plain(row.skill))}</b>: {state}</div>",
            )
            assign(row.add, "visible", not present)

    def _build_explore(self) -> None:
        gui = self._gui
        self._explore = gui.add_folder("Explore a skill")
        with self._explore:
            self._explored: Any = gui.add_dropdown("Skill", (_NO_SKILL,))
            gui.add_html(DIALS_HTML)
            self._chance = Dial(
                gui, "Probability", 0.5, Limits(0.0, 1.0, whole=False, share=True), 0.05
            )
            self._duration = NumberField(gui, "Trials", 2_000, Limits(1, 100_000))
            self._begin = gui.add_button("Start exploring", icon=viser.Icon.COMPASS)
            self._left = gui.add_html("")
            self._end = gui.add_button("Stop exploring", icon=viser.Icon.PLAYER_STOP)
        self._begin.on_click(guarded(self._asker(self._exploration)))
        self._end.on_click(guarded(self._asker(self._end_of_exploration)))

    def _end_of_exploration(self) -> Request:
        ending = self._ending(self._session.status.snapshot)
        if ending is None:
            raise RefusedError("nothing is being explored")
        return StopExploring(ending)

    def _ending(self, snapshot: Snapshot) -> str | None:
        """The exploration that a click would end: the chosen skill's, or else the newest."""
        running = [episode.skill for episode in snapshot.control.episodes]
        chosen = self._chosen_skill()
        return chosen if chosen in running else next(iter(running), None)

    def _exploration(self) -> Request:
        chosen = self._chosen_skill()
        if chosen is None:
            raise RefusedError("a skill must have joined before it can be explored")
        return Explore(chosen, int(self._duration.read()), self._chance.read())

    def _chosen_skill(self) -> str | None:
        return self._explorable.get(str(self._explored.value))

    def _show_explore(self, status: Status) -> None:
        snapshot = status.snapshot
        self._explorable = by_plain_name(snapshot.present)
        assign(self._explored, "options", tuple(self._explorable) or (_NO_SKILL,))
        ending = self._ending(snapshot)
        nothing = not snapshot.present
        assign(self._begin, "disabled", nothing)
        assign(self._end, "visible", ending is not None)
        label = "Stop exploring" if ending is None else f"Stop exploring {plain(ending)}"
        assign(self._end, "label", label)
        lines = [
            f"{escape(plain(e.skill))} at {e.probability:.0%}:"
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
            self._freeze_selection = gui.add_checkbox("Freeze selection", False)
            self._freeze_skills = gui.add_checkbox("Freeze skills", False)
            self._follow = gui.add_checkbox("Follow schedule", True)
            self._why_not = gui.add_html(
                '<div style="padding:0 0.6em;font-size:0.85em">The options are moves: there are no'
                " skills to freeze and nothing to schedule.</div>",
                visible=False,
            )
        self._on(self._freeze_selection, FreezeSelection)
        self._on(self._freeze_skills, FreezeSkills)
        self._on(self._follow, FollowSchedule)

    def _show_learning(self, status: Status) -> None:
        control = status.snapshot.control
        has_skills = bool(status.snapshot.spec.learner.skills)
        show(self._freeze_selection, control.selection_frozen)
        show(self._freeze_skills, control.skills_frozen)
        show(self._follow, control.schedule_on)
        assign(self._freeze_skills, "disabled", not has_skills)
        assign(self._follow, "disabled", not has_skills)
        assign(self._why_not, "visible", not has_skills)

    def _build_start(self, status: Status) -> None:
        gui = self._gui
        with gui.add_folder("Start again"):
            self._take_preset(status.snapshot.preset, status.snapshot.preset_spec)
            self._preset: Any = gui.add_dropdown(
                "Preset",
                (*self._presets, *self._loaded),
                initial_value=status.snapshot.preset,
            )
            self._seed = NumberField(
                gui,
                "Seed",
                status.snapshot.seed,
                Limits(0, MAX_SEED, grouped=False),
                f"A whole number, 0 to {MAX_SEED}",
            )
            self._again = gui.add_button("Start again", icon=viser.Icon.REFRESH)
        self._again.on_click(guarded(lambda event: self.ask(event, self._start_again())))

    def _start_again(self) -> Request:
        preset = str(self._preset.value)
        spec = self._presets.get(preset) or self._loaded.get(preset)
        if spec is None:
            raise RefusedError(f"the preset {preset[:40]!r} is not kept any more; choose another")
        return StartAgain(spec, preset, int(self._seed.read()))

    def _take_preset(self, name: str, spec: RunSpec) -> None:
        """Let the preset of a run be started again."""
        if name in self._presets:
            self._presets[name] = spec
            return
        self._loaded.pop(name, None)
        self._loaded[name] = spec
        while len(self._loaded) > MOST_LOADED:
            del self._loaded[next(iter(self._loaded))]
