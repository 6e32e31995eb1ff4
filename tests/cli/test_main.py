"""The command line: what it answers, where it answers, and what it refuses in which words."""

import csv
import json
import os
import pty
import re
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app import __version__
from app.cli import main
from app.cli.answers import EXIT_PIPE_CLOSED, whole_number
from app.documents import presets
from app.experiments import seeds, task
from app.experiments.crews import Threads
from benchmarks.compare import incomparable
from learners.kernel.state import digest
from learners.run import Run
from learners.spec import RunSpec

ROOT = Path(__file__).resolve().parents[2]
POUNCE = (sys.executable, "-m", "app.cli.main")
QUICK = ("--set", "world.size=30", "world.step_limit=80", "--trials", "60")
QUICK_SETTINGS = ("world.size=30", "world.step_limit=80", "trials=60")


@pytest.fixture(autouse=True)
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the commands run; what they write without being told to would be found there."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    return tmp_path


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def answer(capsys: pytest.CaptureFixture[str], *argv: str) -> str:
    """Standard output of a command that succeeds and says nothing else."""
    code = main.main(argv)
    out, err = capsys.readouterr()
    assert (code, err) == (0, "")
    return out


def json_of(capsys: pytest.CaptureFixture[str], *argv: str) -> dict[str, Any]:
    return json.loads(answer(capsys, *argv, "--json"))


def environment() -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(ROOT), "COLUMNS": "80"}


def process(*argv: str, **options: Any) -> subprocess.Popen[Any]:
    # Whoever runs the tests in the background has them ignore interrupts, and children inherit it.
    return subprocess.Popen(
        [*POUNCE, *argv],
        env=environment(),
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        **options,
    )


