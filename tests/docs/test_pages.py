"""The pages of documentation: short where they are to be, with links and commands that hold."""

import importlib.util
import re
import shlex
from collections.abc import Iterator

import pytest

from app.cli import main
from tests.support.pages import PAGES, ROOT, links_of

MOST_LINES = 200
"""Of the README."""


def text_of(page: str) -> str:
    return (ROOT / page).read_text("utf-8")


def test_the_readme_is_short() -> None:
    assert len(text_of("README.md").splitlines()) <= MOST_LINES


def test_every_page_is_looked_at_and_can_be_reached_from_the_readme() -> None:
    kept = {page.relative_to(ROOT).as_posix() for page in (ROOT / "docs").rglob("*.md")}
    assert kept < set(PAGES)
    # What goes beyond the thesis has a list of pages of its own.
    first = (ROOT / "README.md", ROOT / "docs" / "beyond.md")
    reached = {link.target.resolve() for page in first for link in links_of(page)}
    assert {(ROOT / page).resolve() for page in PAGES} - {ROOT / "README.md"} <= reached


@pytest.mark.parametrize("file", PAGES)
def test_every_link_leads_somewhere(file: str) -> None:
    assert [link for link in links_of(ROOT / file) if not link.leads_somewhere] == []


def test_every_picture_is_shown_and_described() -> None:
    shown = {link.target.resolve() for page in PAGES for link in links_of(ROOT / page)}
    kept = {
        file for folder in ("pictures", "figures") for file in (ROOT / "docs" / folder).iterdir()
    }
    assert kept <= shown
    assert all("![](" not in text_of(page) for page in PAGES)


@pytest.mark.parametrize("file", PAGES)
def test_every_path_that_is_named_is_there(file: str) -> None:
    folders = "app|learners|sim|tests|docs|presets|benchmarks|typings|\\.basedpyright"
    named = re.findall(rf"`((?:{folders})/[^\s`]*)`", text_of(file))
    paths = [name for name in named if not re.search("[A-Z]{2,}[./]|[*…]", name)]
    assert [path for path in paths if not (ROOT / path).exists()] == []


def commands() -> Iterator[str]:
    """Commands of pounce in blocks of code."""
    for page in PAGES:
        blocks = re.findall(r"^```sh\n(.*?)^```", text_of(page), re.DOTALL | re.MULTILINE)
        indented = re.findall(r"^    (\S.*)$", text_of(page), re.MULTILINE)
        for line in [*"".join(blocks).splitlines(), *indented]:
            if re.match(r"pounce\b", line):
                yield line


@pytest.mark.parametrize("command", sorted(set(commands())))
def test_every_command_can_be_typed(command: str) -> None:
    assert main.parse(shlex.split(command, comments=True)[1:]) is not None


@pytest.mark.parametrize("file", PAGES)
def test_every_target_and_every_module_is_there(file: str) -> None:
    makefile = text_of("Makefile")
    for target in re.findall(r"(?:^ {4}|`)make ([a-z]+)", text_of(file), re.MULTILINE):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
    for module in re.findall(r"python -m ((?:tests|benchmarks|app)[\w.]*)", text_of(file)):
        assert importlib.util.find_spec(module) is not None, module
