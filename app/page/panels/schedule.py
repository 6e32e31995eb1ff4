"""The schedule below the board: drawn, edited, saved as a preset and loaded from one.

:class:`Planner` is shared by all browsers, because it changes what the learner will do;
:class:`PresetButtons` belong to one browser, because files go to it and come from it.
"""

import os
import re
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, Final, NamedTuple

import viser

from app.documents import presets
from app.documents.experiments import ExperimentError
from app.documents.tree import PresetError, document_of, printable
from app.live.session import Request, Session, StartAgain, Status
from app.live.snapshot import Snapshot
from app.page.number_field import Limits, NumberField
from app.page.widgets import NAME_HTML, assign
from app.picture.timeline import axis_end, timeline_svg
from app.schedule import carried, edits
from app.schedule.blocks import Block, Past
from app.server.callbacks import RefusedError, guarded
from app.server.notices import close_modal, open_modal, tell
from app.util.files import write_whole
from app.words.numbers import counted
from app.words.plain import plain
from learners.commands import SetSchedule
from learners.spec import MAX_TRIALS, RunSpec, ScheduleSpec

Ask = Callable[[viser.GuiEvent, Request], int]
"""Enqueues a request for the browser of an event; returns its ticket, as ``Session.submit``."""

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
_REFUSED: Final = "That cannot be done now"
_REDRAW_S: Final = 0.5
"""How often the picture is sent again when nothing but the trial has changed."""
_NEW_TRIALS: Final = 2_000
_NEW_CHANCE: Final = 0.5
_NEW_AHEAD: Final = 1_000
_NEW_EVERY: Final = 100

