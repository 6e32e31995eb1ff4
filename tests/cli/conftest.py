"""What tests of several commands share: the folder they run in, and a lab that is not opened."""

from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where a command runs; the user's own sessions are below it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return tmp_path


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """What the lab was opened with, in place of opening it."""
    calls: list[dict[str, Any]] = []

    def run_lab(**arguments: Any) -> int:
        calls.append(arguments)
        return 0

    monkeypatch.setattr("app.page.serving.run_lab", run_lab)
    return calls
