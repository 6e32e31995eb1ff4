"""The command ``pounce``: its commands, how their words are understood, and how it ends.

What takes long to import is imported by the command that needs it, so that help comes at once.
"""

import contextlib
import dataclasses
import difflib
import io
import logging
import os
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TextIO

import tyro
from tyro.conf import FlagCreatePairsOff, OmitArgPrefixes, arg

from app import __version__
from app.cli import (
    bench,
    doctor,
    experiment,
    export,
    lab,
    lesson,
    replay,
    replicate,
    report,
    run,
    tune,
)
from app.cli.answers import (
    COLUMNS,
    EXIT_FAILED,
    EXIT_OK,
    EXIT_PIPE_CLOSED,
    EXIT_USAGE,
    Flag,
    UsageError,
    WrongPresetError,
    complain,
    filled,
    say,
    shown,
)
from app.cli.bench import Bench
from app.cli.doctor import Doctor
from app.cli.experiment import Experiment
from app.cli.export import Export
from app.cli.lab import Lab
from app.cli.lesson import Lesson
from app.cli.replay import Replay
from app.cli.replicate import Replicate
from app.cli.report import Report
from app.cli.run import Run
from app.cli.tune import Tune
from app.util import interrupts
from app.util.interrupts import as_interrupts, ended_by

# --- What can be asked for -----------------------------------------------------------------------
#
# Values stay texts until the checks of a command have seen them, so that every refusal reads the
# same.


@dataclass(frozen=True)
class Presets:
    """List the shipped presets."""


Command = (
    Lab
    | Lesson
    | Replay
    | Export
    | Presets
    | Run
    | Tune
    | Experiment
    | Report
    | Replicate
    | Bench
    | Doctor
)

COMMANDS: dict[str, type[Command]] = {
    "lab": Lab,
    "lesson": Lesson,
    "replay": Replay,
    "export": Export,
    "presets": Presets,
    "run": Run,
    "tune": Tune,
    "experiment": Experiment,
    "report": Report,
    "replicate": Replicate,
    "bench": Bench,
    "doctor": Doctor,
}

EXAMPLES: dict[type[Command], Sequence[str]] = {
    Lab: lab.EXAMPLES,
    Lesson: lesson.EXAMPLES,
    Replay: replay.EXAMPLES,
    Export: export.EXAMPLES,
    Presets: ("pounce presets",),
    Run: run.EXAMPLES,
    Tune: tune.EXAMPLES,
    Experiment: experiment.EXAMPLES,
    Report: report.EXAMPLES,
    Replicate: replicate.EXAMPLES,
    Bench: bench.EXAMPLES,
    Doctor: doctor.EXAMPLES,
}


@dataclass(frozen=True)
class Pounce:
    """A lab in which you see how the timing of skills changes what a learner learns.

    This is what ``pounce --help`` shows; the commands themselves are parsed one by one.
    """

    command: OmitArgPrefixes[
        Annotated[Lab, tyro.conf.subcommand("lab")]
        | Annotated[Lesson, tyro.conf.subcommand("lesson")]
        | Annotated[Replay, tyro.conf.subcommand("replay")]
        | Annotated[Export, tyro.conf.subcommand("export")]
        | Annotated[Presets, tyro.conf.subcommand("presets")]
        | Annotated[Run, tyro.conf.subcommand("run")]
        | Annotated[Tune, tyro.conf.subcommand("tune")]
        | Annotated[Experiment, tyro.conf.subcommand("experiment")]
        | Annotated[Report, tyro.conf.subcommand("report")]
        | Annotated[Replicate, tyro.conf.subcommand("replicate")]
        | Annotated[Bench, tyro.conf.subcommand("bench")]
        | Annotated[Doctor, tyro.conf.subcommand("doctor")]
    ] = dataclasses.field(default_factory=Lab)
    version: Annotated[Flag, arg(aliases=["-V"])] = False
    """Print the version."""


