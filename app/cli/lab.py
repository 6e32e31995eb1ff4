"""The command ``pounce lab``: its words, its checks, and how it serves the page until the end."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, UseAppendAction, arg

from app.cli import terminal
from app.cli.answers import (
    EXIT_FAILED,
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
from app.cli.replay import folder_of, refused, written_of
from app.util.logs import LEVELS
from app.util.texts import as_text

if TYPE_CHECKING:
    from app.documents.lessons import Lesson
    from app.live.journal import Journal
    from app.live.lines import MadeAgain
    from app.live.past import Budget
    from app.live.session import Session
    from app.player.presented import Stand
    from app.server.origin import Authority

EXAMPLES = (
    "pounce",
    "pounce lab hierarchical_3 --seed 7",
    "pounce lab my-preset.yaml --port 9000 --no-browser",
    "pounce lab --resume",
    "pounce lab shared.pounce",
    "pounce lab --audience 0.0.0.0:8090",
)


LATEST = "latest"
"""The session that ``--resume`` takes up alone."""
SUFFIX = ".pounce"
"""Of the file of a session."""
_MOST_MEMORY = 4_096


@dataclass(frozen=True)
class Lab:
    """Open the lab in a browser: watch a learner, and steer it."""

    preset: Annotated[Positional[str], arg(metavar="[PRESET]")] = "timed"
    """A shipped preset, or a file of one (- is standard input); or the file of a session that
    somebody shared."""
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
    audience: Annotated[str | None, arg(metavar="IP:PORT", help_behavior_hint=HIDDEN_HINT)] = None
    """Show phones and a class what the first browser sees, at a port where one can only look; on
    any address but this machine's own, a code is asked for."""
    class_: Annotated[bool, arg(name="class", help_behavior_hint=HIDDEN_HINT)] = False
    """Have the audience answer what the presenter asks, each at a seat without a name; who joins
    types a code of six letters."""
    own: Flag = False
    """Let each of the audience have a learner of their own, with a few controls."""
    no_code: Flag = False
    """Let whoever reaches the audience's page look."""
    lesson: Annotated[str | None, arg(metavar="LESSON")] = None
    """Begin with a lesson: a shipped one by its name, or a file of one."""
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
    resume: Annotated[
        str | None, arg(metavar="[SESSION]", help_behavior_hint="(alone: the latest)")
    ] = None
    """Take up an earlier session where it ended, by its name or its file."""
    sessions: Annotated[
        str | None, arg(metavar="FOLDER", help_behavior_hint="(default: the user's own)")
    ] = None
    """Where sessions are kept: all that is done, so that it can be taken up again."""
    no_journal: Flag = False
    """Keep nothing of this session."""
    past_memory: Annotated[str, arg(metavar="MB")] = "64"
    """Memory for moments of the past, from which others are made; more is quicker."""
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
    past_memory = whole_number("--past-memory", command.past_memory, 1, _MOST_MEMORY)
    _check_keeping(command)
    folder = folder_of(command.sessions)
    names = [*_declared("--name", command.name)]
    names += _declared("POUNCE_NAMES", filter(None, os.environ.get("POUNCE_NAMES", "").split(",")))
    token = _token(command)
    is_shared = command.preset.endswith(SUFFIX)
    spec = spec_of(Lab.preset if is_shared else command.preset)
    lesson = None if command.lesson is None else _lesson(command.lesson)
    opens_stand = _stand(command, names)
    from app.documents import presets
    from app.documents.sources import called
    from app.live.past import Budget
    from app.page.serving import BrokenLabError, ListenError, run_lab

    preset, made, budget = called(command.preset), None, Budget(past_memory * 1_000_000)
    if is_shared:
        journal, made = _opened(command, folder, budget)
    elif command.resume is not None:
        journal, made = _taken_up(command, command.resume, folder, budget)
    else:
        journal = _begun(command, folder, preset, seed)
    if made is not None:
        run = made.family.held.run
        spec, preset, seed = run.preset, made.family.preset, run.seed
    try:
        return run_lab(
            spec=spec,
            preset=preset,
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
            opening=not command.no_opening and made is None,
            sessions=folder,
            journal=journal,
            made_again=made,
            budget=budget,
            opens_stand=opens_stand,
            lesson=lesson,
        )
    except ListenError as error:
        raise UsageError(
            f"--host and --port: {shown(command.host)} and {port} cannot be listened on:"
            f" {error}; allowed: an address of this machine and a free port"
        ) from error
    except BrokenLabError as error:
        complain(str(error))
        return EXIT_FAILED
    finally:
        if journal is not None:
            journal.close()


def _lesson(name: str) -> "Lesson":
    """The lesson that is to be begun.

    Raises:
        WrongPresetError: it cannot be taught; with all that is wrong with it.
    """
    from app.documents import lessons

    try:
        return lessons.load(name)
    except lessons.LessonError as error:
        raise WrongPresetError(str(error)) from error


def _check_keeping(command: Lab) -> None:
    """Refuse options that say nothing together.

    Raises:
        UsageError: there are such.
    """
    if command.resume is None:
        if command.no_journal and command.sessions is not None:
            raise UsageError("--sessions and --no-journal exclude each other; allowed: one of them")
    elif command.preset != Lab.preset or command.seed != Lab.seed:
        raise UsageError("--resume goes on with a session's own preset and seed; allowed: it alone")
    if command.preset.endswith(SUFFIX) and command.seed != Lab.seed:
        raise UsageError("--seed: a session has a seed of its own; allowed: the file alone")


