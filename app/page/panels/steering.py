"""Steering while it learns: parameters, skills of one's own, removal, and undo.

Shared by all browsers, like the other controls.
"""

from functools import partial
from typing import Final, NamedTuple

import viser
from pydantic import TypeAdapter, ValidationError

from app.explain.commands import command_in_words
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.confirm import confirm
from app.page.inbox import Ask, Intent, StatusOf
from app.page.number_field import DIALS_HTML, Dial, Limits, NumberField
from app.page.panels.weights import Weights
from app.page.widgets import CALM, DESTROYS, NAME_HTML, Choice, add_hints, assign
from app.server.callbacks import RefusedError
from app.util.html import escaped
from app.words.numbers import counted
from app.words.plain import PARAMETER_NAMES, by_plain_name, plain
from learners.commands import (
    DefineSkill,
    Event,
    Introduce,
    Remove,
    SetParameter,
    StopTeaching,
    Teach,
    Undo,
)
from learners.misfits import not_for_script
from learners.names import MAX_TRIALS, SkillName
from learners.parameters import value_of
from learners.skill_spec import SkillWeights
from learners.skills import SKILLS

DEFAULT_FREEZE_TRIALS: Final = 300
"""Freeze of a skill added by hand when the schedule has none for it: the thesis's."""

_TAUGHT_TRIALS: Final = 300
"""For which a script teaches unless somebody wants it otherwise."""
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
    hint: str
    """What it is, in one plain sentence."""

    @property
    def label(self) -> str:
        """What it is called."""
        return PARAMETER_NAMES[self.key]

    @property
    def is_share(self) -> bool:
        """Whether it is a part of a whole."""
        return self.low == 0 and self.high <= 1


SLIDERS = (
    Slider(
        "learner.epsilon",
        0.0,
        1.0,
        0.01,
        "How often the learner tries something at random instead of what it knows to be best: 0"
        " never, 1 at every step.",
    ),
    Slider(
        "learner.alpha",
        0.0,
        1.0,
        0.01,
        "How far one experience moves what the learner holds a skill to be worth in a state: 0 not"
        " at all, 1 all the way to what it has just seen.",
    ),
    Slider(
        "learner.skill_alpha",
        0.0,
        1.0,
        0.01,
        "The same within each skill: how far one experience moves what a move is worth to it.",
    ),
    Slider(
        "learner.gamma",
        0.0,
        0.99,
        0.01,
        "How much is left of a reward's worth one step earlier: at 0.9 a capture that is ten steps"
        " away counts for a third.",
    ),
    Slider(
        "world.capture_reward", 0.0, 200.0, 5.0, "What the predator gets for catching the prey."
    ),
    Slider(
        "world.flight_reward",
        -200.0,
        0.0,
        5.0,
        "What the predator gets when the prey sees it coming and flees: less than nothing.",
    ),
    Slider("world.vision_radius", 0.0, 60.0, 1.0, "How far the prey sees, to its front."),
)


def introduction_of(snapshot: Snapshot, skill: str) -> Introduce:
    """Let a skill join now, with the freeze that the schedule has for it."""
    timer = snapshot.spec.schedule.skills.get(skill)
    if timer is None or timer.at == MAX_TRIALS:
        # A timer that never comes only keeps the skill out; its freeze is nobody's choice.
        return Introduce(skill, DEFAULT_FREEZE_TRIALS)
    return Introduce(skill, timer.freeze)


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


