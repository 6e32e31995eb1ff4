"""Learning curves of runs that stand side by side, along one axis of steps: data for scripts.

Who is who is told by colours, widths and dashes together, those of the thesis's figures where the
runs are its learners (:mod:`app.charts.styles`), so that nobody needs to tell colours apart.
"""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from app.charts.bar.axis import axis_of
from app.charts.bar.model import learned_of
from app.charts.page.colours import colour_of, shades_of
from app.charts.styles import styles_of
from app.live.snapshot import Snapshot
from app.words.numbers import labelled_ticks

_MOST_REWARDS: Final = 4
_LEAST_WIDTH: Final = 1.6

Sent = dict[str, Any]
"""What JSON calls an object."""


def looks_of(presets: Sequence[str]) -> list[Sent]:
    """How the line of each run is drawn: ``{"light", "dark", "width", "dashes"}``.

    Args:
        presets: names of the runs' presets, in order.
    """
    looks: list[Sent] = []
    for style in styles_of(presets):
        light, dark = shades_of(style.colour)
        if colour_of(style) == "currentColor":
            light = dark = "currentColor"
        width = max(style.width, _LEAST_WIDTH)
        dashes = [round(length * width, 2) for length in style.dashes]
        looks.append({"light": light, "dark": dark, "width": width, "dashes": dashes})
    return looks


def curves_sent(snapshots: Sequence[Snapshot]) -> Sent:
    """The curves as far as they are known: ``{"axis", "rewards", "levels", "curves"}``.

    The axis is that of the run that has come farthest. Places along it are shares of it.

    Args:
        snapshots: the newest of each run.
    """
    axis = axis_of(max(snapshots, key=lambda one: one.step), "steps")
    ends = [
        end
        for one in snapshots
        for end in (one.spec.world.flight_reward, one.spec.world.capture_reward)
    ]
    low, high = min(*ends, 0.0), max(*ends, 1.0)
    return {
        "axis": {
            "unit": "steps",
            "end": axis.end,
            "trials": [0],
            "steps": [0],
            "pace": 1.0,
            "ticks": [{"at": round(tick.at, 5), "text": tick.text} for tick in axis.ticks],
        },
        "rewards": [low, high],
        "levels": [list(tick) for tick in labelled_ticks(low, high, _MOST_REWARDS)],
        "curves": [_points(*learned_of(one, axis)) for one in snapshots],
    }


def _points(at: np.ndarray, reward: np.ndarray) -> Sent:
    return {
        "at": [round(share, 5) for share in at.tolist()],
        "reward": [round(mean, 2) for mean in reward.tolist()],
    }
