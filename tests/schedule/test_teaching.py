"""Teaching as a block of the schedule, and on the bar."""

from app.charts.bar.model import Moment, bar_of
from app.charts.bar.sent import Around, Sent, bar_sent
from app.documents import presets
from app.explain.happenings import Happening, happenings_of
from app.schedule import carried
from app.schedule.blocks import Block, blocks_of, described
from learners.commands import StopTeaching, Teach, Undo
from learners.run import Run
from tests.support.schedules import SMALL, seen, to


def run_of(*settings: str) -> Run:
    return Run(presets.load("timed", [*SMALL, *settings]), seed=5)


def taught(run: Run) -> list[Block]:
    return [block for block in blocks_of(seen(run)) if block.kind == "teaching"]


def span(block: Block) -> tuple[int, int | None, str, bool]:
    return block.first, block.until, block.state, block.by_hand


def sent(run: Run) -> Sent:
    shot = seen(run)
    return bar_sent(bar_of(Moment(shot, blocks_of(shot)), "trials", 2_000), Around(0))


def test_teaching_of_the_schedule_lasts_from_the_first_trial_on() -> None:
    run = run_of("schedule.teach={trials: 30}")
    (block,) = taught(to(run, 10))
    assert span(block) == (0, 30, "running", False)
    assert described(block) == "a script chooses the skill, trials 0 to 29, by the schedule"
    assert span(*taught(to(run, 30))) == (0, 30, "done", False)


def test_by_hand_it_begins_ends_and_is_taken_back() -> None:
    run = to(run_of(), 40)
    run.apply(Teach("flank", 100))
    assert span(*taught(run)) == (40, 140, "running", True)
    to(run, 60).apply(Teach("flank", 10))
    assert [span(block)[:2] for block in taught(run)] == [(40, 60), (60, 70)]
    to(run, 65).apply(StopTeaching())
    assert [span(block)[:2] for block in taught(run)] == [(40, 60), (60, 65)]
    to(run, 80).apply(Teach("flank", 10))
    to(run, 82).apply(Undo(run.control.history[-1].number))
    last = taught(run)[-1]
    assert (last.first, last.until, last.undone) == (80, 82, True)


def test_a_preset_that_repeats_the_run_is_taught_for_as_long() -> None:
    run = to(run_of("schedule.teach={trials: 30}"), 20)
    run.apply(StopTeaching())
    schedule, left_out = carried.schedule_of(seen(to(run, 50)))
    assert schedule.teach is not None
    assert schedule.teach.trials == 20
    assert left_out == ()
    run.apply(Teach("flank", 7))
    _, left_out = carried.schedule_of(seen(to(run, 90)))
    assert left_out == ("A script chooses the skill, trials 50 to 56, by hand.",)


def test_the_bar_has_a_lane_a_band_and_a_word_for_it() -> None:
    bar = sent(to(run_of("schedule.teach={trials: 30}"), 50))
    lane = bar["lanes"][-1]
    assert (lane["name"], lane["skill"]) == ("taught", "")
    assert [piece["kind"] for piece in lane["pieces"]] == ["taught"]
    assert [label["text"] for label in lane["labels"]] == ["by a script"]
    assert {"taught"} <= {band["kind"] for band in bar["bands"]}
    assert "taught" in {item["text"] for item in bar["legend"]}
    assert "taught" not in {item["text"] for item in sent(to(run_of(), 50))["legend"]}


def happened(run: Run) -> list[Happening]:
    return list(happenings_of(run.control, run.trial, lambda trial: 1_000 * trial))


def test_its_end_is_a_moment_to_go_to() -> None:
    found = happened(to(run_of("schedule.teach={trials: 30}"), 50))
    assert Happening(30_000, 30, "exploration", "the script teaches no more") in found


def test_where_each_skill_has_learned_alone_is_a_moment_to_go_to() -> None:
    run = run_of("schedule.pretrain=400")
    assert happened(run) == []
    found = happened(to(run, 2))
    assert found[:3] == [
        Happening(400, 0, "exploration", "approach has learned alone"),
        Happening(800, 0, "exploration", "circle clockwise has learned alone"),
        Happening(1_200, 0, "exploration", "avoid has learned alone"),
    ]
