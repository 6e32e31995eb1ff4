"""Texts from outside, as what is written may have them: names of files, words, labels.

A path stays as the operating system gave it, with half a character for each byte that its encoding
cannot read. What becomes part of a file, a page or an answer passes through here, and so does a
text that names a file.
"""

import os
import re
from pathlib import Path
from typing import Final

_NOT_WRITTEN: Final = "[^\t\n\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"
_OBEYED: Final = "[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]"
"""Control characters, and what turns the direction of writing for all that follows."""


def as_text(name: str | Path) -> str:
    """A path, or a word of the command line, as a text.

    It is read as UTF-8 whatever the locale; a byte that is none becomes a replacement character.
    """
    try:
        data = os.fsencode(name)
    except UnicodeEncodeError:  # It is a text, and the locale's encoding has not all characters.
        return re.sub("[\ud800-\udfff]", "\ufffd", str(name))
    return data.decode(errors="replace")


def as_path(text: str) -> str:
    """A text as the operating system takes it for a path, in UTF-8 whatever the locale.

    Raises:
        ValueError: it has half a character, which no path has.
    """
    try:
        os.fsencode(text)
    except UnicodeEncodeError:
        return os.fsdecode(text.encode())
    return text


def written(text: str) -> str:
    """A text without control characters and halves of characters, which no document may have."""
    return re.sub(_NOT_WRITTEN, "\ufffd", as_text(text))


def for_terminal(text: str) -> str:
    """A text whose characters a terminal shows and does not obey, in lines as it has them."""
    return re.sub(_OBEYED, lambda found: ascii(found[0])[1:-1], as_text(text))


def folder_name(name: str) -> str:
    """The nearest name of a folder that is within its parent, and ends alike on every system."""
    return name.rstrip(". ") or "experiment"
