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
    """Pictures are empty, since they take most time.

    Tests that are marked as looking at them have those of pages: how PNG files come out is tested
    with the charts.
    """
    is_drawn = request.node.get_closest_marker("pictures") is not None

    def savefig(figure: Figure, file: Any, format: str, **options: Any) -> None:
        # Whatever is to be in them must still be there to be laid out.
        assert figure.axes
        if is_drawn and format == "svg":
            _REAL(figure, file, format=format, **options)
            return
        engine = figure.get_layout_engine()
        if is_drawn and engine is not None:
            # Everything finds its place as the first file is made.
            engine.execute(figure)
        found = _empty(format)
        file.write(found.decode() if isinstance(file, io.StringIO) else found)

    monkeypatch.setattr(Figure, "savefig", savefig)
