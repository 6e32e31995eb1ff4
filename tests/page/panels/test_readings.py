"""What stands beside the board: numbers, curve, marks, legend, and no markup from strangers."""

from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from app.documents import presets
from app.explain.sentence import provenance, said
from app.live import snapshot
from app.live.held import Opened
from app.live.places import Behind, LineSeen
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.clock import clock_html
from app.picture.theme import DARK, LIGHT, Theme
from app.player import headline
from app.server.pulse import Reading
from learners import measures
from learners.commands import (
    Explore,
)
from learners.measures import Endings
from learners.run import Run
from learners.spec import RunSpec
from tests.support.curves import greedy_curve


def spec_of(*settings: str, preset: str = "timed") -> RunSpec:
    """A preset in a small world."""
    return presets.load(preset, ["world.size=40", *settings])


def moment(run: Run | None = None, **parts: object) -> Snapshot:
    """The moment that a run is at, with some parts replaced."""
    return replace(snapshot.take(run or Run(spec_of(), seed=1), "timed", 0), **parts)


def status_of(taken: Snapshot, **parts: object) -> Status:
    """A playing session at a moment, with some parts replaced."""
    idle = Session(taken.spec, "timed", seed=1, speed=100.0, playing=True).status
    return replace(idle, snapshot=taken, preparing=False, **parts)


def sentence_html(status: Status) -> str:
    """The sentence above the board."""
    return headline.sentence_html(status, said(status))


