"""Icons of widgets, out of an archive whose list is read once.

viser opens the archive of its five thousand icons for each that it has not shown lately, and keeps
fewer than a lab has. To read the list takes a twentieth of a second, for each widget of each page.
"""

import io
import zipfile
from functools import cache
from importlib import import_module
from typing import Any, Final

from viser import _icons

_USERS: Final = ("viser._gui_api", "viser._gui_handles")
"""Modules of viser that show icons."""


def keep_icons() -> None:
    """Have viser take icons from here; may be called more than once."""
    for name in _USERS:
        module: Any = import_module(name)
        module.svg_from_icon = svg_from_icon


@cache
def svg_from_icon(icon_name: str) -> str:
    """The ``<svg>`` of an icon of viser's.

    Raises:
        KeyError: there is none of this name.
    """
    return _archive().read(f"{icon_name}.svg").decode("utf-8")


@cache
def _archive() -> zipfile.ZipFile:
    # From memory, so that no file stays open.
    return zipfile.ZipFile(io.BytesIO((_icons.ICONS_DIR / "tabler-icons.zip").read_bytes()))
