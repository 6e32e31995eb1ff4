"""The command ``pounce doctor``: whether this machine has what pounce needs, and what to do if not.

Each check ends in a finding, whatever it meets: nothing that is broken here may keep the rest from
being told.
"""

import json
import platform
import shutil
import sys
import tempfile
import textwrap
import time
import tomllib
import webbrowser
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal, NamedTuple

from tyro.conf import arg

from app import __version__
from app.cli.answers import EXIT_FAILED, EXIT_OK, RESULTS, Flag, UsageError, say, shown
from app.util.machine import available_cores, memory_mb
from app.util.web_browser import CHROMIUM_ADVICE, chosen_browser, find_chromium

if TYPE_CHECKING:
    from packaging.requirements import Requirement

EXAMPLES = ("pounce doctor", "pounce doctor --json", "pounce doctor --results /data/results")

DISTRIBUTION: Final = "pounce-lab"
ROOT: Final = Path(__file__).parents[2]
"""The folder that holds the packages: a clone, or where packages are installed."""
OPTIONAL: Final = {
    "distributed": "pounce experiment --cluster needs it",
    "gymnasium": "pounce bench compares with it",
}
"""What works without, and what does not then."""
SCRIPTS: Final = {
    "Arabic": "ش",
    "Chinese": "猫",
    "Cyrillic": "ж",
    "Devanagari": "अ",
    "Greek": "ε",
    "Hebrew": "ש",
    "Japanese": "か",
    "Korean": "한",
    "Thai": "ก",
}
"""A character of each of some scripts in which labels may be."""
LEAST_MEMORY_MB: Final = 500
"""A lab with a class of readers takes half of it."""
LEAST_ROOM_MB: Final = 500
"""A few thousand runs take less."""

_MARGIN: Final = " " * 22

State = Literal["ok", "warning", "broken"]


class Finding(NamedTuple):
    """What one check has come to."""

    name: str
    state: State
    """Nothing works with what is broken; with a warning, one thing does not, or not well."""
    found: str
    remedy: str = ""
    """What to do, unless all is well."""


@dataclass(frozen=True)
class Doctor:
    """Say whether this machine has what pounce needs, and what to do if not."""

    results: Annotated[str, arg(metavar="FOLDER")] = RESULTS
    """Where results are to be written."""
    json: Flag = False
    """Print one JSON object and nothing else."""


def obey(command: Doctor) -> int:
    """Look at everything and say what was found; returns the exit code.

    Raises:
        UsageError: the words make no sense.
    """
    if not command.results or "\0" in command.results:
        raise UsageError(f"--results: {shown(command.results)} is not allowed; allowed: a folder")
    findings: list[Finding] = []
    for finding in examine(Path(command.results)):
        findings.append(finding)
        if not command.json:
            say(_line(finding))
    broken = [finding.name for finding in findings if finding.state == "broken"]
    if command.json:
        document = {
            "version": __version__,
            "works": not broken,
            "findings": [finding._asdict() for finding in findings],
        }
        say(json.dumps(document))
    else:
        n_warnings = sum(finding.state == "warning" for finding in findings)
        warnings = f"; {n_warnings} warning{'s' * (n_warnings > 1)}" if n_warnings else ""
        say(f"\nBroken: {', '.join(broken)}." if broken else f"\nPounce works here{warnings}.")
    return EXIT_FAILED if broken else EXIT_OK


def _line(finding: Finding) -> str:
    parts = [f"{finding.state:<8} {finding.name:<12} {finding.found}"]
    if finding.remedy:
        parts.append(f"{_MARGIN}To do: {finding.remedy}")
    return "\n".join(map(_filled, parts))


def _filled(text: str) -> str:
    # A path is to be copied, and so stays whole.
    return textwrap.fill(
        text, 80, subsequent_indent=_MARGIN, break_long_words=False, break_on_hyphens=False
    )


# --- What is looked at ---------------------------------------------------------------------------