class Page(HTMLParser):
    """The tags and the text of a piece of HTML."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.words: list[str] = []
        self.feed(html)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.words.append(data)


# Headline and numbers


def test_the_sentence_above_the_board_is_that_of_the_moment() -> None:
    assert ": approach. It is practised until" in Page(sentence_html(status_of(moment()))).text


def test_markup_in_an_error_is_shown_and_not_obeyed() -> None:
    error = "ValueError: <img src=x onerror=alert(1)> & <script>steal()</script>"
    harmless = sentence_html(status_of(moment(), error="ValueError: x"))
    shown = Page(sentence_html(status_of(moment(), error=error)))
    assert error in shown.text
    assert shown.tags == Page(harmless).tags


def test_an_error_is_shown_only_when_there_is_one() -> None:
    assert "Error" not in Page(sentence_html(status_of(moment()))).text


def test_what_is_not_kept_is_said_under_the_sentence() -> None:
    fault = "This session is not kept: /a<b>: no space left on device."
    plain = Page(sentence_html(status_of(moment()))).text
    page = Page(sentence_html(status_of(moment(), journal=fault)))
    assert page.text == f"{plain} {fault}"


@pytest.mark.parametrize("same", [None, True, False])
def test_a_run_of_an_experiment_is_named_under_the_sentence(same: bool | None) -> None:
    digest = "3fa9c1d2" + "0" * 56
    found = "" if same is None else digest if same else "f" * 64
    opened = Opened("figure_4_1: timed, seed 3", 1_000, digest, same, found)
    page = Page(sentence_html(status_of(moment(), opened=opened)))
    sentence = Page(sentence_html(status_of(moment()))).text
    assert page.text == f"{sentence} {provenance(opened)}"


@pytest.mark.parametrize("same", [None, True, False])
def test_markup_in_the_name_of_a_run_is_shown_and_not_obeyed(same: bool | None) -> None:
    name = "<img src=x onerror=alert(1)> & <script>steal()</script>"
    hostile = Opened(name, 1_000, "<b>3f</b>", same, "<b>3f</b>")
    harmless = Opened("timed", 1_000, "3f", same, "3f")
    shown = Page(sentence_html(status_of(moment(), opened=hostile)))
    assert name in shown.text
    expected = Page(sentence_html(status_of(moment(), opened=harmless)))
    assert shown.tags == expected.tags


def test_greedy_says_how_much_of_a_hunt_leads_where_it_has_been() -> None:
    status = status_of(moment(step=2_000))
    curve = greedy_curve((10, 1_000, 1.0), (20, 3_000, 2.0))
    assert "in which the same hunt has been before" not in headline.numbers_html(status, 1, curve)
    with_shares = curve._replace(without_progress=np.array([0.283, 0.5], np.float32))
    shown = headline.numbers_html(status, 1, with_shares)
    assert "in which the same hunt has been before: 28 %" in shown


def test_numbers_are_those_of_the_moment() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=1_234)
    taken = moment(run, recent=Endings(captures=3, flights=4, timeouts=5), recent_reward=8.25)
    status = status_of(taken, steps_per_s=20_480.0)
    shown = headline.numbers_html(status, 2, greedy_curve((1_021, 12_345, -12.25)))
    reached = int((taken.value > 0).sum())
    assert reached > 0
    assert Page(shown).text == (
        f"Trial 1,234 Success 25% Reward 8.2 Greedy \N{MINUS SIGN}12.2"
        f" Steps {run.step:,} Steps/s 20 k States of value {reached:,} Viewers 2"
    )
    assert "measured at trial 1,021, step 12,345" in shown
    assert "of 3,456" in shown


def test_the_numbers_of_a_moment_that_is_not_now_say_so_before_anything_else() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=1_000)
    past = status_of(moment(run), behind=Behind("", 2_150, 300_000), steps_per_s=2_000.0)
    curve = greedy_curve((500, 6_000, 1.0), (2_000, run.step + 1, 2.0))
    shown = headline.numbers_html(past, 1, curve)
    assert Page(shown).text.startswith("The past : 2,150 trials behind Trial 1,000 Success")
    assert "Live steps/s 2 k" in Page(shown).text
    assert "measured at trial 500, step 6,000" in shown
    branch = status_of(moment(run), behind=Behind("<b>no</b> avoid", -1, -70))
    shown = headline.numbers_html(branch)
    assert Page(shown).text.startswith("<b>no</b> avoid: 1 trial ahead Trial 1,000 Success")


def test_the_greedy_reward_of_a_branch_is_none_from_before_it_began() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=1_000)
    line = LineSeen(4, 0, run.step - 100, 990, "no avoid", run.step, 1_000, 8.0, "", is_live=False)
    branch = status_of(moment(run, generation=4), behind=Behind("no avoid", 0, 0), lines=(line,))
    before = greedy_curve((500, line.fork_step, 1.0))
    assert "Greedy \N{EN DASH}" in Page(headline.numbers_html(branch, 1, before)).text
    since = greedy_curve((500, line.fork_step, 1.0), (995, line.fork_step + 1, 2.0))
    assert "Greedy 2.0" in Page(headline.numbers_html(branch, 1, since)).text
    # What it had when it began is what the line had that it left.
    at_fork = replace(line, fork_step=run.step)
    began = greedy_curve((500, run.step - 1, 1.0))
    assert (
        "Greedy 1.0"
        in Page(headline.numbers_html(replace(branch, lines=(at_fork,)), 1, began)).text
    )


def test_a_moment_of_a_run_of_an_experiment_is_not_said_to_be_how_it_ended() -> None:
    opened = Opened("figure_4_1: timed, seed 3", 1_000, "3f", True, "3f")
    assert "as it ended" in sentence_html(status_of(moment(), opened=opened))
    past = status_of(moment(), opened=opened, behind=Behind("", 10, 900))
    assert "as it ended" not in sentence_html(past)


def test_the_clock_says_whose_steps_it_counts() -> None:
    reading = Reading(0.25, 50, 0, 0.0, 10.0)
    now = status_of(moment(), steps_per_s=2_000.0)
    assert Page(clock_html(reading, now, 1)).text.startswith("2 k steps/s; 25%")
    past = replace(now, behind=Behind("", 10, 900))
    text = Page(clock_html(reading, past, 1)).text
    assert text.startswith("The live run: 2 k steps/s; 25%")


def test_what_matters_first_is_read_on_the_stage_too() -> None:
    taken = moment(recent=Endings(captures=3, flights=4, timeouts=5), recent_reward=8.25)
    assert Page(headline.readings_html(taken)).text == (
        f"Trial {taken.trial} Success 25% Reward 8.2 Places worth something 0"
    )


def test_exploration_that_is_forced_is_said_beside_the_numbers_that_it_makes_small() -> None:
    run = Run(spec_of(), seed=1)
    run.advance(until_trial=100)
    assert "forced" not in headline.numbers_html(status_of(moment(run)))
    run.apply(Explore("approach", 100, 0.95))
    status = status_of(moment(run))
    for shown in (headline.numbers_html(status), headline.readings_html(status.snapshot)):
        assert "Forced exploration : approach 95%" in Page(shown).text
    run.advance(until_trial=200)
    over = Page(headline.readings_html(moment(run))).text
    assert "Forced exploration until trial 200 is in these numbers" in over
    run.advance(until_trial=200 + measures.RECENT_TRIALS)
    assert "Forced" not in headline.readings_html(moment(run))


@pytest.mark.parametrize("theme", [LIGHT, DARK])
def test_forced_exploration_has_its_one_colour(theme: Theme) -> None:
    styles = (Path(headline.__file__).parents[1] / "web" / "readings.css").read_text("utf-8")
    assert f"--pounce-forced: rgb({' '.join(map(str, theme.forced))})" in styles


def test_viewers_are_counted_where_there_are_others() -> None:
    assert "Viewers" not in headline.numbers_html(status_of(moment()), viewers=1)


def test_before_the_first_end_of_a_trial_there_is_no_success() -> None:
    text = Page(headline.numbers_html(status_of(moment()))).text
    nothing = "\N{EN DASH}"
    assert f"Success {nothing} Reward {nothing} Greedy {nothing} Steps" in text


def test_rates_are_short() -> None:
    text = Page(headline.numbers_html(status_of(moment(), steps_per_s=1_995.0))).text
    assert "Steps/s 2 k States" in text
