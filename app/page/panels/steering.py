"""Steering while it learns: parameters, skills of one's own, removal, and undo.

Shared by all browsers, like the other controls. Sliders ask only once they have come to rest, so
that a drag is one change and one mark on the curve.
"""

import io
import re
import threading
import time
from collections.abc import Callable
from html import escape
from typing import Any, Final, NamedTuple

import numpy as np
import viser
from pydantic import TypeAdapter, ValidationError

from app.live.session import Session, Status
from app.live.snapshot import Snapshot
from app.page.number_field import DIALS_HTML, Dial, Limits
from app.page.panels.schedule import Ask
from app.page.widgets import NAME_HTML, assign
from app.server.callbacks import RefusedError, guarded
from app.server.notices import close_modal, open_modal
from app.words.numbers import counted
from app.words.plain import PARAMETER_NAMES, by_plain_name, plain
from learners.commands import (
    Command,
    DefineSkill,
    Event,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
    SetSchedule,
    StopExploring,
    Undo,
)
from learners.parameters import value_of
from learners.skills import SKILLS
from learners.spec import MAX_TRIALS, MOVES, SkillName, SkillWeights

DEFAULT_FREEZE_TRIALS: Final = 300
"""Freeze of a skill added by hand when the schedule has none for it: the thesis's."""

_REST_S = 0.35
"""A slider that has not moved for so long has come to rest."""
_SHOWN_CHANGES = 6
_MOST_CHANGES = 100
"""The latest changes by hand, which alone can be taken back here."""
_NOTHING = "(nothing to undo)"
_NO_OTHER = "(no other skill)"
_NO_SKILL = "(no skill yet)"
_SKILL_NAME: Final = TypeAdapter[str](SkillName)


class Slider(NamedTuple):
    """One parameter that can be steered."""

    key: str
    low: float
    high: float
    step: float

    @property
    def label(self) -> str:
        """What it is called."""
        return PARAMETER_NAMES[self.key]

    @property
    def is_share(self) -> bool:
        """Whether it is a part of a whole."""
        return self.low == 0 and self.high <= 1


SLIDERS = (
    Slider("learner.epsilon", 0.0, 1.0, 0.01),
    Slider("learner.alpha", 0.0, 1.0, 0.01),
    Slider("learner.skill_alpha", 0.0, 1.0, 0.01),
    Slider("learner.gamma", 0.0, 0.99, 0.01),
    Slider("world.capture_reward", 0.0, 200.0, 5.0),
    Slider("world.flight_reward", -200.0, 0.0, 5.0),
    Slider("world.vision_radius", 0.0, 60.0, 1.0),
)


def introduction_of(snapshot: Snapshot, skill: str) -> Introduce:
    """Let a skill join now, with the freeze that the schedule has for it."""
    timer = snapshot.spec.schedule.skills.get(skill)
    if timer is None or timer.at >= MAX_TRIALS:
        # A timer that never comes only keeps the skill out; its freeze is nobody's choice.
        return Introduce(skill, DEFAULT_FREEZE_TRIALS)
    return Introduce(skill, timer.freeze)


def command_in_words(command: Command) -> str:
    """A command in a few words."""
    match command:
        case Introduce(skill=skill):
            return f"{plain(skill)} added"
        case Explore(skill=skill, probability=probability):
            return f"{plain(skill)} explored at {probability:.0%}"
        case StopExploring(skill=skill):
            return f"exploring {plain(skill)} stopped"
        case FreezeSelection(frozen=frozen):
            return f"selection {'frozen' if frozen else 'learning again'}"
        case FreezeSkills(frozen=frozen):
            return f"skills {'frozen' if frozen else 'learning again'}"
        case FollowSchedule(on=on):
            return f"schedule {'on' if on else 'off'}"
        case DefineSkill(skill=skill):
            return f"{plain(skill)} defined"
        case Remove(skill=skill):
            return f"{plain(skill)} removed"
        case SetParameter(key=key, value=value):
            return f"{PARAMETER_NAMES[key]} = {value:g}"
        case SetSchedule():
            return "schedule edited"
        case Undo(number=number):
            return f"change {number} undone"


def undoable(history: tuple[Event, ...]) -> list[Event]:
    """Changes by hand that can still be taken back, the newest first."""
    fixed = (Undo, DefineSkill)
    return [
        event
        for event in reversed(history)
        if event.author == "hand" and not event.undone and not isinstance(event.command, fixed)
    ]


