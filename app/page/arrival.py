"""A session from elsewhere comes to one browser, by a file or by a link, and is opened there.

Opening begins a session of its own, which is kept like any other; the file stays as it is. It takes
away what is on the board, so where others look, or where that would be lost, the browser is asked
first.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import viser

from app.explain.branches import name_of
from app.explain.opened import contents_in_words, verdict_in_words
from app.live import kept
from app.live.made_again import made_again
from app.live.session import Session
from app.live.shared import MOST_STEPS, contents_of, read_link
from app.live.written import SessionError, Written
from app.page.confirm import confirm, confirm_for_all
from app.page.inbox import Intent, Work, check_there
from app.page.taking_up import Submit, Taken, take_up
from app.page.widgets import CALM
from app.server.links import Links
from app.server.notices import close_modal, open_modal, tell
from app.util.html import element, joined
from app.util.texts import for_terminal

Made = TypeVar("Made")
Read = Callable[[], Written]
"""Reads a session; it raises a SessionError if that is none which may be opened."""

_SHOWN_S = 12.0


class Arrival:
    """Opens sessions from elsewhere in one browser."""

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        submit: Submit,
        work: Work,
        n_viewers: Callable[[], int],
        folder: Path | None,
        links: Links,
    ) -> None:
        """Prepare it.

        Args:
            client: the browser.
            session: that they are opened in.
            submit: asks that.
            work: has something made in another thread.
            n_viewers: browsers that see the session.
            folder: where what is done in them is kept, if the session is.
            links: what came in links.
        """
        self._client = client
        self._session = session
        self._submit = submit
        self._work = work
        self._n_viewers = n_viewers
        self._folder = folder if session.is_kept else None
        self._links = links
        self._is_busy = False
        self._say: Callable[[str], object] = lambda text: None

    def call_when_told(self, say: Callable[[str], object]) -> None:
        """Have what is told for a while said where it stays, too."""
        self._say = say

    def came(self, ticket: str) -> None:
        """Open what came in the link that has led the browser here."""
        code = self._links.take(ticket)
        if code is not None:
            self.open(partial(read_link, code), is_sure=False)

    def open(self, read: Read, is_sure: bool) -> None:
        """Open a session, or say why that cannot be.

        Args:
            read: reads it, in another thread.
            is_sure: whether somebody has just chosen it here, and did not only follow a link.
        """
        if self._is_busy:
            self._refuse("Another session is being opened; wait for that.")
            return
        self._is_busy = True
        self._work(self._client, partial(self._freed_by, _read, read), partial(self._ask, is_sure))

    def _ask(self, is_sure: bool, found: Written | str) -> None:
        """Ask before something is taken away that others look at, or that somebody has made."""
        self._is_busy = False
        if isinstance(found, str):
            self._refuse(found)
            return
        n_others, is_kept = self._n_viewers() - 1, self._folder is not None
        kept_words = "which is kept, and can be resumed later" if is_kept else "which is not kept"
        begin = partial(self._begin, found)
        what = contents_in_words(contents_of(found))
        if n_others > 0:
            text = f"the session on the board, {kept_words}. To be opened: {what}"
            confirm_for_all(self._client, n_others, "Open", text, begin)
        elif self._has_begun() and not (is_sure and is_kept):
            text = f"{what} It takes the place of the session on the board, {kept_words}."
            confirm(self._client, "Open this session?", text, ("Open", "No"), begin)
        else:
            begin()

    def _has_begun(self) -> bool:
        status = self._session.status
        return status.snapshot.step > 0 or len(status.lines) > 1

    def _begin(self, written: Written) -> None:
        if self._is_busy:
            return
        self._is_busy = True
        tell(self._client, "Opening", "The session is being made again …", auto_close_seconds=60.0)
        make = partial(self._freed_by, _made, written, self._session, self._folder)
        then = partial(self._tell, written)
        take_up(self._client, self._session, self._submit, self._work, make, then)

    def _freed_by(self, make: Callable[..., Made], *args: Any) -> Made:
        """What is made, in another thread; if that fails the page is told, and may try another."""
        try:
            return make(*args)
        except BaseException:
            self._is_busy = False
            raise

    def _tell(self, written: Written, found: Taken | str) -> None:
        self._is_busy = False
        if isinstance(found, str):
            self._refuse(found)
            return
        contents = contents_of(written)
        verdict = verdict_in_words(found.remade, contents)
        torn = " Its last record is torn, and left out." if written.is_torn else ""
        sentences = [contents_in_words(contents), f"{verdict}{torn}"]
        self._say(f"Opened: {' '.join(sentences)}")
        if found.remade.differ:
            tell(self._client, "Opened", "Not as it was recorded.", auto_close_seconds=_SHOWN_S)
            self._show("Opened, and not as it was recorded", sentences)
        else:
            tell(self._client, "Opened", " ".join(sentences), auto_close_seconds=_SHOWN_S)

    def _refuse(self, reason: str) -> None:
        tell(self._client, "Not opened", "Nothing has changed.", color="red")
        self._show("This session cannot be opened; nothing has changed", [reason])

    def _show(self, title: str, sentences: list[str]) -> None:
        style = "margin:0 0 0.7em;padding:0 0.7em;overflow-wrap:anywhere"
        modal = open_modal(self._client, title)
        with modal:
            lines = [element("p", sentence, style=style) for sentence in sentences]
            self._client.gui.add_html(str(joined(lines)))
            close = self._client.gui.add_button("Close", color=CALM)
        close.on_click(Intent(lambda _, __: close_modal(modal)))


def _read(read: Read) -> Written | str:
    try:
        return read()
    except SessionError as error:
        return for_terminal(str(error))


def _made(
    written: Written, session: Session, folder: Path | None, first_number: int
) -> Taken | str:
    """A session made again, with a journal of its own; or why that cannot be."""
    try:
        remade = made_again(
            written,
            session.budget,
            name_of,
            first_number,
            on_step=lambda _: check_there(session),
            most_steps=MOST_STEPS,
        )
    except SessionError as error:
        return for_terminal(str(error))
    if folder is None:
        return Taken(remade, None, is_shared=True)
    run = remade.made.family.held.run
    journal = kept.begun(folder, remade.made.family.preset, run.seed)
    journal.begin_with(remade.records)
    return Taken(remade, journal, is_shared=True)
