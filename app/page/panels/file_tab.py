"""The *File* tab of one browser: what it keeps as files, and what it brings.

What takes long is read or written in a thread of its own.
"""

import io
import os
import re
import threading
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Final, TypeVar

import numpy as np
import viser

from app.documents import experiments, presets
from app.documents.experiments import Experiment, ExperimentError
from app.documents.tree import PresetError, document_of, printable
from app.live.requests import StartAgain
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.page.inbox import Ask, Intent, Work
from app.page.widgets import CALM, DESTROYS, NAME_HTML, add_hints, assign
from app.schedule import carried
from app.server.notices import close_modal, open_modal, tell
from app.util.files import write_whole
from app.util.html import escaped
from learners.spec import RunSpec

Document = TypeVar("Document")
OfferPreset = Callable[[str, RunSpec], object]
"""Has a preset in the list of those to start again with, under a name."""
TakeExperiment = Callable[[Experiment, bytes, str], str]
"""Offers a loaded experiment, given its file and the name of that; returns what it is called."""

_SAFE_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
_NAME_RULE: Final = (
    "A name has up to 64 letters from a to z, digits, - and _, and starts with a letter or digit."
    " A blank becomes a _."
)
_SAVING: Final = threading.Lock()
_EXPERIMENT_KEY: Final = "presets"
_PRESET_KEYS: Final = {"extends", "world", "learner", "schedule"}
"""What every experiment has and no preset, and what presets have and no experiment."""


def is_safe_name(name: str) -> bool:
    """Whether a preset may be saved under a name: it can lead out of no folder."""
    return _SAFE_NAME.fullmatch(name) is not None


def file_stem(typed: str) -> str:
    """What a preset is called whose name was typed: without blanks, which commands would part."""
    return "_".join(typed.split())


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


