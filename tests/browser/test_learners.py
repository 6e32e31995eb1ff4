"""In a real browser: a learner in which a rule selects, from the list of layers to its weights."""

import pytest
from playwright.sync_api import expect

from app.documents import presets
from app.picture.layers import LAYERS
from app.picture.look import Look
from tests.support.live import LiveLab
from tests.support.screen import OpenPage, StartLab

TRIAL = 300


@pytest.fixture
def lab(start_lab: StartLab) -> LiveLab:
    spec = presets.load("static_appetite_fear", ["world.size=30", "trials=2000"])
    return start_lab(spec, trial=TRIAL)


def test_a_learner_with_a_rule_is_shown_as_what_it_is(lab: LiveLab, open_page: OpenPage) -> None:
    screen = open_page(lab)
    expect(screen.headline).to_contain_text("No table selects: each move is the one")
    expect(screen.headline).to_contain_text("They agree")
    expect(screen.legend).to_contain_text("Own reward that a skill expects")
    screen.choose("Layer", "Who decides")
    expect(screen.legend).to_contain_text("fear decides")
    screen.expect_cell_colours(lab.colours(Look(layer="chosen")))
    # What makes no sense is in the list with the reason, and says why.
    learner = lab.session.status.snapshot.spec.learner
    listed = LAYERS["traces"].listed(learner)
    assert listed == "Eligibility now (nothing is kept)"
    screen.choose("Layer", listed)
    assert screen.reads("no earlier move has a trace")
    screen.turn_to("Steer")
    screen.choose("Weight of", "fear")
    screen.fill("Weight as a number", 3)
    lab.wait_for(lambda status: status.snapshot.spec.learner.weights.get("fear") == 3.0)
    assert screen.reads("Weight of fear = 3 at trial 300")
