"""The command ``pounce lab``: its words, its checks, and how it serves the page until the end."""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, UseAppendAction, arg

from app.cli.answers import (
    EXIT_FAILED,
    HIDDEN_HINT,
    RESULTS,
    Flag,
    UsageError,
    complain,
    shown,
    spec_of,
    whole_number,
)
from app.util.logs import LEVELS

if TYPE_CHECKING:
    from app.server.origin import Authority

EXAMPLES = (
    "pounce",
    "pounce lab hierarchical_3 --seed 7",
    "pounce lab my-preset.yaml --port 9000 --no-browser",
)


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
    no_opening: Flag = False
    """Learn at the set speed from the first trial on. Otherwise the first three hunts are slow
    enough to be seen."""
    save_dir: Annotated[str | None, arg(metavar="FOLDER", help_behavior_hint=HIDDEN_HINT)] = None
    """Let *Save as preset* write into that folder as well."""
    results: Annotated[str, arg(metavar="FOLDER")] = RESULTS
    """Where experiments that are started in the page put their folders."""
    log_level: Annotated[str, arg(metavar="LEVEL")] = "warning"
    """What the terminal is told: debug, info, warning or error, and all that is worse."""


def obey(command: Lab) -> int:
    """Serve the page until the end; returns the exit code.

    Raises:
        UsageError: what was asked for makes no sense.
    """
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
    log_level = LEVELS.get(command.log_level.lower())
    if log_level is None:
        raise UsageError(
            f"--log-level: {shown(command.log_level)} is not allowed; allowed: {', '.join(LEVELS)}"
        )
    names = [*_declared("--name", command.name)]
    names += _declared("POUNCE_NAMES", filter(None, os.environ.get("POUNCE_NAMES", "").split(",")))
    token = _token(command)
    spec = spec_of(command.preset)
    from app.documents import presets
    from app.documents.sources import called
    from app.page.serving import BrokenLabError, ListenError, run_lab

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
            log_level=log_level,
            opening=not command.no_opening,
        )
    except ListenError as error:
        raise UsageError(
            f"--host and --port: {shown(command.host)} and {port} cannot be listened on:"
            f" {error}; allowed: an address of this machine and a free port"
        ) from error
    except BrokenLabError as error:
        complain(str(error))
        return EXIT_FAILED


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
