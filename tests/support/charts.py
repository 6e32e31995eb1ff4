"""Charts of results that tests make, and what is to be seen in them."""

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from app.analysis.estimates import Axis, Band, Estimate, Windows
from app.charts import live
from app.charts.live import LiveChart
from app.charts.page.svg import Frame
from app.charts.view import View
from app.documents.experiments import Experiment
from app.metrics import Metric
from app.results.gather import Curve, PlacedRun
from tests.support.runs import NOTHING, address, gathering_of, reward

WIDTH = 684


def estimates_of(experiment: Experiment, runs: Sequence[PlacedRun]) -> list[Estimate]:
    """Means with intervals of a sort."""
    found = []
    for place in range(len(experiment.variants)):
        values = [reward(r) for r in runs if r[0] == place and not math.isnan(reward(r))]
        mean = float(np.mean(values)) if values else NOTHING
        ends = (min(values), max(values)) if len(values) > 1 else (NOTHING, NOTHING)
        found.append(Estimate(mean, *ends, len(values)))
    return found


NO_BAND = Band(*(np.zeros(0, kind) for kind in (np.int64, np.int64, *3 * [np.float64], np.int64)))


class Averages:
    """What a gatherer knows of averages, as a test says."""

    def __init__(self, found: Sequence[Estimate], curves: Sequence[Curve] = ()) -> None:
        self._found = found
        self._curves = {curve.variant: curve for curve in curves}

    def estimate(self, place: int, metric: Metric | None = None) -> Estimate:
        """The mean of a variant."""
        return self._found[place]

    def width(self, axis: Axis, windows: Windows = "steps") -> int:
        """Of a window."""
        return 500

    def curve(self, place: int, axis: Axis, windows: Windows = "steps") -> Curve:
        """The curve of a variant; empty unless there is one."""
        return self._curves.get(place, Curve(place, 0, NO_BAND, ()))


def chart_of(
    experiment: Experiment, runs: Sequence[PlacedRun], view: View, curves: Sequence[Curve] = ()
) -> tuple[LiveChart, Frame]:
    """The chart of these runs with intervals of a sort, and what it is drawn for."""
    gathering = gathering_of(experiment, runs)
    averages: Any = Averages(estimates_of(experiment, runs), curves)
    chart = live.chart_of(averages, gathering, view)
    note = live.left_out(gathering, chart)
    return chart, Frame(address, WIDTH, view.variant, note=note)


def points_of(path: str) -> list[tuple[float, float]]:
    """Corners of a path of absolute lines."""
    return [(float(x), float(y)) for x, y in re.findall(r"[ML](-?[\d.]+) (-?[\d.]+)", path)]


def luminance(colour: str) -> float:
    """Of a colour, from 0 to 1."""
    rgb = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))
