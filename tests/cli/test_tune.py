"""The command ``pounce tune``: what it prints and writes, and what it refuses."""

import errno
import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from app.cli import main
from app.documents import presets
from app.experiments import tuning
from learners.spec import RunSpec

ROOT = Path(__file__).resolve().parents[2]
SMALL = ("--set", "world.size=20", "world.step_limit=60", "--horizon", "6000")
QUICK = (*SMALL, "--seeds", "2", "--judge-seeds", "2", "--weights", "2,0,0.5")


@pytest.fixture(autouse=True)
def in_a_folder(here: Path) -> Path:
    return here


def answer(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Standard output of a command that succeeds and says nothing else."""
    code = main.main(["tune", "static_appetite_fear", *words])
    out, err = capsys.readouterr()
    assert (code, err) == (0, "")
    return out


def test_json_is_one_object_of_the_promised_shape(capsys: pytest.CaptureFixture[str]) -> None:
    out = answer(capsys, *QUICK, "--first-seed", "40", "--json")
    assert out.count("\n") == 1
    document = json.loads(out)
    assert [*document] == [
        "preset",
        "settings",
        "horizon",
        "seeds",
        "judge_seeds",
        "stages",
        "weights",
        "judged",
    ]
    assert (document["seeds"], document["judge_seeds"]) == ([40, 41], [42, 43])
    first, second = document["stages"]
    assert (first["skill"], [tried["weight"] for tried in first["tried"]]) == ("appetite", [1])
    assert (second["skill"], [each["weight"] for each in second["tried"]]) == ("fear", [0, 0.5, 2])
    best = max(second["tried"], key=lambda tried: tried["reward"])
    assert best["reward"] == pytest.approx(sum(best["rewards"]) / 2)
    assert document["weights"] == {"appetite": 1, "fear": second["weight"]}
    assert RunSpec.model_validate(document["settings"]).learner.weights == document["weights"]
    assert set(document["judged"]) == {"horizon_area", "horizon_reward"}
    for judged in document["judged"].values():
        assert set(judged) == {"tuned", "ones", "difference"}
        assert all(found["low"] <= found["mean"] <= found["high"] for found in judged.values())


def test_the_same_words_find_the_same_whatever_the_workers(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert answer(capsys, *QUICK, "--workers", "1") == answer(capsys, *QUICK, "--workers", "3")


def test_a_table_has_each_skill_with_each_weight(capsys: pytest.CaptureFixture[str]) -> None:
    lines = answer(capsys, *QUICK).splitlines()
    assert max(map(len, lines)) <= 80
    rows = [line.split() for line in lines]
    tried = [row[:2] for row in rows if row[:1] in (["appetite"], ["fear"]) and len(row) > 4]
    assert tried[:4] == [["appetite", "1"], ["fear", "0"], ["fear", "0.5"], ["fear", "2"]]
    assert sum(row[-1:] == ["kept"] for row in rows) == 2
    assert "With fewer than 10 seeds an interval decides nothing." in lines
    assert any(line.startswith("all weights 1") for line in lines)


def test_where_the_best_weight_is_at_an_end_more_may_be_tried(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    hint = "Of fear the best is at an end of what was tried"
    for is_at_an_end in (False, True):
        monkeypatch.setattr(tuning.Stage, "is_at_an_end", is_at_an_end)
        assert (hint in " ".join(answer(capsys, *QUICK).split())) == is_at_an_end


def test_what_was_found_is_a_preset_that_runs(
    capsys: pytest.CaptureFixture[str], here: Path
) -> None:
    out = answer(capsys, *QUICK, "--save", "mine.yaml")
    assert out.endswith("The preset with these weights is in mine.yaml.\n")
    text = (here / "mine.yaml").read_text("utf-8")
    assert text.startswith("# static_appetite_fear, its weights tuned in one at a time")
    spec = presets.load("mine.yaml")
    weights = spec.learner.weights
    start = presets.load("static_appetite_fear", SMALL[1:3])
    assert spec == tuning.with_weights(start, weights)
    assert main.main(["run", "mine.yaml", "--trials", "3"]) == 0


def test_a_file_is_replaced_only_if_that_is_asked_for(
    capsys: pytest.CaptureFixture[str], here: Path
) -> None:
    file = here / "mine.yaml"
    file.write_text("mine", encoding="utf-8")
    assert main.main(["tune", "static_appetite_fear", *QUICK, "--save", "mine.yaml"]) == 2
    assert "'mine.yaml' is there already" in " ".join(capsys.readouterr().err.split())
    assert file.read_text("utf-8") == "mine"
    answer(capsys, *QUICK, "--save", "mine.yaml", "--force")
    assert presets.load("mine.yaml").learner.weights


def test_what_cannot_be_written_is_said(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("app.util.files.write_whole", full)
    assert main.main(["tune", "static_appetite_fear", *QUICK, "--save", "mine.yaml"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err == "--save: 'mine.yaml' cannot be written: No space left on device\n"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "PRESET is missing; allowed: a shipped preset"),
        (("timed",), "timed learns its selection, which has no weights"),
        (("standard_q",), "standard_q has no skills to be weighed: its options are moves"),
        (("nothing_known",), "nothing_known"),
        (("static_appetite_fear", "--seeds", "0"), "--seeds: '0' is not allowed"),
        (("static_appetite_fear", "--judge-seeds", "many"), "--judge-seeds: 'many' is not"),
        (("static_appetite_fear", "--first-seed", "-1"), "--first-seed: '-1' is not allowed"),
        (("static_appetite_fear", "--horizon", "0"), "--horizon: '0' is not allowed"),
        (("static_appetite_fear", "--workers", "0"), "--workers: '0' is not allowed"),
        (("static_appetite_fear", "--weights", "1,-1"), "--weights: '-1' is not allowed"),
        (("static_appetite_fear", "--weights", "1,1.0"), "--weights: 1 is there twice"),
        (("static_appetite_fear", "--weights", "1,000"), "may be within a number"),
        (("static_appetite_fear", "--weights", ""), "--weights: '' is not allowed"),
        (("static_appetite_fear", "--force"), "--force goes with --save"),
        (("static_appetite_fear", "--save", "mine.txt"), "allowed: a file that ends in .yaml"),
        (("static_appetite_fear", "--save", "no/mine.yaml"), "is in no folder"),
        (("static_appetite_fear", "--set", "nothing=1"), "nothing"),
        (
            ("static_appetite_fear", "--horizon", "1", "--seeds", "1"),
            "static_appetite_fear ends no trial within the horizon, or all 2,000,000",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(
    words: Sequence[str], message: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["tune", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in " ".join(err.split())
    assert list(here.iterdir()) == []


def test_the_help_says_the_numbers_that_count(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["tune", "--help"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert f"{tuning.HORIZON // 1_000_000} million" in told
    assert f"1/{1 / tuning.GRID[1]:.0f} to {tuning.GRID[-1]:.0f}, doubled" in told


def test_ctrl_c_ends_it_and_writes_nothing(here: Path) -> None:
    words = ("static_appetite_fear", "--horizon", "1e10", "--workers", "1", "--save", "mine.yaml")
    # Whoever runs the tests in the background has them ignore interrupts, and children inherit it.
    process = subprocess.Popen(
        [sys.executable, "-c", _TELLS_WHEN_IT_RUNS, "tune", *words],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "running\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert (out, err, process.returncode) == ("", "interrupted\n", 130)
    assert list(here.iterdir()) == []


_TELLS_WHEN_IT_RUNS = """
import sys
from app.cli import main
from app.experiments import tuning
from app.util import interrupts

def told(*arguments):
    print("running", flush=True)
    return made(*arguments)

made, tuning.run_experiment = tuning.run_experiment, told
interrupts.end_the_program()
sys.exit(main.main(sys.argv[1:]))
"""