def examine(results: Path) -> Iterator[Finding]:
    """Look at one thing after another.

    Args:
        results: folder into which results are to be written; it need not exist.
    """
    yield Finding("pounce", "ok", f"{__version__} in {ROOT}")
    yield _examined("guide", _guide)
    works = True
    for finding in _versions():
        works = works and finding.state != "broken"
        yield finding
    if works:
        # What these need is there, so they say something of their own.
        yield _examined("learner", _learner)
        yield _examined("cache", _cache)
        yield _examined("fonts", _fonts)
    yield _examined("cores", _cores)
    yield _examined("memory", _memory)
    yield _examined("browser", _browser)
    if _is_clone():
        yield _examined("chromium", _chromium)
    yield _examined("results", lambda: _results(results))


def _examined(name: str, check: Callable[[], Finding]) -> Finding:
    try:
        return check()
    except Exception as error:  # noqa: BLE001 - whatever it is, it is what was looked for
        remedy = "install pounce anew; if it comes again, it is a fault of pounce"
        return Finding(name, "broken", f"{type(error).__name__}: {error}", remedy)


def _is_clone() -> bool:
    return (ROOT / "pyproject.toml").is_file() and (ROOT / "tests").is_dir()


def _guide() -> Finding:
    page = ROOT / "README.md"
    if not page.is_file():
        files = metadata.distribution(DISTRIBUTION).files or ()
        page = next(
            (
                Path(str(file.locate())).resolve()
                for file in files
                if file.parts[-3:] == ("doc", DISTRIBUTION, "README.md")
            ),
            page,
        )
    if page.is_file():
        return Finding("guide", "ok", str(page))
    return Finding("guide", "warning", "the documentation is not here", "look where pounce is from")


def _versions() -> Iterator[Finding]:
    try:
        python, needed = _declared()
    except Exception as error:  # noqa: BLE001 - whatever it is, it is what was looked for
        yield Finding("versions", "broken", f"{type(error).__name__}: {error}", _install())
        return
    from packaging.specifiers import SpecifierSet

    version = platform.python_version()
    is_right = SpecifierSet(python).contains(version, prereleases=True)
    remedy = "" if is_right else f"install pounce with a Python {python}"
    where = f"{version} in {sys.prefix}"
    yield Finding("Python", "ok" if is_right else "broken", where, remedy)
    for requirement in needed:
        yield _package(requirement)
    for name, without in OPTIONAL.items():
        yield Finding(name, "ok", _version_of(name) or f"not installed; {without}")


def _declared() -> "tuple[str, list[Requirement]]":
    """Which Python and which packages pounce asks for."""
    from packaging.requirements import Requirement

    if _is_clone():
        # What was noted when it was installed may be older than the clone.
        with (ROOT / "pyproject.toml").open("rb") as file:
            project = tomllib.load(file)["project"]
        return project["requires-python"], [Requirement(text) for text in project["dependencies"]]
    installed = metadata.distribution(DISTRIBUTION)
    all_of_them = [Requirement(text) for text in installed.requires or ()]
    needed = [one for one in all_of_them if not one.marker or one.marker.evaluate({"extra": ""})]
    return installed.metadata["Requires-Python"], needed


