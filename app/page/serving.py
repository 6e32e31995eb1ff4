"""From a lab's settings to a page that is served until a signal or a failure ends it."""

import contextlib
import logging
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from app.documents.lessons import Lesson
from app.explain.branches import name_of
from app.live import kept
from app.live.lines import MadeAgain
from app.live.past import Budget
from app.live.records import Journal
from app.live.session import Session
from app.page.lab import DEFAULT_SPEED, Lab
from app.player.presented import Stand
from app.server.origin import Authority
from app.server.server import addresses_of
from app.util.ending import watched
from app.util.logs import sparing_log
from app.util.web_browser import open_in_browser
from learners.spec import RunSpec

log = logging.getLogger(__name__)


class ListenError(Exception):
    """A host and a port that cannot be listened on; the message says why."""


class BrokenLabError(Exception):
    """A lab that has ended by itself; the message says why."""


def run_lab(
    spec: RunSpec,
    preset: str,
    seed: int,
    presets: Mapping[str, RunSpec],
    host: str,
    port: int,
    open_browser: bool,
    save_dir: Path | None,
    results: Path,
    names: Sequence[Authority],
    token: str | None,
    log_level: int,
    opening: bool,
    sessions: Path | None,
    journal: Journal | None,
    made_again: MadeAgain | None,
    budget: Budget,
    opens_stand: Callable[[Session], Stand] | None = None,
    lesson: Lesson | None = None,
) -> int:
    """Serve the live page until Ctrl-C or another signal; returns the exit code.

    With an ``opening`` the first hunts are slow enough to be seen. A session that was made again is
    taken up instead of beginning a run. With ``opens_stand`` there is a port for those who only
    look. A ``lesson`` is taken at once. What is logged meanwhile is said sparingly
    (:func:`app.util.logs.sparing_log`).

    Raises:
        ListenError: the host is not an address of this machine, or no port is free.
        BrokenLabError: it has ended by itself; the message says why.
    """
    with sparing_log(log_level), watched() as ending:
        session = Session(
            spec,
            preset,
            seed,
            DEFAULT_SPEED,
            False,
            opening,
            journal=journal,
            made_again=made_again,
            name_of=name_of,
            budget=budget,
        )
        if journal is not None and sessions is not None:
            # Its own file is there by now, and in use.
            kept.clear(sessions)
        stand = None if opens_stand is None else opens_stand(session)
        try:
            lab = Lab(
                session,
                {preset: spec, **presets},
                host,
                port,
                results,
                save_dir,
                True,
                names,
                token,
                sessions,
                stand,
                lesson,
            )
        except (OSError, UnicodeError) as error:
            if stand is not None:
                stand.close()
            # Of some names that no host can have Python says that they are no text.
            raise ListenError(getattr(error, "strerror", None) or str(error)) from error
        # Between two frames and not within one, where it would leave things half done.
        ending.by(lab.end)
        _announce(lab, port)
        if stand is not None:
            _announce_stand(stand)
        session.start()
        if open_browser:
            _show(lab)
        try:
            lab.serve()
        except Exception as error:
            log.exception("a frame could not be drawn")
            lab.failure = f"drawing failed: {type(error).__name__}: {error}"
        finally:
            lab.close()
    if lab.failure is not None:
        reasons = "".join(f"; {name}: {words}" for name, words in ending.last_words.items())
        raise BrokenLabError(f"The lab has ended by itself: {lab.failure}{reasons}")
    # Where the terminal is gone there is nobody to tell.
    with contextlib.suppress(OSError):
        _say("\nEnded.")
    return ending.exit_code


def _announce(lab: Lab, port: int) -> None:
    """Say where the lab is to be found."""
    if port not in (0, lab.server.get_port()):
        _say(f"Port {port} is busy, so this uses {lab.server.get_port()}.")
    first, *others = lab.urls
    _say(f"pounce is at {first}  (Ctrl-C ends it)")
    for other in others:
        _say(f"      and at {other}")


def _announce_stand(stand: Stand) -> None:
    """Say where those are to look who only look."""
    code = "" if stand.code is None else f"/?token={stand.code}"
    first, *others = stand.addresses
    _say(f"Its audience looks at {first}{code}")
    for other in others:
        _say(f"               and at {other}{code}")
    if stand.code is not None:
        _say(f"Whoever opens it without what follows the / is asked for the code {stand.code}")


def _show(lab: Lab) -> None:
    """Open the page in a browser; its address says that it is to be used once."""
    address = addresses_of(lab.server)[0]
    question = "" if lab.access is None else f"/{lab.access.question_for_once()}"
    open_in_browser(f"{address}{question}")


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()