def _begun(command: Lab, folder: Path | None, preset: str, seed: int) -> "Journal | None":
    """What is written down of a session that begins; None if nothing is.

    Raises:
        UsageError: the folder that is to have it cannot be written to.
    """
    from app.live import kept

    if command.no_journal:
        return None
    if folder is None:
        complain(
            "Warning: this session is not kept, as there is no telling where this user's files are."
        )
        return None
    if command.sessions is not None:
        try:
            kept.try_out(folder)
        except OSError as error:
            raise UsageError(
                f"--sessions: {shown(command.sessions)} cannot be written to:"
                f" {error.strerror or error}; allowed: a folder that can, or --no-journal"
            ) from error
    return kept.begun(folder, preset, seed)


def _taken_up(
    command: Lab, name: str, folder: Path | None, budget: "Budget"
) -> "tuple[Journal | None, MadeAgain]":
    """An earlier session, made again, and its journal, unless nothing is to be kept.

    Raises:
        UsageError: it cannot be taken up.
    """
    from app.explain.branches import name_of
    from app.live.journal import Journal
    from app.live.made_again import made_again
    from app.live.written import DamagedError, SessionError

    written = written_of("--resume", name, folder)
    try:
        journal = None if command.no_journal else Journal.going_on(written)
    except SessionError as error:
        raise UsageError(f"--resume: {as_text(str(error))}") from error
    try:
        with terminal.status() as show:
            remade = made_again(
                written, budget, name_of, on_step=lambda share: show(f"made again: {share:.0%}")
            )
    except DamagedError as error:
        if journal is not None:
            journal.close()
        raise UsageError(f"--resume: {refused(error)}") from error
    for line in remade.differ:
        complain(
            filled(
                f"Warning: {line} is not what was recorded: this pounce learns otherwise than"
                f" {written.header.version}. pounce replay says from where on."
            )
        )
    return journal, remade.made


def _opened(
    command: Lab, folder: Path | None, budget: "Budget"
) -> "tuple[Journal | None, MadeAgain]":
    """A session that somebody shared, made again, and the journal of what is done from here on.

    Raises:
        UsageError: it cannot be opened.
    """
    from app.explain.branches import name_of
    from app.explain.opened import contents_in_words, verdict_in_words
    from app.live.made_again import made_again
    from app.live.shared import MOST_STEPS, contents_of, read_file
    from app.live.written import SessionError

    try:
        written = read_file(Path(command.preset))
        with terminal.status() as show:
            remade = made_again(
                written,
                budget,
                name_of,
                on_step=lambda share: show(f"made again: {share:.0%}"),
                most_steps=MOST_STEPS,
            )
    except SessionError as error:
        raise UsageError(f"PRESET: {as_text(str(error))}") from error
    contents = contents_of(written)
    say(filled(f"{as_text(written.path)}: {contents_in_words(contents)}", ""))
    verdict = verdict_in_words(remade, contents)
    if remade.differ:
        complain(filled(f"Warning: {verdict}"))
    else:
        say(filled(verdict, ""))
    held = remade.made.family.held
    journal = _begun(command, folder, held.preset, held.run.seed)
    if journal is not None:
        journal.begin_with(remade.records)
    return journal, remade.made


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


def _stand(command: Lab, names: "Sequence[Authority]") -> "Callable[[Session], Stand] | None":
    """Opens the port for those who only look; None if nobody is to.

    Raises:
        UsageError: there can be no such port.
    """
    from app.server.access import new_code, new_short_code
    from app.server.origin import is_loopback

    if command.audience is None:
        if command.no_code:
            raise UsageError("--no-code is about the code of --audience; allowed: with that")
        if command.class_:
            raise UsageError("--class is about those who look with --audience; allowed: with that")
        if command.own:
            raise UsageError("--own is about those who look with --audience; allowed: with that")
        return None
    host, _, digits = command.audience.rpartition(":")
    host = host.removeprefix("[").removesuffix("]").strip()
    if not host or not digits:
        raise UsageError(
            f"--audience: {shown(command.audience)} is not allowed; allowed: an address of this"
            " machine and a port, such as 0.0.0.0:8090"
        )
    port = whole_number("--audience", digits, 0, 65_535)
    code = None
    if command.class_ and not command.no_code:
        # On this machine's own address as well: a proxy may be what brings a class there.
        code = new_short_code()
    elif not is_loopback(host) and not command.no_code:
        code = new_code()
    if command.no_code and not is_loopback(host):
        complain("Warning: whoever can reach this machine can look at the lab.")

    def opened(session: "Session") -> "Stand":
        from app.audience.audience import Audience

        try:
            return Audience(
                session.past_of,
                host,
                port,
                code=code,
                names=names,
                is_class=command.class_,
                has_own=command.own,
            )
        except (OSError, UnicodeError) as error:
            raise UsageError(
                f"--audience: {shown(command.audience or '')} cannot be listened on:"
                f" {getattr(error, 'strerror', None) or error}; allowed: an address of this machine"
                " and a free port"
            ) from error

    return opened


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
