"""Draws the README's moving picture: how value spreads, from a run of ``timed``.

``python -m tests.docs.film`` writes ``docs/pictures/spread.gif``; it needs no browser.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from app.documents import presets
from app.live import snapshot
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.picture.raster import raster
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
N_COLOURS = 64


def frames() -> Iterator[Image.Image]:
    """The folded value over the whole board, with the trial and the skills that are there."""
    run = Run(presets.load("timed"), SEED)
    font = ImageFont.load_default(13)
    for trial in (*TRIALS, run.spec.trials):
        run.advance(until_trial=trial)
        seen = snapshot.take(run, "timed", 0)
        pixels = raster(seen.spec.world, SIDE)
        colours = LAYERS["value"].draw(seen, Look(), Extras(), pixels).colours
        board = Image.fromarray(np.flipud(colours.reshape(SIDE, SIDE, 3)))
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
