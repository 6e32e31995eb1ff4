"""The few controls that a lesson's card has: what is shown of them, and what using one asks for.

What a lesson does not show is not there, and using it does nothing. All that is asked for goes the
way that a click in the panels goes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

from app.documents.lesson_cards import Card
from app.lessons.doing import EXPLORED
from app.lessons.story import has, layers_of
from app.lessons.words import Words
from app.live.requests import Pause, Play, Request, RunTo, SetSpeed, StepOnce, TrialOnce
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.panels.steering import introduction_of, undoable
from app.picture.layers import LAYERS
from app.picture.look import ALL, FOLDED, OF_TRIAL, Look
from app.words.plain import plain
from learners.commands import (
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    StopExploring,
    Undo,
)
from learners.spec import RunSpec

FRAMES: Final[Mapping[str, int]] = {"turned": FOLDED, "all": ALL, "trial": OF_TRIAL}
"""What headings are shown, as lessons call it."""
_FRAME_WORDS: Final = {
    "turned": "control.turned",
    "all": "control.all",
    "trial": "control.as_in_trial",
}
"""What is said of each."""
_SPEEDS: Final = (10.0, 200.0, 2_000.0, 20_000.0, 200_000.0)
_READ: Final = ("ask", "see", "why", "transfer")
"""Cards on which nothing is done to the learner: what is asked and told there is about the run as
it is."""


class Layer(NamedTuple):
    """Another layer is to be seen."""

    key: str


class Headings(NamedTuple):
    """Other headings are to be seen."""

    frame: int


class StartLessonAgain(NamedTuple):
    """Another run of the lesson is to begin."""

    spec: RunSpec | None = None
    """None for the lesson's own, to where that begins."""
    preset: str | None = None
    """As shown, if it is not the lesson's."""
    seed: int | None = None


class RunExperiment(NamedTuple):
    """An experiment is to be run, by its name."""

    name: str


class LookInto(NamedTuple):
    """A place of a region is to be looked into."""

    region: str


class OpenSide(NamedTuple):
    """Runs side by side are to be seen."""


class Watch(NamedTuple):
    """A hunt is to be watched."""


Wanted = Request | Layer | Headings | StartLessonAgain | OpenSide | Watch | RunExperiment | LookInto
"""What using a control comes to."""


@dataclass(frozen=True)
class Control:
    """One control, as the frame draws it."""

    control: str
    """By which it is told from others."""
    label: str
    kind: str
    """``button``, ``toggle``, ``slider`` or ``choice``."""
    wants: Mapping[Any, Wanted]
    """What each value of it asks for; of a button, its own and that of None."""
    value: Any = None
    options: tuple[tuple[Any, str], ...] = ()
    why: str = ""
    """Why it cannot be used now; it can if this is empty."""
    main: bool = False
    """Whether it does what the card asks for."""

    @property
    def sent(self) -> dict[str, Any]:
        """As the frame is told."""
        return {
            "control": self.control,
            "label": self.label,
            "kind": self.kind,
            "value": self.value,
            "options": [list(option) for option in self.options],
            "on": not self.why,
            "why": self.why,
            "main": self.main,
        }


def controls_of(
    names: frozenset[str], card: Card, status: Status, began: int, look: Look, words: Words
) -> tuple[Control, ...]:
    """All that there are.

    Args:
        names: what the lesson shows by now.
        card: the one that is shown.
        status: what is true for the browser.
        began: trial in which the card was entered.
        look: how the browser sees the board.
        words: in which they are named.
    """
    found = [
        *_transport(names, card, status, began, words),
        *_skills(names, card, status, words),
        *_views(names, card, look, words),
        *_others(names, card, status, words),
    ]
    if card.do is not None and card.do.command == "fork" and status.behind is None:
        # First one goes back: what is done at the end of the run makes no branch.
        return tuple(replace(one, main=False) for one in found)
    if any(one.main and one.control.startswith(("add_skill.", "explore.")) for one in found):
        # Whoever lets it learn before it is given what the card asks for has missed that.
        found = [one for one in found if one.control != "play" or status.playing]
    if card.do is not None and not status.playing and not any(one.main for one in found):
        # All that the card asks for has been given: what is left is to let it learn.
        found = [replace(one, main=one.control == "play") for one in found]
    return tuple(found)


