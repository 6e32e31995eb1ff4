"""One way to escape: texts become markup once, and what is markup already stays as it is."""

from collections.abc import Iterable

import markupsafe
from markupsafe import Markup

from app.util.texts import written


def escaped(text: object) -> Markup:
    """A text as it may stand in a page; what is markup already stays as it is."""
    return text if isinstance(text, Markup) else markupsafe.escape(written(str(text)))


def element(tag: str, content: object, **attributes: str) -> Markup:
    """An element; attributes that are words of Python end in an underscore."""
    shown = "".join(f' {key.rstrip("_")}="{escaped(v)}"' for key, v in attributes.items())
    return Markup(f"<{tag}{shown}>{escaped(content)}</{tag}>")


def joined(parts: Iterable[object], between: str = "\n") -> Markup:
    """Parts one after another, each escaped unless it is markup."""
    return Markup(between.join(escaped(part) for part in parts))
