"""The schedule below the board, drawn and edited; shared, as it is what the learner will do."""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import viser

from app.live.session import Session, Status
from app.live.snapshot import Snapshot
from app.page.inbox import Ask, Intent
from app.page.number_field import Limits, NumberField
from app.page.widgets import Choice, add_buttons, assign
from app.picture.timeline import axis_end, timeline_svg
from app.schedule import edits
from app.schedule.blocks import Block, Past
from app.server.callbacks import RefusedError
from app.words.numbers import counted
from app.words.plain import plain
from learners.commands import SetSchedule
from learners.spec import MAX_TRIALS, ScheduleSpec

_LEFT, _BOTTOM, _WIDTH = 8, 8, 684
"""Pixels: this panel lies between two side panels of 330 on a screen of 1366. On others the style
sheet places it (``app/web/looks.css``)."""
_PICTURE_WIDTH: Final = _WIDTH - 20.0

NUDGES: Final[Mapping[str, int]] = {
    "\N{MINUS SIGN}1,000": -1_000,
    "\N{MINUS SIGN}500": -500,
    "\N{MINUS SIGN}100": -100,
    "+100": 100,
    "+500": 500,
    "+1,000": 1_000,
}
"""Trials to move a block by, as the buttons say it."""

_NOTHING: Final = "\N{EN DASH} nothing \N{EN DASH}"
_REDRAW_S: Final = 0.5
"""How often the picture is sent again when nothing but the trial has changed."""
_NEW_TRIALS: Final = 2_000
_NEW_CHANCE: Final = 0.5
_NEW_AHEAD: Final = 1_000
_NEW_EVERY: Final = 100

# viser puts one widget below the other, which takes more height than there is below the board. The
# rules apply to the container of this panel alone. Where they do not, widgets are stacked.
_LAYOUT: Final = """<div class="pounce-schedule"></div><style>
div:has(> div > .pounce-schedule) {
  display: flex; flex-wrap: wrap; align-items: center; padding: 2px 6px 0 !important; }
div:has(> div > .pounce-schedule) > div {
  flex: 0 1 auto; padding: 0 4px 4px !important; margin: 0 !important; }
div:has(> div > .pounce-schedule) > div:has(> .pounce-schedule) { display: none; }
div:has(> div > .pounce-schedule) > div:has(> .pounce-timeline) { flex: 1 0 100%; }
div:has(> div > .pounce-schedule) > div > .mantine-Flex-root > div:first-child {
  width: auto !important; padding-right: 5px !important; }
div:has(> div > .pounce-schedule) > div:has(.mantine-Select-root),
div:has(> div > .pounce-schedule) > div:has(.mantine-Select-root)
  > .mantine-Flex-root > div:last-child { flex: 1 1 220px; }
div:has(> div > .pounce-schedule) .mantine-TextInput-root { width: 6.2em; }
div:has(> div > .pounce-schedule) .mantine-Button-root[data-size="sm"] {
  height: 1.9em !important; padding-inline: 0.9em; }
</style>"""


# --- What the widgets are to show ----------------------------------------------------------------


class Form(NamedTuple):
    """What can be done with what is chosen, and what its fields hold."""

    chosen: str
    """Id of a block, id of a new exploration, or nothing."""
    caption: str
    """What to do, or why nothing can be done."""
    at: int = 0
    trials: int = 0
    trials_label: str = "Lasts"
    probability: float = 0.0
    movable: bool = False
    editable: bool = False
    explores: bool = False
    """Whether it has a probability."""
    deletable: bool = False
    is_new: bool = False


def new_id(skill: str) -> str:
    """Id of an exploration of a skill that is about to be planned."""
    return f"new:{skill}"


def choices_of(blocks: Sequence[Block], snapshot: Snapshot) -> dict[str, str]:
    """What can be chosen, by its label: nothing, blocks that lie ahead, and new explorations."""
    ahead = sorted((block for block in blocks if block.editable), key=lambda block: block.first)
    choices = {_NOTHING: ""}
    for skill in snapshot.spec.learner.skills:
        mine = [block for block in ahead if block.skill == skill]
        explorations = [block for block in mine if block.kind == "exploration"]
        for block in mine:
            name = f"{plain(skill)}: joins"
            if block.kind == "exploration":
                number = f" {explorations.index(block) + 1}" if len(explorations) > 1 else ""
                name = f"{plain(skill)}: exploration{number}"
            choices[name] = block.id
    for skill in snapshot.spec.learner.skills:
        choices[f"{plain(skill)}: new exploration"] = new_id(skill)
    return choices


