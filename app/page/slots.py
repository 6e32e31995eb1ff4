"""What the stage shows: HTML that stands in viser's page as a template, and is shown in a slot.

The stage is the part of the page around the board that is ours (``app/web/stage.js``). A browser
gets what is in it as the content of ordinary widgets, of which nothing is to be seen where they
are; the page's script copies each into the slot of its name (``app/web/slots.js``).
"""

from typing import Literal

from app.util.html import escaped

Slot = Literal[
    "task",
    "sentence",
    "readings",
    "legend",
    "bar",
    "said",
    "opening",
    "tour",
    "experiment",
    "side",
    "lesson",
]
"""A place of the stage: the task in one line, what goes on, a few numbers, what colours mean, curve
and timeline, what was just done, the first hunts, the tour, how an experiment stands, runs side by
side, a lesson."""


def slot_html(name: Slot, content: str) -> str:
    """Content of a widget for a slot; ``content`` is HTML, and "" leaves the slot empty."""
    return f'<template data-slot="{escaped(name)}">{content}</template>'
