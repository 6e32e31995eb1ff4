"""Steering while it learns: parameters, skills of one's own, removal, and undo.

Shared by all browsers, like the other controls. Sliders ask only once they have come to rest, so
that a drag is one change and one mark on the curve.
"""

import io
import re
import time
from collections.abc import Callable
from html import escape
from typing import Any, NamedTuple

import numpy as np
import viser

from app.door import RefusedError, guarded
from app.narrate import plain
from app.session import Request, Session, Status
from app.snapshot import Snapshot
from app.widgets import assign, on_change, show
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
    Undo,
)
from learners.run import Event
from learners.skills import SKILLS
from learners.spec import MOVES, SkillWeights

Ask = Callable[[viser.GuiEvent, Request], int]

_REST_S = 0.35
"""A slider that has not moved for so long has come to rest."""
_SHOWN_CHANGES = 6
_OWN_FREEZE_TRIALS = 300
_NOTHING = "(nothing to undo)"
_NO_OTHER = "(no other skill)"
_NO_SKILL = "(no skill yet)"
_SKILL_NAME = re.compile(r"[a-z][a-z0-9_]{0,31}")


class Slider(NamedTuple):
    """One parameter that can be steered."""

    key: str
    label: str
    low: float
    high: float
    step: float


SLIDERS = (
    Slider("learner.epsilon", "Exploration ε", 0.0, 1.0, 0.01),
    Slider("learner.alpha", "α of selection", 0.0, 1.0, 0.01),
    Slider("learner.skill_alpha", "α of skills", 0.0, 1.0, 0.01),
    Slider("learner.gamma", "Discount γ", 0.0, 0.99, 0.01),
    Slider("world.capture_reward", "Capture reward", 0.0, 200.0, 5.0),
    Slider("world.flight_reward", "Flight reward", -200.0, 0.0, 5.0),
    Slider("world.vision_radius", "Vision radius", 0.0, 60.0, 1.0),
)


def value_of(snapshot: Snapshot, key: str) -> float:
    """Present value of a parameter by its dotted key."""
    section, name = key.split(".")
    return float(getattr(getattr(snapshot.spec, section), name))


