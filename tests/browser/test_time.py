"""The past in a real browser: everything on the page is that of the moment that it looks at."""

import numpy as np
import pytest
from playwright.sync_api import expect

from app.explain.cell import reading_at
from app.explain.cell_html import reading_html
from app.live.requests import Pause, Play, SetSpeed
from app.picture.layer import Extras
from app.picture.look import Look
from learners.commands import SetParameter
from learners.kernel import rows
from learners.run import replay
from tests.support.live import SEED
from tests.support.moments import expect_moment, moment_of
from tests.support.person import words
from tests.support.screen import Begin

LEARNED = 2_000
"""Trials after which there is a cone in the small world."""


def test_the_whole_page_is_that_of_a_moment_while_the_learner_goes_on(begin: Begin) -> None:
    live, screen = begin(trial=LEARNED)
    end = live.session.status.snapshot.step
    live.ask(SetSpeed(2_000.0), Play())
    for step in (end // 3, end - 1_000, 41):
        screen.tell("seek", step=step)
        expect_moment(live, screen, live.stopped_at(step))
        expect(screen.headline).to_contain_text("The past, trial")
    shot = live.stopped_at(end // 3)
    screen.tell("seek", step=shot.step)
    expect_moment(live, screen, shot)
    # West of the prey, where value comes first.
    x, y = shot.world.size // 2 - 4, shot.world.size // 2
    screen.page.mouse.click(*screen.place_of(y * shot.world.size + x))
    # Folded, so that of a prey that looks east.
    read = words(reading_html(reading_at(shot, x, y, 0), Look()).partition("</div>")[0])
    expect(screen.page.get_by_text(read)).to_be_visible()
    screen.page.evaluate("document.activeElement.blur()")
    live.wait_for(lambda status: status.snapshot.step > end)
    live.ask(Pause())
    screen.page.keyboard.press("End")
    now = live.session.status.snapshot
    expect_moment(live, screen, now)
    expect(screen.headline).not_to_contain_text("The past")
    run = replay(now.preset_spec, SEED, [], now.step)
    np.testing.assert_array_equal(rows.best(run.state.selection), now.value.ravel())


def test_a_command_in_the_past_makes_a_branch_and_live_is_as_it_was(begin: Begin) -> None:
    live, screen = begin(trial=LEARNED)
    now = live.session.status.snapshot
    step = now.step // 2
    screen.tell("seek", step=step)
    expect_moment(live, screen, live.stopped_at(step))
    screen.page.keyboard.press("f")
    live.wait_for(lambda status: len(status.lines) == 2)
    expect(screen.headline).to_contain_text("Frozen by hand: the selection")
    frame = screen.page.frame_locator("iframe.pounce-time")
    expect(frame.get_by_text("End goes back to the live run")).to_be_visible()
    screen.expect_place("step", step)
    assert live.session.status.snapshot.control == now.control
    screen.page.keyboard.press("End")
    expect_moment(live, screen, now)
    expect(frame.get_by_text("End goes back to the live run")).to_have_count(0)


def test_a_click_on_first_reach_goes_to_the_moment_at_which_value_came(begin: Begin) -> None:
    live, screen = begin(trial=LEARNED)
    screen.choose("Layer", "First reach")
    now = live.session.status.snapshot
    size = now.spec.world.size
    cell = size * (size // 2) + size // 2 - 3
    screen.expect_cell_colours(live.colours(Look(layer="reach")))
    screen.page.mouse.click(*screen.place_of(cell))
    expect(screen.headline).to_contain_text("The past, trial")
    expect(screen.time.locator(".time.past")).to_be_attached()
    step = moment_of(screen)["step"]
    before, after = live.stopped_at(step - 1), live.stopped_at(step)
    risen = (before.first_reach < 0) & (after.first_reach >= 0)
    assert risen.sum() == 1
    # What plays stands still there, or that moment would be gone at once.
    screen.page.keyboard.press("Space")
    expect(screen.reading("Trial")).not_to_have_text(f"{after.trial:,}")
    screen.page.mouse.click(*screen.place_of(cell))
    expect(screen.reading("Trial")).to_have_text(f"{after.trial:,}")
    screen.expect_place("step", step)
    assert not moment_of(screen)["playing"]


def test_what_changed_since_a_is_a_layer_of_this_page_alone(begin: Begin) -> None:
    live, screen = begin(trial=LEARNED)
    look, now = Look(layer="change"), live.session.status.snapshot
    screen.choose("Layer", "Change since A")
    expect(screen.legend).to_contain_text("There is no A yet. The key A makes the moment")
    screen.expect_cell_colours(live.colours(look))
    # What is newly known on the way from one to the other is known no longer on the way back.
    early, late = live.stopped_at(now.step // 8), live.stopped_at(now.step // 2)
    for a, others in ((early, (late, now)), (late, (early, now))):
        screen.tell("seek", step=a.step)
        expect(screen.reading("Trial")).to_have_text(f"{a.trial:,}")
        screen.page.keyboard.press("a")
        expect(screen.legend).to_contain_text(f"what changed since A, trial {a.trial:,}")
        for shot in others:
            # The end of the live run is what is live.
            screen.tell("seek", step=shot.step)
            screen.expect_cell_colours(live.colours(look, shot, Extras(since=a)))
        screen.page.keyboard.press("End")
    seen = live.colours(look, now, Extras(since=late))
    assert (seen != live.colours(look, now, Extras(since=early))).any()
    assert len(np.unique(seen, axis=0)) > 3


@pytest.mark.parametrize("epsilon", [0.3])
def test_a_branch_is_exactly_what_it_would_have_been_from_the_start(
    begin: Begin, epsilon: float
) -> None:
    live, screen = begin(trial=LEARNED)
    step = live.session.status.snapshot.step // 2
    screen.tell("seek", step=step)
    expect_moment(live, screen, live.stopped_at(step))
    command = SetParameter("learner.epsilon", epsilon)
    browser = live.lab.browsers[0]
    live.lab.inbox.put(lambda: live.lab.ask(browser.client, command))
    status = live.wait_for(
        lambda status: len(status.lines) == 2 and not status.lines[-1].is_growing
    )
    # Only then is the browser there: it would be taken away from where it goes next.
    row = screen.time.locator(f'.line[data-line="{status.lines[-1].number}"]')
    expect(row).to_have_attribute("aria-current", "true")
    later = step + 3_000
    screen.tell("seek", step=later)
    expect_moment(live, screen, live.stopped_at(later, (step, command)))
