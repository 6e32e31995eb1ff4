"""The command ``pounce export``: a session as a page that plays it, as pictures and as films.

Like the command line, it imports what takes long only once it is needed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from app.cli import terminal
from app.cli.answers import (
    EXIT_FAILED,
    EXIT_OK,
    HIDDEN_HINT,
    Flag,
    UsageError,
    complain,
    filled,
    say,
    shown,
    spec_of,
    whole_number,
)
from app.cli.replay import folder_of, refused, written_of
from app.util import interrupts

if TYPE_CHECKING:
    from app.live.snapshot import Snapshot
    from app.picture.look import Look
    from app.player.reel import Recorded, Tell
    from app.player.shapes import Picture

EXAMPLES = (
    "pounce export latest --html replay.html",
    "pounce export timed --seed 3 --html timed.html --gif timed.gif",
    "pounce export mine.pounce --png ring.png --at 30000 --layer chosen",
)

KINDS = ("html", "png", "svg", "gif", "mp4")
"""What can be written: each has an option, and files of it end so."""
_PRESET_FILES = (".yaml", ".yml")
_NO_HINT = "(default: none)"


@dataclass(frozen=True)
class Export:
    """Write a session as a page that plays it offline, as pictures or as a film."""

    session: Annotated[Positional[str], arg(metavar="SESSION", help_behavior_hint=HIDDEN_HINT)] = ""
    """A session's file or name; latest is the one that was written last. Or a preset, whose run is
    made for it."""
    html: Annotated[str | None, arg(metavar="FILE", help_behavior_hint=_NO_HINT)] = None
    """One page, below 1 MB, that plays all of it without a network."""
    png: Annotated[str | None, arg(metavar="FILE", help_behavior_hint=_NO_HINT)] = None
    """A moment as a picture: board, legend, sentence and step."""
    svg: Annotated[str | None, arg(metavar="FILE", help_behavior_hint=_NO_HINT)] = None
    """The same for print, of any size."""
    gif: Annotated[str | None, arg(metavar="FILE", help_behavior_hint=_NO_HINT)] = None
    """The whole run as a film that any program shows."""
    mp4: Annotated[str | None, arg(metavar="FILE", help_behavior_hint=_NO_HINT)] = None
    """The same, smaller; takes the package imageio-ffmpeg."""
    at: Annotated[str | None, arg(metavar="TRIAL", help_behavior_hint="(default: the end)")] = None
    """Trial at whose start pictures are taken."""
    layer: Annotated[str, arg(metavar="LAYER")] = "value"
    """What pictures and films show: value, chosen or reach."""
    frame: Annotated[str, arg(metavar="FRAME")] = "turned"
    """All headings turned, or each by itself: turned or each."""
    dark: Flag = False
    """Pictures and films with the colours of dark pages."""
    seed: Annotated[str | None, arg(metavar="N", help_behavior_hint="(default: 0)")] = None
    """Of a preset's run: its seed."""
    trials: Annotated[
        str | None, arg(metavar="N", help_behavior_hint="(default: the preset's)")
    ] = None
    """Of a preset's run: how many trials it has."""
    sessions: Annotated[
        str | None, arg(metavar="FOLDER", help_behavior_hint="(default: the user's own)")
    ] = None
    """Where sessions are that are asked for by their name."""


def obey(command: Export) -> int:
    """Write what was asked for, and say where it is; returns the exit code.

    Raises:
        UsageError: the words make no sense, or a file cannot be written.
    """
    files = _files(command)
    _check(command)
    with interrupts.undoing(), terminal.status() as show:

        def tell(what: str, share: float) -> None:
            show(f"{what}: {share:.0%}")

        recorded = _recorded(command, tell)
        makers = _makers(command, recorded, tell)
        for kind, path in files.items():
            try:
                _write(path, makers[kind]())
            except _RefusedError as error:
                complain(filled(f"--{kind}: {error}"))
                return EXIT_FAILED
    for path in files.values():
        say(str(path))
    return EXIT_OK


class _RefusedError(Exception):
    """Something that cannot be made of this session; the message says why."""


def _files(command: Export) -> dict[str, Path]:
    """Where to write what.

    Raises:
        UsageError: nothing is to be written, or it cannot be.
    """
    files: dict[str, Path] = {}
    for kind in KINDS:
        name: str | None = getattr(command, kind)
        if name is None:
            continue
        if "\0" in name or Path(name).suffix.lower() != f".{kind}" or Path(name).is_dir():
            raise UsageError(
                f"--{kind}: {shown(name)} is not allowed; allowed: a file that ends in .{kind}"
            )
        if not Path(name).absolute().parent.is_dir():
            raise UsageError(f"--{kind}: {shown(name)} is in no folder; allowed: one there is")
        files[kind] = Path(name)
    if not files:
        options = ", ".join(f"--{kind}" for kind in KINDS)
        raise UsageError(f"nothing is to be written; allowed: one or more of {options}")
    return files