def form_of(chosen: str, blocks: Sequence[Block], snapshot: Snapshot) -> Form:
    """What the widgets are to show for a choice."""
    block = next((block for block in blocks if block.id == chosen and block.editable), None)
    if block is not None:
        return _form_of_block(block, snapshot)
    kind, _, skill = chosen.partition(":")
    if kind == "new" and skill in snapshot.spec.learner.skills:
        return _form_of_new(chosen, skill, blocks, snapshot)
    if not snapshot.spec.learner.skills:
        return Form("", "The options are the nine moves: nothing to schedule.")
    if chosen:
        return Form("", "What was chosen has begun or is gone.")
    if not any(block.editable for block in blocks):
        running = bool(snapshot.control.episodes)
        what = "All that was planned has begun" if running else "All that was planned is past"
        return Form("", f"{what}; plan a new exploration.")
    return Form("", _if_followed("Choose below what to change; the past is locked.", snapshot))


def _if_followed(caption: str, snapshot: Snapshot) -> str:
    if snapshot.control.schedule_on:
        return caption
    return "The schedule is not followed: none of this will happen."


def _form_of_block(block: Block, snapshot: Snapshot) -> Form:
    joins = block.kind == "introduction"
    caption = (
        "It can be moved, not deleted. Explorations move along."
        if joins
        else "It can be moved, changed and deleted until it begins."
    )
    return Form(
        chosen=block.id,
        caption=_if_followed(caption, snapshot),
        at=block.first,
        trials=block.trials,
        trials_label="Freeze" if joins else "Lasts",
        probability=0.0 if block.probability is None else block.probability,
        movable=True,
        editable=True,
        explores=not joins,
        deletable=not joins,
    )


