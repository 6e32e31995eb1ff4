"""Runs side by side in words: what each is, who leads, and one cell in all of them."""

from dataclasses import replace

import pytest

from app.explain.beside import ahead_of_others, cell_rows, leaders, repertoire, standing
from app.explain.cell import reading_at
from app.live.snapshot import Snapshot, take
from learners.run import Run
from tests.support.person import words
from tests.support.races import small


def snapshot(preset: str = "hierarchical_2", steps: int = 400) -> Snapshot:
    run = Run(small(preset), 3)
    run.advance(steps)
    return take(run, preset, 1)


def with_rewards(*rewards: float) -> list[Snapshot]:
    shot = snapshot()
    return [replace(shot, recent_reward=reward) for reward in rewards]


@pytest.mark.parametrize(
    ("preset", "words"),
    [
        ("standard_q", "nine moves, no skills"),
        ("q_lambda", "nine moves, no skills, and traces of the last moves"),
        ("feudal", "five commands of a manager, no skills"),
        ("hierarchical_2", "approach and circle clockwise, all from the start"),
        ("hierarchical_3", "approach, circle clockwise and avoid, all from the start"),
        (
            "timed",
            "skills one by one, planned by trial: approach, circle clockwise (12,000), avoid"
            " (14,500)",
        ),
    ],
)
def test_what_a_learner_is_is_said_to_those_who_do_not_know_its_name(
    preset: str, words: str
) -> None:
    assert repertoire(small(preset)) == words


def test_whoever_leads_is_named_and_the_others_follow_by_their_rewards() -> None:
    shots = with_rewards(-10.0, 52.4, 61.0)
    said = words(standing(["standard_q", "timed", "two"], shots, shots[0].step, True))
    assert said == (
        "Three runs, step for step, from the same starts of trials. After 400 steps two leads with"
        " 61 a trial (mean of the last 500); timed 52 and standard_q \N{MINUS SIGN}10."
    )
    assert leaders(shots, 400) == ahead_of_others(shots, 400) == (2,)


def test_rewards_that_are_as_sure_as_the_best_are_level_with_it() -> None:
    shots = with_rewards(50.0, 52.0, 10.0)
    assert leaders(shots, 400) == (1, 0)
    said = words(standing(["a", "b", "c"], shots, 400, False))
    assert said.startswith("Three runs, step for step. After 400 steps b and a lead with 52 a")
    said = words(standing(["a", "b"], shots[:2], 400, False))
    assert said.endswith("After 400 steps they are level: 52 a trial (mean of the last 500).")


def test_a_run_that_has_not_come_as_far_does_not_count_unless_it_is_over() -> None:
    early, late = snapshot(steps=200), snapshot(steps=400)
    ahead = [replace(early, recent_reward=90.0), replace(late, recent_reward=1.0)]
    assert leaders(ahead, 400) == (1,)
    assert ahead_of_others(ahead, 400) == ()
    assert "b is there alone: 1 a trial" in words(standing(["a", "b"], ahead, 400, True))
    over = replace(early, recent_reward=90.0, trial=early.spec.trials)
    assert leaders([over, late], 400) == (0,)


def test_nobody_leads_before_a_trial_of_each_has_ended() -> None:
    shots = with_rewards(float("nan"), 3.0)
    assert leaders(shots, 400) == ()
    assert "No trial has ended yet" in standing(["a", "b"], shots, 400, True)


def test_names_are_escaped() -> None:
    shots = with_rewards(50.0, 0.0)
    said = standing(["<b>", "<i>"], shots, 400, True)
    assert "&lt;b&gt;" in said
    assert "&lt;i&gt;" in said


def test_a_cell_is_read_in_all_runs() -> None:
    one, other = snapshot("hierarchical_2", 3_000), snapshot("standard_q", 3_000)
    x = y = one.world.size // 2
    readings = [reading_at(shot, x - 1, y, 0) for shot in (one, other)]
    rows = {row.what: row.values for row in cell_rows([*readings, None])}
    assert list(rows) == ["worth", "takes", "since", "visits", "a hunt"]
    assert all(values[2] == "not on this board" for values in rows.values())
    visits = sum(option.visits for option in readings[0].options)
    assert rows["visits"][0] == f"{visits:,}"
    assert all(row.hint for row in cell_rows(readings))
