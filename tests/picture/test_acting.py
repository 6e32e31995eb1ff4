"""Where an exploration by context acts, over what is shown."""

import numpy as np
import pytest

from app.picture import acting
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.picture.theme import LIGHT
from app.player.boards import board_sent
from learners.commands import Explore, Introduce
from learners.run import Run
from tests.support.schedules import ruled_spec, seen, to

NOTHING = Extras()


def exploring(value_at_most: float | None = 1.0) -> Run:
    """Circling has joined by hand and is explored."""
    run = to(Run(ruled_spec("schedule.episodes=[]"), seed=5), 300)
    run.apply(Introduce("circle_clockwise", 0))
    run.apply(Explore("circle_clockwise", 100, 0.9, value_at_most))
    return to(run, 350)


def test_it_acts_where_all_others_are_worth_little() -> None:
    shot = seen(exploring())
    acts = acting.acts_in(shot, acting.by_context(shot))
    approach = shot.spec.learner.skills.index("approach")
    np.testing.assert_array_equal(acts, shot.selection_q[..., approach] <= 1.0)
    assert acts.any()
    assert not acts.all()


def test_a_skill_that_is_alone_is_explored_everywhere() -> None:
    run = Run(ruled_spec("schedule.episodes=[]"), seed=5)
    to(run, 1).apply(Explore("approach", 100, 0.9, 1.0))
    shot = seen(run)
    assert acting.acts_in(shot, acting.by_context(shot)).all()


@pytest.mark.parametrize(
    "key", ["value", "option", "chosen", "advantage", "visits", "reach", "now"]
)
@pytest.mark.parametrize("frame", [Look().frame, 3])
def test_each_layer_of_what_is_known_shows_it(key: str, frame: int) -> None:
    look = Look(layer=key, frame=frame)
    layer, shot = LAYERS[key], seen(exploring())
    anywhere = seen(exploring(None))
    hatch = layer.paint(shot, look, NOTHING)
    colours = {edge.colour for edge in hatch.edges()}
    assert LIGHT.forced in colours
    assert "forced exploration acts here" in layer.legend(shot, look, NOTHING)
    said = "Hatched: where nothing else is worth more than 1, circle clockwise is explored."
    assert layer.caption(shot, look, NOTHING).endswith(said)
    # Where it acts everywhere, there is nothing to be shown.
    plain = layer.paint(anywhere, look, NOTHING)
    assert LIGHT.forced not in {edge.colour for edge in plain.edges()}
    assert "acts here" not in layer.legend(anywhere, look, NOTHING)


def test_it_is_over_on_the_board_once_it_is_over() -> None:
    shot = seen(to(exploring(), 400))
    assert acting.by_context(shot) == []
    assert "Hatched" not in LAYERS["value"].caption(shot, Look(), NOTHING)


def test_light_pages_have_the_hatch_and_the_line() -> None:
    sent = board_sent(seen(exploring()), Look(), NOTHING)
    without = board_sent(seen(exploring(None)), Look(), NOTHING)
    assert "falling" in sent
    assert "falling" not in without
    lines = {line["colour"] for line in sent["lines"]}
    assert lines > {line["colour"] for line in without["lines"]}
