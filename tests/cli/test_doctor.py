"""``pounce doctor``: what it finds here, and what it says where something is amiss."""

import json
import os
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

from app.cli import doctor, main
from app.cli.doctor import Finding, examine
from sim import compile_cache

OF_ALL_MACHINES = ("pounce", "guide", "Python", "numba", "viser", "learner", "cache", "fonts")


@pytest.fixture(autouse=True)
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def found(name: str, results: Path = Path("results")) -> Finding:
    return next(finding for finding in examine(results) if finding.name == name)


def test_all_is_well_where_tests_run(
    empty_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["doctor"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    states = {line.split()[1]: line.split()[0] for line in out.splitlines() if line[:1] > " "}
    assert {states[name] for name in OF_ALL_MACHINES} <= {"ok", "warning"}
    assert out.splitlines()[-1].startswith("Pounce works here")
    assert os.listdir(empty_folder) == []


def test_json_has_every_finding(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["doctor", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["works"] is True
    names = [finding["name"] for finding in document["findings"]]
    assert set(OF_ALL_MACHINES) < set(names)
    assert len(names) == len(set(names))
    for finding in document["findings"]:
        assert set(finding) == {"name", "state", "found", "remedy"}
        assert (finding["state"] == "ok") == (finding["remedy"] == "")


def version_but_for(package: str, version: str | None) -> Callable[[str], str]:
    true = metadata.version

    def told(name: str) -> str:
        if name != package:
            return true(name)
        if version is None:
            raise metadata.PackageNotFoundError(name)
        return version

    return told


@pytest.mark.parametrize(
    ("package", "version", "says"),
    [("scipy", None, "not installed"), ("viser", "1.2.0", "1.2.0, and not <1.2,>=1.1.1")],
)
def test_a_package_that_is_not_as_it_must_be_is_told_and_nothing_is_tried_with_it(
    package: str,
    version: str | None,
    says: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(metadata, "version", version_but_for(package, version))
    assert main.main(["doctor"]) == 1
    out = capsys.readouterr().out
    assert f"broken   {package:<12} {says}\n" in out
    assert "make setup" in out
    assert f"\nBroken: {package}.\n" in out
    assert "learner" not in out


def test_what_pounce_can_do_without_is_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metadata, "version", version_but_for("distributed", None))
    finding = found("distributed")
    assert (finding.state, finding.remedy) == ("ok", "")
    assert finding.found == "not installed; pounce experiment --cluster needs it"


def test_a_check_that_fails_hides_no_other(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail() -> Any:
        raise ImportError("libnothing.so: cannot open shared object file")

    monkeypatch.setattr("app.experiments.task.prepare", fail)
    assert main.main(["doctor"]) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert "broken learner ImportError: libnothing.so: cannot open shared object file" in out
    assert " results " in out


def test_numba_that_is_switched_off_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim.compiled.is_compiled", lambda: False)
    finding = found("learner")
    assert finding.state == "warning"
    assert finding.remedy == "unset NUMBA_DISABLE_JIT"


def test_a_cache_without_a_place_is_told(
    empty_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (empty_folder / "file").write_text("")
    monkeypatch.setattr(compile_cache, "places", lambda _: [empty_folder / "file" / "compiled"])
    finding = found("cache")
    assert finding.state == "warning"
    assert "NUMBA_CACHE_DIR" in finding.remedy


def test_a_cache_that_is_still_empty_is_told(
    empty_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = empty_folder / "new" / "compiled"
    monkeypatch.setattr(compile_cache, "places", lambda _: [place])
    assert found("cache") == Finding("cache", "ok", f"empty; code will be kept in {place}")


def test_scripts_without_a_font_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.charts.paper.fonts.system_fonts", lambda: ())
    finding = found("fonts")
    assert finding.state == "warning"
    assert "Chinese" in finding.found
    assert "Greek" not in finding.found


@pytest.mark.parametrize("variable", ["CHROMIUM", "BROWSER"])
def test_a_browser_that_is_not_there_is_told(
    variable: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(variable, "/nowhere/chromium")
    monkeypatch.setattr("app.cli.doctor.chosen_browser", lambda: None)
    finding = found({"CHROMIUM": "chromium", "BROWSER": "browser"}[variable])
    assert finding.state == "warning"
    assert finding.remedy


def test_results_that_cannot_be_written_are_told(empty_folder: Path) -> None:
    (empty_folder / "file").write_text("")
    finding = found("results", empty_folder / "file" / "results")
    assert finding.state == "warning"
    assert finding.found.endswith(": Not a directory")


def test_a_disk_without_locks_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.experiments.claims.takes_locks", lambda _: False)
    assert found("results").found.endswith("its disk cannot lock files")


def test_a_full_disk_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    free = doctor.shutil.disk_usage("/")._replace(free=10**6)
    monkeypatch.setattr(doctor.shutil, "disk_usage", lambda _: free)
    assert found("results").state == "warning"


def test_no_folder_at_all_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["doctor", "--results", ""]) == 2
    assert capsys.readouterr() == ("", "--results: '' is not allowed; allowed: a folder\n")
