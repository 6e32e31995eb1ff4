"""Earlier sessions on the *File* tab of one browser: which are kept, and taking one up again."""

from collections.abc import Callable
from datetime import datetime
from functools import partial
from pathlib import Path

import viser

from app.explain.branches import name_of
from app.live import kept
from app.live.journal import Journal
from app.live.kept import Kept
from app.live.made_again import made_again
from app.live.session import Session
from app.live.written import DamagedError, SessionError, read, save
from app.page.confirm import confirm_for_all
from app.page.inbox import Intent, Work, check_there
from app.page.taking_up import Submit, Taken, take_up
from app.page.widgets import CALM, add_hints, assign
from app.util.html import element
from app.util.texts import as_text
from app.words.numbers import counted

_NONE = "none"


class Earlier:
    """The folder of widgets, in the container that is current."""

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        submit: Submit,
        work: Work,
        n_viewers: Callable[[], int],
        folder: Path,
    ) -> None:
        """Show which sessions are kept.

        Args:
            client: the browser.
            session: that a session is taken up in.
            submit: asks that.
            work: has something made in another thread.
            n_viewers: browsers that see the session.
            folder: of the sessions.
        """
        self._client = client
        self._session = session
        self._submit = submit
        self._work = work
        self._n_viewers = n_viewers
        self._folder = folder
        self._listed: dict[str, Kept] = {}
        gui = client.gui
        with gui.add_folder("Earlier sessions", expand_by_default=False):
            self._choice = gui.add_dropdown(
                "Session",
                (_NONE,),
                hint="When it was left, its preset and seed, and how far it was. The lab keeps all"
                " that is done in it.",
            )
            self._resume = gui.add_button(
                "Resume",
                icon=viser.Icon.HISTORY,
                color=CALM,
                disabled=True,
                hint="Go on with that session where it was left, with its branches and marks. The"
                " one on the board is kept and can be resumed later.",
            )
            again = gui.add_button(
                "Look again",
                icon=viser.Icon.REFRESH,
                color=CALM,
                hint="List the sessions that are kept by now.",
            )
            self._said = gui.add_html("")
        add_hints(gui, self._choice, self._resume, again)
        self._resume.on_click(Intent(self._ask_first))
        again.on_click(Intent(lambda _, __: self._look()))
        self._look()

    def _look(self) -> None:
        self._work(self._client, partial(kept.sessions_in, self._folder), self._show)

    def _show(self, found: list[Kept]) -> None:
        # That of this lab is in use as well.
        there = [session for session in found if session.is_begun and not session.in_use]
        self._listed = {_label(session): session for session in there}
        assign(self._choice, "options", tuple(self._listed) or (_NONE,))
        assign(self._resume, "disabled", not there)

    def _say(self, text: str) -> None:
        style = "padding:0 0.7em 0.5em;font-size:0.85em;overflow-wrap:anywhere"
        assign(self._said, "content", str(element("div", text, style=style)) if text else "")

    def _ask_first(self, client: viser.ClientHandle, _: object) -> None:
        """Ask before the run is taken away that others are looking at."""
        chosen = self._listed.get(str(self._choice.value))
        if chosen is None:
            return
        n_others = self._n_viewers() - 1
        if n_others < 1:
            self._begin(chosen)
            return
        confirm_for_all(
            client,
            n_others,
            "Resume",
            "this session. It is kept, and can be resumed later.",
            lambda: self._begin(chosen),
        )

    def _begin(self, chosen: Kept) -> None:
        self._say("The session is being made again …")
        assign(self._resume, "disabled", True)
        make = partial(_made, chosen.path, self._session)
        take_up(self._client, self._session, self._submit, self._work, make, self._taken)

    def _taken(self, found: Taken | str) -> None:
        assign(self._resume, "disabled", False)
        if isinstance(found, str):
            self._say(found)
            return
        differ = ", ".join(found.remade.differ)
        end = ". This pounce learns otherwise."
        self._say(f"Not as it was recorded: {differ}{end}" if differ else "")
        self._look()


def _made(path: Path, session: Session, first_number: int) -> Taken | str:
    """A session made again, and its journal; or why that cannot be."""
    journal = None
    try:
        written = read(path)
        journal = Journal.going_on(written)
        remade = made_again(
            written, session.budget, name_of, first_number, lambda _: check_there(session)
        )
        return Taken(remade, journal)
    except BaseException as error:
        if journal is not None:
            # Nobody could resume it as long as this lab holds its file.
            journal.close()
        if not isinstance(error, SessionError):
            raise
        return _refused(path, error)


def _refused(path: Path, error: SessionError) -> str:
    # Where it is on this machine is nothing for a page.
    message = as_text(str(error).replace(f"{path.parent}/", ""))
    if not isinstance(error, DamagedError) or error.saved is None:
        return message
    records = counted(len(error.saved.records), "record")
    try:
        saved = save(error.saved)
    except OSError as failure:
        return f"{message}; the {records} before it cannot be saved: {failure.strerror or failure}"
    return f"{message}; the {records} before it are saved as {as_text(saved.name)}"


def _label(session: Kept) -> str:
    seen = session.glance
    when = datetime.fromtimestamp(session.written_at)
    return (
        f"{when:%Y-%m-%d %H:%M:%S} · {seen.header.preset}, seed {seen.header.seed}"
        f" · trial {seen.trial:,} · {counted(seen.n_commands, 'command')}"
    )
