"""The bar as it is sent: plain data, small, and whole whatever people called their things."""

import json
import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.analysis.estimates import Axis
from app.charts.bar.model import Ghost, Moment, bar_of
from app.charts.bar.sent import Around, Sent, bar_sent
from app.documents import presets
from app.explain.happenings import Happening
from app.live import snapshot
from app.live.places import LineSeen, Mark, Place
from app.schedule.blocks import Block, Past, blocks_of
from learners.commands import Command, Explore, FreezeSelection
from learners.names import MAX_TRIALS
from learners.run import Run
from tests.support.curves import greedy_curve, learned
from tests.support.schedules import (
    AVOID,
    AVOIDING,
    CIRCLE,
    CIRCLING,
    commands,
    driven,
    seen,
    small_run,
    to,
)


def moment(run: Run, **parts: Any) -> Moment:
    shot = seen(run)
    return Moment(shot, blocks_of(shot))._replace(**parts)


def sent(of: Moment, unit: Axis = "trials", **around: Any) -> Sent:
    """The bar as it arrives."""
    return json.loads(json.dumps(bar_sent(bar_of(of, unit, 2_000), Around(1, **around))))


def legend(bar: Sent) -> list[str]:
    return [item["text"] for item in bar["legend"]]


def pieces(bar: Sent) -> dict[str, Sent]:
    return {piece["key"]: piece for lane in bar["lanes"] for piece in lane["pieces"]}


def test_the_legend_names_what_is_there_and_nothing_else() -> None:
    before = sent(moment(small_run()))
    assert legend(before) == ["as it learns", "greedy", "forced exploration", "frozen", "planned"]
    run = to(small_run(), 400)
    run.apply(FreezeSelection(True))
    ghost = Ghost(
        "the run before", "seed 3", learned([9], [1]), learned([9], [1]), seen(run).progress
    )
    after = sent(moment(run, ghost=ghost, left_out=3))
    assert legend(after) == [
        "as it learns",
        "greedy",
        "the run before",
        "forced exploration",
        "frozen",
        "by hand",
        "3 earlier changes not drawn",
    ]


def test_curves_are_points_along_the_axis() -> None:
    run = to(small_run(), 400)
    greedy = greedy_curve((100, 2_000, 4), (200, 4_000, 40), (400, run.step, 50))
    bar = sent(moment(run, greedy=greedy))
    at = bar["greedy"]["at"]
    assert (at, at[-1]) == (sorted(at), 0.8)
    assert bar["greedy"]["reward"] == [4, 40, 50]
    assert bar["gaps"] == [False, False]
    assert bar["ghost"] is None
    assert bar["learned"]["at"][-1] == 0.8
    assert bar["rewards"] == [-50, 100]
    assert bar["levels"][1] == [0, "0"]


def test_where_the_run_is_and_how_steps_and_trials_go_together_is_told() -> None:
    run = to(small_run(), 330)
    for unit in ("trials", "steps"):
        bar = sent(moment(run), unit)
        assert bar["end"] == {"step": run.step, "trial": 330}
        axis = bar["axis"]
        assert (axis["unit"], axis["trials"][-1], axis["steps"][-1]) == (unit, 330, run.step)
        assert axis["pace"] > 1


def test_what_lies_ahead_can_be_edited_by_its_id_and_the_past_cannot() -> None:
    found = pieces(sent(moment(to(small_run(), 130), chosen=AVOIDING)))
    free = [piece["id"] for piece in found.values() if piece["editable"]]
    assert sorted(free) == [AVOIDING, "episode:2:approach", AVOID]
    assert [key for key, piece in found.items() if piece["chosen"]] == [AVOIDING]
    assert len(found) == 6
    avoiding = found[AVOIDING]
    assert (avoiding["first"], avoiding["until"], avoiding["probability"]) == (200, 250, 0.3)
    assert avoiding["what"] == "Forced exploration of avoid"
    assert avoiding["hint"].startswith("avoid is explored in 30% of the steps, trials 200 to 249")


def test_from_an_earlier_moment_what_happened_since_can_be_edited_as_it_was_planned_then() -> None:
    ahead = blocks_of(seen(to(small_run(), 50)))
    run = to(small_run(), 60)
    run.apply(Explore("approach", 30, 0.5))
    bar = sent(moment(to(run, 230)), ahead=ahead)
    free = {piece["id"] for piece in pieces(bar).values() if piece["editable"]}
    assert free == {CIRCLE, CIRCLING, AVOID, AVOIDING, "episode:2:approach"}
    # What was done by hand is in no plan.
    by_hand = [piece for piece in pieces(bar).values() if piece["hand"]]
    assert [(piece["first"], piece["editable"]) for piece in by_hand] == [(60, False)]
    # From a moment after it the join of circle is past.
    later = sent(moment(run), ahead=blocks_of(seen(to(small_run(), 105))))
    free = {piece["id"] for piece in pieces(later).values() if piece["editable"]}
    assert free == {AVOID, AVOIDING, "episode:2:approach"}


def test_a_join_that_was_moved_since_is_edited_as_the_join_of_its_skill() -> None:
    ahead = blocks_of(seen(to(small_run(), 50)))
    moved = to(small_run("schedule.skills.avoid={at: 220, freeze: 5}"), 230)
    found = pieces(sent(moment(moved), ahead=ahead))
    assert [p["first"] for p in found.values() if p["id"] == AVOID] == [220]


def test_labels_say_of_which_blocks_they_are() -> None:
    bar = sent(moment(small_run()))
    (avoid,) = (lane for lane in bar["lanes"] if lane["skill"] == "avoid")
    assert [(label["text"], label["of"]) for label in avoid["labels"]] == [
        ("30%", [AVOIDING]),
        ("200", [AVOID]),
    ]


