"""What is seen of a moment as a picture for slides and papers: board, legend, sentence and step."""

import io
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple, cast

import numpy as np
from PIL import Image

from app.explain import sentence
from app.live.snapshot import Snapshot
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.player.boards import board_sent, described, world_sent
from app.player.legends import legend_shapes
from app.player.reel import Recorded, Tell, snapshots_at, stops_along
from app.player.shapes import Picture, Shape, Words, painted, svg_of, wrapped
from app.player.sketch import sketch

_MARGIN: Final = 24
_LARGE, _PLAIN, _SMALL = 22.0, 16.0, 14.0
_LEADING: Final = 1.35
_LIGHT_PAGE, _DARK_PAGE = "rgb(255,255,255)", "rgb(20,20,20)"
_QUIET_ON_LIGHT, _QUIET_ON_DARK = "rgb(73,80,87)", "rgb(184,184,184)"


class Size(NamedTuple):
    """How large a picture is: its board, and what stands to the right of it."""

    board: int = 620
    beside: int = 400


SLIDE: Final = Size()
SMALL: Final = Size(440, 330)
"""Of films, each picture of which takes room."""
FILM_MOMENTS: Final = 150
_GIF_COLOURS: Final = 192
FILM_MOMENT_S: Final = 0.12


class MissingError(Exception):
    """Something that a kind of file takes is not there; the message says what."""


def picture_of(
    snapshot: Snapshot,
    look: Look,
    extras: Extras | None = None,
    size: Size = SLIDE,
    rests: bool = False,
) -> Picture:
    """A moment as it is seen.

    Args:
        snapshot: the moment.
        look: how it is seen.
        extras: what the layer shows besides.
        size: of the picture.
        rests: whether the learner stands still.
    """
    extras = extras or Extras()
    board = board_sent(snapshot, look, extras, rests=rests)
    layer = LAYERS[look.layer]
    said = sentence.said_of(snapshot).striptags()
    scale = size.board / SLIDE.board
    left = 2 * _MARGIN + size.board
    writer = _Writer(left, size.beside, _MARGIN, board["theme"], scale)
    writer.write(f"{snapshot.preset}, seed {snapshot.seed}", _LARGE, is_bold=True)
    writer.write(f"Trial {snapshot.trial:,}, step {snapshot.step:,}", _PLAIN)
    writer.skip(8)
    writer.write(said, _PLAIN)
    writer.skip(12)
    writer.write(layer.title_of(snapshot.spec.learner), _PLAIN, is_bold=True)
    writer.write(layer.caption(snapshot, look, extras), _SMALL, is_quiet=True)
    writer.skip(6)
    writer.legend(str(layer.legend(snapshot, look, extras)))
    shapes: list[Shape] = [
        *sketch(board, world_sent(snapshot.spec.world), _MARGIN, _MARGIN, size.board),
        *writer.shapes,
    ]
    wide, high = left + size.beside + _MARGIN, size.board + 2 * _MARGIN
    # Films of most codecs have an even number of pixels along each side.
    high = max(high, int(writer.y) + _MARGIN)
    about = f"{described(snapshot, look)} {said}"
    return Picture(wide + wide % 2, high + high % 2, tuple(shapes), about)


class _Writer:
    """Writes one thing below the other."""

    def __init__(
        self, x: float, wide: float, y: float, theme: Mapping[str, Any], scale: float
    ) -> None:
        self._x, self._wide, self.y = x, wide, y
        self._ink = str(theme["ink"])
        self._quiet = _QUIET_ON_DARK if theme["dark"] else _QUIET_ON_LIGHT
        self._scale = scale
        self.shapes: list[Shape] = []

    def write(self, text: str, size: float, is_bold: bool = False, is_quiet: bool = False) -> None:
        size *= self._scale
        for line in wrapped(text, size, self._wide):
            self.y += _LEADING * size
            ink = self._quiet if is_quiet else self._ink
            self.shapes.append(
                Words(self._x, self.y - 0.3 * size, line, size, ink, is_bold=is_bold)
            )

    def skip(self, pixels: float) -> None:
        self.y += pixels * self._scale

    def legend(self, html: str) -> None:
        inks = self._ink, self._quiet
        found, high = legend_shapes(html, self._x, self.y, self._wide, _SMALL * self._scale, inks)
        self.shapes += found
        self.y += high


def page_colour(look: Look) -> str:
    """The ground on which a look's pictures stand."""
    return _DARK_PAGE if look.theme.is_dark else _LIGHT_PAGE


# --- Files ---------------------------------------------------------------------------------------


def png_of(picture: Picture, ground: str) -> bytes:
    """The picture as pixels, twice as many along each side as it says, for screens and slides."""
    buffer = io.BytesIO()
    Image.fromarray(painted(picture, ground, scale=2)).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def svg_file(picture: Picture, ground: str) -> bytes:
    """The picture as a file that is as sharp at any size."""
    whole = svg_of(picture, ground)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{whole}\n'.encode()


WriteFilm = Callable[[Iterable[np.ndarray], float], bytes]
"""Makes a file of pictures, each of which is seen for so many seconds."""


def film_pictures(
    recorded: Recorded,
    line: int,
    look: Look,
    tell: Tell = lambda _, __: None,
    extras: Extras | None = None,
) -> Iterator[np.ndarray]:
    """The moments of a line from its beginning, each as pixels ``(row, column, 3) uint8``."""
    stops = stops_along(recorded, line, FILM_MOMENTS, tell)
    ground, high = page_colour(look), 0
    for number, snapshot in enumerate(snapshots_at(recorded, stops)):
        picture = picture_of(snapshot, look, extras, SMALL)
        # The text may be long at one moment and short at another.
        high = high or picture.high
        yield painted(picture._replace(high=high), ground)
        tell("Pictures are painted", number / len(stops))


def gif_of(frames: Iterable[np.ndarray], seconds: float) -> bytes:
    """Pictures ``(row, column, 3) uint8`` of one size as a film, each for so many seconds.

    The last one stays for a while before it begins anew.
    """
    found = list(frames)
    some = np.concatenate([found[round(n * (len(found) - 1) / 7)] for n in range(8)])
    colours = Image.fromarray(some).quantize(_GIF_COLOURS)
    # With the same colours in all, and none mixed of others, of each but what changes is written.
    images = [
        Image.fromarray(frame).quantize(palette=colours, dither=Image.Dither.NONE)
        for frame in found
    ]
    each = max(round(1000 * seconds), 20)
    times = [*([each] * (len(images) - 1)), 3_000]
    buffer = io.BytesIO()
    images[0].save(
        buffer,
        "GIF",
        save_all=True,
        append_images=images[1:],
        duration=times,
        loop=0,
        optimize=False,
    )
    return buffer.getvalue()


def mp4_of(frames: Iterable[np.ndarray], seconds: float) -> bytes:
    """The same as a film in MP4.

    Raises:
        MissingError: imageio has no ffmpeg here.
    """
    import imageio.v2 as imageio

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        try:
            writer = cast(Any, imageio).get_writer(
                path, format="FFMPEG", fps=1 / seconds, codec="libx264", macro_block_size=2
            )
        except (ImportError, ValueError, RuntimeError) as error:
            raise MissingError(
                "a film in MP4 takes ffmpeg, which imageio does not have here; pip install"
                " imageio-ffmpeg brings it, and --gif needs nothing"
            ) from error
        with writer:
            for frame in frames:
                writer.append_data(frame)
        return path.read_bytes()