# --- Help ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", [(), *((name,) for name in main.COMMANDS)])
@pytest.mark.parametrize("flag", ["-h", "--help"])
def test_help_fits_a_terminal(
    command: Sequence[str], flag: str, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = answer(capsys, *command, flag).splitlines()
    assert lines[0].startswith(" ".join(["usage: pounce", *command]))
    assert max(map(len, lines)) <= 80


def test_help_in_colours_is_as_narrow(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plain = answer(capsys, "replicate", "-h")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    coloured = answer(capsys, "replicate", "-h")
    assert "\x1b[1m" in coloured
    assert re.sub(r"\x1b\[[\d;]*m", "", coloured) == plain


@pytest.mark.parametrize("kind", main.EXAMPLES)
def test_help_has_examples_that_can_be_typed(
    kind: type[main.Command], capsys: pytest.CaptureFixture[str]
) -> None:
    name = next(name for name, command in main.COMMANDS.items() if command is kind)
    text = answer(capsys, name, "--help")
    for example in main.EXAMPLES[kind]:
        assert f"  {example}\n" in text
        assert isinstance(main.parse(example.split()[1:]), kind)


def test_help_names_every_command_and_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    text = answer(capsys, "--help")
    assert all(f"• {name}" in text for name in main.COMMANDS)
    assert "--version" in text
    options = "--seeds --seed-list --trials --set --workers --json --out --force"
    text = answer(capsys, "run", "--help")
    assert [option for option in options.split() if f" {option} " not in text] == []


@pytest.mark.parametrize("argument", ["--help", "--version", "run --help", "lab --help"])
def test_help_comes_without_what_takes_long_to_import(argument: str) -> None:
    program = (
        "import sys; from app.cli.main import main; code = main(sys.argv[1:]);"
        "print(*sorted({'numba', 'viser', 'numpy', 'pydantic'} & set(sys.modules)));"
        "sys.exit(code)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *argument.split()],
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines()[-1] == ""


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    for option in ("--version", "-V"):
        assert answer(capsys, option) == f"pounce {__version__}\n"


# --- pounce run ----------------------------------------------------------------------------------


def test_json_is_one_object_of_the_promised_shape(capsys: pytest.CaptureFixture[str]) -> None:
    out = answer(capsys, "run", "timed", *QUICK, "--seeds", "2", "--json")
    assert out.count("\n") == 1
    document = json.loads(out)
    assert list(document) == ["preset", "settings", "runs"]
    assert document["preset"] == "timed"
    spec = presets.load("timed", QUICK_SETTINGS)
    assert RunSpec.model_validate(document["settings"]) == spec
    assert [run["seed"] for run in document["runs"]] == [0, 1]
    for run in document["runs"]:
        reference = Run(spec, run["seed"])
        reference.advance()
        assert run["digest"] == digest(reference.state)
        assert (run["trials"], run["steps"]) == (60, reference.step)
        assert run["captures"] + run["flights"] + run["timeouts"] == 60
        assert set(run) == {
            "seed",
            "trials",
            "steps",
            "seconds",
            "captures",
            "flights",
            "timeouts",
            "mean_reward_last_2000",
            "curve",
            "digest",
        }


def test_workers_and_repetition_make_no_difference(capsys: pytest.CaptureFixture[str]) -> None:
    def digests(workers: str) -> list[str]:
        argv = ("run", "hierarchical_3", *QUICK, "--seeds", "9", "--workers", workers)
        return [run["digest"] for run in json_of(capsys, *argv)["runs"]]

    alone = digests("1")
    assert len(set(alone)) == 9
    assert digests("8") == alone
    assert digests("8") == alone


def test_the_order_of_a_seed_list_is_kept(capsys: pytest.CaptureFixture[str]) -> None:
    runs = json_of(capsys, "run", "timed", *QUICK, "--seed-list", "9, 2,5")["runs"]
    assert [run["seed"] for run in runs] == [9, 2, 5]


def test_a_seed_list_has_no_more_seeds_than_a_number_of_seeds(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(seeds, "run_seeds", None)  # no work may be done
    for words in (["--seeds", "100001"], ["--seed-list", ",".join(map(str, range(100_001)))]):
        assert main.main(["run", "timed", *words]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.startswith(f"{words[0]}: ")
        assert " ".join(err.split()).endswith("1 to 100000")


def test_one_seed_is_the_default(capsys: pytest.CaptureFixture[str]) -> None:
    assert [run["seed"] for run in json_of(capsys, "run", "timed", *QUICK)["runs"]] == [0]


@pytest.mark.parametrize(
    "argv",
    [
        ("--set", "world.size=40", "--set", "learner.epsilon=0.25"),
        ("--set", "world.size=40", "learner.epsilon=0.25"),
        ("--set=world.size=40", "--set=learner.epsilon=0.25"),
    ],
)
def test_settings_reach_the_preset(argv: Sequence[str], capsys: pytest.CaptureFixture[str]) -> None:
    document = json_of(capsys, "run", "standard_q", *argv, "--trials", "20")
    assert document["settings"]["world"]["size"] == 40
    assert document["settings"]["learner"]["epsilon"] == 0.25
    assert document["settings"]["trials"] == document["runs"][0]["trials"] == 20


def test_the_option_for_trials_goes_above_a_setting(capsys: pytest.CaptureFixture[str]) -> None:
    argv = ("run", "standard_q", "--trials", "20", "--set", "trials=30")
    assert json_of(capsys, *argv)["settings"]["trials"] == 20


def test_options_may_stand_before_the_preset(capsys: pytest.CaptureFixture[str]) -> None:
    document = json_of(capsys, "run", "--trials", "20", "--set", "world.size=40", "timed")
    assert document["preset"] == "timed"
    assert document["settings"]["world"]["size"] == 40


def test_a_preset_may_be_a_file(empty_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = empty_folder / "my üwn.preset.yaml"
    file.write_text("extends: timed\nworld: {size: 30}\ntrials: 40\n", encoding="utf-8")
    document = json_of(capsys, "run", str(file), "--out", "my results")
    assert document["preset"] == str(file)
    assert document["settings"]["world"]["size"] == 30
    assert names(empty_folder / "my results") == [
        "my üwn.preset-seed0.npz",
        "my üwn.preset.csv",
        "my üwn.preset.json",
    ]


def test_the_table_has_every_seed(capsys: pytest.CaptureFixture[str]) -> None:
    argv = ("run", "timed", *QUICK, "--seed-list", "3,7")
    runs = json_of(capsys, *argv)["runs"]
    lines = answer(capsys, *argv).splitlines()
    assert max(map(len, lines)) <= 80
    rows = {cells[0]: cells for cells in map(str.split, lines) if cells}
    header = "seed trials steps seconds captures flights time-outs reward digest"
    assert rows["seed"] == header.split()
    for run in runs:
        seed, trials, steps, _, *endings, reward, short = rows[str(run["seed"])]
        assert [int(seed), int(trials), int(steps)] == [run["seed"], 60, run["steps"]]
        assert list(map(int, endings)) == [run[k] for k in ("captures", "flights", "timeouts")]
        assert float(reward) == pytest.approx(run["mean_reward_last_2000"], abs=0.051)
        assert short == run["digest"][:12]


def test_the_table_has_the_curve_in_windows(capsys: pytest.CaptureFixture[str]) -> None:
    out = answer(capsys, "run", "standard_q", "--trials", "5000", "--seeds", "2")
    results = seeds.run_seeds(presets.load("standard_q", ["trials=5000"]), range(2), Threads(2))
    # They end within the fourth window, and each whole one is there.
    header, *rows = [" ".join(line.split()) for line in out.splitlines()[-5:]]
    names, shown = zip(*(row.rsplit(" ", 1) for row in rows), strict=True)
    assert header == "steps reward"
    assert names == ("0–0.5 M", "0.5–1 M", "1–1.5 M", "last 2,000 trials")
    means = [np.mean([result.phases[window] for result in results]) for window in range(3)]
    means.append(np.mean([result.record.values["final_reward"] for result in results]))
    assert [float(number) for number in shown] == pytest.approx(means, abs=0.051)


# --- Progress, pipes and interrupts --------------------------------------------------------------


def test_progress_is_not_shown_in_a_pipe() -> None:
    done = subprocess.run(
        [*POUNCE, "run", "timed", *QUICK], env=environment(), capture_output=True, check=True
    )
    assert done.stderr == b""
    assert done.stdout.startswith(b"timed: ")


def test_what_a_terminal_cannot_show_is_escaped() -> None:
    done = subprocess.run(
        [*POUNCE, "run", "timed", *QUICK[:-1], "80000"],  # half a million steps and more
        env=environment() | {"PYTHONIOENCODING": "ascii"},
        capture_output=True,
        check=True,
    )
    assert b"0\\u20130.5 M" in done.stdout


def read_all(terminal: int) -> bytes:
    """What is written to a terminal until its last writer has gone."""
    parts = []
    while True:
        try:
            part = os.read(terminal, 65_536)
        except OSError:  # how Linux says that nobody is there any more
            part = b""
        if not part:
            return b"".join(parts)
        parts.append(part)


def test_progress_is_shown_on_a_terminal() -> None:
    terminal, end = pty.openpty()
    running = process("run", "timed", *QUICK, "--json", stdout=subprocess.PIPE, stderr=end)
    os.close(end)
    shown = read_all(terminal).decode()
    os.close(terminal)
    out, _ = running.communicate()
    assert running.returncode == 0
    assert len(json.loads(out)["runs"]) == 1
    assert "1/1 runs" in shown
    assert "M steps/s" in shown


def test_a_closed_pipe_ends_quietly() -> None:
    running = process("presets", stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert running.stdout is not None
    running.stdout.close()
    assert running.stderr is not None
    assert running.stderr.read() == b""
    running.stderr.close()
    assert running.wait() == EXIT_PIPE_CLOSED


def test_a_closed_pipe_ends_the_lab_quietly() -> None:
    running = process(
        "lab", "--no-browser", "--port", "9000", stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert running.stdout is not None
    running.stdout.close()
    assert running.stderr is not None
    assert running.stderr.read() == b""
    running.stderr.close()
    assert running.wait() == EXIT_PIPE_CLOSED


def test_a_closed_pipe_for_errors_ends_quietly() -> None:
    running = process("run", "timed", "--seeds", "0", stderr=subprocess.PIPE)
    assert running.stderr is not None
    running.stderr.close()
    assert running.wait() == EXIT_PIPE_CLOSED


def test_an_interrupt_ends_a_run_with_nothing_written(empty_folder: Path) -> None:
    terminal, end = pty.openpty()
    argv = ("run", "timed", "--seeds", "1000", "--out", "results")
    running = process(*argv, stdout=subprocess.PIPE, stderr=end)
    os.close(end)
    os.read(terminal, 1)  # the progress bar: it is at work
    running.send_signal(signal.SIGINT)
    shown = read_all(terminal).decode()
    os.close(terminal)
    out, _ = running.communicate()
    assert (running.returncode, out) == (130, b"")
    assert shown.rstrip().endswith("interrupted")
    assert "Traceback" not in shown
    assert names(empty_folder) == []


def test_a_run_that_fails_is_named_and_nothing_is_written(
    empty_folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(run: Run) -> str:
        raise ZeroDivisionError("no luck")

    monkeypatch.setattr(task, "digest", fail)
    code = main.main(["run", "timed", *QUICK, "--seed-list", "6", "--out", "results"])
    out, err = capsys.readouterr()
    assert (code, out) == (1, "")
    assert err == "the run of seed 6 failed: ZeroDivisionError: no luck\n"
    assert names(empty_folder) == []


# --- --out ---------------------------------------------------------------------------------------


def test_out_writes_what_json_prints(
    empty_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = json_of(capsys, "run", "timed", *QUICK, "--seed-list", "7,3", "--out", "a/b c")
    folder = empty_folder / "a" / "b c"
    assert names(folder) == ["timed-seed3.npz", "timed-seed7.npz", "timed.csv", "timed.json"]
    assert json.loads((folder / "timed.json").read_text(encoding="utf-8")) == document
    rows = list(csv.DictReader((folder / "timed.csv").open(encoding="utf-8")))
    assert [int(row["seed"]) for row in rows] == [7, 3]
    with np.load(folder / "timed-seed7.npz", allow_pickle=False) as kept:
        assert kept["selection_q"].shape == (8, 18, 24, 3)


def test_out_overwrites_only_when_told_to(
    empty_folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    answer(capsys, "run", "timed", *QUICK, "--out", "out")
    before = (empty_folder / "out" / "timed.json").read_bytes()
    argv = ("run", "timed", *QUICK, "--trials", "30", "--out", "out")

    with monkeypatch.context() as patch:
        patch.setattr(seeds, "run_seeds", None)  # no work may be done
        assert main.main(argv) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert " ".join(err.split()) == (
        "--out: 'out' has results of that name already: timed-seed0.npz and 2 more;"
        " allowed: another folder, or --force to replace them"
    )
    assert (empty_folder / "out" / "timed.json").read_bytes() == before

    answer(capsys, *argv, "--force")
    assert (
        json.loads((empty_folder / "out" / "timed.json").read_bytes())["settings"]["trials"] == 30
    )


# --- What is refused -----------------------------------------------------------------------------

TOO_LONG = "9" * 5_000

REFUSED: Sequence[tuple[Sequence[str], str]] = (
    (
        ["rnu"],
        "'rnu' is not a command; allowed: lab, lesson, replay, export, presets, run, tune,"
        " experiment, report, replicate, bench, doctor (did you mean run?)",
    ),
    (
        ["timed"],
        "'timed' is not a command; allowed: lab, lesson, replay, export, presets, run, tune,"
        " experiment, report, replicate, bench, doctor (to open a preset: pounce lab timed)",
    ),
    (["--version", "x"], "'x' is one word too many (see pounce --help)"),
    (
        ["--tyro-print-completion", "nosuch"],
        "'--tyro-print-completion' is not an option of pounce lab (see pounce lab --help)",
    ),
    (
        ["run"],
        "PRESET is missing; allowed: a shipped preset (pounce presets) or a file",
    ),
    (
        ["run", "timed", "--set", "world.size=30", "extra"],
        "'extra' is one word too many (see pounce run --help)",
    ),
    (["run", "timed", "extra"], "'extra' is one word too many (see pounce run --help)"),
    (
        ["run", "timed", "--sedes", "3"],
        "'--sedes' is not an option of pounce run (did you mean --seeds?)",
    ),
    (
        ["run", "timed", "--no-json"],
        "'--no-json' is not an option of pounce run (did you mean --json?)",
    ),
    (["run", "timed", "--seeds"], "--seeds: its value is missing (see pounce run --help)"),
    (["run", "timed", "--set"], "--set: its value is missing (see pounce run --help)"),
    (["run", "timed", "--out", "--json"], "--out: its value is missing (see pounce run --help)"),
    *(
        (
            ["run", "timed", "--seeds", value],
            f"--seeds: {value!r} is not allowed; allowed: a whole number, 1 to 100000",
        )
        for value in ("0", "-1", "1.5", "many", "1_0", " ", "nan", "100001", "1,5", "½")
    ),
    (
        ["run", "timed", "--seeds", TOO_LONG],
        f"--seeds: '{'9' * 37}...' is not allowed; allowed: a whole number, 1 to 100000",
    ),
    *(
        (
            ["run", "timed", "--seed-list", value],
            f"--seed-list: {wrong!r} is not allowed;"
            " allowed: a whole number, 0 to 9223372036854775807",
        )
        for value, wrong in (
            ("", ""),
            ("3,", ""),
            ("3,x", "x"),
            ("-1", "-1"),
            ("3;4", "3;4"),
            ("9223372036854775808", "9223372036854775808"),
        )
    ),
    (
        ["run", "timed", "--seed-list", "7,12,000"],
        "--seed-list: '7,12,000' is not allowed, as its commas may be within a number; allowed:"
        " seeds with commas between them alone",
    ),
    (
        ["run", "timed", "--seed-list", "7,3,7"],
        "--seed-list: 7 is there twice; allowed: each seed once",
    ),
    (
        ["run", "timed", "--seeds", "2", "--seed-list", "7"],
        "--seeds and --seed-list exclude each other; allowed: one of them",
    ),
    *(
        (
            ["run", "timed", "--trials", value],
            f"--trials: {value!r} is not allowed; allowed: a whole number, 1 to 2000000",
        )
        for value in ("0", "-5", "2000001", "few")
    ),
    (
        ["run", "timed", "--workers", "0"],
        "--workers: '0' is not allowed; allowed: a whole number, 1 to 1024",
    ),
    (["run", "timed", "--force"], "--force goes with --out; allowed: both, or neither"),
    (["run", "timed", "--out", ""], "--out: '' is not allowed; allowed: a folder"),
    (
        ["run", "timed", "--out", "/dev/null"],
        "--out: '/dev/null' cannot be written to: File exists; allowed: a folder that can",
    ),
    (
        ["run", "timed", "--out", "/dev/null/out"],
        "--out: '/dev/null/out' cannot be written to: Not a directory; allowed: a folder that can",
    ),
    (
        ["lab", "--port", "99999"],
        "--port: '99999' is not allowed; allowed: a whole number, 0 to 65535",
    ),
    (["--port", "x"], "--port: 'x' is not allowed; allowed: a whole number, 0 to 65535"),
    (
        ["lab", "--seed", "-1"],
        "--seed: '-1' is not allowed; allowed: a whole number, 0 to 9223372036854775807",
    ),
    (["lab", "--host", ""], "--host: '' is not allowed; allowed: an address of this machine"),
    (["presets", "x"], "'x' is one word too many (see pounce presets --help)"),
    (
        ["bench", "--repetitions", "0"],
        "--repetitions: '0' is not allowed; allowed: a whole number, 1 to 1000",
    ),
    (
        ["bench", "--scrub", "--load", "2"],
        "--learners, --page, --load, --audience, --own, --scrub and --side exclude each other;"
        " allowed: one of them",
    ),
)


@pytest.mark.parametrize(
    ("argv", "message"), REFUSED, ids=[" ".join(argv)[:40] for argv, _ in REFUSED]
)
def test_what_makes_no_sense_is_refused(
    argv: Sequence[str], message: str, empty_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code = main.main(argv)
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    assert " ".join(err.split()) == " ".join(message.split())
    assert max(map(len, err.splitlines())) <= 80
    assert names(empty_folder) == []


WRONG_PRESETS: Sequence[tuple[Sequence[str], Sequence[str]]] = (
    (["run", "tmied"], ["tmied: is neither a shipped preset nor a file (did you mean timed?)"]),
    (
        ["run", "timed", "--set", "world.size=3", "lerner.alpha=1"],
        ["--set world.size=3: ", "--set lerner.alpha=1: "],
    ),
    (["run", "timed", "--set", "foo"], ["--set foo: is not a setting; allowed: KEY=VALUE"]),
    (["run", "wrong.yaml"], ["wrong.yaml:1: extends: ", "wrong.yaml:2: trials: value -3"]),
    (["lab", "nosuch"], ["nosuch: is neither"]),
    (["bench", "timed", "nosuch"], ["nosuch: is neither"]),
)


@pytest.mark.parametrize(("argv", "starts"), WRONG_PRESETS, ids=lambda value: " ".join(value)[:40])
def test_a_wrong_preset_is_refused_with_all_its_problems(
    argv: Sequence[str],
    starts: Sequence[str],
    empty_folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (empty_folder / "wrong.yaml").write_text("extends: nosuch\ntrials: -3\n", encoding="utf-8")
    out_folder = ["--out", "out"] if argv[0] == "run" else []
    code = main.main([*argv, *out_folder])
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    lines = err.splitlines()
    assert len(lines) == len(starts)
    assert [line[: len(start)] for line, start in zip(lines, starts, strict=True)] == starts
    assert names(empty_folder) == ["wrong.yaml"]


def test_the_process_ends_with_the_exit_code() -> None:
    done = subprocess.run(
        [*POUNCE, "run", "timed", "--seeds", "0"], env=environment(), capture_output=True
    )
    assert (done.returncode, done.stdout) == (2, b"")
    assert done.stderr.startswith(b"--seeds: '0' is not allowed")


# --- The other commands --------------------------------------------------------------------------


KEPT = ("sessions", "journal", "made_again", "budget")
"""What the lab is told of sessions (``test_lab.py``)."""


@pytest.mark.parametrize("argv", [[], ["lab"], ["lab", "timed"]])
def test_the_lab_is_the_default(
    argv: Sequence[str], opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert answer(capsys, *argv) == ""
    call = {key: value for key, value in opened[0].items() if key not in KEPT}
    assert [call] == [
        {
            "spec": presets.load("timed"),
            "preset": "timed",
            "seed": 0,
            "presets": {name: presets.load(name) for name in presets.shipped()},
            "host": "127.0.0.1",
            "port": 8080,
            "open_browser": True,
            "save_dir": None,
            "results": Path("results"),
            "names": [],
            "token": None,
            "log_level": 30,
            "opening": True,
            "opens_stand": None,
            "lesson": None,
        }
    ]


@pytest.mark.parametrize("command", [["lab", "hierarchical_2"], []])
def test_the_lab_takes_options(
    command: Sequence[str], opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    options = ("--host", "0.0.0.0", "--port", "9000", "--no-browser", "--seed", "3")
    options = (*options, "--no-opening")
    answer(capsys, *command, *options)
    (call,) = opened
    assert call["preset"] == (command or ["", "timed"])[1]
    assert call["spec"] == presets.load(call["preset"])
    assert (call["host"], call["port"], call["open_browser"]) == ("0.0.0.0", 9000, False)
    assert (call["seed"], call["opening"]) == (3, False)


def test_the_lab_answers_to_names_of_the_command_line_and_the_environment(
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("POUNCE_NAMES", "HUB.example.edu.:8443,, box ")
    answer(capsys, "lab", "--name", "lab.example.edu", "--name", "lübeck.example")
    assert [str(name) for name in opened[0]["names"]] == [
        "lab.example.edu",
        "xn--lbeck-kva.example",
        "hub.example.edu:8443",
        "box",
    ]


@pytest.mark.parametrize("name", ["", "two words", "https://lab.example.edu", "a..b"])
def test_a_name_that_no_host_can_have_is_refused(
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    name: str,
) -> None:
    assert main.main(["lab", "--name", name]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert said.startswith(f"--name: {name!r} is not allowed")
    assert "allowed: the name of a host, such as lab.example.edu" in said
    if name:
        monkeypatch.setenv("POUNCE_NAMES", f"lab.example.edu,{name}")
        assert main.main(["lab"]) == 2
        said = " ".join(capsys.readouterr().err.split())
        assert said.startswith(f"POUNCE_NAMES: {name!r} is not allowed")
    assert opened == []


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.7.7", "lab.example.edu"])
def test_a_lab_on_the_network_wants_a_token_unless_it_is_told_not_to(
    opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str], host: str
) -> None:
    for _ in range(2):
        answer(capsys, "lab", "--host", host)
    assert main.main(["lab", "--host", host, "--no-token"]) == 0
    assert capsys.readouterr().err.startswith("Warning: whoever can reach this machine")
    first, second, none = (call["token"] for call in opened)
    assert len(first) >= 32
    assert first != second
    assert none is None


@pytest.mark.parametrize("host", ["127.0.0.1", "::1", "localhost"])
def test_a_lab_for_this_machine_wants_no_token_unless_one_is_chosen(
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    host: str,
) -> None:
    answer(capsys, "lab", "--host", host)
    answer(capsys, "lab", "--host", host, "--no-token")
    monkeypatch.setenv("POUNCE_TOKEN", "correct-horse-battery")
    answer(capsys, "lab", "--host", host)
    answer(capsys, "lab", "--host", "0.0.0.0")
    tokens = [call["token"] for call in opened]
    assert tokens == [None, None, "correct-horse-battery", "correct-horse-battery"]


@pytest.mark.parametrize("token", ["", "short", "with a blank in it", "a&b=c;d" * 3])
def test_a_token_that_cannot_be_used_is_refused_and_not_repeated(
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    token: str,
) -> None:
    monkeypatch.setenv("POUNCE_TOKEN", token)
    assert main.main(["lab"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("POUNCE_TOKEN: its value is not allowed; allowed: 12 to 200")
    assert not token or token not in err
    assert opened == []


@pytest.mark.parametrize(
    ("words", "level"), [((), 30), (("--log-level", "debug"), 10), (("--log-level", "ERROR"), 40)]
)
def test_the_lab_says_as_much_as_it_is_told_to(
    opened: list[dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    words: Sequence[str],
    level: int,
) -> None:
    answer(capsys, "lab", *words)
    assert opened[0]["log_level"] == level


@pytest.mark.parametrize("level", ["", "loud", "10"])
def test_a_log_level_that_there_is_not_is_refused(
    opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str], level: str
) -> None:
    assert main.main(["lab", "--log-level", level]) == 2
    assert capsys.readouterr() == (
        "",
        f"--log-level: {level!r} is not allowed; allowed: debug, info, warning, error\n",
    )
    assert opened == []


def test_port_0_is_any_free_one(
    opened: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    answer(capsys, "lab", "--port", "0")
    assert opened[0]["port"] == 0


@pytest.mark.parametrize(
    ("host", "reason"),
    [("192.0.2.1", "Cannot assign requested address"), ("no..host", "label empty or too long")],
)
def test_an_address_that_cannot_be_listened_on_is_refused(
    host: str, reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["lab", "--host", host, "--port", "9000"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    said = " ".join(err.split())
    assert said.startswith(f"--host and --port: {host!r} and 9000 cannot be listened on: ")
    assert reason in said
    assert said.endswith("; allowed: an address of this machine and a free port")


def test_what_goes_wrong_while_the_lab_is_open_is_not_laid_to_the_address(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run_lab(**arguments: Any) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("app.page.serving.run_lab", run_lab)
    assert main.main(["lab"]) == 1
    assert capsys.readouterr().err == "cannot go on: [Errno 28] No space left on device\n"


def test_presets_are_listed_with_their_files(capsys: pytest.CaptureFixture[str]) -> None:
    text = answer(capsys, "presets")
    for name, file in presets.shipped().items():
        assert f"\n{name}" in "\n" + text
        assert f"  {file}\n" in text
        assert presets.load(name).description in " ".join(text.split())
    descriptions = text.partition("\n\n")[0].splitlines()
    assert max(map(len, descriptions)) <= 80


FOUND = {
    "learners": {
        "standard_q": {
            "steps_per_s": 41_500_000.0,
            "ratio_to_c": None,
            "ratio_to_plain": 2.125,
            "ratio_to_python": 612.4,
        }
    },
    "notes": ["no C compiler: no comparison with C"],
}


@pytest.fixture
def compared(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Any, int]]:
    """What was to be measured, in place of measuring it."""
    from benchmarks import compare

    calls: list[tuple[Any, int]] = []

    def fake(specs: dict[str, RunSpec], repetitions: int, progress: Any) -> Any:
        progress("busy")
        calls.append((specs, repetitions))
        return FOUND

    monkeypatch.setattr(compare, "compare", fake)
    return calls


def test_bench_measures_all_shipped_presets_that_the_programs_know(
    compared: list[tuple[Any, int]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["bench"]) == 0
    ((specs, repetitions),) = compared
    loaded = {name: presets.load(name) for name in presets.shipped()}
    assert specs == {name: spec for name, spec in loaded.items() if incomparable(spec) is None}
    assert repetitions == 5
    out, err = capsys.readouterr()
    rows = [line.split() for line in out.splitlines()]
    assert rows[1] == ["standard_q", "41.50", "–", "2.12", "612"]
    assert err == "no C compiler: no comparison with C\n"


def test_bench_prints_json_of_the_promised_shape(
    compared: list[tuple[Any, int]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["bench", "timed", "standard_q", "--json", "--repetitions", "2"]) == 0
    ((specs, repetitions),) = compared
    assert (list(specs), repetitions) == (["timed", "standard_q"], 2)
    out, err = capsys.readouterr()
    assert json.loads(out) == {"learners": FOUND["learners"]}
    assert err == "no C compiler: no comparison with C\n"


def test_bench_measures_learners_beside_the_timed_one(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from benchmarks import speeds

    found = {
        "learners": {"standard_q": {"steps_per_s": 61.4e6, "ratio_to_timed": 1.234}},
        "watching": {"novelty": 0.987},
    }
    calls: list[tuple[Any, ...]] = []

    def fake(*given: Any) -> Any:
        calls.append(given[:2])
        return found

    monkeypatch.setattr(speeds, "measure_speeds", fake)
    assert main.main(["bench", "--learners", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == found
    assert main.main(["bench", "standard_q", "--learners", "--repetitions", "2"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["standard_q", "61.4", "1.23"] in lines
    assert lines[-1] == ["novelty", "0.987"]
    every = {name: presets.load(name) for name in presets.shipped()}
    assert calls == [(every, 5), ({"standard_q": every["standard_q"]}, 2)]


def test_bench_measures_walking_in_the_past(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from benchmarks import scrub

    found = {"moments_per_s": 61.4, "p95_ms": 24.8, "learner_share": 0.964}
    calls: list[tuple[Any, ...]] = []

    def fake(*given: Any) -> Any:
        calls.append(given[:3])
        return found

    monkeypatch.setattr(scrub, "measure_scrub", fake)
    assert main.main(["bench", "--scrub", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == found
    assert main.main(["bench", "standard_q", "--scrub", "--repetitions", "2"]) == 0
    assert "standard_q" in (out := capsys.readouterr().out)
    assert all(number in out for number in ("61 a second", "25 ms", "0.96 of its rate"))
    assert calls == [
        (presets.load("timed"), "timed", 5),
        (presets.load("standard_q"), "standard_q", 2),
    ]

    def fail(*_: Any) -> Any:
        raise RuntimeError("a moment was not made in time")

    monkeypatch.setattr(scrub, "measure_scrub", fail)
    assert main.main(["bench", "--scrub"]) == 1
    assert capsys.readouterr() == ("", "a moment was not made in time\n")


def test_bench_measures_an_audience(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from benchmarks import audience

    found = {
        "watchers": 30,
        "click_ms": {"p50": 90.0, "p95": 121.0},
        "class_click_ms": {"p50": 91.0, "p95": 133.0},
        "kB_per_s_each": 4.2,
        "learner_share": 0.97,
    }
    calls: list[tuple[Any, ...]] = []

    def fake(*given: Any) -> Any:
        calls.append((given[1], given[3], given[4]))
        return found

    monkeypatch.setattr(audience, "measure_audience", fake)
    assert main.main(["bench", "--audience", "30", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == found
    assert main.main(["bench", "standard_q", "--audience", "30", "--repetitions", "2"]) == 0
    out = capsys.readouterr().out
    assert all(
        words in out for words in ("30 who look on", "121 (95 %)", "133 (95 %)", "4.2 kB", "0.97")
    )
    assert calls == [("timed", 30, 5), ("standard_q", 30, 2)]


def test_a_bench_whose_programs_disagree_fails(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from benchmarks import compare

    def disagree(*_: Any) -> Any:
        raise compare.MismatchError("timed: other steps in C")

    monkeypatch.setattr(compare, "compare", disagree)
    assert main.main(["bench"]) == 1
    assert capsys.readouterr() == ("", "timed: other steps in C\n")


@pytest.mark.parametrize("argv", [["run", "timed"], ["bench"]])
def test_an_interrupt_has_its_exit_code(
    argv: Sequence[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from benchmarks import compare

    def interrupt(*_: Any, **__: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(compare, "compare", interrupt)
    monkeypatch.setattr(seeds, "run_seeds", interrupt)
    assert main.main(argv) == 130
    assert capsys.readouterr() == ("", "interrupted\n")


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("12,000", 12_000),
        ("12 000", 12_000),
        ("12\u202f000", 12_000),
        ("12.000", 12_000),
        ("1e3", 1_000),
        ("٣", 3),
        ("+5", 5),
    ],
)
def test_numbers_are_taken_as_people_write_them(text: str, number: int) -> None:
    assert whole_number("--trials", text, 1, 2_000_000) == number