def test_what_goes_on_has_no_end() -> None:
    run = to(small_run(), 30)
    run.apply(FreezeSelection(True))
    bar = sent(moment(to(run, 40)))
    (held,) = (lane for lane in bar["lanes"] if not lane["skill"])
    assert [(piece["first"], piece["until"]) for piece in held["pieces"]] == [(30, None)]
    assert {"key": held["pieces"][0]["key"], "first": 30, "until": None, "kind": "frozen"} in bar[
        "bands"
    ]


def test_events_and_marks_are_told() -> None:
    note = Mark(4, Place(1, 900), 60, "the ring closes")
    happened = Happening(900, 60, "mark", note.text)
    bar = sent(moment(to(small_run(), 130), notes=(note,)), notes=(note,), happenings=(happened,))
    assert bar["notes"] == [{"number": 4, "step": 900, "trial": 60, "text": "the ring closes"}]
    assert bar["happenings"][0] == {**happened._asdict()}
    (mark,) = (mark for mark in bar["marks"] if mark["note"] is not None)
    assert (mark["note"], mark["at"]) == (4, 0.12)
    assert "the ring closes".startswith(mark["name"].rstrip("…"))
    assert mark["hint"] == "trial 60: the ring closes"


LINES = (
    LineSeen(1, None, 0, 0, "live run", 9_000, 130, 72.44, "7b705641", True),
    LineSeen(2, 1, 4_000, 60, "no avoid", 5_000, 80, math.nan, "", False, True),
)


def test_a_tree_is_told_once_there_is_more_than_one_line() -> None:
    run = to(small_run(), 130)
    assert sent(moment(run), lines=LINES[:1])["lines"] == []
    live, branch = sent(moment(run), lines=LINES)["lines"]
    assert (live["line"], live["live"], live["reward"], live["digest"]) == (
        1,
        True,
        "72.4",
        "7b7056",
    )
    assert live["hint"] == (
        "live run (live), known to trial 130, reward 72.4 a trial at the end, digest 7b705641"
    )
    assert (branch["parent"], branch["fork"], branch["growing"]) == (
        1,
        {"step": 4_000, "trial": 60},
        True,
    )
    assert branch["hint"] == (
        "no avoid, branched off at trial 60, being made, so far to trial 80,"
        " reward – a trial at the end"
    )


def test_a_bar_says_whether_it_is_that_of_the_live_run() -> None:
    bar = bar_of(moment(small_run()), "trials", 2_000)
    assert [bar_sent(bar, Around(line, LINES))["live"] for line in (1, 2)] == [True, False]
    assert bar_sent(bar, Around(1))["live"]


@settings(deadline=None)
@given(
    script=st.lists(st.tuples(st.integers(0, 800), commands), max_size=20),
    unit=st.sampled_from(["trials", "steps"]),
)
def test_whatever_was_done_can_be_sent(script: list[tuple[int, Command]], unit: Axis) -> None:
    bar = sent(moment(driven(small_run(), script)), unit)
    places = [label["at"] for lane in bar["lanes"] for label in lane["labels"]]
    places += [mark["at"] for mark in bar["marks"]] + bar["learned"]["at"]
    assert all(0 <= place <= 1 for place in places)
    for lane in bar["lanes"]:
        for piece in (*lane["pieces"], *lane["presence"]):
            assert piece["until"] is None or piece["until"] >= piece["first"]
        keys = [piece["key"] for piece in lane["pieces"]]
        assert len(set(keys)) == len(keys)


def test_no_text_has_what_no_document_may_have() -> None:
    hostile = 'x</span><script>alert("x")</script>&\x00\ud800'
    shot = seen(small_run())
    learner = shot.spec.learner.model_copy(update={"options": ("approach", hostile)})
    shot = replace(shot, spec=shot.spec.model_copy(update={"learner": learner}))
    blocks = (Block("a", "exploration", hostile, 5, 50, "planned", probability=0.5),)
    ghost = Ghost(hostile, hostile, learned([9], [1]), learned([9], [1]), shot.progress)
    note = Mark(1, Place(1, 5), 1, hostile)
    of = Moment(shot, blocks, chosen=hostile, ghost=ghost, notes=(note,))
    text = json.dumps(sent(of, notes=(note,)), ensure_ascii=False)
    assert "\x00" not in text
    assert "\\u0000" not in text
    text.encode()


@pytest.mark.parametrize("n_skills", [1, 12])
@pytest.mark.parametrize("trials", [1, 100, 48_000, MAX_TRIALS])
def test_few_and_many_skills_and_trials_fit(n_skills: int, trials: int) -> None:
    names = [f"a_skill_of_ones_own_number_{k}" for k in range(n_skills)]
    spec = presets.load(
        "hierarchical_2",
        [
            "world.size=30",
            f"trials={trials}",
            f"learner.custom_skills={{{', '.join(f'{name}: {{approach: 1}}' for name in names)}}}",
            f"learner.options=[{', '.join(names)}]",
        ],
    )
    assert len(sent(moment(Run(spec, 1)))["lanes"]) == n_skills


def test_a_whole_run_is_sent_in_few_bytes() -> None:
    run = Run(presets.load("timed"), 3)
    run.advance(until_trial=48_000)
    shot = snapshot.take(run, "timed", 0)
    for unit in ("trials", "steps"):
        bar = bar_of(Moment(shot, Past().blocks_of(shot)), unit, 2_000)
        assert len(json.dumps(bar_sent(bar, Around(1)))) < 16_000
