"""Where somebody is in a lesson: a fold of what was done in it, whatever the lesson says.

A session has at most one lesson that is on, and keeps how each stands that was left: so one comes
back to it at the same card, from another browser, after a reload and after a restart. What is done
in one is a record of the session's journal (:mod:`app.live.records`); a record that makes no sense
where a lesson stands, such as another answer to a question that is locked, changes nothing. So any
sequence of them leads to a story that holds together. What a card asks for is known elsewhere.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Final, NewType

from app.live.places import Place
from learners.commands import CommandError

LongText = NewType("LongText", str)
"""The text of a file, or a whole curve: up to :data:`MOST_TEXT` characters."""
MOST_TEXT: Final = 64 * 1024
MOST_CARDS: Final = 40
MOST_STORIES: Final = 16
"""Lessons that a session keeps."""
MOST_HINTS: Final = 5
"""Of a card."""
MOST_CHARACTERS: Final = 1_000
"""Of an answer, as JSON; names have fewer."""


# --- What is done, and is written down -----------------------------------------------------------


@dataclass(frozen=True)
class TookLesson:
    """A lesson was begun, or gone on with where it was left; it is on from here on."""

    run: int
    """In which it is: a line that began by itself."""
    name: str
    source: str
    """How its file was named; empty if it came without one, or in a session from elsewhere."""
    digest: str
    """Of its text."""
    text: LongText
    """All of its file: so it can be gone on with whatever has become of that."""
    language: str
    start: int
    """The trial in which that run is to be when the card that is shown begins."""
    follows: bool
    """Whether its schedule is followed from there on."""
    is_anew: bool
    """Whether nothing is left of what was done in it before."""


@dataclass(frozen=True)
class LeftLesson:
    """No lesson is on any more."""


@dataclass(frozen=True)
class WentToCard:
    """Another card of the lesson that is on was shown; where the live run was then."""

    card: int
    run: int = 0
    step: int = 0
    trial: int = 0
    events: int = 0
    """Events that the run's history had by then."""
    is_again: bool = False
    """Whether what was to be done there begins anew here: somebody went back to before."""


@dataclass(frozen=True)
class Answered:
    """A question was given an answer, in the place of the one before."""

    question: str
    value: str
    """The answer, as JSON."""


@dataclass(frozen=True)
class Committed:
    """The answer to a question is not to be changed any more."""

    question: str
    confidence: int | None
    """How sure its giver is, in percent."""


@dataclass(frozen=True)
class Revealed:
    """The run has come to where it answers a question."""

    question: str
    value: LongText
    """What it answers, as JSON; a curve has many points."""
    is_within: bool | None
    """Whether the guess lies in the spread of runs; None if that says nothing."""


@dataclass(frozen=True)
class Passed:
    """What a card asks for has been done."""

    card: int


@dataclass(frozen=True)
class Hinted:
    """One hint more was asked for."""

    card: int


@dataclass(frozen=True)
class Spoke:
    """The lesson is read in another language."""

    language: str


Act = WentToCard | Answered | Committed | Revealed | Passed | Hinted | Spoke
"""What is done in a lesson that is on."""


def check(record: TookLesson | Act) -> None:
    """Refuse what is too long to be written down, and read again.

    Raises:
        CommandError: it is.
    """
    for part in fields(record):
        value = getattr(record, part.name)
        most = MOST_TEXT if part.type is LongText else MOST_CHARACTERS
        if isinstance(value, str) and len(value) > most:
            raise CommandError(f"{part.name} has at most {most:,} characters")


# --- What comes of it ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Given:
    """An answer, and what became of it."""

    value: str
    """As JSON."""
    confidence: int | None = None
    locked: bool = False
    shown: str | None = None
    """What the run answered, as JSON; None before it has come so far."""
    is_within: bool | None = None
    """Whether the answer lies in the spread of runs."""


@dataclass(frozen=True)
class Began:
    """Where the live run was when a card was shown first."""

    place: Place
    trial: int
    events: int
    """Events that the run's history had by then."""


