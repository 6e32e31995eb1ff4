"""The lessons that a lab has, shared by all its browsers: which there are, and how one is taken."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from app.documents import lessons
from app.documents.lessons import Lesson, LessonError
from app.lessons.taken import lesson_of
from app.lessons.words import Words
from app.live.requests import StartAgain, TakeLesson
from app.live.status import Status
from app.live.story import LongText, Story, TookLesson
from app.page.lesson.controls import StartLessonAgain
from learners.spec import RunSpec

MOST_OWN: Final = 8
"""Lessons beside the shipped ones; of more, the oldest go."""
PLAIN_SPEED: Final = 20_000.0
"""Steps per second where a lesson states none."""
_CHANGED: Final = "news.changed"
_GONE: Final = "news.gone"


class Library:
    """The lessons. The render loop alone has to do with it."""

    def __init__(self) -> None:
        """Have the shipped ones."""
        self._shipped: dict[str, Lesson] | None = None
        self._own: dict[str, Lesson] = {}
        self._sources: dict[tuple[str, str], str] = {}
        """By name and digest, what has become of a lesson's file."""

    @property
    def offered(self) -> Mapping[str, Lesson]:
        """All that can be begun, by name: the shipped ones in the order of the syllabus, then one's
        own."""
        if self._shipped is None:
            self._shipped = {name: lessons.load(name) for name in lessons.shipped()}
        return {**self._shipped, **self._own}

    def add(self, text: str, file_name: str) -> Lesson:
        """Offer a lesson that somebody brought, in the place of an own one of its name.

        Raises:
            LessonError: it cannot be taught; with all that is wrong with it.
        """
        return self.offer(lessons.parse(text, file_name))

    def offer(self, lesson: Lesson) -> Lesson:
        """Offer a lesson, in the place of an own one of its name; returns it as it is offered: one
        that is called as a shipped one is has another name."""
        shipped = lessons.shipped()
        if lesson.source in shipped:
            return lesson
        if lesson.name in shipped:
            lesson = replace(lesson, name=f"{lesson.name}_own")
        self._own.pop(lesson.name, None)
        self._own[lesson.name] = lesson
        while len(self._own) > MOST_OWN:
            del self._own[next(iter(self._own))]
        return lesson

    def of(self, story: Story) -> Lesson | None:
        """The lesson that somebody is in, as it was when it was begun; None if this pounce cannot
        read it any more."""
        took = story.took
        offered = self.offered.get(took.name)
        if offered is not None and offered.digest == took.digest:
            return offered
        return lesson_of(took)

    def news_of(self, story: Story, words: Words) -> str:
        """What is to be said of the file of a lesson that is gone on with; "" if nothing is."""
        news = self._news_of(story.took)
        return words.say(news) if news else ""

    def _news_of(self, took: TookLesson) -> str:
        offered = self.offered.get(took.name)
        if offered is not None:
            return "" if offered.digest == took.digest else _CHANGED
        if not took.source:
            return ""
        key = (took.source, took.digest)
        if key not in self._sources:
            self._sources[key] = _news_of_file(took.source, took.digest)
        return self._sources[key]


def _news_of_file(source: str, digest: str) -> str:
    try:
        return "" if lessons.load(source).digest == digest else _CHANGED
    except LessonError:
        return _GONE


def request_to_begin(lesson: Lesson, language: str, is_anew: bool) -> TakeLesson:
    """What has a lesson be on, where it was left, or from its beginning."""
    spec, setup = lesson.spec, lesson.spec.setup
    return TakeLesson(
        name=lesson.name,
        source=lesson.source,
        digest=lesson.digest,
        text=LongText(lesson.text.decode()),
        language=language if language in spec.languages else spec.language,
        begin=start_of(lesson.run_spec, setup.preset, setup.seed),
        start=setup.start,
        follows=setup.schedule == "on",
        speed=setup.speed or PLAIN_SPEED,
        is_anew=is_anew,
    )


def begun_again(lesson: Lesson, story: Story, again: StartLessonAgain) -> TakeLesson:
    """What has another run of a lesson begin, at the same card."""
    request = request_to_begin(lesson, story.language, is_anew=False)
    setup = lesson.spec.setup
    seed = setup.seed if again.seed is None else again.seed
    begin = start_of(again.spec or lesson.run_spec, again.preset or setup.preset, seed)
    if again.spec is not None:
        # A run that a card begins is of another kind, and is seen from its first trial on.
        request = replace(request, start=0, follows=True)
    return replace(request, begin=begin, runs_anew=True)


def start_of(spec: RunSpec, preset: str, seed: int) -> StartAgain:
    """What begins a run of a lesson, which stands still."""
    return StartAgain(spec, Path(preset).stem or preset, seed, paused=True)


def listed(library: Library, status: Status) -> list[dict[str, Any]]:
    """What there is to choose from, as the frame shows it."""
    offered = library.offered
    titles = {name: lesson.spec.titles for name, lesson in offered.items()}
    found: list[dict[str, Any]] = []
    for name, lesson in offered.items():
        story = status.stories.of(name)
        spec = lesson.spec
        found.append(
            {
                "name": name,
                "titles": titles[name],
                "minutes": spec.minutes,
                "needs": [titles.get(need, {"en": need}) for need in spec.needs],
                "languages": list(spec.languages),
                "at": None if story is None else story.card,
                "n": len(spec.steps),
            }
        )
    return found