def wanted(controls: tuple[Control, ...], control: str, value: Any) -> Wanted | None:
    """What using a control asks for; None if there is no such control or value, or not now."""
    found = next((one for one in controls if one.control == control), None)
    if found is None or found.why:
        return None
    # True is 1, and neither is a value of the other's control.
    for known, wants in found.wants.items():
        if known == value and isinstance(known, bool) == isinstance(value, bool):
            return wants
    return None


def _button(
    control: str, label: str, wants: Wanted, why: str = "", main: bool = False, says: str = ""
) -> Control:
    """One that is pressed.

    Args:
        says: which of two things it means now. A press that comes late, when it means the other, is
            none of that.
    """
    value = says or None
    return Control(control, label, "button", {None: wants, value: wants}, value, why=why, main=main)


def _toggle(control: str, label: str, on: bool, wants: Mapping[bool, Wanted]) -> Control:
    return Control(control, label, "toggle", wants, value=on)


# --- Going on ------------------------------------------------------------------------------------


def _transport(
    names: frozenset[str], card: Card, status: Status, began: int, words: Words
) -> list[Control]:
    found: list[Control] = []
    over = words.say("control.over") if status.finished else ""
    command = None if card.do is None else card.do.command
    if has(names, "play"):
        key, wants = ("pause", Pause()) if status.playing else ("play", Play())
        label = words.say(f"control.{key}")
        found.append(_button("play", label, wants, over, command == "play", says=key))
    do = card.do
    if do is not None and do.command == "run_to" and do.at is not None:
        until = do.at.after(began)
        is_there = status.snapshot.trial >= until
        why = over or (words.say("control.is_there") if is_there else "")
        goes = status.runs_to is not None
        label = words.say("control.runs_to" if goes else "control.run_to", trial=until)
        why = words.say("control.on_its_way") if goes else why
        found.append(_button("run_to", label, RunTo(until), why, main=not is_there))
    if has(names, "step"):
        label = words.say("control.step")
        found.append(_button("step", label, StepOnce(), over, command == "step"))
    if has(names, "trial"):
        label = words.say("control.trial")
        found.append(_button("trial", label, TrialOnce(), over, command == "trial"))
    if has(names, "speed"):
        nearest = min(_SPEEDS, key=lambda speed: abs(speed - status.speed))
        options = tuple((speed, words.say("control.speed_of", n=speed)) for speed in _SPEEDS)
        label = words.say("control.speed")
        wants = {speed: SetSpeed(speed) for speed in _SPEEDS}
        found.append(Control("speed", label, "slider", wants, nearest, options))
    return found


# --- Skills --------------------------------------------------------------------------------------