def _check(command: Export) -> None:
    """Refuse words that make no sense.

    Raises:
        UsageError: there are such.
    """
    from app.player.reel import FRAMES, LAYERS_SHOWN

    if not command.session:
        raise UsageError(
            "SESSION is missing; allowed: a session's file or name, latest, or a preset"
        )
    for option, value, allowed in (
        ("--layer", command.layer, LAYERS_SHOWN),
        ("--frame", command.frame, tuple(FRAMES)),
    ):
        if value not in allowed:
            names = ", ".join(allowed)
            raise UsageError(f"{option}: {shown(value)} is not allowed; allowed: {names}")
    if not _is_preset(command.session):
        for option, value in (("--seed", command.seed), ("--trials", command.trials)):
            if value is not None:
                raise UsageError(f"{option} is of a preset's run; a session has its own")


def _is_preset(name: str) -> bool:
    from app.documents import presets

    return name in presets.shipped() or Path(name).suffix.lower() in _PRESET_FILES


def _recorded(command: Export, tell: "Tell") -> "Recorded":
    """What is asked for, made again.

    Raises:
        UsageError: it cannot be.
    """
    from app.player.reel import recorded_family, recorded_run

    if _is_preset(command.session):
        from app.documents.sources import called
        from learners.names import MAX_TRIALS
        from sim.rng import MAX_SEED

        settings: list[str] = []
        if command.trials is not None:
            settings = [f"trials={whole_number('--trials', command.trials, 1, MAX_TRIALS)}"]
        seed = 0 if command.seed is None else whole_number("--seed", command.seed, 0, MAX_SEED)
        spec = spec_of(command.session, settings)
        return recorded_run(spec, called(command.session), seed, tell)
    from app.explain.branches import name_of
    from app.live.made_again import made_again
    from app.live.past import Budget
    from app.live.written import DamagedError

    written = written_of("SESSION", command.session, folder_of(command.sessions))
    try:
        remade = made_again(
            written, Budget(), name_of, on_step=lambda share: tell("The session is made", share)
        )
    except DamagedError as error:
        raise UsageError(f"SESSION: {refused(error)}") from error
    for line in remade.differ:
        complain(
            filled(
                f"Warning: {line} is not what was recorded: this pounce learns otherwise than"
                f" {written.header.version}. pounce replay says from where on."
            )
        )
    return recorded_family(remade.made.family)


def _makers(command: Export, recorded: "Recorded", tell: "Tell") -> dict[str, Callable[[], bytes]]:
    """What makes each kind of file."""
    from app.player import images

    def page() -> bytes:
        from app.player.replay_page import ReplayError, replay_page

        try:
            return replay_page(recorded, tell).encode()
        except ReplayError as error:
            raise _RefusedError(str(error)) from error

    def picture(write: "Callable[[Picture, str], bytes]") -> bytes:
        look = _look(command)
        return write(
            images.picture_of(_snapshot(command, recorded), look), images.page_colour(look)
        )

    def film(write: "images.WriteFilm") -> bytes:
        frames = images.film_pictures(recorded, recorded.live.number, _look(command), tell)
        try:
            return write(frames, images.FILM_MOMENT_S)
        except images.MissingError as error:
            raise _RefusedError(str(error)) from error

    return {
        "html": page,
        "png": lambda: picture(images.png_of),
        "svg": lambda: picture(images.svg_file),
        "gif": lambda: film(images.gif_of),
        "mp4": lambda: film(images.mp4_of),
    }


def _look(command: Export) -> "Look":
    from app.picture.look import Look
    from app.picture.theme import DARK, LIGHT
    from app.player.reel import FRAMES

    return Look(DARK if command.dark else LIGHT, command.layer, frame=FRAMES[command.frame])


def _snapshot(command: Export, recorded: "Recorded") -> "Snapshot":
    """The moment of which pictures are taken.

    Raises:
        UsageError: there is no such moment.
    """
    from app.player.reel import Stop, snapshots_at

    line = recorded.live
    step = line.until_step
    if command.at is not None:
        trial = whole_number("--at", command.at, 0, line.until_trial)
        step = recorded.pasts[line.number].step_of_trial(trial)
    return next(iter(snapshots_at(recorded, [Stop(line.number, step)])))


def _write(path: Path, content: bytes) -> None:
    """Put a file into place, whole or not at all.

    Raises:
        UsageError: it cannot be written.
    """
    from app.util.files import write_whole

    try:
        write_whole(path, content)
    except OSError as error:
        raise UsageError(
            f"{shown(str(path))} cannot be written: {error.strerror or error}; allowed: a place"
            " that can"
        ) from error