# viser puts one widget below the other, which takes more height than there is below the board. The
# rules apply to the container of this panel alone. Where they do not, widgets are stacked.
_LAYOUT: Final = """<div class="pounce-planner"></div><style>
div:has(> div > .pounce-planner) {
  display: flex; flex-wrap: wrap; align-items: center; padding: 2px 6px 0 !important; }
div:has(> div > .pounce-planner) > div {
  flex: 0 1 auto; padding: 0 4px 4px !important; margin: 0 !important; }
div:has(> div > .pounce-planner) > div:has(> .pounce-planner) { display: none; }
div:has(> div > .pounce-planner) > div:has(> .pounce-timeline) { flex: 1 0 100%; }
div:has(> div > .pounce-planner) > div > .mantine-Flex-root > div:first-child {
  width: auto !important; padding-right: 5px !important; }
div:has(> div > .pounce-planner) > div:has(.mantine-Select-root),
div:has(> div > .pounce-planner) > div:has(.mantine-Select-root)
  > .mantine-Flex-root > div:last-child { flex: 1 1 220px; }
div:has(> div > .pounce-planner) .mantine-TextInput-root { width: 6.2em; }
div:has(> div > .pounce-planner) .mantine-Button-root[data-size="sm"] {
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


class Planner:
    """The shared panel of the schedule; the render loop calls :meth:`update`."""

    def __init__(self, gui: viser.GuiApi, ask: Ask, session: Session) -> None:
        self._ask = ask
        self._session = session
        # Callbacks run in threads of their own, beside the render loop.
        self._lock = threading.RLock()
        self._ticket = 0
        self._pending: ScheduleSpec | None = None
        self._past = Past()
        self._generation = -1
        self._choices = {_NOTHING: ""}
        self._shown = _NOTHING
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
        self._choice = gui.add_dropdown("Change", tuple(self._choices))
        self._nudges = gui.add_button_group("Move by", tuple(NUDGES), visible=False)
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
        self._nudges.on_click(guarded(self._nudge))
        self._apply.on_click(guarded(lambda event: self._edit(event, self._applied)))
        self._delete.on_click(guarded(lambda event: self._edit(event, self._deleted)))

    def update(self, status: Status) -> None:
        """Show what is true; not before the last request made here has been answered."""
        with self._lock:
            self._take_choice()
            if status.answered < self._ticket:
                return
            self._pending = None
            snapshot = status.snapshot
            if snapshot.generation != self._generation:
                self._generation, self._chosen, self._loaded = snapshot.generation, "", None
            blocks = self._past.blocks_of(snapshot)
            form = form_of(self._chosen, blocks, snapshot)
            self._show_choices(choices_of(blocks, snapshot), form)
            self._show_form(form)
            self._show_picture(blocks, snapshot, form, status.playing)

    def _show_choices(self, choices: dict[str, str], form: Form) -> None:
        self._choices = choices
        labels = tuple(choices)
        label = next((label for label, id in choices.items() if id == form.chosen), labels[0])
        is_renewed = self._choice.options != labels
        if is_renewed:
            self._choice.options = labels
        # Left alone otherwise: a person may just have chosen something else.
        if is_renewed or label != self._shown:
            self._shown = label
            assign(self._choice, "value", label)
        assign(self._choice, "disabled", len(labels) == 1)

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

    def _take_choice(self) -> None:
        """Go by what a person has chosen since the dropdown was last set.

        It is asked and not called back: the render loop, which sets it to what is true, could come
        between a choice and its callback, and undo the choice.
        """
        label = str(self._choice.value)
        if label != self._shown:
            self._shown = label
            self._chosen = self._choices.get(label, "")
            self._loaded = None

    def _nudge(self, event: viser.GuiEvent) -> None:
        by = NUDGES[str(self._nudges.value)]
        self._edit(event, lambda plan, now, _: edits.moved(plan, self._chosen, by, now))

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
        event: viser.GuiEvent,
        edited: Callable[[ScheduleSpec, edits.Now, Snapshot], ScheduleSpec],
    ) -> None:
        """Ask for an edited schedule, or say why it cannot be had."""
        if event.client is None:
            return
        with self._lock:
            self._take_choice()
            status = self._session.status
            snapshot = status.snapshot
            plan = snapshot.spec.schedule
            if self._pending is not None and status.answered < self._ticket:
                # A second click before the first was answered goes on from what that asked for.
                plan = self._pending
            try:
                plan = edited(plan, edits.now_of(snapshot), snapshot)
            except ValueError as error:
                tell(event.client, _REFUSED, str(error), auto_close_seconds=6)
                return
            self._pending = plan
            self._ticket = self._ask(event, SetSchedule(plan))


# --- Presets -------------------------------------------------------------------------------------

_SAFE_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
_NAME_RULE: Final = "A name has up to 64 letters, digits, - and _, and starts with none of the two."
_SAVING: Final = threading.Lock()
_EXPERIMENT_KEY: Final = "presets"
_PRESET_KEYS: Final = {"extends", "world", "learner", "schedule"}
"""What every experiment has and no preset, and what presets have and no experiment."""


def is_safe_name(name: str) -> bool:
    """Whether a preset may be saved under a name: it can lead out of no folder."""
    return _SAFE_NAME.fullmatch(name) is not None


def safe_name(name: str) -> str:
    """The nearest name that is safe, for the stem of any file name or path."""
    stem = Path(name.replace("\\", "/")).name
    stem = re.sub(r"\.ya?ml$", "", stem, flags=re.IGNORECASE)
    return re.sub(r"[^A-Za-z0-9_-]+", "_", stem).lstrip("_-")[:64] or "preset"


def loaded_name(file_name: str) -> str:
    """What a loaded preset is called: not as a shipped one, from which it may differ."""
    name = safe_name(file_name)
    return f"{name[:57]}_loaded" if name in presets.shipped() else name


def preset_text(spec: RunSpec, left_out: Iterable[str]) -> str:
    """A preset as a file; what it cannot repeat is said in comments."""
    lines = [f"# {sentence}\n" for sentence in left_out]
    if lines:
        lines.insert(0, "# Saved from a run. What this preset does not repeat:\n")
    return "".join(lines) + presets.dump(spec)


def save_file(folder: Path, name: str, text: str, overwrite: bool = False) -> Path:
    """Write a preset to a folder, as a whole or not at all.

    Raises:
        ValueError: the name is not safe.
        FileExistsError: there is such a file, and it is not to be overwritten.
        OSError: it cannot be written.
    """
    if not is_safe_name(name):
        raise ValueError(_NAME_RULE)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{folder.name} is not a folder")
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"{name}.yaml"
    # One at a time, so that of two browsers that save under one name the second is asked.
    with _SAVING:
        if os.path.lexists(target) and not overwrite:
            raise FileExistsError(f"{target.name} is there already")
        write_whole(target, text.encode())
    return target


class PresetButtons:
    """*Save as preset* and *Load preset* of one browser, in the container that is current."""

    def __init__(
        self, client: viser.ClientHandle, session: Session, ask: Ask, save_dir: Path | None
    ) -> None:
        self._client = client
        self._session = session
        self._ask = ask
        self._save_dir = save_dir
        gui = client.gui
        name = safe_name(f"my_{session.status.snapshot.preset}")
        gui.add_html(NAME_HTML)
        self._name = gui.add_text("Name", name, hint="Letters, digits, - and _")
        self._save = gui.add_button(
            "Save as preset", icon=viser.Icon.DEVICE_FLOPPY, hint="What was done so far, as a file"
        )
        self._overwrite = gui.add_button(
            "Overwrite", icon=viser.Icon.ALERT_TRIANGLE, color="red", visible=False
        )
        self._said = gui.add_html("")
        self._load = gui.add_upload_button(
            "Load preset", icon=viser.Icon.UPLOAD, mime_type=".yaml,.yml"
        )
        self._name.on_update(guarded(lambda _: self._judge_name()))
        self._save.on_click(guarded(lambda _: self._store(overwrite=False)))
        self._overwrite.on_click(guarded(lambda _: self._store(overwrite=True)))
        self._load.on_upload(guarded(self._take))

    def _judge_name(self) -> None:
        """A question about another name is moot; and a name may not do at all."""
        safe = is_safe_name(str(self._name.value))
        assign(self._overwrite, "visible", False)
        assign(self._save, "disabled", not safe)
        self._say([] if safe else [_NAME_RULE])

    def _say(self, sentences: Iterable[str]) -> None:
        lines = "".join(f"<div>{escape(sentence)}</div>" for sentence in sentences)
        assign(
            self._said,
            "content",
            f'<div style="padding:0 0.7em 0.5em;font-size:0.85em">{lines}</div>' if lines else "",
        )

    def _store(self, overwrite: bool) -> None:
        """Save what has been done; ask first where that would lose a file."""
        name = str(self._name.value)
        if not is_safe_name(name):
            self._say([_NAME_RULE])
            return
        spec, left_out = carried.preset_of(self._session.status.snapshot)
        text = preset_text(spec, left_out)
        said = f"Saved as {name}.yaml."
        if self._save_dir is not None:
            try:
                save_file(self._save_dir, name, text, overwrite)
            except FileExistsError:
                self._overwrite.visible = True
                self._say([f"There is a {name}.yaml in the folder. Overwrite it?"])
                return
            except OSError as error:
                said = f"Downloaded, but not written to the folder: {error.strerror or error}."
        assign(self._overwrite, "visible", False)
        self._client.send_file_download(f"{name}.yaml", text.encode(), save_immediately=True)
        self._say([said, *left_out])

    def _take(self, event: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
        """Start again with an uploaded preset; or show all that is wrong with it."""
        file = event.target.value
        try:
            spec = presets.parse(file.content, file.name)
        except PresetError as error:
            title = "This preset cannot be used; nothing has changed"
            show_problems(self._client, title, error, file)
            return
        name = loaded_name(file.name)
        self._ask(event, StartAgain(spec, name, self._session.status.snapshot.seed))
        self._say([f"Started again with {name}."])


def _mistaken(file: viser.UploadedFile, error: PresetError) -> str | None:
    """Which file of the other kind, of presets and experiments, this is; None if of neither."""
    tree = document_of(file.content, "", [])
    keys = set() if tree is None else set(tree.value)
    name = printable(file.name)
    if not isinstance(error, ExperimentError) and _EXPERIMENT_KEY in keys:
        return f"{name} is an experiment, not a preset: Load experiment takes it."
    if isinstance(error, ExperimentError) and _EXPERIMENT_KEY not in keys and keys & _PRESET_KEYS:
        return f"{name} is a preset, not an experiment: Load preset takes it."
    return None


def show_problems(
    client: viser.ClientHandle, title: str, error: PresetError, file: viser.UploadedFile
) -> None:
    """Show all that is wrong with a file; or else that it is of the other kind."""
    mistaken = _mistaken(file, error)
    sentences = list(map(str, error.problems)) if mistaken is None else [mistaken]
    lines = "".join(
        f'<div style="margin-bottom:0.5em">{escape(sentence)}</div>' for sentence in sentences
    )
    modal = open_modal(client, title)
    with modal:
        client.gui.add_html(
            '<div style="font-family:monospace;font-size:0.85em;line-height:1.5;'
            'max-height:55vh;overflow:auto;padding:0 0.7em;overflow-wrap:anywhere">'
            f"{lines}</div>"
        )
        close = client.gui.add_button("Close")
    close.on_click(guarded(lambda _: close_modal(modal)))