def _form_of_new(chosen: str, skill: str, blocks: Sequence[Block], snapshot: Snapshot) -> Form:
    here = skill in snapshot.present
    joins = next(
        (
            b.first
            for b in blocks
            if b.kind == "introduction" and b.skill == skill and b.state == "planned"
        ),
        None,
    )
    if not here and joins is None:
        return Form(chosen, f"{plain(skill)} is not going to join: add it or plan that first.")
    soon = -(-(snapshot.trial + _NEW_AHEAD) // _NEW_EVERY) * _NEW_EVERY
    return Form(
        chosen=chosen,
        caption=_if_followed("Say when, how long and how likely; then add it.", snapshot),
        at=min(soon if joins is None or here else max(soon, joins), MAX_TRIALS),
        trials=_NEW_TRIALS,
        probability=_NEW_CHANCE,
        editable=True,
        explores=True,
        is_new=True,
    )


# --- The panel -----------------------------------------------------------------------------------


class SchedulePanel:
    """The panel; the render loop calls :meth:`update`."""

    def __init__(self, gui: viser.GuiApi, ask: Ask, session: Session) -> None:
        self._ask = ask
        self._session = session
        self._pending: ScheduleSpec | None = None
        """What was asked for and has not been answered."""
        self._past = Past()
        self._generation = -1
        self._chosen = ""
        self._loaded: Form | None = None
        self._drawn: object = None
        self._drawn_trial = -1
        self._drawn_s = 0.0
        panel = gui.add_panel()
        panel.float(x=_LEFT, y=-_BOTTOM, width=_WIDTH)
        with panel.add_tab("Schedule", icon=viser.Icon.TIMELINE):
            self._build(gui)
        self.update(session.status)

    def _build(self, gui: viser.GuiApi) -> None:
        gui.add_html(_LAYOUT)
        self._picture = gui.add_html("")
        self._choice: Choice[str] = Choice(gui, "Change", {_NOTHING: ""}, self._choose)
        self._nudges = add_buttons(gui, "Move by", NUDGES, self._nudge, visible=False)
        # A button group cannot be disabled once it is there, so there is another one that is.
        self._no_nudges = gui.add_button_group("Move by", tuple(NUDGES), disabled=True)
        trials = Limits(0, MAX_TRIALS)
        self._at = NumberField(gui, "At trial", 0, trials)
        self._trials = NumberField(gui, "Lasts", 0, trials, "In trials")
        self._chance = NumberField(
            gui,
            "Chance",
            _NEW_CHANCE,
            Limits(0.0, 1.0, whole=False, share=True),
            "That a step takes the skill",
        )
        self._apply = gui.add_button("Apply", icon=viser.Icon.CHECK)
        self._delete = gui.add_button("Delete", icon=viser.Icon.TRASH, color="red")
        self._apply.on_click(Intent(lambda client, _: self._edit(client, self._applied)))
        self._delete.on_click(Intent(lambda client, _: self._edit(client, self._deleted)))

    def update(self, status: Status) -> None:
        """Show what is true; not to be called before all requests have been answered."""
        self._pending = None
        snapshot = status.snapshot
        if snapshot.generation != self._generation:
            self._generation, self._chosen, self._loaded = snapshot.generation, "", None
        blocks = self._past.blocks_of(snapshot)
        form = form_of(self._chosen, blocks, snapshot)
        choices = choices_of(blocks, snapshot)
        self._choice.offer(choices)
        self._choice.choose(form.chosen)
        assign(self._choice.handle, "disabled", len(choices) == 1)
        self._show_form(form)
        self._show_picture(blocks, snapshot, form, status.playing)

    def _show_form(self, form: Form) -> None:
        assign(self._nudges, "visible", form.movable)
        assign(self._no_nudges, "visible", not form.movable)
        assign(self._no_nudges, "hint", form.caption)
        for field in (self._at, self._trials):
            assign(field.handle, "disabled", not form.editable)
        assign(self._chance.handle, "disabled", not form.explores)
        assign(self._trials.handle, "label", form.trials_label)
        assign(self._apply, "label", "Add" if form.is_new else "Apply")
        assign(self._delete, "disabled", not form.deletable)
        if self._is_news(form):
            self._loaded = form
            self._at.put(form.at)
            self._trials.put(form.trials)
            self._chance.put(form.probability)
        changed = form.editable and (form.is_new or self._is_typed(form))
        assign(self._apply, "disabled", not changed)

    def _is_news(self, form: Form) -> bool:
        """Whether the fields are to be filled: not while a person is changing them."""
        former = self._loaded
        if former is None or former.chosen != form.chosen:
            return True
        values = (form.at, form.trials, form.probability)
        # The start that a new exploration is proposed to have moves on with the run.
        return not form.is_new and values != (former.at, former.trials, former.probability)

    def _typed(self, form: Form) -> dict[str, Any]:
        """What the fields hold that is not so.

        Raises:
            RefusedError: one of them holds no number.
        """
        typed: dict[str, Any] = {"at": int(self._at.read()), "trials": int(self._trials.read())}
        true: dict[str, Any] = {"at": form.at, "trials": form.trials}
        if form.explores:
            typed["probability"] = self._chance.read()
            true["probability"] = form.probability
        return {name: value for name, value in typed.items() if value != true[name]}

    def _is_typed(self, form: Form) -> bool:
        """Whether the fields hold something that is not so, be it no number at all."""
        try:
            return self._typed(form) != {}
        except RefusedError:
            return True

    def _show_picture(
        self, blocks: Sequence[Block], snapshot: Snapshot, form: Form, playing: bool
    ) -> None:
        shape = (
            blocks,
            form.chosen,
            form.caption,
            snapshot.spec,
            axis_end(snapshot),
        )
        now_s = time.monotonic()
        rests = snapshot.trial == self._drawn_trial
        if shape == self._drawn and (rests or (playing and now_s - self._drawn_s < _REDRAW_S)):
            return
        self._drawn, self._drawn_trial, self._drawn_s = shape, snapshot.trial, now_s
        caption = form.caption
        if self._past.left_out:
            caption += f" {counted(self._past.left_out, 'earlier change')} not drawn."
        self._picture.content = timeline_svg(
            blocks, snapshot, None, _PICTURE_WIDTH, form.chosen, caption
        )

    def _choose(self, client: viser.ClientHandle, chosen: str) -> None:
        self._chosen = chosen
        self._loaded = None

    def _nudge(self, client: viser.ClientHandle, by: int) -> None:
        self._edit(client, lambda plan, now, _: edits.moved(plan, self._chosen, by, now))

    def _applied(self, plan: ScheduleSpec, now: edits.Now, snapshot: Snapshot) -> ScheduleSpec:
        form = form_of(self._chosen, self._past.blocks_of(snapshot), snapshot)
        if form.is_new:
            _, _, skill = form.chosen.partition(":")
            plan = edits.with_episode(
                plan,
                skill,
                int(self._at.read()),
                int(self._trials.read()),
                self._chance.read(),
                now,
            )
            self._chosen = edits.newest_episode_id(plan)
            return plan
        return edits.changed(plan, self._chosen, now, **self._typed(form))

    def _deleted(self, plan: ScheduleSpec, now: edits.Now, _: Snapshot) -> ScheduleSpec:
        plan = edits.without(plan, self._chosen, now)
        self._chosen = ""
        return plan

    def _edit(
        self,
        client: viser.ClientHandle,
        edited: Callable[[ScheduleSpec, edits.Now, Snapshot], ScheduleSpec],
    ) -> None:
        """Ask for an edited schedule.

        Raises:
            RefusedError: it cannot be had.
        """
        snapshot = self._session.status.snapshot
        # A second click before the first was answered goes on from what that asked for.
        plan = snapshot.spec.schedule if self._pending is None else self._pending
        try:
            plan = edited(plan, edits.now_of(snapshot), snapshot)
        except ValueError as error:
            raise RefusedError(str(error)) from error
        self._pending = plan
        self._ask(client, SetSchedule(plan))