class FileTab:
    """The tab's buttons, in the container that is current."""

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        ask: Ask,
        work: Work,
        take_experiment: TakeExperiment,
        offer_preset: OfferPreset,
        save_dir: Path | None,
    ) -> None:
        self._client = client
        self._session = session
        self._ask = ask
        self._work = work
        self._take_experiment = take_experiment
        self._offer_preset = offer_preset
        self._save_dir = save_dir
        gui = client.gui
        name = safe_name(f"my_{session.status.snapshot.preset}")
        with gui.add_folder("Save"):
            gui.add_html(NAME_HTML)
            self._name = gui.add_text(
                "Name", name, hint="What the file is called: letters, digits, - and _."
            )
            self._save = gui.add_button(
                "Save as preset",
                icon=viser.Icon.DEVICE_FLOPPY,
                color=CALM,
                hint="A file with what was done so far and is planned: loaded again, with the same"
                " seed, it gives the same run.",
            )
            self._overwrite = gui.add_button(
                "Overwrite", icon=viser.Icon.ALERT_TRIANGLE, color=DESTROYS, visible=False
            )
            self._said = gui.add_html("")
            tables = gui.add_button(
                "Save tables",
                icon=viser.Icon.TABLE,
                color=CALM,
                hint="All numbers that the learner has learned by now, as a NumPy file, for work of"
                " your own. The lab cannot load them again: a preset makes the whole run again.",
            )
        with gui.add_folder("Load"):
            load = gui.add_upload_button(
                "Load preset",
                icon=viser.Icon.UPLOAD,
                color=CALM,
                mime_type=".yaml,.yml",
                hint="Begin a run with a preset from a file. It stands still until you play; the"
                " run on the board is set aside.",
            )
            experiment = gui.add_upload_button(
                "Load experiment",
                icon=viser.Icon.FLASK,
                color=CALM,
                mime_type=".yaml,.yml",
                hint="Offer an experiment from a file under Experiments. Nothing is started.",
            )
        add_hints(gui, self._save, tables, load, experiment)
        self._name.on_update(Intent(self._judge_name))
        self._save.on_click(Intent(lambda _, __: self._store(overwrite=False)))
        self._overwrite.on_click(Intent(lambda _, __: self._store(overwrite=True)))
        load.on_upload(Intent(self._load_preset))
        tables.on_click(Intent(self._save_tables))
        experiment.on_upload(Intent(self._load_experiment))

    def _judge_name(self, client: viser.ClientHandle, name: str) -> None:
        """A question about another name is moot; and a name may not do at all."""
        safe = is_safe_name(file_stem(name))
        assign(self._overwrite, "visible", False)
        assign(self._save, "disabled", not safe)
        self._say([] if safe else [_NAME_RULE])

    def _say(self, sentences: Iterable[str]) -> None:
        lines = "".join(f"<div>{escaped(sentence)}</div>" for sentence in sentences)
        assign(
            self._said,
            "content",
            f'<div style="padding:0 0.7em 0.5em;font-size:0.85em">{lines}</div>' if lines else "",
        )

    def _store(self, overwrite: bool) -> None:
        """Save what has been done; ask first where that would lose a file."""
        name = file_stem(str(self._name.value))
        if not is_safe_name(name):
            self._say([_NAME_RULE])
            return
        snapshot, folder = self._session.status.snapshot, self._save_dir

        def store() -> tuple[RunSpec, bytes, list[str]] | None:
            spec, left_out = carried.preset_of(snapshot)
            text = preset_text(spec, left_out)
            said = f"Saved as {name}.yaml."
            if folder is not None:
                try:
                    save_file(folder, name, text, overwrite)
                except FileExistsError:
                    return None
                except OSError as error:
                    said = f"Downloaded, but not written to the folder: {error.strerror or error}."
            return spec, text.encode(), [said, *left_out]

        def show(stored: tuple[RunSpec, bytes, list[str]] | None) -> None:
            assign(self._overwrite, "visible", stored is None)
            if stored is None:
                self._say([f"There is a {name}.yaml in the folder. Overwrite it?"])
                return
            spec, data, sentences = stored
            self._offer_preset(loaded_name(name), spec)
            self._client.send_file_download(f"{name}.yaml", data, save_immediately=True)
            self._say(sentences)

        self._work(self._client, store, show)

    def _save_tables(self, client: viser.ClientHandle, _: object) -> None:
        def send(file: tuple[str, bytes]) -> None:
            client.send_file_download(*file, save_immediately=True)

        self._work(client, partial(saved_state, self._session.status.snapshot), send)

    def _load_preset(self, client: viser.ClientHandle, file: viser.UploadedFile) -> None:
        """Start again with an uploaded preset; or show all that is wrong with it."""

        def begin(spec: RunSpec) -> None:
            name, seed = loaded_name(file.name), self._session.status.snapshot.seed
            self._offer_preset(name, spec)
            self._ask(client, StartAgain(spec, name, seed, paused=True))
            self._say([f"{name} is loaded, and is in the list under Start again."])

        title = "This preset cannot be used; nothing has changed"
        read_file(client, self._work, file, presets.parse, title, begin)

    def _load_experiment(self, client: viser.ClientHandle, file: viser.UploadedFile) -> None:
        """Offer an uploaded experiment; or show all that is wrong with it.

        It may name shipped presets or hold presets of its own; no other file is looked at.
        """

        def offer(found: Experiment) -> None:
            name = self._take_experiment(found, file.content, file.name)
            tell(client, "Loaded", f"{name} is chosen under Experiments.", auto_close_seconds=6.0)

        title = "This experiment cannot be run; nothing has changed"
        parse = partial(experiments.parse, folder=None)
        read_file(client, self._work, file, parse, title, offer)


def read_file(
    client: viser.ClientHandle,
    work: Work,
    file: viser.UploadedFile,
    parse: Callable[[bytes, str], Document],
    title: str,
    then: Callable[[Document], object],
) -> None:
    """Read an uploaded file and go on with what it says; or show, under a title, what is wrong."""

    def read() -> Document | PresetError:
        try:
            return parse(file.content, file.name)
        except PresetError as error:
            return error

    def go_on(found: Document | PresetError) -> None:
        if isinstance(found, PresetError):
            show_problems(client, title, found, file)
        else:
            then(found)

    work(client, read, go_on)


def _mistaken(file: viser.UploadedFile, error: PresetError) -> str | None:
    """Which file of the other kind, of presets and experiments, this is; None if of neither."""
    tree = document_of(file.content, "", [])
    keys: set[str] = set() if tree is None else set(tree.value)
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
        f'<div style="margin-bottom:0.5em">{escaped(sentence)}</div>' for sentence in sentences
    )
    modal = open_modal(client, title)
    with modal:
        client.gui.add_html(
            '<div style="font-family:monospace;font-size:0.85em;line-height:1.5;'
            'max-height:55vh;overflow:auto;padding:0 0.7em;overflow-wrap:anywhere">'
            f"{lines}</div>"
        )
        close = client.gui.add_button("Close", color=CALM)
    close.on_click(Intent(lambda _, __: close_modal(modal)))