def _skills(names: frozenset[str], card: Card, status: Status, words: Words) -> list[Control]:
    if card.kind in _READ:
        return []
    snapshot, do = status.snapshot, card.do
    skills, present = snapshot.spec.learner.skills, snapshot.present
    found: list[Control] = []
    if has(names, "add_skill"):
        added = _added_by(card)
        for skill in skills:
            if skill not in present and (not added or skill in added):
                is_main = do is not None and (do.command, do.skill) == ("introduce", skill)
                wants = introduction_of(snapshot, skill)
                label = words.say("control.add_skill", skill=plain(skill))
                found.append(_button(f"add_skill.{skill}", label, wants, main=is_main))
    if has(names, "explore"):
        running = {episode.skill for episode in snapshot.control.running(snapshot.trial)}
        asked = _explored_by(card)
        for skill in present if len(present) > 1 else ():
            if asked and skill not in asked:
                continue
            trials, chance = asked.get(skill, EXPLORED)
            is_main = skill in asked and not was_explored(skill, snapshot)
            if skill in running:
                says = "stop"
                wants: Wanted = StopExploring(skill)
                label = words.say("control.stop_exploring", skill=plain(skill))
                is_main = do is not None and (do.command, do.skill) == ("stop_exploring", skill)
            else:
                says = "explore"
                wants = Explore(skill, trials, chance)
                label = words.say(
                    "control.explore",
                    skill=plain(skill),
                    trials=trials,
                    chance=words.percent(chance),
                )
            found.append(_button(f"explore.{skill}", label, wants, main=is_main, says=says))
    if has(names, "freeze"):
        control = snapshot.control
        frozen = {on: FreezeSelection(on) for on in (True, False)}
        label = words.say("control.freeze_selection")
        found.append(_toggle("freeze.selection", label, control.selection_frozen, frozen))
        if skills:
            still = {on: FreezeSkills(on) for on in (True, False)}
            label = words.say("control.freeze_skills")
            found.append(_toggle("freeze.skills", label, control.skills_frozen, still))
    if has(names, "plan") and skills:
        follow = {on: FollowSchedule(on) for on in (True, False)}
        on = snapshot.control.schedule_on
        found.append(_toggle("plan", words.say("control.plan"), on, follow))
    return found


def _added_by(card: Card) -> set[str]:
    """The skills that a card has added."""
    do = card.do
    given = () if do is None else (do, *(do.then or ()))
    return {one.skill for one in given if one.command == "introduce" and one.skill is not None}


def _explored_by(card: Card) -> dict[str, tuple[int, float]]:
    """The skills that a card has explored, each for how many trials and with which chance."""
    do = card.do
    given = () if do is None else (do, *(do.then or ()))
    return {
        one.skill: (one.explore.trials, one.explore.chance)
        for one in given
        if one.skill is not None and one.explore is not None
    }


def was_explored(skill: str, snapshot: Snapshot) -> bool:
    """Whether somebody has had a skill explored."""
    return any(
        isinstance(event.command, Explore) and event.command.skill == skill
        for event in snapshot.control.history
        if event.author == "hand" and not event.undone
    )


# --- What is seen --------------------------------------------------------------------------------


def _views(names: frozenset[str], card: Card, look: Look, words: Words) -> list[Control]:
    found: list[Control] = []
    races = card.do is not None and card.do.command == "race"
    keys = layers_of(names)
    if len(keys) > 1:
        options = tuple((key, LAYERS[key].title) for key in keys)
        wants: Mapping[Any, Wanted] = {key: Layer(key) for key in keys}
        label = words.say("control.layer")
        found.append(Control("layer", label, "choice", wants, look.layer, options))
    if has(names, "headings"):
        now = next((name for name, one in FRAMES.items() if one == look.frame), "turned")
        options = tuple((name, words.say(key)) for name, key in _FRAME_WORDS.items())
        label = words.say("control.headings")
        wants = {name: Headings(one) for name, one in FRAMES.items()}
        found.append(Control("headings", label, "choice", wants, now, options))
    if has(names, "side"):
        found.append(_button("side", words.say("control.side"), OpenSide(), main=races))
    if has(names, "watch"):
        found.append(_button("watch", words.say("control.watch"), Watch()))
    return found


def _others(names: frozenset[str], card: Card, status: Status, words: Words) -> list[Control]:
    found: list[Control] = []
    do = card.do
    if has(names, "experiments") and do is not None and do.command == "experiment" and do.name:
        label = words.say("control.experiment", name=do.name.replace("_", " "))
        found.append(_button("experiments", label, RunExperiment(do.name), main=True))
    if card.kind in _READ:
        return found
    if has(names, "undo"):
        newest = next(iter(undoable(status.snapshot.control.history)), None)
        why = "" if newest else words.say("control.nothing_done")
        wants = Undo(0 if newest is None else newest.number)
        found.append(_button("undo", words.say("control.undo"), wants, why))
    if has(names, "start_again"):
        label = words.say("control.start_again")
        found.append(_button("start_again", label, StartLessonAgain()))
    return found
