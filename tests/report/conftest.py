"""Most tests of reports read what is said, and not what is drawn."""

import io
from functools import cache
from typing import Any

import pytest
from matplotlib.figure import Figure

_REAL = Figure.savefig


@cache
def _empty(kind: str) -> bytes:
    """A picture of nothing, as matplotlib writes it."""
    out = io.BytesIO()
    _REAL(
        Figure(figsize=(1, 1)), out, format=kind, metadata={"Date": None} if kind == "svg" else {}
    )
    return out.getvalue()


@pytest.fixture(autouse=True)
def pictures(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are empty but for tests that are marked as looking at them: they take most time."""
    if request.node.get_closest_marker("pictures") is not None:
        return

    def savefig(figure: Figure, file: Any, format: str, **_: Any) -> None:
        # Whatever is to be in them must still be there to be laid out.
        assert figure.axes
        found = _empty(format)
        file.write(found.decode() if isinstance(file, io.StringIO) else found)

    monkeypatch.setattr(Figure, "savefig", savefig)