def described(command: Command) -> str:
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
            return f"{key.split('.')[1].replace('_', ' ')} = {value:g}"
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
        if event.by_hand and not event.undone and not isinstance(event.command, fixed)
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
        self._pending: dict[str, tuple[viser.GuiEvent, float, float]] = {}
        self._sliders: dict[str, Any] = {}
        self._build_parameters(session.status.snapshot)
        self._build_undo()
        self._build_skills()
        self._build_removal()

    def settle(self, now_s: float) -> None:
        """Ask for what sliders that came to rest were set to."""
        for key, (event, value, moved_at) in list(self._pending.items()):
            if now_s - moved_at >= _REST_S:
                self._ask(event, SetParameter(key, value))
                del self._pending[key]

    def update(self, status: Status) -> None:
        """Show what is true."""
        snapshot = status.snapshot
        for slider in SLIDERS:
            if slider.key not in self._pending:
                value = min(max(value_of(snapshot, slider.key), slider.low), slider.high)
                show(self._sliders[slider.key], value)
        assign(self._sliders["learner.skill_alpha"], "disabled", not snapshot.spec.learner.skills)
        self._show_undo(snapshot)
        self._show_skills(snapshot)

    def _build_parameters(self, snapshot: Snapshot) -> None:
        with self._gui.add_folder("Parameters"):
            for slider in SLIDERS:
                handle = self._gui.add_slider(
                    slider.label,
                    min=slider.low,
                    max=slider.high,
                    step=slider.step,
                    initial_value=min(max(value_of(snapshot, slider.key), slider.low), slider.high),
                    hint=f"{slider.key}; takes effect at the next step",
                )
                on_change(handle, self._mover(slider.key))
                self._sliders[slider.key] = handle

    def _mover(self, key: str) -> Callable[[viser.GuiEvent, Any], None]:
        def moved(event: viser.GuiEvent, value: Any) -> None:
            self._pending[key] = (event, float(value), time.perf_counter())

        return moved

    def _build_undo(self) -> None:
        with self._gui.add_folder("Changes by hand"):
            self._changes = self._gui.add_html("")
            self._chosen: Any = self._gui.add_dropdown("Take back", (_NOTHING,))
            self._undo = self._gui.add_button("Undo", icon=viser.Icon.ARROW_BACK_UP)
        self._undo.on_click(guarded(self._undo_clicked))

    def _undo_clicked(self, event: viser.GuiEvent) -> None:
        number = str(self._chosen.value).partition(":")[0]
        if number.isdigit():
            self._ask(event, Undo(int(number)))

    def _show_undo(self, snapshot: Snapshot) -> None:
        changes = [
            event
            for event in snapshot.control.history
            if event.by_hand and not isinstance(event.command, Undo)
        ]
        lines = [
            f"<span style='{'text-decoration:line-through;opacity:0.6' if e.undone else ''}'>"
            f"{e.number}: {escape(described(e.command))}, trial {e.trial:,}</span>"
            for e in changes[-_SHOWN_CHANGES:]
        ]
        body = "<br>".join(lines) or "Nothing has been changed by hand."
        assign(
            self._changes, "content", f'<div style="padding:0 0.6em;font-size:0.8em">{body}</div>'
        )
        open_events = undoable(snapshot.control.history)
        options = tuple(f"{e.number}: {described(e.command)}" for e in open_events) or (_NOTHING,)
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
            self._weights = {
                skill: gui.add_slider(
                    f"× {plain(skill)}", min=-2.0, max=2.0, step=0.1, initial_value=0.0
                )
                for skill in SKILLS
            }
            self._name = gui.add_text("Own skill", "my_skill", hint="a name of small letters and _")
            self._define = gui.add_button("Add my own skill now", icon=viser.Icon.SPARKLES)
        self._skills_folder = folder
        self._add_other.on_click(guarded(self._add_other_clicked))
        self._define.on_click(guarded(self._define_clicked))

    def _add_other_clicked(self, event: viser.GuiEvent) -> None:
        skill = str(self._other.value).replace(" ", "_")
        self._ask(event, Introduce(skill, _OWN_FREEZE_TRIALS))

    def _define_clicked(self, event: viser.GuiEvent) -> None:
        name = str(self._name.value)
        if not _SKILL_NAME.fullmatch(name):
            raise RefusedError(
                f"{name[:40]!r} is not a name; allowed: small letters, digits and _, up to 32"
            )
        weights = {skill: round(float(slider.value), 3) for skill, slider in self._weights.items()}
        if not any(weights.values()):
            raise RefusedError("all weights are 0, so nothing would be rewarded; set at least one")
        self._ask(event, DefineSkill(name, SkillWeights(**weights)))
        self._ask(event, Introduce(name, _OWN_FREEZE_TRIALS))

    def _show_skills(self, snapshot: Snapshot) -> None:
        learner = snapshot.spec.learner
        assign(self._skills_folder, "visible", learner.options != MOVES)
        known = [*SKILLS, *learner.custom_skills]
        others = tuple(plain(s) for s in known if s not in snapshot.present) or (_NO_OTHER,)
        if self._other.options != others:
            self._other.options = others
        assign(self._add_other, "disabled", others == (_NO_OTHER,))
        present = tuple(plain(skill) for skill in snapshot.present) or (_NO_SKILL,)
        if self._leaver.options != present:
            self._leaver.options = present
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
        skill = str(self._leaver.value).replace(" ", "_")
        if client is None or skill not in snapshot.present:
            return
        modal = client.gui.add_modal(f"Remove {plain(skill)}?")
        with modal:
            client.gui.add_markdown(escape(loss_of(snapshot, skill)))
            yes = client.gui.add_button(f"Remove {plain(skill)}", color="red")
            no = client.gui.add_button("Keep it")

        def removed(_: viser.GuiEvent) -> None:
            modal.close()
            self._ask(event, Remove(skill))

        yes.on_click(guarded(removed))
        no.on_click(guarded(lambda _: modal.close()))
