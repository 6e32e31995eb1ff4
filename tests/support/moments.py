"""A moment of a run, as a page in a real browser shows it."""

from typing import Any

import numpy as np
from playwright.sync_api import expect

from app.live.snapshot import Snapshot
from app.picture.look import Look
from app.player.hunts import placed
from tests.support.live import LiveLab
from tests.support.screen import Screen

_POINTS = """name => {
    const node = window.__viserSceneTree.getState()[name];
    return Array.from(node.message.props.points);
}"""
_MOMENT = """async () => {
    const { state } = await import(new URL("../../web/time/state.js", location.href));
    return state.moment;
}"""


def moment_of(screen: Screen) -> dict[str, Any]:
    """Where the bar says that the page is."""
    found: dict[str, Any] = screen.time_page.evaluate(_MOMENT)
    return found


def expect_moment(live: LiveLab, screen: Screen, shot: Snapshot) -> None:
    """Wait until the page shows a moment: board, sentence, reading, predator and playhead."""
    screen.expect_cell_colours(live.colours(moment=shot))
    expect(screen.reading("Trial")).to_have_text(f"{shot.trial:,}")
    here = placed(shot.world, shot.spec.world, Look(), np.array([shot.cell]), shot.heading, shown=0)
    if shot.trial_step:
        points = np.array(screen.page.evaluate(_POINTS, "/board/predator")).reshape(-1, 3)
        np.testing.assert_allclose(points[0, :2], here[0], atol=1e-4)
    screen.expect_place("step", shot.step)
    assert moment_of(screen)["trial"] == shot.trial