class Steering:
    """The shared panel of what changes the learner while it learns."""

    def __init__(self, gui: viser.GuiApi, ask: Ask, status_of: StatusOf, status: Status) -> None:
        self._gui = gui
        self._status_of = status_of
        self._ask = ask
        self._history: tuple[Event, ...] | None = None
        """As it was when the list of changes was made."""
        self._dials: dict[str, Dial] = {}
        self._build_parameters(status.snapshot)
        self._of_rule = Weights(
            gui, lambda client, key, value: ask(client, SetParameter(key, value))
        )
        self._build_undo()
        self._build_teaching()
        self._build_skills()
        self._build_removal()

    def settle(self, now_s: float) -> None:
        """Ask for what parameters were set to that came to rest."""
        for dial in self._dials.values():
            dial.settle(now_s)
        self._of_rule.settle(now_s)

    def update(self, status: Status) -> None:
        """Show what is true."""
        snapshot = status.snapshot
        for key, dial in self._dials.items():
            dial.show(value_of(snapshot.spec, key))
        self._dials["learner.skill_alpha"].disable(not snapshot.spec.learner.sub_policies)
        self._of_rule.update(snapshot)
        self._show_undo(snapshot)
        self._show_teaching(snapshot)
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
                    f"{slider.hint} From the next step on ({slider.key}).",
                    partial(self._set, slider.key),
                )

    def _set(self, key: str, client: viser.ClientHandle, value: float) -> None:
        self._ask(client, SetParameter(key, value))

    def _build_undo(self) -> None:
        with self._gui.add_folder("Changes by hand"):
            self._changes = self._gui.add_html("")
            self._undoable: Choice[int | None] = Choice(
                self._gui,
                "Take back",
                {},
                nothing=_NOTHING,
                hint="Which of the changes that were made by hand is to be taken back.",
            )
            self._undo = self._gui.add_button(
                "Undo",
                icon=viser.Icon.ARROW_BACK_UP,
                color=CALM,
                hint="What the change has set is as if it had not been made. What was learned"
                " meanwhile stays.",
            )
            add_hints(self._gui, self._undo)
        self._undo.on_click(Intent(self._undo_clicked))

    def _undo_clicked(self, client: viser.ClientHandle, _: object) -> None:
        if self._undoable.chosen is not None:
            self._ask(client, Undo(self._undoable.chosen))

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
            f"{escaped(names[e.number])}, trial {e.trial:,}</span>"
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
        if self._undoable.offer({names[e.number]: e.number for e in open_events}) and open_events:
            self._undoable.choose(open_events[0].number)
        assign(self._undo, "disabled", not open_events)

    def _build_teaching(self) -> None:
        gui = self._gui
        with gui.add_folder("Teaching", expand_by_default=False) as folder:
            self._taught_for = NumberField(
                gui,
                "Taught trials",
                _TAUGHT_TRIALS,
                Limits(1, MAX_TRIALS),
                "For how many trials, that is hunts, from now on.",
            )
            self._teach = gui.add_button(
                "Teach now",
                icon=viser.Icon.SCHOOL,
                color=CALM,
                hint="A script chooses the skill: avoid before the prey sees it, approach from"
                " behind, and else a circle to get there. The learner learns from that.",
            )
            self._stop_teaching = gui.add_button(
                "Stop teaching",
                icon=viser.Icon.PLAYER_STOP,
                color=CALM,
                hint="From now on the learner chooses for itself again.",
            )
            self._taught = gui.add_html("")
            add_hints(gui, self._teach, self._stop_teaching)
        self._teaching_folder = folder
        self._teach.on_click(Intent(self._teach_clicked))
        self._stop_teaching.on_click(Intent(lambda client, _: self._ask(client, StopTeaching())))

    def _teach_clicked(self, client: viser.ClientHandle, _: object) -> None:
        self._ask(client, Teach("flank", int(self._taught_for.read())))

    def _show_teaching(self, snapshot: Snapshot) -> None:
        learner, until = snapshot.spec.learner, snapshot.control.taught_until
        why_not, is_taught = not_for_script(learner), until > snapshot.trial
        assign(self._teaching_folder, "visible", bool(learner.skills))
        assign(self._teach, "disabled", why_not is not None)
        assign(self._stop_teaching, "visible", is_taught)
        said = "" if why_not is None else f"The script {why_not}."
        if is_taught:
            said = f"A script chooses until trial {until:,}."
        assign(self._taught, "content", f'<div class="pounce-note">{escaped(said)}</div>')

    def _build_skills(self) -> None:
        gui = self._gui
        with gui.add_folder("Other skills", expand_by_default=False) as folder:
            self._other: Choice[str | None] = Choice(
                gui,
                "Skill",
                {},
                nothing=_NO_OTHER,
                hint="Skills that there are and this learner does not have.",
            )
            self._add_other = gui.add_button(
                "Add this skill now",
                icon=viser.Icon.PLUS,
                color=CALM,
                hint="The skill joins now: the learner may choose it from the next step on.",
            )
            gui.add_html(
                '<div style="padding:0 0.6em;font-size:0.85em">A skill of your own is rewarded for'
                " so much of what each of these is rewarded for:</div>"
            )
            gui.add_html(DIALS_HTML)
            self._weights = {
                skill: Dial(
                    gui,
                    f"× {plain(skill)}",
                    0.0,
                    Limits(-2.0, 2.0, whole=False),
                    0.1,
                    f"How much of what {plain(skill)} is rewarded for the new skill is rewarded"
                    " for, too; below 0 it is punished for it.",
                )
                for skill in SKILLS
            }
            self._behind = Dial(
                gui,
                "× coming near from behind",
                0.0,
                Limits(-2.0, 2.0, whole=False),
                0.1,
                "How much it is rewarded for coming nearer where the prey does not look; needs to"
                " see where it does.",
            )
            self._flight = Dial(
                gui,
                "When the prey flees",
                0.0,
                Limits(-100.0, 100.0, whole=False),
                5.0,
                "What it earns when a move puts the prey to flight; below 0 it fears that.",
            )
            self._sees = gui.add_checkbox(
                "Sees where the prey looks",
                False,
                hint="Its table then tells the prey's eight headings apart, and is eight times as"
                " large.",
            )
            gui.add_html(NAME_HTML)
            self._name = gui.add_text(
                "Own skill",
                "my_skill",
                hint="What the new skill is called: small letters, digits and _.",
            )
            define = gui.add_button(
                "Add my own skill now",
                icon=viser.Icon.SPARKLES,
                color=CALM,
                hint="The new skill joins now, and is learned from nothing.",
            )
            add_hints(gui, self._add_other, define)
        self._skills_folder = folder
        self._add_other.on_click(Intent(self._add_other_clicked))
        define.on_click(Intent(self._define_clicked))

    def _add_other_clicked(self, client: viser.ClientHandle, _: object) -> None:
        if self._other.chosen is None:
            raise RefusedError("there is no such skill to add any more; choose one")
        self._ask(client, introduction_of(self._status_of(client).snapshot, self._other.chosen))

    def _define_clicked(self, client: viser.ClientHandle, _: object) -> None:
        name = str(self._name.value)
        try:
            _SKILL_NAME.validate_python(name)
        except ValidationError as error:
            raise RefusedError(
                f"{name[:40]!r} is not allowed; allowed: {_SKILL_NAME.json_schema()['description']}"
            ) from error
        if name in self._status_of(client).snapshot.spec.learner.known_skills:
            # Or the skill of that name that there is would join in the place of this one.
            raise RefusedError(f"there is a skill named {name!r}; allowed: another name")
        weights = {skill: round(dial.read(), 3) for skill, dial in self._weights.items()}
        own = SkillWeights.model_validate(
            {
                **weights,
                "behind": round(self._behind.read(), 3),
                "flight": round(self._flight.read(), 3),
                "sees": "prey_heading" if self._sees.value else None,
            }
        )
        if not (any(weights.values()) or own.behind or own.flight):
            raise RefusedError("all weights are 0, so nothing would be rewarded; set at least one")
        self._ask(client, DefineSkill(name, own))
        self._ask(client, Introduce(name, DEFAULT_FREEZE_TRIALS))

    def _show_skills(self, snapshot: Snapshot) -> None:
        learner = snapshot.spec.learner
        assign(self._skills_folder, "visible", bool(learner.skills))
        absent = (skill for skill in learner.known_skills if skill not in snapshot.present)
        self._other.offer(by_plain_name(absent))
        assign(self._add_other, "disabled", self._other.chosen is None)
        self._leaver.offer(by_plain_name(snapshot.present))
        assign(self._remove, "disabled", len(snapshot.present) < 2)

    def _build_removal(self) -> None:
        with self._skills_folder:
            self._leaver: Choice[str | None] = Choice(
                self._gui,
                "To remove",
                {},
                nothing=_NO_SKILL,
                hint="A skill that the learner has; it keeps at least one.",
            )
            self._remove = self._gui.add_button(
                "Remove this skill …",
                icon=viser.Icon.TRASH,
                color=DESTROYS,
                hint="The learner can no longer choose the skill. What is lost is said first.",
            )
            add_hints(self._gui, self._remove)
        self._remove.on_click(Intent(self._confirm_removal))

    def _confirm_removal(self, client: viser.ClientHandle, _: object) -> None:
        """Say what is lost, and ask."""
        snapshot, skill = self._status_of(client).snapshot, self._leaver.chosen
        if skill is None or skill not in snapshot.present:
            return
        confirm(
            client,
            f"Remove {plain(skill)}?",
            loss_of(snapshot, skill),
            (f"Remove {plain(skill)}", "Keep it"),
            lambda: self._ask(client, Remove(skill)),
        )
