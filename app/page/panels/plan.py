"""The plan: what the schedule has ahead, edited in numbers; shared, as it is what will be done.

Blocks are changed by hand on the time bar; these fields are for those who want numbers, and fold
away.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import viser

from app.charts.bar.axis import last_trial
from app.charts.bar.rule import long_of
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.inbox import Ask, Intent, StatusOf
from app.page.number_field import Limits, NumberField
from app.page.widgets import Choice, add_buttons, assign
from app.schedule import edits
from app.schedule.blocks import NEVER, Block, Past
from app.server.callbacks import RefusedError
from app.util.html import escaped
from app.words.plain import plain
from learners.commands import SetSchedule
from learners.names import MAX_TRIALS
from learners.schedule_spec import ScheduleSpec, TriggerSpec

EARLIER: Final[Mapping[str, int]] = {
    "\N{MINUS SIGN}1,000": -1_000,
    "\N{MINUS SIGN}500": -500,
    "\N{MINUS SIGN}100": -100,
}
LATER: Final[Mapping[str, int]] = {"+100": 100, "+500": 500, "+1,000": 1_000}
"""Trials to move a block by, as the buttons say it."""

JOINS: Final[Mapping[str, bool]] = {"At a trial": False, "By a rule": True}
"""How a skill can be told when to join: whether by a rule."""
WATCHED: Final[Mapping[str, str]] = {
    "New states visited": "novelty",
    "New states of value": "reach",
    "Change of value": "change",
}
"""What a rule can watch, by what it is called here."""
_RULE: Final = TriggerSpec(by="reach")
"""What is proposed."""

_NOTHING: Final = "\N{EN DASH} nothing \N{EN DASH}"
_NEW_TRIALS: Final = 2_000
_NEW_CHANCE: Final = 0.5
_NEW_AHEAD: Final = 1_000
_NEW_EVERY: Final = 100

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
    joins: bool = False
    """Whether it is a skill that joins."""
    rule: TriggerSpec | None = None
    """By which it does; None if it does so in a trial."""
    comes_by_rule: bool = False
    """Whether a rule says when it comes, so that it cannot be moved."""


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
        return Form("", "This learner has no skills, and chooses moves alone: nothing to plan.")
    if chosen:
        return Form("", "What was chosen has begun or is gone; what has begun is locked.")
    if not any(block.editable for block in blocks):
        running = bool(snapshot.control.episodes)
        what = "All that was planned has begun" if running else "All that was planned is past"
        return Form("", f"{what}; plan a new exploration.")
    return Form(
        "",
        _if_followed(
            "Choose under Edit plan what to change or a new exploration, or drag an outlined block"
            " of the time bar. The past is locked.",
            snapshot,
        ),
    )


def beyond_in_words(trial: int, snapshot: Snapshot) -> str:
    """What is to be said of a plan for a trial that the run is not to have; nothing of others."""
    last = last_trial(snapshot)
    if trial < last or trial >= NEVER:
        return ""
    return f"Trial {trial:,} is after the run's last, {last:,}: it happens only if the run goes on."


def _if_followed(caption: str, snapshot: Snapshot) -> str:
    if snapshot.control.schedule_on:
        return caption
    return "The schedule is not followed: none of this will happen."


def _form_of_block(block: Block, snapshot: Snapshot) -> Form:
    joins = block.kind == "introduction"
    rule = snapshot.spec.schedule.rule_of(block.skill) if block.by_rule else None
    caption = "It can be moved, changed and deleted until it begins."
    if joins:
        caption = "It can be moved, not deleted. Explorations move along."
        if rule is not None:
            caption = f"{long_of(block.skill, rule)}. A trial can take the place of the rule."
    elif rule is not None:
        caption = "It begins when its skill joins, by a rule; it can be changed and deleted."
    return Form(
        chosen=block.id,
        caption=_if_followed(caption, snapshot),
        at=_soon(snapshot) if block.by_rule else block.first,
        trials=block.trials,
        trials_label="Freeze" if joins else "Lasts",
        probability=0.0 if block.probability is None else block.probability,
        movable=not block.by_rule,
        editable=True,
        explores=not joins,
        deletable=not joins,
        joins=joins,
        rule=rule if joins else None,
        comes_by_rule=block.by_rule,
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
    soon = _soon(snapshot)
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


def _soon(snapshot: Snapshot) -> int:
    """A round trial a little ahead, which is proposed."""
    return -(-(snapshot.trial + _NEW_AHEAD) // _NEW_EVERY) * _NEW_EVERY


# --- The panel -----------------------------------------------------------------------------------


class PlanPanel:
    """The tab; the render loop calls :meth:`update`."""

    def __init__(
        self,
        gui: viser.GuiApi,
        ask: Ask,
        status_of: StatusOf,
        status: Status,
    ) -> None:
        """Build it where ``gui`` stands, for how things stand; ``status_of`` a browser, later."""
        self._ask = ask
        self._status_of = status_of
        self._pending: ScheduleSpec | None = None
        """What was asked for and has not been answered."""
        self._past = Past()
        self._generation: int = -1
        self._loaded: Form | None = None
        self.chosen = ""
        """Id of the block that is being edited."""
        self.blocks: tuple[Block, ...] = ()
        """All that has happened and is planned, as it was shown last."""
        self._caption = gui.add_html("")
        with gui.add_folder("Edit plan", expand_by_default=False):
            self._choice: Choice[str] = Choice(gui, "Change", {_NOTHING: ""}, self._chose)
            self._earlier = add_buttons(gui, "Earlier", EARLIER, self._nudge, visible=False)
            self._later = add_buttons(gui, "Later", LATER, self._nudge, visible=False)
            self._build_rule(gui)
            trials = Limits(0, MAX_TRIALS)
            self._at = NumberField(gui, "At trial", 0, trials)
            self._trials = NumberField(gui, "Lasts", 0, trials, "In trials")
            self._chance = NumberField(
                gui,
                "Probability",
                _NEW_CHANCE,
                Limits(0.0, 1.0, whole=False, share=True),
                "That a step takes the skill",
            )
            self._apply = gui.add_button("Apply", icon=viser.Icon.CHECK)
            self._delete = gui.add_button("Delete", icon=viser.Icon.TRASH, color="red")
        self._apply.on_click(Intent(lambda client, _: self._edit(client, self._applied)))
        self._delete.on_click(Intent(lambda client, _: self._edit(client, self._deleted)))
        self.update(status)

    def _build_rule(self, gui: viser.GuiApi) -> None:
        """How a skill is told when to join, and the rule by which it may."""
        hint = "In a trial that is known, or once learning on without it brings little."
        self._joins: Choice[bool] = Choice(gui, "Joins", JOINS, hint=hint)
        self._watched: Choice[str] = Choice(
            gui, "Watches", WATCHED, hint="What is to have become rare before the skill joins."
        )
        self._window = NumberField(
            gui, "Over", _RULE.window, Limits(1, 100_000), "Trials over which the mean is taken."
        )
        self._below = NumberField(
            gui,
            "Below",
            _RULE.below,
            Limits(0.0, 1e6, whole=False),
            "The skill joins once the mean is less than this: states a trial, or change a step.",
        )

    @property
    def left_out(self) -> int:
        """Blocks by hand that are over and not among :attr:`blocks`."""
        return self._past.left_out

    def choose(self, block_id: str) -> None:
        """Let a block that lies ahead be edited; nothing happens if there is none of that id."""
        if any(block.id == block_id and block.editable for block in self.blocks):
            self.chosen, self._loaded = block_id, None

    def update(self, status: Status) -> None:
        """Show what is true; not to be called before all requests have been answered."""
        self._pending = None
        snapshot = status.snapshot
        if snapshot.generation != self._generation:
            self._generation, self.chosen, self._loaded = snapshot.generation, "", None
        self.blocks = self._past.blocks_of(snapshot)
        form = form_of(self.chosen, self.blocks, snapshot)
        choices = choices_of(self.blocks, snapshot)
        self._choice.offer(choices)
        self._choice.choose(form.chosen)
        assign(self._choice.handle, "disabled", len(choices) == 1)
        self._show_form(form, snapshot)

    def _show_form(self, form: Form, snapshot: Snapshot) -> None:
        assign(self._earlier, "visible", form.movable)
        assign(self._later, "visible", form.movable)
        assign(self._trials.handle, "visible", form.editable)
        assign(self._joins.handle, "visible", form.joins)
        assign(self._chance.handle, "visible", form.explores)
        assign(self._trials.handle, "label", form.trials_label)
        assign(self._apply, "label", "Add" if form.is_new else "Apply")
        assign(self._apply, "visible", form.editable)
        assign(self._delete, "visible", form.deletable)
        if self._is_news(form):
            self._loaded = form
            self._at.put(form.at)
            self._trials.put(form.trials)
            self._chance.put(form.probability)
            rule = form.rule or _RULE
            self._joins.choose(form.rule is not None)
            self._watched.choose(rule.by)
            self._window.put(rule.window)
            self._below.put(rule.below)
        by_rule = form.joins and self._joins.chosen
        for handle in (self._watched.handle, self._window.handle, self._below.handle):
            assign(handle, "visible", by_rule)
        has_trial = not by_rule if form.joins else form.editable and not form.comes_by_rule
        assign(self._at.handle, "visible", has_trial)
        changed = form.editable and (form.is_new or self._is_typed(form))
        assign(self._apply, "disabled", not changed)
        sentences = form.caption, self._beyond(form, snapshot) if has_trial else ""
        text = " ".join(sentence for sentence in sentences if sentence)
        assign(self._caption, "content", f'<div class="pounce-plan">{escaped(text)}</div>')

    def _beyond(self, form: Form, snapshot: Snapshot) -> str:
        """What is to be said of the trial that stands in the field."""
        try:
            return beyond_in_words(int(self._at.read()), snapshot)
        except RefusedError:
            return beyond_in_words(form.at, snapshot)

    def _is_news(self, form: Form) -> bool:
        """Whether the fields are to be filled: not while a person is changing them."""
        former = self._loaded
        if former is None or former.chosen != form.chosen:
            return True
        # The start that is proposed moves on with the run.
        is_proposed = form.is_new or form.comes_by_rule
        values = (form.at if not is_proposed else 0, form.trials, form.probability, form.rule)
        former_at = former.at if not is_proposed else 0
        known = (former_at, former.trials, former.probability, former.rule)
        return not form.is_new and values != known

    def _typed(self, form: Form) -> dict[str, Any]:
        """What the fields hold that is not so.

        Raises:
            RefusedError: one of them holds no number.
        """
        typed: dict[str, Any] = {"trials": int(self._trials.read())}
        true: dict[str, Any] = {"trials": form.trials}
        if form.joins and self._joins.chosen:
            typed["rule"] = TriggerSpec.model_validate(
                {
                    "by": self._watched.chosen,
                    "window": int(self._window.read()),
                    "below": self._below.read(),
                }
            )
            true["rule"] = form.rule
        elif form.joins or not form.comes_by_rule:
            typed["at"] = int(self._at.read())
            true["at"] = None if form.comes_by_rule else form.at
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

    def _chose(self, client: viser.ClientHandle, chosen: str) -> None:
        self.chosen = chosen
        self._loaded = None

    def _nudge(self, client: viser.ClientHandle, by: int) -> None:
        self._edit(client, lambda plan, now, _: edits.moved(plan, self.chosen, by, now))

    def _applied(self, plan: ScheduleSpec, now: edits.Now, snapshot: Snapshot) -> ScheduleSpec:
        form = form_of(self.chosen, self._past.blocks_of(snapshot), snapshot)
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
            self.chosen = edits.newest_episode_id(plan)
            return plan
        return edits.changed(plan, self.chosen, now, **self._typed(form))

    def _deleted(self, plan: ScheduleSpec, now: edits.Now, _: Snapshot) -> ScheduleSpec:
        plan = edits.without(plan, self.chosen, now)
        self.chosen = ""
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
        snapshot = self._status_of(client).snapshot
        # A second click before the first was answered goes on from what that asked for.
        plan = snapshot.spec.schedule if self._pending is None else self._pending
        try:
            plan = edited(plan, edits.now_of(snapshot), snapshot)
        except ValueError as error:
            raise RefusedError(str(error)) from error
        self._pending = plan
        self._ask(client, SetSchedule(plan))