def loss_of(snapshot: Snapshot, skill: str) -> str:
    """What removing a skill loses, in words."""
    option = snapshot.spec.learner.skills.index(skill)
    others = [
        index
        for index, name in enumerate(snapshot.spec.learner.skills)
        if index != option and name in snapshot.present
    ]
    q = snapshot.selection_q
    lower = int((q[..., option] > q[..., others].max(axis=-1)).sum()) if others else 0
    tried = int((snapshot.visits[..., option] > 0).sum())
    return (
        f"The selection has tried {plain(skill)} in {tried:,} states and finds it best in"
        f" {lower:,}, whose values will fall. What the skill itself has learned stays. The removal"
        " can be undone under Changes by hand."
    )


def saved_state(snapshot: Snapshot) -> tuple[str, bytes]:
    """A name for a file and the tables in it, as NumPy's ``npz`` without pickles."""
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        selection_q=np.where(np.isneginf(snapshot.selection_q), np.nan, snapshot.selection_q),
        skill_q=snapshot.skill_q,
        visits=snapshot.visits,
        first_reach=snapshot.first_reach,
        step=np.int64(snapshot.step),
        trial=np.int64(snapshot.trial),
        seed=np.int64(snapshot.seed),
    )
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", snapshot.preset)
    return f"{name}-seed{snapshot.seed}-trial{snapshot.trial}.npz", buffer.getvalue()


