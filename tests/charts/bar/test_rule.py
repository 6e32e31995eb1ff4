"""What rules watch, as data under the curve."""

import pytest

from app.charts.bar.model import Moment, View, bar_of
from app.charts.bar.rule import long_of, outlook_in_words, rules_of
from app.charts.bar.sent import Around, Sent, bar_sent
from app.live.watched import watched_along
from app.schedule.blocks import blocks_of
from learners.run import Run
from learners.schedule_spec import TriggerSpec
from tests.support.schedules import ruled_spec, seen, to


def run_at(trial: int) -> Run:
    """Skills join in trials 436 and 874."""
    return to(Run(ruled_spec("trials=2000"), seed=5), trial)


def sent(run: Run, view: View | None = None) -> Sent:
    shot = seen(run)
    return bar_sent(bar_of(Moment(shot, blocks_of(shot)), "trials", 2_000, view), Around(0))


def test_a_stretch_says_what_it_asks_for_and_whether_it_was_met() -> None:
    circle, avoid = rules_of(watched_along(run_at(600)))
    assert (circle.skill, circle.first, circle.known, circle.until) == (
        "circle_clockwise",
        10,
        60,
        436,
    )
    assert (circle.met, avoid.met, avoid.until) == (True, False, None)
    assert circle.what == ("new states", "per trial")
    assert circle.short == ("Circle clockwise", "joins below 0.2")
    assert circle.ends == avoid.ends
    low, high = circle.ends
    assert low < circle.below < circle.values.max() < high


@pytest.mark.parametrize(
    ("by", "said"),
    [
        (
            "novelty",
            "Avoid joins when the last 500 trials visit fewer than 0.01 new states a trial",
        ),
        ("reach", "Avoid joins when the last 500 trials give value to fewer than 0.01 new states"),
        ("change", "Avoid joins when values change by less than 0.01 a step in the last 500"),
    ],
)
def test_each_rule_is_said_in_words(by: str, said: str) -> None:
    assert long_of("avoid", TriggerSpec.model_validate({"by": by})).startswith(said)


def test_the_outlook_is_said_in_words() -> None:
    (early,) = watched_along(run_at(30))
    assert outlook_in_words(early) == "known from trial 60 on"
    (circle,) = watched_along(run_at(120))
    trial = int(circle.fires[-1])
    assert (
        outlook_in_words(circle) == f"{circle.values[-1]:.2g} now; at this rate at trial {trial:,}"
    )
    (level,) = watched_along(run_at(400))
    assert outlook_in_words(level).endswith(" now; not falling")


def test_a_rule_without_a_number_has_a_scale() -> None:
    (rule,) = rules_of(watched_along(run_at(12)))
    low, high = rule.ends
    assert 0 < low < rule.below < high


def test_a_rule_that_is_never_met_has_a_scale() -> None:
    run = Run(ruled_spec("schedule.introduce={by: novelty, window: 50, below: 0}"), seed=5)
    (rule,) = rules_of(watched_along(to(run, 300)))
    low, high = rule.ends
    assert 0 < low < high


def test_what_rules_watch_is_sent_in_trials() -> None:
    circle, avoid = sent(run_at(600))["rules"]
    assert (circle["first"], circle["until"], circle["met"]) == (10, 436, True)
    assert len(circle["trials"]) == len(circle["values"]) == len(circle["fires"])
    assert avoid["until"] is None


def test_of_a_part_whose_end_is_hidden_nothing_later_is_sent() -> None:
    (circle,) = sent(run_at(600), View(0, 600, hides_after=300))["rules"]
    assert circle["until"] is None
    assert not circle["met"]
    assert circle["trials"][-1] <= 300


def test_what_is_planned_for_no_known_trial_is_no_band() -> None:
    assert all(band["first"] < 2_000 for band in sent(run_at(100))["bands"])


def test_lanes_say_which_skills_joined_by_a_rule_and_which_will() -> None:
    (_, circle, avoid) = sent(run_at(600))["lanes"]
    (joined,) = (label for label in circle["labels"] if label["before"])
    assert (joined["before"], joined["text"], joined["after"]) == (
        "joined at ",
        "436",
        " by its rule",
    )
    assert [label["text"] for label in avoid["labels"]] == ["joins next, by its rule"]
    (_, circle, avoid) = sent(run_at(100))["lanes"]
    assert [label["text"] for label in circle["labels"]] == ["joins next, by its rule"]
    assert [label["text"] for label in avoid["labels"]] == ["joins by its rule"]
