"""Icons of widgets: they are viser's own, and their archive is opened once."""

import zipfile
from pathlib import PurePath
from typing import Any

import pytest
import viser
from viser import _icons

from app.server import icons
from tests.support.server import lab_of

with zipfile.ZipFile(_icons.ICONS_DIR / "tabler-icons.zip") as archive:
    NAMES: Any = [PurePath(name).stem for name in archive.namelist()[:60]]
"""More than viser keeps."""


def test_they_are_those_of_viser() -> None:
    for name in NAMES[:3]:
        assert icons.svg_from_icon(name) == _icons.svg_from_icon(name)


def test_many_widgets_of_two_labs_open_the_archive_once(monkeypatch: pytest.MonkeyPatch) -> None:
    icons.svg_from_icon.cache_clear()
    icons._archive.cache_clear()
    opened: list[Any] = []

    class Counted(zipfile.ZipFile):
        def __init__(self, *words: Any, **options: Any) -> None:
            opened.append(words)
            super().__init__(*words, **options)

    monkeypatch.setattr(zipfile, "ZipFile", Counted)
    for _ in range(2):
        with lab_of() as lab:
            buttons = [lab.server.gui.add_button("Press", icon=name) for name in NAMES]
            buttons[0].icon = viser.Icon.BOLT
            assert buttons[1]._impl.props._icon_html == icons.svg_from_icon(NAMES[1])
    assert len(opened) == 1


def test_an_icon_that_is_not_there_is_refused() -> None:
    with pytest.raises(KeyError), lab_of() as lab:
        lab.server.gui.add_button("Press", icon=NAMES[0] + "-that-is-none")
