"""Pictures and films of what is seen: board, legend, sentence and step."""

import io
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from app.live.snapshot import Snapshot, take
from app.page.success import success_of
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import ALL, FOLDED, Look
from app.picture.theme import DARK, LIGHT
from app.player import images
from app.player.boards import board_sent, world_sent
from app.player.sketch import colours_on
from tests.support.replays import fewer_moments, small_recorded

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def snapshot() -> Snapshot:
    recorded = small_recorded()
    run = recorded.pasts[0].run_at(recorded.live.until_step // 2)
    assert run is not None
    return take(run, "timed", 0)


@pytest.mark.parametrize("key", LAYERS)
@pytest.mark.parametrize("frame", [FOLDED, ALL, 3])
def test_a_picture_has_the_colours_that_the_layer_paints(
    snapshot: Snapshot, key: str, frame: int
) -> None:
    layer = LAYERS[key]
    extras = Extras(success_of(snapshot, lambda: True), snapshot)
    look = layer.heeded(Look(DARK, key, frame=frame), snapshot.spec.learner)
    if look.frame == ALL:
        return
    board = board_sent(snapshot, look, extras)
    world = world_sent(snapshot.spec.world)
    found = colours_on(board, world, world["size"]).reshape(-1, 3)
    assert np.array_equal(found, layer.paint(snapshot, look, extras).colours)


@pytest.mark.parametrize("key", LAYERS)
@pytest.mark.parametrize("theme", [LIGHT, DARK])
@pytest.mark.parametrize("frame", [FOLDED, ALL])
def test_an_svg_has_the_words_that_are_read_beside_the_board(
    snapshot: Snapshot, key: str, theme: object, frame: int
) -> None:
    look = Look(DARK if theme is DARK else LIGHT, key, frame=frame)
    picture = images.picture_of(snapshot, look)
    root = ET.fromstring(images.svg_file(picture, images.page_colour(look)))
    words = " ".join(node.text or "" for node in root.iter(f"{SVG}text"))
    assert f"Trial {snapshot.trial:,}, step {snapshot.step:,}" in words
    assert LAYERS[key].title in words
    caption = LAYERS[key].caption(
        snapshot, LAYERS[key].heeded(look, snapshot.spec.learner), Extras()
    )
    for word in caption.split():
        assert word in words
    assert "predator" in words
    # Nothing is written beyond the edge.
    for node in root.iter(f"{SVG}text"):
        assert 0 <= float(node.attrib["x"]) <= picture.wide
        assert 0 < float(node.attrib["y"]) <= picture.high


def test_a_png_is_the_picture_twice_as_fine(snapshot: Snapshot) -> None:
    picture = images.picture_of(snapshot, Look())
    png = Image.open(io.BytesIO(images.png_of(picture, images.page_colour(Look()))))
    assert png.size == (2 * picture.wide, 2 * picture.high)
    pixels = np.asarray(png.convert("RGB"))
    assert (pixels[0, 0] == 255).all()
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 20


def test_a_gif_has_a_picture_for_each_moment_and_rests_at_its_end() -> None:
    recorded = small_recorded()
    with fewer_moments():
        frames = list(images.film_pictures(recorded, 0, Look()))
    assert len({frame.shape for frame in frames}) == 1
    gif = Image.open(io.BytesIO(images.gif_of(frames[::20], 0.1)))
    n_frames = getattr(gif, "n_frames", 1)
    assert n_frames >= len(frames[::20]) - 1
    gif.seek(n_frames - 1)
    assert gif.info["duration"] >= 3_000


def test_where_there_is_no_ffmpeg_a_film_in_mp4_says_what_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    import imageio.v2 as imageio

    def refuse(*_: object, **__: object) -> None:
        raise ImportError("no ffmpeg")

    monkeypatch.setattr(imageio, "get_writer", refuse)
    with pytest.raises(images.MissingError, match="pip install imageio-ffmpeg"):
        images.mp4_of([np.zeros((4, 4, 3), np.uint8)], 0.1)
