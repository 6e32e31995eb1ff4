"""Most tests of reports read what is said, and not what is drawn."""

import io
from typing import Any

import pytest
from matplotlib.figure import Figure

from tests.support.reports import SAVE, empty_picture, without_pictures


@pytest.fixture(autouse=True)
def pictures(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are not drawn.

    Tests that are marked as looking at them have those of pages: how PNG files come out is tested
    with the charts.
    """
    if request.node.get_closest_marker("pictures") is None:
        without_pictures(monkeypatch)
        return

    def savefig(figure: Figure, file: Any, format: str, **options: Any) -> None:
        if format == "svg":
            SAVE(figure, file, format=format, **options)
            return
        engine = figure.get_layout_engine()
        if engine is not None:
            # Everything finds its place as the first file is made.
            engine.execute(figure)
        found = empty_picture(format)
        file.write(found.decode() if isinstance(file, io.StringIO) else found)

    monkeypatch.setattr(Figure, "savefig", savefig)
