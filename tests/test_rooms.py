"""Rules of the rooms that are no contract on imports, held against the text of every module."""

import ast
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CODE = ("app", "sim", "learners")
KNOW_VISER = ("app/server", "app/page")
"""Rooms that may use what viser does not offer to others."""
MOST_LINES = 500


def modules(*folders: str) -> Sequence[Path]:
    """All modules below some folders."""
    found = [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]
    assert found
    return found


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def imported(tree: ast.AST) -> Iterator[str]:
    """Full names of what is imported, whether that is a module or something of one."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def private_names(code: str) -> list[str]:
    """What is private of viser among what is imported, or taken from it by its name."""
    if "viser" not in code:
        return []
    tree = ast.parse(code)
    attributes = [ast.unparse(n) for n in ast.walk(tree) if isinstance(n, ast.Attribute)]
    return [
        name
        for name in (*imported(tree), *attributes)
        if name.startswith("viser.") and any(is_private(part) for part in name.split("."))
    ]


def is_private(part: str) -> bool:
    return part.startswith("_") and not part.startswith("__")


def test_nothing_private_of_viser_is_known_outside_server_and_page() -> None:
    found = {
        name_of(path): private_names(path.read_text(encoding="utf-8")) for path in modules(*CODE)
    }
    knowing = {name for name, names in found.items() if names}
    assert knowing, "nobody does: the search is broken, or this test is no longer needed"
    assert [name for name in knowing if not name.startswith(KNOW_VISER)] == []


@pytest.mark.parametrize(
    "code",
    [
        "from viser import _messages",
        "from viser._scene_api import SceneApi",
        "import viser._messages as wire",
        "import viser\nviser._gui_api.GuiApi",
    ],
)
def test_private_names_of_viser_are_found_however_they_are_used(code: str) -> None:
    assert private_names(code)
    assert not private_names(code.replace("_", ""))


def test_no_module_is_too_long_to_be_read_at_once() -> None:
    lengths = {
        name_of(path): len(path.read_text(encoding="utf-8").splitlines()) for path in modules(*CODE)
    }
    assert {name: n for name, n in lengths.items() if n > MOST_LINES} == {}


def test_no_test_module_imports_another() -> None:
    """What tests share is in ``tests/support``."""
    for path in modules("tests"):
        for name in imported(ast.parse(path.read_text(encoding="utf-8"))):
            parts = name.split(".")
            is_test = parts[0] == "tests" and any(p.startswith("test_") for p in parts[1:])
            assert not is_test, f"{name_of(path)} imports {name}"