@dataclass(frozen=True)
class Story:
    """How a lesson stands."""

    took: TookLesson
    card: int = 0
    """The one that is shown; the first is 0."""
    furthest: int = 0
    """The last that was shown."""
    began: Mapping[int, Began] = field(default_factory=dict[int, Began])
    """By card."""
    answers: Mapping[str, Given] = field(default_factory=dict[str, Given])
    """By question."""
    passed: frozenset[int] = frozenset()
    """Cards of which what they ask for has been done."""
    hints: Mapping[int, int] = field(default_factory=dict[int, int])
    """By card, how many were asked for."""

    @property
    def name(self) -> str:
        """Of the lesson."""
        return self.took.name

    @property
    def language(self) -> str:
        """In which it is read."""
        return self.took.language


def after(story: Story, act: Act) -> Story:
    """The story after something was done; the same if that makes no sense there."""
    match act:
        case WentToCard():
            return _gone(story, act)
        case Answered(question=question, value=value):
            given = story.answers.get(question)
            if given is not None and given.locked:
                return story
            return _with_answer(story, question, Given(value))
        case Committed(question=question, confidence=confidence):
            given = story.answers.get(question)
            if given is None or given.locked:
                return story
            return _with_answer(story, question, replace(given, confidence=confidence, locked=True))
        case Revealed(question=question, value=value, is_within=is_within):
            given = story.answers.get(question)
            if given is None or not given.locked or given.shown is not None:
                return story
            return _with_answer(story, question, replace(given, shown=value, is_within=is_within))
        case Passed(card=card):
            if not 0 <= card <= story.furthest:
                return story
            return replace(story, passed=story.passed | {card})
        case Hinted(card=card):
            n_hints = story.hints.get(card, 0)
            if not 0 <= card <= story.furthest or n_hints >= MOST_HINTS:
                return story
            return replace(story, hints={**story.hints, card: n_hints + 1})
        case Spoke(language=language):
            return replace(story, took=replace(story.took, language=language))


def _gone(story: Story, went: WentToCard) -> Story:
    card = went.card
    if not 0 <= card <= min(story.furthest + 1, MOST_CARDS - 1):
        return story
    began = dict(story.began)
    is_new = card not in began
    if is_new or went.is_again:
        began[card] = Began(Place(went.run, went.step), went.trial, went.events)
    passed = story.passed - {card} if went.is_again else story.passed
    furthest = max(story.furthest, card)
    return replace(story, card=card, furthest=furthest, began=began, passed=passed)


def _not_begun(story: Story) -> Story:
    """The same with another run, in which the card that is shown has not begun yet."""
    began = {card: at for card, at in story.began.items() if card != story.card}
    return replace(story, began=began, passed=story.passed - {story.card})


def _with_answer(story: Story, question: str, given: Given) -> Story:
    return replace(story, answers={**story.answers, question: given})


@dataclass(frozen=True)
class Stories:
    """All lessons that a session keeps, and which of them is on."""

    kept: tuple[Story, ...] = ()
    """Those taken up last come last."""
    is_on: bool = False
    """Whether the last of them is."""

    @property
    def on(self) -> Story | None:
        """The lesson that is on; None if none is."""
        return self.kept[-1] if self.is_on else None

    def of(self, name: str) -> Story | None:
        """How a lesson stands, by its name; None if it was never begun."""
        return next((story for story in self.kept if story.name == name), None)

    def after(self, record: TookLesson | LeftLesson | Act) -> "Stories":
        """What there is once something was done."""
        story = self.on
        match record:
            case TookLesson():
                return self._taken(record)
            case LeftLesson():
                return replace(self, is_on=False)
            case _ if story is None:
                return self
            case _:
                return replace(self, kept=(*self.kept[:-1], after(story, record)))

    def _taken(self, took: TookLesson) -> "Stories":
        former = self.of(took.name)
        others = tuple(story for story in self.kept if story.name != took.name)
        goes_on = former is not None and former.took.digest == took.digest and not took.is_anew
        if former is None or not goes_on:
            story = Story(took)
        else:
            story = replace(former, took=took)
            if took.run != former.took.run:
                story = _not_begun(story)
        return Stories((*others, story)[-MOST_STORIES:], is_on=True)
