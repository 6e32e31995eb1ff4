"""What is sent of a board, expanded as a page does it, is what the layer paints."""

import base64
import functools
import json
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.documents import presets
from app.live import snapshot
from app.live.snapshot import Snapshot
from app.page.success import success_of
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import ALL, FOLDED, OF_TRIAL, Look
from app.picture.multiples import SIDE, all_headings
from app.picture.raster import PATTERNS
from app.picture.theme import DARK, LIGHT
from app.player.boards import board_sent, ground_sent, over_sent, world_sent
from learners.run import Run

FRAMES = (FOLDED, OF_TRIAL, ALL, 0, 5)
PRESETS = {
    "timed": (),
    "standard_q": (),
    "hierarchical_3": ("world.skill_n_directions=16", "world.skill_n_distances=7"),
    "hierarchical_2": ("world.size=61", "world.n_distances=9"),
}


@functools.cache
def moments(preset: str) -> tuple[Snapshot, Snapshot, Extras]:
    """A moment of a run, a later one, and what is shown besides."""
    run = Run(presets.load(preset, [*PRESETS[preset], "trials=2000"]), seed=3)
    run.advance(until_trial=40)
    early = snapshot.take(run, preset, 0)
    run.advance(until_trial=900)
    run.advance(max_steps=7)
    late = snapshot.take(run, preset, 0, early)
    return early, late, Extras(success_of(late, lambda: True), early)


def colours_of(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(-1, 3)


def expanded(sent: dict[str, Any], world: dict[str, Any], side: int) -> np.ndarray:
    """The pixels of a board, ``(board * y * x, 3)``, by what a page is sent and nothing else."""
    plain = colours_of(sent["colours"])
    if sent["by"] == "cell":
        return plain
    size, n_states = world["size"], world["n_states"]
    states = np.frombuffer(base64.b64decode(world["states"]), "<u2").reshape(size, size)
    nearest = (2 * np.arange(side) + 1) * size // (2 * side)
    y, x = (part.ravel() for part in np.meshgrid(nearest, nearest, indexing="ij"))
    patterns = {
        "falling": (x + y) % 4 == 0,
        "rising": (x - y) % 4 == 0,
        "dots": (x % 3 == 1) & (y % 3 == 1),
    }
    found: list[np.ndarray] = []
    for board in range(len(plain) // n_states):
        own = slice(board * n_states, (board + 1) * n_states)
        at = states[y, x]
        pixels = plain[own][at].copy()
        for pattern in PATTERNS[1:]:
            if pattern in sent:
                colours = colours_of(sent[pattern])[own]
                there = (colours != plain[own]).any(axis=1)[at] & patterns[pattern]
                pixels[there] = colours[at[there]]
        found.append(pixels)
    return np.concatenate(found)


@pytest.mark.parametrize("key", LAYERS)
@settings(deadline=None, max_examples=40, suppress_health_check=list(HealthCheck))
@given(
    preset=st.sampled_from(sorted(PRESETS)),
    is_late=st.booleans(),
    theme=st.sampled_from([LIGHT, DARK]),
    frame=st.sampled_from(FRAMES),
    option=st.integers(0, 9),
    scale=st.sampled_from(["steps", "linear"]),
    fitted=st.booleans(),
    flight=st.booleans(),
)
def test_what_is_sent_is_what_is_painted(key: str, preset: str, is_late: bool, **how: Any) -> None:
    early, late, extras = moments(preset)
    moment, layer = (late if is_late else early), LAYERS[key]
    look = layer.heeded(Look(layer=key, **how), moment.spec.learner)
    if look.frame == ALL:
        painted, side = all_headings(moment, look, layer, extras), SIDE
    else:
        painted, side = layer.paint(moment, look, extras), moment.spec.world.size
    sent = json.loads(json.dumps(board_sent(moment, look, extras)))
    world = json.loads(json.dumps(world_sent(moment.spec.world)))
    assert sent["world"] == world["key"]
    np.testing.assert_array_equal(expanded(sent, world, side), painted.colours)
    assert sent["tiles"] == (look.frame == ALL)
    parts = ground_sent(moment, look, extras) | over_sent(moment, look, extras)
    assert parts == board_sent(moment, look, extras)