# --- From words to commands ----------------------------------------------------------------------


def parse(argv: Sequence[str]) -> Command | Pounce | None:
    """What was asked for; None if it was help, which has been printed.

    Raises:
        UsageError: the words make no sense.
    """
    first = argv[0] if argv else ""
    if first in COMMANDS:
        return _parsed(COMMANDS[first], f"pounce {first}", argv[1:])
    if first and not first.startswith("-"):
        raise UsageError(_unknown_command(first))
    if first in ("-h", "--help", "-V", "--version"):
        return _parsed(Pounce, "pounce", argv)
    return _parsed(Lab, "pounce lab", argv)


def _unknown_command(word: str) -> str:
    close = difflib.get_close_matches(word, COMMANDS, n=1)
    hint = f"did you mean {close[0]}?" if close else f"to open a preset: pounce lab {word}"
    return f"{shown(word)} is not a command; allowed: {', '.join(COMMANDS)} ({hint})"


def _parsed(kind: type[Any], prog: str, argv: Sequence[str]) -> Any:
    for word in argv[:1]:
        # tyro's own options, which are not ours.
        if word.replace("_", "-").startswith("--tyro-"):
            raise UsageError(_unknown_word(kind, prog, [word]))
    complaint, told = io.StringIO(), _Told(sys.stdout)
    try:
        with contextlib.redirect_stderr(complaint), contextlib.redirect_stdout(told):
            command, unknown = tyro.cli(
                kind,
                prog=prog,
                description=_description(kind),
                args=_with_the_latest(_one_value_for_each_set(argv), kind),
                return_unknown_args=True,
                config=(FlagCreatePairsOff,),
            )
    except SystemExit as end:
        if not end.code:
            sys.stdout.write(_narrow(told.text))
            return None
        # Values are texts, so all that tyro itself can miss is one.
        option = re.search(r"--[a-z][a-z-]*", complaint.getvalue())
        name = option[0] if option else "an option"
        raise UsageError(f"{name}: its value is missing (see {prog} --help)") from end
    if unknown:
        raise UsageError(_unknown_word(kind, prog, unknown))
    return command


_COLOURS = r"(?:\x1b\[[\d;]*m)*"


class _Told(io.TextIOWrapper):
    """Keeps what is printed, in the characters and colours that another stream can show."""

    def __init__(self, stream: TextIO) -> None:
        self._kept = io.BytesIO()
        super().__init__(self._kept, encoding=stream.encoding, errors="backslashreplace")
        self._stream = stream

    def isatty(self) -> bool:
        return self._stream.isatty()

    @property
    def text(self) -> str:
        self.flush()
        return self._kept.getvalue().decode(self.encoding)


def _narrow(told: str) -> str:
    """A help whose first line, how the command is used, fits a terminal as all others do."""
    usage, end, rest = told.partition("\n")
    lines = [""]
    # Between two options, or two of the words that an option may be.
    for words in re.split(rf" (?={_COLOURS}\[)|(?<=,)", usage):
        space = "" if lines[-1].endswith(",") or not lines[-1] else " "
        line = f"{lines[-1]}{space}{words}"
        if len(re.sub(_COLOURS, "", line)) <= COLUMNS:
            lines[-1] = line
        else:
            lines.append(f"  {words}")
    return "\n".join(lines) + end + rest


def _description(kind: type[Any]) -> str:
    text = (kind.__doc__ or "").splitlines()[0]
    if kind not in EXAMPLES:
        return text
    return "\n".join([text, "", "Examples:", *(f"  {line}" for line in EXAMPLES[kind])])


def _one_value_for_each_set(argv: Sequence[str]) -> list[str]:
    """``--set A=1 B=2`` as ``--set A=1 --set B=2``."""
    words: list[str] = []
    after_setting = False
    for word in argv:
        if words[-1:] == ["--set"]:
            after_setting = True
        elif after_setting and re.match(r"[A-Za-z_][\w.]*=", word):
            words.append("--set")
        else:
            after_setting = False
        words.append(word)
    return words


