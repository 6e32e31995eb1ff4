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
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO

import tyro
from tyro.conf import FlagCreatePairsOff, OmitArgPrefixes, Positional, UseAppendAction, arg

from app import __version__, bench_cli, experiment_cli, interrupts, report_cli, run_cli
from app.bench_cli import Bench
from app.cli_words import (
    EXIT_FAILED,
    EXIT_OK,
    EXIT_PIPE_CLOSED,
    EXIT_USAGE,
    HIDDEN_HINT,
    RESULTS,
    Flag,
    UsageError,
    WrongPresetError,
    complain,
    filled,
    say,
    shown,
    spec_of,
    whole_number,
)
from app.experiment_cli import Experiment
from app.interrupts import as_interrupts, ended_by
from app.report_cli import Report
from app.run_cli import Run

if TYPE_CHECKING:
    from app.server.origin import Authority

# --- What can be asked for -----------------------------------------------------------------------
#
# Values stay texts until the checks of a command have seen them, so that every refusal reads the
# same.


@dataclass(frozen=True)
class Lab:
    """Open the lab in a browser: watch a learner, and steer it."""

    preset: Annotated[Positional[str], arg(metavar="[PRESET]")] = "timed"
    """A shipped preset, or a file; - is standard input."""
    host: Annotated[str, arg(metavar="IP")] = "127.0.0.1"
    """Address to listen on; on any but this machine's own, the page's address has a token in it."""
    name: Annotated[
        UseAppendAction[tuple[str, ...]],
        arg(metavar="NAME", help_behavior_hint="(may be repeated; also POUNCE_NAMES=NAME,...)"),
    ] = ()
    """A name under which browsers reach the lab through a proxy, with its port unless that is 80
    or 443."""
    no_token: Flag = False
    """Let in whoever reaches the lab. Otherwise POUNCE_TOKEN may hold the token to ask for."""
    port: Annotated[str, arg(metavar="PORT")] = "8080"
    """Port to listen on; if it is busy, the next free one."""
    no_browser: Flag = False
    """Print the address, and open no browser."""
    seed: Annotated[str, arg(metavar="N")] = "0"
    """Seed of the run."""
    save_dir: Annotated[str | None, arg(metavar="FOLDER", help_behavior_hint=HIDDEN_HINT)] = None
    """Let *Save as preset* write into that folder as well."""
    results: Annotated[str, arg(metavar="FOLDER")] = RESULTS
    """Where experiments that are started in the page put their folders."""


@dataclass(frozen=True)
class Presets:
    """List the shipped presets."""


Command = Lab | Presets | Run | Experiment | Report | Bench

COMMANDS: dict[str, type[Command]] = {
    "lab": Lab,
    "presets": Presets,
    "run": Run,
    "experiment": Experiment,
    "report": Report,
    "bench": Bench,
}

EXAMPLES: dict[type[Command], Sequence[str]] = {
    Lab: (
        "pounce",
        "pounce lab hierarchical_3 --seed 7",
        "pounce lab my-preset.yaml --port 9000 --no-browser",
    ),
    Presets: ("pounce presets",),
    Run: run_cli.EXAMPLES,
    Experiment: experiment_cli.EXAMPLES,
    Report: report_cli.EXAMPLES,
    Bench: bench_cli.EXAMPLES,
}


@dataclass(frozen=True)
class Pounce:
    """A lab in which you see how the timing of skills changes what a learner learns.

    This is what ``pounce --help`` shows; the commands themselves are parsed one by one.
    """

    command: OmitArgPrefixes[
        Annotated[Lab, tyro.conf.subcommand("lab")]
        | Annotated[Presets, tyro.conf.subcommand("presets")]
        | Annotated[Run, tyro.conf.subcommand("run")]
        | Annotated[Experiment, tyro.conf.subcommand("experiment")]
        | Annotated[Report, tyro.conf.subcommand("report")]
        | Annotated[Bench, tyro.conf.subcommand("bench")]
    ] = dataclasses.field(default_factory=Lab)
    version: Flag = False
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
    if first in ("-h", "--help", "--version"):
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
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            command, unknown = tyro.cli(
                kind,
                prog=prog,
                description=_description(kind),
                args=_one_value_for_each_set(argv),
                return_unknown_args=True,
                config=(FlagCreatePairsOff,),
            )
    except SystemExit as end:
        if not end.code:
            return None
        # Values are texts, so all that tyro itself can miss is one.
        option = re.search(r"--[a-z][a-z-]*", complaint.getvalue())
        name = option[0] if option else "an option"
        raise UsageError(f"{name}: its value is missing (see {prog} --help)") from end
    if unknown:
        raise UsageError(_unknown_word(kind, prog, unknown))
    return command


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


