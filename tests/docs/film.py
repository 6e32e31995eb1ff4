"""Draws the README's moving picture: how value spreads, from a run of ``timed``.

``python -m tests.docs.film`` writes ``docs/pictures/spread.gif``; it needs no browser.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from app.documents import presets
from app.live import snapshot
from app.live.snapshot import Snapshot
from app.picture import outlines
from app.picture.frames import rim
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.picture.outlines import BOARD_UNITS
from app.picture.raster import raster
from app.picture.theme import LIGHT, Colour
from learners.run import Run

FILE = Path(__file__).resolve().parents[2] / "docs" / "pictures" / "spread.gif"
SEED = 3
TRIALS = (
    *range(500, 6_001, 500),
    *range(7_000, 12_001, 1_000),
    *range(12_250, 16_001, 250),
    *range(20_000, 48_000, 4_000),
)
"""When the picture is taken, and then once more at the end; most often while the ring grows."""
FRAME_MS, LAST_MS = 150, 3_000
SIDE = 240
"""Pixels along each side of the board."""
FINER = 3
"""Pixels that are drawn for one, so that lines are smooth."""
N_COLOURS = 64


def drawn(seen: Snapshot) -> Image.Image:
    """The folded value on the round board, with its edge and what the prey sees."""
    world, theme = seen.spec.world, LIGHT
    side = SIDE * FINER
    picture = LAYERS["value"].draw(seen, Look(), Extras(), raster(world, side))
    board = Image.fromarray(np.flipud(picture.colours.reshape(side, side, 3)))
    pen = ImageDraw.Draw(board)
    pixel = side / world.size
    middle = np.array([0.5 + world.size // 2, world.size - 0.5 - world.size // 2]) * pixel

    def line(points: np.ndarray, colour: Colour, width: int) -> None:
        ends = middle + points * [pixel, -pixel]
        pen.line([*map(tuple, ends.tolist())], fill=colour, width=width * FINER)

    for contour in picture.over().contours:
        for part in contour.segments:
            line(part, contour.colour, 2 if contour.is_edge else 1)
    unit = world.size / BOARD_UNITS
    for part in (*outlines.visual_field(world, 0), *outlines.arrow(0)):
        line(part * unit, theme.prey, 2)
    mask = Image.new("L", (side, side), 0)
    reach = rim(world) * pixel
    ImageDraw.Draw(mask).ellipse([*(middle - reach), *(middle + reach)], fill=255)
    white = Image.new("RGB", (side, side), "white")
    white.paste(board, mask=mask)
    return white.resize((SIDE, SIDE), Image.Resampling.LANCZOS)


def frames() -> Iterator[Image.Image]:
    """The folded value over the whole board, with the trial and the skills that are there."""
    run = Run(presets.load("timed"), SEED)
    font = ImageFont.load_default(13)
    for trial in (*TRIALS, run.spec.trials):
        run.advance(until_trial=trial)
        seen = snapshot.take(run, "timed", 0)
        board = drawn(seen)
        frame = Image.new("RGB", (SIDE, SIDE + 40), "white")
        frame.paste(board)
        pen = ImageDraw.Draw(frame)
        skills = [name for name in seen.spec.learner.skills if name in seen.present]
        pen.text((4, SIDE + 3), f"trial {trial:,}", "black", font)
        pen.text((4, SIDE + 20), ", ".join(skills).replace("_", " "), "black", font)
        yield frame


def main() -> None:
    """Draw all frames, in one palette, and write the file."""
    pictures = list(frames())
    # Of early and late ones together, so that all colours are in it.
    palette = Image.fromarray(np.vstack([np.asarray(picture) for picture in pictures[::4]]))
    palette = palette.quantize(N_COLOURS)
    first, *rest = (
        picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures
    )
    durations = [*[FRAME_MS] * len(rest), LAST_MS]
    first.save(FILE, save_all=True, append_images=rest, duration=durations, loop=0, optimize=True)


if __name__ == "__main__":
    main()