def _with_the_latest(argv: Sequence[str], kind: type[Any]) -> list[str]:
    """``--resume`` of the lab, where no session is named, with the latest one."""
    words = list(argv)
    if kind is Lab:
        for place in [place for place, word in enumerate(argv) if word == "--resume"][::-1]:
            if all(word.startswith("-") for word in argv[place + 1 : place + 2]):
                words.insert(place + 1, lab.LATEST)
    return words


def _unknown_word(kind: type[Any], prog: str, unknown: Sequence[str]) -> str:
    word = next((word for word in unknown if word.startswith("-")), None)
    if word is None:
        return f"{shown(unknown[0])} is one word too many (see {prog} --help)"
    options = [
        f"--{field.name.removesuffix('_').replace('_', '-')}" for field in dataclasses.fields(kind)
    ]
    close = difflib.get_close_matches(word, options, n=1)
    hint = f"did you mean {close[0]}?" if close else f"see {prog} --help"
    return f"{shown(word)} is not an option of {prog} ({hint})"


# --- Commands ------------------------------------------------------------------------------------


def _presets() -> int:
    from app.documents import presets

    shipped = presets.shipped()
    width = max(map(len, shipped))
    for name in shipped:
        say(filled(f"{name:{width}}  {presets.load(name).description}", " " * (width + 2)))
    say("\nFiles:")
    for file in shipped.values():
        say(f"  {file}")
    return EXIT_OK


# --- The program ---------------------------------------------------------------------------------


def _obey(command: Command | Pounce | None) -> int:
    match command:
        case None:
            return EXIT_OK
        case Pounce():
            say(f"pounce {__version__}")
            return EXIT_OK
        case Lab():
            return lab.obey(command)
        case Lesson():
            return lesson.obey(command)
        case Replay():
            return replay.obey(command)
        case Export():
            return export.obey(command)
        case Presets():
            return _presets()
        case Run():
            return run.obey(command)
        case Tune():
            return tune.obey(command)
        case Experiment():
            return experiment.obey(command)
        case Report():
            return report.obey(command)
        case Replicate():
            return replicate.obey(command)
        case Bench():
            return bench.obey(command)
        case Doctor():
            return doctor.obey(command)


def main(argv: Sequence[str] | None = None) -> int:
    """Do what the command line says; returns the exit code."""
    for stream in (sys.stdout, sys.stderr):
        # Where the terminal knows no such character, better an escape than a traceback.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    # Without a home it warns of where it keeps what it has found of fonts, which is no matter.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    try:
        code = _answer(sys.argv[1:] if argv is None else argv)
        sys.stdout.flush()
    except BrokenPipeError:
        # Nobody reads on. What is still to be flushed at exit must have somewhere to go.
        _say_no_more(sys.stdout, sys.stderr)
        return EXIT_PIPE_CLOSED
    except OSError as error:
        # Where standard output goes is full, or gone, and standard error may be so too.
        with contextlib.suppress(OSError):
            complain(f"cannot go on: {error}")
        with contextlib.suppress(OSError):
            _say_no_more(sys.stdout)
        return EXIT_FAILED
    return code


def _say_no_more(*streams: TextIO) -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in streams:
        os.dup2(nowhere, stream.fileno())


def _answer(argv: Sequence[str]) -> int:
    try:
        with as_interrupts():
            return _obey(parse(argv))
    except WrongPresetError as error:
        complain(str(error))
        return EXIT_USAGE
    except UsageError as error:
        complain(filled(str(error)))
        return EXIT_USAGE
    except KeyboardInterrupt as ending:
        said, code = ended_by(ending)
        # Where it was the terminal that went, there is nobody to tell.
        with contextlib.suppress(OSError):
            complain(said)
        return code


if __name__ == "__main__":
    interrupts.end_the_program()
    sys.exit(main())
