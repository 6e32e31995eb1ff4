"""The lesson that a session is in, made of what was written down of it."""

from functools import lru_cache
from pathlib import Path

from app.documents import lessons
from app.documents.lessons import Lesson, LessonError
from app.live.story import TookLesson


def lesson_of(took: TookLesson) -> Lesson | None:
    """The lesson as it was when it was begun; None if this pounce cannot read it any more."""
    return _read(took.text, took.name, took.source)


@lru_cache(maxsize=8)
def _read(text: str, name: str, source: str) -> Lesson | None:
    # The paths of presets begin where the file was.
    for folder in (None, *([Path(source).parent] if source else [])):
        try:
            return lessons.parse(text, f"{name}.yaml", folder)
        except LessonError:
            continue
    return None
