"""Sharing on the *File* tab of one browser: a session as a file or as a link, and one that comes.

What is shared is the line that the browser looks at, or all lines of its tree.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

import viser

from app.live.excerpt import Excerpt
from app.live.session import Session
from app.live.shared import code_of, read_shared
from app.live.status import Status
from app.live.written import SUFFIX, SessionError
from app.page.arrival import Arrival
from app.page.inbox import Intent, StatusOf, Work
from app.page.widgets import CALM, NOTE, add_hints, assign
from app.server.links import address_of_link
from app.util.html import element
from app.words.numbers import counted
from learners.commands import CommandError

_ANYWHERE: Final = "It opens in this lab, for whoever has its token if there is one."
_ONLY_HERE: Final = (
    "You reach this lab at an address of your own machine, so for others the link leads to a lab of"
    " theirs at the same port. To be sure, send the file."
)


class Share:
    """The folder of widgets, in the container that is current."""

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        status_of: StatusOf,
        work: Work,
        arrival: Arrival,
    ) -> None:
        """Offer to share, and to open what others have shared.

        Args:
            client: the browser.
            session: of which something is shared.
            status_of: what the browser looks at.
            work: has something made in another thread.
            arrival: opens what comes.
        """
        self._client = client
        self._session = session
        self._status_of = status_of
        self._work = work
        self._arrival = arrival
        self._n_links = 0
        gui = client.gui
        with gui.add_folder("Share"):
            self._what = gui.add_html("")
            self._all = gui.add_checkbox(
                "All lines",
                False,
                hint="Share the whole tree, with its branches, names and marks, and not only the"
                " line that you look at.",
                visible=False,
            )
            save = gui.add_button(
                "Download session",
                icon=viser.Icon.FILE_EXPORT,
                color=CALM,
                hint="A file of some kB with preset, seed and commands: another pounce makes the"
                " same of them, and compares digests. Open session takes it, and pounce lab FILE.",
            )
            link = gui.add_button(
                "Copy link",
                icon=viser.Icon.LINK,
                color=CALM,
                hint="An address with all of that in it. It opens in the lab that is reached by it;"
                " a token is not in it.",
            )
            self._said = gui.add_html("")
            come = gui.add_upload_button(
                "Open session",
                icon=viser.Icon.FOLDER_OPEN,
                color=CALM,
                mime_type=SUFFIX,
                hint="Take up a session that somebody shared, from its file. The one on the board"
                " is kept.",
            )
        add_hints(gui, save, link, come)
        self._all.on_update(Intent(lambda client, _: self.update(self._status_of(client))))
        save.on_click(Intent(lambda client, _: self._make(client, self._download)))
        link.on_click(Intent(lambda client, _: self._make(client, self._show_link)))
        come.on_upload(Intent(self._take))
        arrival.call_when_told(self._say)
        self.update(session.status)

    def update(self, status: Status) -> None:
        """Say what would be shared now."""
        n_others = len(status.lines) - 1
        assign(self._all, "visible", n_others > 0)
        assign(self._what, "content", str(element("div", self._words(status), style=NOTE)))

    def _words(self, status: Status) -> str:
        n_others = len(status.lines) - 1
        if not n_others:
            return "What is shared: this run from its beginning to now, with its marks."
        if self._all.value:
            return f"What is shared: all {len(status.lines)} lines, with names and marks."
        shown = status.snapshot.generation
        name = next((line.name for line in status.lines if line.number == shown), "this line")
        return (
            f"What is shared: {name}, the line that you look at, from its beginning to its end,"
            f" with its marks. Not in it: {counted(n_others, 'other line')}."
        )

    def _make(self, client: viser.ClientHandle, then: Callable[[Excerpt], object]) -> None:
        """Have the file made, and go on with it; or say why it cannot be shared."""
        line = None if self._all.value else self._status_of(client).snapshot.generation

        def make() -> Excerpt | str:
            try:
                return self._session.excerpt(line)
            except (SessionError, CommandError) as error:
                return f"This cannot be shared: {error}."

        def go_on(found: Excerpt | str) -> None:
            if isinstance(found, str):
                self._say(found)
            else:
                then(found)

        self._work(client, make, go_on)

    def _download(self, found: Excerpt) -> None:
        self._client.send_file_download(found.file_name, found.data, save_immediately=True)
        self._say(f"{found.file_name}, {_size(found)}: {_extent(found)}.")

    def _show_link(self, found: Excerpt) -> None:
        try:
            code = code_of(found.data)
        except SessionError as error:
            self._say(f"There is no link to this: {error}.")
            return
        self._n_links += 1
        link = element("a", "the link", href=address_of_link(code), target="_blank", rel="noopener")
        # The page's script copies it (app/web/share.js), says in the status that it has, and shows
        # one of the two texts: it knows at which address the page was reached.
        status = element("span", "", role="status")
        text = element("span", f" to {_extent(found)}. ")
        where = element("span", _ANYWHERE, **{"data-where": "anywhere"})
        here = element("span", _ONLY_HERE, hidden="", **{"data-where": "here"})
        content = f"{status}{link}{text}{where}{here}"
        copied = f'<div style="{NOTE}" data-copy-link="{self._n_links}">{content}</div>'
        assign(self._said, "content", copied)

    def _take(self, client: viser.ClientHandle, file: viser.UploadedFile) -> None:
        path = Path(Path(file.name.replace("\\", "/")).name or "the file")
        self._arrival.open(partial(read_shared, path, file.content), is_sure=True)

    def _say(self, text: str) -> None:
        assign(self._said, "content", str(element("div", text, style=NOTE)))


def _extent(found: Excerpt) -> str:
    if found.n_lines == 1:
        return f"1 line, up to trial {found.trial:,}"
    return f"{found.n_lines} lines, the live one up to trial {found.trial:,}"


def _size(found: Excerpt) -> str:
    return f"{len(found.data) / 1000:.1f} kB"