class Steering:
    """The shared panel of what changes the learner while it learns."""

    def __init__(self, gui: viser.GuiApi, session: Session, ask: Ask) -> None:
        self._gui = gui
        self._session = session
        self._ask = ask
        self._lock = threading.Lock()
        self._pending: dict[str, tuple[viser.GuiEvent, float, float]] = {}
        self._open_changes: dict[str, int] = {}
        self._history: tuple[Event, ...] | None = None
        """As it was when the list of changes was made."""
        self._others: dict[str, str] = {}
        self._leavers: dict[str, str] = {}
        self._dials: dict[str, Dial] = {}
        self._build_parameters(session.status.snapshot)
        self._build_undo()
        self._build_skills()
        self._build_removal()

    def settle(self, now_s: float) -> None:
        """Ask for what parameters were set to that came to rest."""
        with self._lock:
            rested = [key for key, moved in self._pending.items() if now_s - moved[2] >= _REST_S]
            # Taken out before anything is asked: what is set meanwhile is another change.
            changes = [(key, *self._pending.pop(key)) for key in rested]
        for key, event, value, _ in changes:
            self._ask(event, SetParameter(key, value))

    def update(self, status: Status) -> None:
        """Show what is true."""
        snapshot = status.snapshot
        for slider in SLIDERS:
            if slider.key not in self._pending:
                self._dials[slider.key].show(value_of(snapshot.spec, slider.key))
        self._dials["learner.skill_alpha"].disable(not snapshot.spec.learner.skills)
        self._show_undo(snapshot)
        self._show_skills(snapshot)

    def _build_parameters(self, snapshot: Snapshot) -> None:
        with self._gui.add_folder("Parameters"):
            self._gui.add_html(DIALS_HTML)
            for slider in SLIDERS:
                self._dials[slider.key] = Dial(
                    self._gui,
                    slider.label,
                    value_of(snapshot.spec, slider.key),
                    Limits(slider.low, slider.high, whole=False, share=slider.is_share),
                    slider.step,
                    f"{slider.key}, {slider.low:g} to {slider.high:g}; takes effect at the next"
                    " step",
                    self._mover(slider.key),
                )

    def _mover(self, key: str) -> Callable[[viser.GuiEvent, float], None]:
        def moved(event: viser.GuiEvent, value: float) -> None:
            with self._lock:
                self._pending[key] = (event, value, time.perf_counter())

        return moved

    def _build_undo(self) -> None:
        with self._gui.add_folder("Changes by hand"):
            self._changes = self._gui.add_html("")
            self._chosen: Any = self._gui.add_dropdown("Take back", (_NOTHING,))
            self._undo = self._gui.add_button("Undo", icon=viser.Icon.ARROW_BACK_UP)
        self._undo.on_click(guarded(self._undo_clicked))

    def _undo_clicked(self, event: viser.GuiEvent) -> None:
        number = self._open_changes.get(str(self._chosen.value))
        if number is not None:
            self._ask(event, Undo(number))

    def _show_undo(self, snapshot: Snapshot) -> None:
        history = snapshot.control.history
        if history is self._history:
            return
        self._history = history
        changes = [e for e in history if e.author == "hand" and not isinstance(e.command, Undo)]
        # Counted as they are listed: what the schedule did between them has numbers of its own.
        names = {
            e.number: f"{n}: {command_in_words(e.command)}"
            for n, e in list(enumerate(changes, 1))[-_MOST_CHANGES:]
        }
        lines = [
            f"<span style='{'text-decoration:line-through;opacity:0.6' if e.undone else ''}'>"
            f"{escape(names[e.number])}, trial {e.trial:,}</span>"
            for e in changes[-_SHOWN_CHANGES:]
        ]
        body = "<br>".join(lines) or "Nothing has been changed by hand."
        if len(changes) > _SHOWN_CHANGES:
            earlier = counted(len(changes) - _SHOWN_CHANGES, "earlier change")
            body = f"… {earlier}<br>{body}"
        assign(
            self._changes, "content", f'<div style="padding:0 0.6em;font-size:0.8em">{body}</div>'
        )
        open_events = [e for e in undoable(history) if e.number in names]
        self._open_changes = {names[e.number]: e.number for e in open_events}
        options = tuple(self._open_changes) or (_NOTHING,)
        if self._chosen.options != options:
            self._chosen.options = options
            self._chosen.value = options[0]
        assign(self._undo, "disabled", not open_events)

    def _build_skills(self) -> None:
        gui = self._gui
        with gui.add_folder("Other skills", expand_by_default=False) as folder:
            self._other: Any = gui.add_dropdown("Skill", (_NO_OTHER,))
            self._add_other = gui.add_button("Add this skill now", icon=viser.Icon.PLUS)
            gui.add_html(
                '<div style="padding:0 0.6em;font-size:0.85em">A skill of your own is rewarded for'
                " so much of what each of these is rewarded for:</div>"
            )
            gui.add_html(DIALS_HTML)
            self._weights = {
                skill: Dial(gui, f"× {plain(skill)}", 0.0, Limits(-2.0, 2.0, whole=False), 0.1)
                for skill in SKILLS
            }
            gui.add_html(NAME_HTML)
            self._name = gui.add_text("Own skill", "my_skill", hint="a name of small letters and _")
            self._define = gui.add_button("Add my own skill now", icon=viser.Icon.SPARKLES)
        self._skills_folder = folder
        self._add_other.on_click(guarded(self._add_other_clicked))
        self._define.on_click(guarded(self._define_clicked))

    def _add_other_clicked(self, event: viser.GuiEvent) -> None:
        skill = self._others.get(str(self._other.value))
        if skill is None:
            raise RefusedError("there is no such skill to add any more; choose one")
        self._ask(event, introduction_of(self._session.status.snapshot, skill))

    def _define_clicked(self, event: viser.GuiEvent) -> None:
        name = str(self._name.value)
        try:
            _SKILL_NAME.validate_python(name)
        except ValidationError as error:
            raise RefusedError(
                f"{name[:40]!r} is not allowed; allowed: {_SKILL_NAME.json_schema()['description']}"
            ) from error
        if name in self._session.status.snapshot.spec.learner.known_skills:
            # Or the skill of that name that there is would join in the place of this one.
            raise RefusedError(f"there is a skill named {name!r}; allowed: another name")
        weights = {skill: round(dial.read(), 3) for skill, dial in self._weights.items()}
        if not any(weights.values()):
            raise RefusedError("all weights are 0, so nothing would be rewarded; set at least one")
        self._ask(event, DefineSkill(name, SkillWeights(**weights)))
        self._ask(event, Introduce(name, DEFAULT_FREEZE_TRIALS))

    def _show_skills(self, snapshot: Snapshot) -> None:
        learner = snapshot.spec.learner
        assign(self._skills_folder, "visible", learner.options != MOVES)
        absent = (skill for skill in learner.known_skills if skill not in snapshot.present)
        self._others, self._leavers = by_plain_name(absent), by_plain_name(snapshot.present)
        assign(self._other, "options", tuple(self._others) or (_NO_OTHER,))
        assign(self._add_other, "disabled", not self._others)
        assign(self._leaver, "options", tuple(self._leavers) or (_NO_SKILL,))
        assign(self._remove, "disabled", len(snapshot.present) < 2)

    def _build_removal(self) -> None:
        with self._skills_folder:
            self._leaver: Any = self._gui.add_dropdown("To remove", (_NO_SKILL,))
            self._remove = self._gui.add_button(
                "Remove this skill …",
                icon=viser.Icon.TRASH,
                hint="The learner keeps at least one skill",
            )
        self._remove.on_click(guarded(self._confirm_removal))

    def _confirm_removal(self, event: viser.GuiEvent) -> None:
        """Say what is lost, and ask."""
        client, snapshot = event.client, self._session.status.snapshot
        skill = self._leavers.get(str(self._leaver.value))
        if client is None or skill is None or skill not in snapshot.present:
            return
        modal = open_modal(client, f"Remove {plain(skill)}?")
        with modal:
            client.gui.add_markdown(escape(loss_of(snapshot, skill)))
            yes = client.gui.add_button(f"Remove {plain(skill)}", color="red")
            no = client.gui.add_button("Keep it")

        def removed(_: viser.GuiEvent) -> None:
            close_modal(modal)
            self._ask(event, Remove(skill))

        yes.on_click(guarded(removed))
        no.on_click(guarded(lambda _: close_modal(modal)))
