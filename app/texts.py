"""Texts from outside, as what is written may have them: names of files, words, labels.

A path stays as the operating system gave it, with half a character for each byte that its encoding
cannot read. What becomes part of a file, a page or an answer passes through here, and so does a
text that names a file.
"""

import os
import re
import unicodedata
from pathlib import Path
from typing import Final

_NOT_WRITTEN: Final = "[^\t\n\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"
_DIRECTIONS: Final = re.compile("[\u2028-\u202e\u2066-\u2069]")
"""Ends of lines, and what turns the direction of writing for what follows."""


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
    return "".join(map(_shown, as_text(text)))


def _shown(character: str) -> str:
    is_obeyed = unicodedata.category(character) == "Cc" or _DIRECTIONS.match(character)
    return ascii(character)[1:-1] if is_obeyed and character not in "\n\t" else character


def folder_name(name: str) -> str:
    """The nearest name that a folder may have on any system, and that is within its parent."""
    return name.rstrip(". ") or "experiment"
