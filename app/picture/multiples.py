"""All headings at once: a layer for each of them, in one small picture."""

import base64
import functools
import io

import numpy as np
from markupsafe import Markup
from PIL import Image

from app.live.snapshot import Snapshot
from app.picture.layer import Extras, Layer
from app.picture.look import Look
from app.picture.raster import raster
from app.util.html import element
from app.words.plain import HEADING_NAMES
from sim import geometry
from sim.spec import N_HEADINGS

TILE = 75
"""Pixels along each side of one of the eight small pictures."""
_TILES_PER_ROW = 4


def all_headings_png(snapshot: Snapshot, look: Look, layer: Layer, extras: Extras) -> bytes:
    """A layer for each heading by itself, four to a row from east on counter-clockwise, as a PNG.

    North is up in each; a mark shows where the prey looks.
    """
    small = raster(snapshot.spec.world, TILE)
    theme = look.theme
    n_rows = N_HEADINGS // _TILES_PER_ROW
    pitch = TILE + 1
    image = np.empty((n_rows * pitch - 1, _TILES_PER_ROW * pitch - 1, 3), np.uint8)
    image[:] = theme.border
    mark = _marks()
    for heading in range(N_HEADINGS):
        picture = layer.draw(snapshot, look._replace(frame=heading), extras, small)
        tile = picture.colours.reshape(TILE, TILE, 3)
        rows, columns = mark[heading]
        tile[rows, columns] = theme.prey
        top, left = heading // _TILES_PER_ROW * pitch, heading % _TILES_PER_ROW * pitch
        image[top : top + TILE, left : left + TILE] = tile[::-1]
    return png(image)


@functools.cache
def _marks() -> list[tuple[np.ndarray, np.ndarray]]:
    """For each heading the rows and columns of a dot with a line the way the prey looks."""
    middle, reach = TILE // 2, 9
    marks = []
    for east, north in geometry.HEADINGS:
        length = np.arange(round(reach / np.hypot(east, north)) + 1)
        rows = np.concatenate([np.repeat([-1, 0, 1], 3), north * length])
        columns = np.concatenate([np.tile([-1, 0, 1], 3), east * length])
        marks.append((middle + rows, middle + columns))
    return marks


def small_multiples_html(png: bytes) -> Markup:
    """The eight small pictures as wide as the panel, with what they are."""
    data = base64.b64encode(png).decode("ascii")
    names = ", ".join(HEADING_NAMES)
    shown = Markup(
        f'<img src="data:image/png;base64,{data}" alt="The layer for each heading: {names}"'
        ' style="width:100%;display:block;image-rendering:pixelated">'
    )
    note = "Each heading by itself, north up; the mark shows where the prey looks."
    content = shown + element("div", note, style="opacity:0.7")
    return element("div", content, style="padding:0 0.7em;font-size:0.8em;line-height:1.5")


def png(image: np.ndarray) -> bytes:
    """A PNG file with a palette.

    Where an image has more than 256 colours, those that differ least become one.

    Args:
        image: ``(row, column, 3) uint8``, the first row on top.
    """
    index, colours = _with_palette(image)
    shown = Image.fromarray(index)
    shown.putpalette(colours.tobytes())
    file = io.BytesIO()
    shown.save(file, "PNG")
    return file.getvalue()


def _with_palette(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """An image as indices ``(row, column) uint8`` into colours ``(index, 3) uint8``."""
    for bits in (5, 4, 2):
        kept = (image >> (8 - bits)).astype(np.int32)
        code = (kept[..., 0] << 2 * bits) | (kept[..., 1] << bits) | kept[..., 2]
        met = np.zeros(1 << 3 * bits, bool)
        met[code] = True
        colours_met = np.flatnonzero(met)
        if len(colours_met) <= 256:
            break
    place = np.zeros(met.size, np.uint8)
    place[colours_met] = np.arange(len(colours_met))
    index = place[code]
    colours = np.zeros((len(colours_met), 3), np.uint8)
    colours[index] = image
    return index, colours