def _version_of(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _package(requirement: "Requirement") -> Finding:
    version = _version_of(requirement.name)
    if version is None:
        return Finding(requirement.name, "broken", "not installed", _install())
    if not requirement.specifier.contains(version, prereleases=True):
        found = f"{version}, and not {requirement.specifier}"
        return Finding(requirement.name, "broken", found, _install())
    return Finding(requirement.name, "ok", version)


def _install() -> str:
    if _is_clone():
        return f"make setup in {ROOT}, or pip install -e {ROOT}"
    return "install pounce anew"


def _learner() -> Finding:
    from app.experiments.task import prepare
    from sim.compiled import is_compiled

    began = time.perf_counter()
    prepare()
    seconds = time.perf_counter() - began
    if not is_compiled():
        found = "it learns, some hundred times too slowly: NUMBA_DISABLE_JIT is set"
        return Finding("learner", "warning", found, "unset NUMBA_DISABLE_JIT")
    return Finding("learner", "ok", f"makes its first step after {seconds:.1f} s")


def _cache() -> Finding:
    from sim import compile_cache

    places = compile_cache.places("learners")
    there = next((place for place in places if place.is_dir()), None)
    free = next((place for place in places if _obstacle(place) is None), None)
    if free is None:
        found = f"nothing can be kept in {', '.join(map(str, places)) or 'any folder'}"
        remedy = "let NUMBA_CACHE_DIR name a folder that can be written to; without, code is"
        return Finding("cache", "warning", found, f"{remedy} compiled at each start")
    if there is None:
        return Finding("cache", "ok", f"empty; code will be kept in {free}")
    size = sum(file.stat().st_size for file in there.rglob("*") if file.is_file())
    return Finding("cache", "ok", f"{size / 1e6:.1f} MB in {there}")


def _fonts() -> Finding:
    from app.charts.paper.fonts import fonts_for, system_fonts
    from app.words.plain import joined_by_and

    missing = fonts_for("".join(SCRIPTS.values())).missing
    lacking = [script for script, character in SCRIPTS.items() if character in missing]
    n_fonts = len(system_fonts())
    if lacking:
        found = f"{n_fonts} installed, with none for {joined_by_and(lacking)}"
        remedy = "only for labels in them in PNG figures: install fonts, such as Noto"
        return Finding("fonts", "warning", found, remedy)
    return Finding("fonts", "ok", f"{n_fonts} installed; have {joined_by_and(list(SCRIPTS))}")


def _cores() -> Finding:
    cores = available_cores()
    if cores == 1:
        remedy = "nothing must be done; the page and the learner share it"
        return Finding("cores", "warning", "1, for everything", remedy)
    return Finding("cores", "ok", str(cores))


def _memory() -> Finding:
    size_mb = memory_mb()
    if size_mb < LEAST_MEMORY_MB:
        remedy = f"give it {LEAST_MEMORY_MB} MB"
        return Finding("memory", "warning", f"{size_mb:,.0f} MB", remedy)
    return Finding("memory", "ok", f"{size_mb / 1e3:.1f} GB")


def _browser() -> Finding:
    name = chosen_browser()
    if name is None:
        remedy = "open the address that pounce lab prints in one, here or elsewhere"
        return Finding("browser", "warning", "none with windows is found here", remedy)
    browser = webbrowser.get(name or None)
    return Finding("browser", "ok", str(getattr(browser, "name", type(browser).__name__)))


def _chromium() -> Finding:
    path = find_chromium()
    if path is None:
        return Finding("chromium", "warning", "none for the tests of the page", CHROMIUM_ADVICE)
    return Finding("chromium", "ok", f"{path}, for the tests of the page")


def _results(folder: Path) -> Finding:
    obstacle = _obstacle(folder)
    if obstacle is not None:
        remedy = "let --out, or --results of pounce lab, name a folder elsewhere"
        return Finding("results", "warning", f"{folder.absolute()}: {obstacle}", remedy)
    room_mb = shutil.disk_usage(_nearest(folder)).free / 1e6
    found = f"{room_mb / 1e3:,.1f} GB free for {folder.absolute()}"
    if room_mb < LEAST_ROOM_MB:
        return Finding("results", "warning", found, "make room, or write them elsewhere")
    return Finding("results", "ok", found)


def _nearest(path: Path) -> Path:
    """The path, or what there is of it."""
    path = path.absolute()
    return next(place for place in (path, *path.parents) if place.exists())


def _obstacle(folder: Path) -> str | None:
    """What is in the way of writing into a folder, which need not exist; None if nothing is."""
    from app.experiments.claims import takes_locks

    try:
        with tempfile.TemporaryFile(dir=_nearest(folder)) as probe:
            probe.write(b"there is room")
            probe.flush()
            return None if takes_locks(probe.fileno()) else "its disk cannot lock files"
    except OSError as error:
        return error.strerror or str(error)
