"""Names and words that come from outside: what they become in files, answers and pages."""

import io
import json
import os
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from app.cli import main
from app.documents import experiments, tree
from app.util.texts import as_path, as_text, folder_name, for_terminal, written
from tests.support.reports import without_pictures

EXPERIMENT = "presets: [timed]\nset: {world.size: 40}\ntrials: 30\nseeds: 1\n"
PRESET = "extends: timed\nworld: {size: 40}\ntrials: 30\n"
LATIN_1 = os.fsdecode(b"caf\xe9")
ESCAPE = "a\nb\x1b[31m"

on_bytes = pytest.mark.skipif(
    sys.platform in ("win32", "darwin"), reason="this system's names are all Unicode"
)


def answer(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    code = main.main(words)
    said = capsys.readouterr()
    return code, said.out, said.err


# --- Names of files ------------------------------------------------------------------------------


@on_bytes
@pytest.mark.parametrize(
    ("stem", "called"),
    [(LATIN_1, "caf\ufffd"), (ESCAPE, "a\ufffdb\ufffd[31m")],
)
def test_an_experiment_in_a_file_of_any_name_is_made_resumed_and_reported(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    stem: str,
    called: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    if stem != ESCAPE:
        # What a picture says might be obeyed as well.
        without_pictures(monkeypatch)
    Path(f"{stem}.yaml").write_text(EXPERIMENT)
    code, out, err = answer(capsys, "experiment", f"{stem}.yaml")
    assert (code, err) == (0, "")
    assert f"results in results/{called}" in out
    code, out, _ = answer(capsys, "experiment", f"{stem}.yaml", "--resume", "--json")
    found = json.loads(out)
    assert (code, found["experiment"], found["folder"]) == (0, called, f"results/{called}")
    assert not any("\ud800" <= c <= "\udfff" for c in json.dumps(found, ensure_ascii=False))
    code, out, err = answer(capsys, "report", f"results/{called}", "--out", f"{stem}.html")
    assert (code, err) == (0, "")
    assert "\x1b" not in out
    page = Path(f"{stem}.html").read_text(encoding="utf-8")
    assert f"<title>{called[0].upper()}{called[1:]}</title>" in page
    assert "\x1b" not in page


@on_bytes
def test_a_preset_in_a_file_of_any_name_is_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path(f"{LATIN_1}.yaml").write_text(PRESET)
    out = os.fsdecode(b"to \xff")
    code, said, err = answer(capsys, "run", f"{LATIN_1}.yaml", "--json", "--out", out)
    assert (code, err) == (0, "")
    assert json.loads(said)["preset"] == "caf\ufffd.yaml"
    assert json.loads(Path(out, f"{LATIN_1}.json").read_text("utf-8")) == json.loads(said)
    assert answer(capsys, "run", f"{LATIN_1}.yaml")[1].startswith("caf\ufffd.yaml: ")


@on_bytes
def test_a_locale_that_knows_ascii_alone_makes_no_difference(tmp_path: Path) -> None:
    (tmp_path / "Übung.yaml").write_text("extends: größe.yaml\ntrials: 30\n")
    (tmp_path / "größe.yaml").write_text(PRESET)
    (tmp_path / "frage.yaml").write_text(EXPERIMENT.replace("timed", "Übung.yaml"))
    shutil.copy(tmp_path / "frage.yaml", tmp_path / "Frage ü.yaml")
    locale = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    script = (
        "import sys; from app.cli import main\n"
        "assert sys.getfilesystemencoding() == 'ascii'\n"
        "name, folder = sys.argv[1:]\n"
        "codes = [main.main(['experiment', name, '--json']),\n"
        "    main.main(['experiment', name, '--resume', '--json']),\n"
        "    main.main(['run', name, '--json', '--set', 'description=' + folder]),\n"
        "    main.main(['report', folder])]\n"
        "sys.exit(str(codes))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, "Frage ü.yaml", "results/Frage ü"],
        cwd=tmp_path,
        env=os.environ | locale,
        capture_output=True,
        check=False,
    )
    # What is no preset is said in its own words, with its name.
    complaint, codes = done.stderr.decode().strip().rsplit("\n", 1)
    assert codes == "[0, 0, 2, 0]"
    assert "Frage \\xfc.yaml:1: presets:" in complaint
    first, second, report = done.stdout.decode().splitlines()
    for line in (first, second):
        assert json.loads(line)["folder"] == "results/Frage ü"
    assert report == "results/Frage \\xfc/report.html"
    folder = tmp_path / "results" / "Frage ü"
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "pounce experiment &#39;Frage ü.yaml&#39;" in page
    with closing(sqlite3.connect(folder / "results.sqlite")) as database:
        assert database.execute("SELECT preset FROM runs").fetchall() == [("Übung.yaml",)]


@pytest.mark.parametrize(
    ("name", "called"),
    [
        ("mine.yaml", "mine"),
        ("..yaml", "experiment"),
        ("...yaml", "experiment"),
        ("two. .yaml", "two"),
        (" .yaml", "experiment"),
    ],
)
def test_an_experiments_folder_is_within_the_results(name: str, called: str) -> None:
    assert experiments.parse(EXPERIMENT, name).name == called
    assert folder_name(called) == called


def test_names_become_texts_and_texts_become_names() -> None:
    assert as_text(os.fsdecode("Übung".encode())) == "Übung"
    assert as_text(LATIN_1) == "caf\ufffd"
    assert as_text("\ud800x") == "\ufffdx"
    assert as_path("Übung") == os.fsdecode("Übung".encode())
    with pytest.raises(ValueError, match="surrogates"):
        as_path("\ud800")
    assert written("a\x00b\x1bc\ud800\n") == "a\ufffdb\ufffdc\ufffd\n"


# --- What is printed -----------------------------------------------------------------------------


def test_nothing_that_a_terminal_obeys_is_printed() -> None:
    assert for_terminal("Ü 先\t\n🐱\u200d👓") == "Ü 先\t\n🐱\u200d👓"
    assert for_terminal("\x1b[31m\x07\r\x9b\u202e\u2029") == r"\x1b[31m\x07\r\x9b\u202e\u2029"


@pytest.mark.parametrize(
    "words",
    [
        ["\x1b[31m"],
        ["run", "\x1b[31m"],
        ["run", "timed", "\x1b[31m"],
        ["run", "timed", "--\x1b[31m"],
        ["run", "timed", "--seeds", "\x1b[31m"],
        ["run", "timed", "--set", "trials=\x1b[31m"],
        ["run", "timed", "--set", "\udce9\x1b[31m=3"],
        ["run", "timed", "--set", "description=\udce9\x1b[31m"],
        ["lab", "--save-dir", "\x1b[31m\udce9"],
        ["experiment", "\x1b[31m"],
        ["report", "\x1b[31m"],
        ["bench", "\x1b[31m"],
    ],
    ids=lambda words: " ".join(words).encode("ascii", "replace").decode().replace("\x1b", "ESC"),
)
def test_words_are_refused_without_being_obeyed(
    capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    code, out, err = answer(capsys, *words)
    assert code in (1, 2)
    assert "[31m" in err
    assert "\x1b" not in out + err
    assert not any("\ud800" <= character <= "\udfff" for character in err)


# --- Standard input ------------------------------------------------------------------------------


class Piped:
    """Standard input as a pipe brings it."""

    def __init__(self, data: bytes) -> None:
        self.buffer = io.BytesIO(data)

    def isatty(self) -> bool:
        return False


def test_a_preset_comes_from_standard_input(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", Piped(PRESET.encode()))
    code, out, err = answer(capsys, "run", "-", "--json", "--out", str(tmp_path))
    assert (code, err) == (0, "")
    assert json.loads(out)["preset"] == "stdin"
    assert json.loads((tmp_path / "stdin.json").read_text()) == json.loads(out)


def test_an_experiment_comes_from_standard_input_and_goes_on_by_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    without_pictures(monkeypatch)
    codes = []
    for text, words in (
        (EXPERIMENT, []),
        (EXPERIMENT.replace("\n", "\r\n"), ["--resume"]),
        (EXPERIMENT.replace("30", "31"), ["--resume"]),
    ):
        monkeypatch.setattr(sys, "stdin", Piped(text.encode()))
        codes.append(answer(capsys, "experiment", "-", *words))
    assert [code for code, _, _ in codes] == [0, 0, 2]
    assert "results in results/stdin" in codes[0][1]
    assert "another experiment" in codes[2][2]
    # It cannot be read again; what was read is in the folder.
    assert main.main(["report", "results/stdin"]) == 0
    page = Path("results/stdin/report.html").read_text(encoding="utf-8")
    assert "pounce experiment results/stdin/experiment.yaml" in page


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"", "stdin:1: is empty"),
        (b"\0" * 9, "stdin: is not a text: it contains a NUL byte"),
        (b"#" * (tree.MAX_BYTES + 1), "stdin: is too large; allowed: at most 65536 bytes"),
        (b"\n\ntrials: 0\n", "stdin:3: trials: value 0: must be at least 1"),
    ],
)
@pytest.mark.parametrize("command", ["run", "experiment", "lab", "bench"])
def test_what_standard_input_brings_is_checked_as_a_file_is(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
    data: bytes,
    expected: str,
) -> None:
    monkeypatch.setattr(sys, "stdin", Piped(data))
    code, _, err = answer(capsys, command, "-")
    assert code == 2
    assert expected in err


def test_standard_input_that_is_closed_or_a_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", None)
    assert answer(capsys, "run", "-")[::2] == (
        2,
        "stdin: is closed; allowed: a text, or a file instead of -\n",
    )
    terminal = Piped(b"trials: 0\n")
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stdin", terminal)
    assert answer(capsys, "run", "-")[2].startswith("reading from the terminal; Ctrl-D")


@pytest.mark.parametrize("command", ["run", "experiment", "lab", "bench"])
def test_what_is_no_file_of_text_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    made = {
        "folder": "is a directory",
        "empty": "is empty",
        "binary": "is not a text",
        "large": "is too large, 1073741824 bytes",
        "loop": "cannot be read: Too many levels of symbolic links",
        "pipe": "is not a regular file; allowed: a file",
        "x" * 300: "cannot be read: File name too long",
    }
    (tmp_path / "folder").mkdir()
    (tmp_path / "empty").touch()
    (tmp_path / "binary").write_bytes(bytes(range(256)))
    with (tmp_path / "large").open("wb") as file:
        file.truncate(1 << 30)
    (tmp_path / "loop").symlink_to("loop")
    os.mkfifo(tmp_path / "pipe")
    for name, expected in made.items():
        code, _, err = answer(capsys, command, str(tmp_path / name))
        assert code == 2
        assert expected in err
