"""Curves of runs side by side: one axis of steps, and lines that nobody can take for each other."""

import json

import numpy as np

from app.charts.race import curves_sent, looks_of
from app.live.snapshot import Snapshot, take
from learners.run import Run
from tests.support.races import small

FOUR = ("standard_q", "hierarchical_3", "timed", "hierarchical_2")


def test_no_two_lines_look_alike_without_their_colours() -> None:
    for presets in (FOUR, ("timed",) * 4, ("timed", "mine.yaml", "timed")):
        looks = looks_of(presets)
        told = {(look["width"], *look["dashes"]) for look in looks}
        assert len(told) == len({look["light"] for look in looks}) == len(presets)
        assert all(look["dark"] for look in looks)


def test_all_curves_lie_along_the_axis_of_the_run_that_has_come_farthest() -> None:
    shots: list[Snapshot] = []
    for preset, steps in (("timed", 6_000), ("standard_q", 2_000)):
        run = Run(small(preset, "trials=4000"), 3)
        run.advance(steps)
        shots.append(take(run, preset, 1))
    sent = curves_sent(shots)
    assert json.loads(json.dumps(sent)) == sent
    assert sent["axis"]["unit"] == "steps"
    assert sent["axis"]["end"] >= 6_000
    ends = [max(curve["at"]) * sent["axis"]["end"] for curve in sent["curves"]]
    np.testing.assert_allclose(ends, [6_000, 2_000], rtol=0.01)
    low, high = sent["rewards"]
    for curve in sent["curves"]:
        assert len(curve["at"]) == len(curve["reward"])
        assert all(low <= reward <= high for reward in curve["reward"])


def test_runs_that_have_done_nothing_have_no_curve() -> None:
    shot = take(Run(small("timed"), 3), "timed", 1)
    sent = curves_sent([shot, shot])
    assert [curve["at"] for curve in sent["curves"]] == [[], []]