def _unknown_word(kind: type[Any], prog: str, unknown: Sequence[str]) -> str:
    word = next((word for word in unknown if word.startswith("-")), None)
    if word is None:
        return f"{shown(unknown[0])} is one word too many (see {prog} --help)"
    options = [f"--{field.name.replace('_', '-')}" for field in dataclasses.fields(kind)]
    close = difflib.get_close_matches(word, options, n=1)
    hint = f"did you mean {close[0]}?" if close else f"see {prog} --help"
    return f"{shown(word)} is not an option of {prog} ({hint})"


# --- Commands ------------------------------------------------------------------------------------


def _lab(command: Lab) -> int:
    from sim.rng import MAX_SEED

    port = whole_number("--port", command.port, 0, 65_535)
    seed = whole_number("--seed", command.seed, 0, MAX_SEED)
    if not command.host.strip():
        # An empty host would mean all addresses.
        raise UsageError("--host: '' is not allowed; allowed: an address of this machine")
    save_dir = None if command.save_dir is None else Path(command.save_dir)
    if save_dir is not None and not save_dir.is_dir():
        raise UsageError(f"--save-dir: {shown(str(save_dir))} is no folder; allowed: one there is")
    results = Path(command.results)
    if not command.results or (results.exists() and not results.is_dir()):
        raise UsageError(f"--results: {shown(command.results)} is not allowed; allowed: a folder")
    names = [*_declared("--name", command.name)]
    names += _declared("POUNCE_NAMES", filter(None, os.environ.get("POUNCE_NAMES", "").split(",")))
    token = _token(command)
    spec = spec_of(command.preset)
    from app import presets
    from app.document import called
    from app.lab import ListenError, run_lab

    try:
        return run_lab(
            spec=spec,
            preset=called(command.preset),
            seed=seed,
            presets={name: presets.load(name) for name in presets.shipped()},
            host=command.host,
            port=port,
            open_browser=not command.no_browser,
            save_dir=save_dir,
            results=results,
            names=names,
            token=token,
        )
    except ListenError as error:
        raise UsageError(
            f"--host and --port: {shown(command.host)} and {port} cannot be listened on:"
            f" {error}; allowed: an address of this machine and a free port"
        ) from error


def _declared(option: str, texts: Iterable[str]) -> "Iterator[Authority]":
    """The names that the lab is to answer to.

    Raises:
        UsageError: no host can have such a name.
    """
    from app.server.origin import declared_name

    for text in texts:
        try:
            yield declared_name(text)
        except ValueError as error:
            raise UsageError(
                f"{option}: {shown(text)} is not allowed ({error}); allowed: the name of a host,"
                " such as lab.example.edu or lab.example.edu:8443"
            ) from error


def _token(command: Lab) -> str | None:
    """What a browser must bring to be let in; None if whoever comes is.

    Raises:
        UsageError: the environment has one that cannot be used.
    """
    from app.server.access import MIN_TOKEN_CHARACTERS, is_token, new_token
    from app.server.origin import is_loopback

    if command.no_token:
        if not is_loopback(command.host):
            complain("Warning: whoever can reach this machine can open the lab and steer it.")
        return None
    chosen = os.environ.get("POUNCE_TOKEN")
    if chosen is None:
        return None if is_loopback(command.host) else new_token()
    if not is_token(chosen):
        # A secret is not repeated in a message.
        raise UsageError(
            f"POUNCE_TOKEN: its value is not allowed; allowed: {MIN_TOKEN_CHARACTERS} to 200"
            " letters, digits and the signs - . _ ~"
        )
    return chosen


def _presets() -> int:
    from app import presets

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
            return _lab(command)
        case Presets():
            return _presets()
        case Run():
            return run_cli.obey(command)
        case Experiment():
            return experiment_cli.obey(command)
        case Report():
            return report_cli.obey(command)
        case Bench():
            return bench_cli.obey(command)


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
