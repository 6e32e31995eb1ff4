"""What a browser can take away on the *File* tab: the replay page, pictures and films."""

import re
import threading
from collections.abc import Callable
from typing import Final, NamedTuple

import viser

from app.live.session import Session
from app.live.snapshot import Snapshot
from app.page.inbox import Intent, Work, check_there
from app.page.widgets import CALM, NOTE, add_hints, assign
from app.picture.layer import Extras
from app.picture.look import Look
from app.player import images
from app.player.reel import recorded_status
from app.player.replay_page import ReplayError, replay_page
from app.util.html import element

_MAKING: Final = threading.Lock()
"""One at a time: it takes a core for a while, which the learner and other pages need."""
_BUSY: Final = "Something else is being written; try again when that is there."


class Seen(NamedTuple):
    """What is on a browser's board."""

    snapshot: Snapshot
    look: Look
    extras: Extras
    line: int
    """That it looks at."""


class Export:
    """The folder of buttons, in the container that is current."""

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        seen: Callable[[], Seen],
        work: Work,
    ) -> None:
        """``seen`` tells what is on the board; ``work`` has something made in another thread."""
        self._client, self._session, self._seen, self._work = client, session, seen, work
        gui = client.gui
        with gui.add_folder("Export"):
            # Above the buttons: what is below them may be out of sight while one waits.
            self._said = gui.add_html("")
            replay = gui.add_button(
                "Replay page",
                icon=viser.Icon.PLAYER_PLAY,
                color=CALM,
                hint="One file, below 1 MB, in which this session plays without the lab and without"
                " a network: board, curve, timeline and sentence. It takes about a minute.",
            )
            png = gui.add_button(
                "Picture (PNG)",
                icon=viser.Icon.PHOTO,
                color=CALM,
                hint="What you see, with legend, sentence and step, for a slide.",
            )
            svg = gui.add_button(
                "Picture (SVG)",
                icon=viser.Icon.VECTOR,
                color=CALM,
                hint="The same for print, as sharp at any size.",
            )
            gif = gui.add_button(
                "Film (GIF)",
                icon=viser.Icon.GIF,
                color=CALM,
                hint="The line that you look at from its beginning, as you see it now, in some"
                " 20 s; it takes a while.",
            )
            mp4 = gui.add_button(
                "Film (MP4)",
                icon=viser.Icon.MOVIE,
                color=CALM,
                hint="The same, in a file that is smaller. It needs the package imageio-ffmpeg.",
            )
        add_hints(gui, replay, png, svg, gif, mp4)
        replay.on_click(Intent(lambda _, __: self._make("html", self._replay)))
        png.on_click(Intent(lambda _, __: self._make("png", self._picture(images.png_of))))
        svg.on_click(Intent(lambda _, __: self._make("svg", self._picture(images.svg_file))))
        gif.on_click(Intent(lambda _, __: self._make("gif", self._film(images.gif_of))))
        mp4.on_click(Intent(lambda _, __: self._make("mp4", self._film(images.mp4_of))))

    def _make(self, kind: str, make: Callable[[Seen], bytes]) -> None:
        """Have a file made of what is seen now, and download it; or say why there is none."""
        seen = self._seen()
        self._say(f"The {kind.upper()} file is being written …")

        def one() -> bytes | str:
            if not _MAKING.acquire(blocking=False):
                return _BUSY
            try:
                return make(seen)
            except (images.MissingError, ReplayError) as error:
                return f"There is no such file: {error}."
            finally:
                _MAKING.release()

        def send(found: bytes | str) -> None:
            if isinstance(found, str):
                self._say(found)
                return
            name = f"{_stem(seen.snapshot)}.{kind}"
            self._client.send_file_download(name, found, save_immediately=True)
            self._say(f"{name}, {len(found) / 1e6:.2f} MB.")

        self._work(self._client, one, send)

    def _replay(self, seen: Seen) -> bytes:
        recorded = recorded_status(self._session.status, self._session.past_of)
        return replay_page(recorded, self._go_on).encode()

    def _picture(self, write: Callable[[images.Picture, str], bytes]) -> Callable[[Seen], bytes]:
        def picture(seen: Seen) -> bytes:
            drawn = images.picture_of(seen.snapshot, seen.look, seen.extras)
            return write(drawn, images.page_colour(seen.look))

        return picture

    def _film(self, write: images.WriteFilm) -> Callable[[Seen], bytes]:
        def film(seen: Seen) -> bytes:
            recorded = recorded_status(self._session.status, self._session.past_of)
            frames = images.film_pictures(
                recorded, seen.line, seen.look, self._go_on, extras=seen.extras
            )
            return write(frames, images.FILM_MOMENT_S)

        return film

    def _go_on(self, what: str, share: float) -> None:
        check_there(self._session)

    def _say(self, text: str) -> None:
        assign(self._said, "content", str(element("div", text, style=NOTE)))


def _stem(snapshot: Snapshot) -> str:
    preset = re.sub(r"[^A-Za-z0-9_-]+", "-", snapshot.preset).strip("-") or "run"
    return f"{preset[:64]}-seed{snapshot.seed}-trial{snapshot.trial}"
