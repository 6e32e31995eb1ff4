"""The command ``pounce replay``: makes a session again and says whether it is what it was.

Like the command line, it imports what takes long only once it is needed.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
    table,
    whole_number,
)
from app.util.texts import as_text
from app.words.numbers import counted

if TYPE_CHECKING:
    from app.live.replayed import Difference, Given, LineMade, Replayed
    from app.live.written import DamagedError, Written

EXAMPLES = (
    "pounce replay latest",
    "pounce replay my-session.pounce --until 250000 --json",
)

_MOST_STEPS = 2**62
_HEADER = ("line", "began", "step", "trial", "digest", "as recorded")
_SHORT = 12
"""Digits of a digest in a table."""


@dataclass(frozen=True)
class Replay:
    """Make a session of the lab again, and compare it with what was recorded."""

    session: Annotated[Positional[str], arg(metavar="SESSION", help_behavior_hint=HIDDEN_HINT)] = ""
    """A session's file or name; latest is the one that was written last."""
    until: Annotated[str | None, arg(metavar="STEP", help_behavior_hint="(default: the end)")] = (
        None
    )
    """Make each line no farther than to this step."""
    json: Flag = False
    """Print one JSON object and nothing else."""
    sessions: Annotated[
        str | None, arg(metavar="FOLDER", help_behavior_hint="(default: the user's own)")
    ] = None
    """Where sessions are that are asked for by their name."""


def obey(command: Replay) -> int:
    """Replay the session and say what came of it; returns the exit code.

    Raises:
        UsageError: the words make no sense, or the session cannot be used.
    """
    until = None
    if command.until is not None:
        until = whole_number("--until", command.until, 0, _MOST_STEPS)
    if not command.session:
        raise UsageError("SESSION is missing; allowed: a session's file or name, or latest")
    written = written_of("SESSION", command.session, folder_of(command.sessions))

    from app.explain.branches import name_of
    from app.live.replayed import ReplayError, replayed

    try:
        with terminal.status() as show:

            def tell(line: int, step: int) -> None:
                show(f"line {line}, step {step:,}")

            made = replayed(written.records, until, tell, name_of)
    except ReplayError as error:
        complain(filled(f"{written.path}: {error}"))
        return EXIT_FAILED
    say(json.dumps(_document(written, until, made)) if command.json else _report(written, made))
    return EXIT_OK if made.is_same else EXIT_FAILED


def folder_of(option: str | None) -> Path | None:
    """The folder of sessions; the user's own unless one is named, None if there is no such.

    Raises:
        UsageError: it cannot be one.
    """
    from app.live.kept import default_folder

    if option is not None:
        folder = Path(option)
        if not option or "\0" in option or (folder.exists() and not folder.is_dir()):
            raise UsageError(f"--sessions: {shown(option)} is not allowed; allowed: a folder")
        return folder
    try:
        return default_folder()
    except RuntimeError:
        return None


def written_of(option: str, name: str, folder: Path | None) -> "Written":
    """The session that was asked for; what was torn of it is said.

    Raises:
        UsageError: there is none, or it is damaged; what could be saved of it has been.
    """
    from app.live.kept import found
    from app.live.written import DamagedError, SessionError, read

    try:
        written = read(found(name, folder))
    except DamagedError as error:
        raise UsageError(f"{option}: {refused(error)}") from error
    except SessionError as error:
        raise UsageError(f"{option}: {as_text(str(error))}") from error
    if written.is_torn:
        complain(
            filled(
                f"Warning: {as_text(written.path)}: its last record was torn when the lab was"
                " killed, and is dropped: nobody had been told that it was done."
            )
        )
    return written


def refused(error: "DamagedError") -> str:
    """What is said of a damaged session: what is wrong, and what could be saved."""
    from app.live.written import save

    message = as_text(str(error))
    if error.saved is None:
        return message
    records = counted(len(error.saved.records), "record")
    try:
        path = save(error.saved)
    except OSError as failure:
        return (
            f"{message}; the {records} before it could be saved, but not beside it:"
            f" {failure.strerror or failure}"
        )
    return f"{message}; the {records} before it are saved in {as_text(path)}; allowed: that one"


# --- What is said --------------------------------------------------------------------------------


def _report(written: "Written", made: "Replayed") -> str:
    header = written.header
    title = (
        f"{as_text(written.path)}: {header.preset}, seed {header.seed}; begun {header.began} with"
        f" pounce {header.version}; {counted(len(written.records), 'record')}"
    )
    rows = [
        (
            _called(line, line.number == made.live),
            "" if line.parent is None else f"line {line.parent}, step {line.fork_step:,}",
            f"{line.run.step:,}",
            f"{line.run.trial:,}",
            line.digest[:_SHORT],
            _VERDICTS[line.is_same],
        )
        for line in made.lines.values()
    ]
    differences = [
        filled(_difference_in_words(line.number, line.difference), "")
        for line in made.lines.values()
        if line.difference is not None
    ]
    return "\n\n".join([filled(title, ""), table(_HEADER, rows), *differences])


def _called(line: "LineMade", is_live: bool) -> str:
    what = " (live)" if is_live else "" if line.is_there else " (deleted)"
    return f"{line.number} {as_text(line.name)}{what}"


_VERDICTS = {True: "yes", False: "NO", None: "none was"}


def _difference_in_words(line: int, found: "Difference") -> str:
    stood = found.stood
    text = (
        f"Line {line} is not as recorded. At step {found.same_step:,} it still was. At step"
        f" {stood.step:,} it is in trial {found.trial:,} with the digest {found.digest[:_SHORT]},"
        f" and trial {stood.trial:,} and {stood.digest[:_SHORT]} were recorded."
    )
    if not found.given:
        return f"{text} No command was given in between: this pounce learns otherwise."
    given = "; ".join(_in_words(given) for given in found.given)
    what = "this command" if len(found.given) == 1 else "one of these commands"
    return f"{text} It came after {what}: {given}."


def _in_words(given: "Given") -> str:
    from app.explain.commands import command_in_words

    return f"{command_in_words(given.command)} (step {given.step:,})"


def _document(written: "Written", until: int | None, made: "Replayed") -> dict[str, Any]:
    return {
        "session": as_text(written.path),
        **asdict(written.header),
        "records": len(written.records),
        "torn": written.is_torn,
        "until": until,
        "same": made.is_same,
        "live": made.live,
        "lines": [_line_document(line) for line in made.lines.values()],
    }


def _line_document(line: "LineMade") -> dict[str, Any]:
    return {
        "line": line.number,
        "name": line.name,
        "deleted": not line.is_there,
        "preset": line.preset,
        "seed": line.seed,
        "parent": line.parent,
        "fork_step": line.fork_step,
        "step": line.run.step,
        "trial": line.run.trial,
        "digest": line.digest,
        "commands": len(line.given),
        "compared": line.n_stands,
        "same": line.is_same,
        "difference": None if line.difference is None else _difference(line.difference),
    }


def _difference(found: "Difference") -> dict[str, Any]:
    from app.live.codec import encoded_command

    return {
        "same_step": found.same_step,
        "step": found.stood.step,
        "trial": found.trial,
        "digest": found.digest,
        "recorded_trial": found.stood.trial,
        "recorded_digest": found.stood.digest,
        "given": [
            {"step": given.step, "command": encoded_command(given.command)} for given in found.given
        ],
    }
