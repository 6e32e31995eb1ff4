"""The markup of lessons: ``**bold**`` and `` `code` ``, and nothing else; all else is text."""

import re
from typing import Final

from markupsafe import Markup

from app.util.html import element, escaped, joined

_MARKED: Final = re.compile(r"\*\*(?P<bold>[^*\s](?:[^*\n]*[^*\s])?)\*\*|`(?P<code>[^`\n]+)`")


def html_of(text: str) -> Markup:
    """A text as HTML, escaped; lines stay apart."""
    parts: list[Markup] = []
    end = 0
    for found in _MARKED.finditer(text):
        parts.append(escaped(text[end : found.start()]))
        bold = found["bold"]
        parts.append(element("b", bold) if bold is not None else element("code", found["code"]))
        end = found.end()
    parts.append(escaped(text[end:]))
    return Markup("<br>".join(joined(parts, "").strip().splitlines()))


def plain_of(text: str) -> str:
    """A text without its markup."""
    return _MARKED.sub(lambda found: found["bold"] or found["code"], text)
