"""A lesson as its file states it (validated, frozen): setup, cards and translations."""

from typing import Annotated, Final, Literal, Self

from pydantic import AfterValidator, Field, field_validator, model_validator

from app.documents.experiment_spec import Settings
from app.documents.lesson_cards import MAX_HINTS, Card, Controls
from app.documents.lesson_questions import MAX_OPTIONS, Asked, Id, Label, Text, readable
from learners.names import MAX_TRIALS
from sim.rng import MAX_SEED
from sim.spec import FiniteFloat, Problem, ProblemsError, Spec

MAX_CARDS: Final = 40
MAX_LANGUAGES: Final = 12
MAX_SPEED: Final = 10_000_000
MAX_SEEDS: Final = 1_000
"""That a lesson is proved with."""
MAX_NEEDS: Final = 12

Language = Annotated[
    str, Field(pattern=r"^[a-z]{2}(-[A-Z]{2})?$", description="a language such as de or de-CH")
]

Title = Annotated[str, Field(max_length=80), AfterValidator(readable)]


class Setup(Spec):
    """The run that a lesson is about, and where it begins."""

    preset: Annotated[str, Field(max_length=1_024, description="a shipped preset, or a path")]
    set: Settings = Field(default_factory=dict)
    """Keys of presets that are other than in the preset."""
    seed: Annotated[int, Field(ge=0, le=MAX_SEED)] = 0
    start: Annotated[int, Field(ge=0, le=MAX_TRIALS)] = 0
    """Trial at which the first card is shown."""
    schedule: Literal["on", "off"] = "on"
    """Whether the timers act from there on."""
    speed: Annotated[FiniteFloat, Field(ge=1, le=MAX_SPEED)] | None = None
    """Steps per second."""


class Words(Spec):
    """What people read on one card, in another language: in the shape that the card has."""

    text: Text | None = None
    options: Annotated[tuple[Label, ...], Field(strict=False, max_length=MAX_OPTIONS)] | None = None
    unit: Label | None = None
    hints: Annotated[tuple[Text, ...], Field(strict=False, max_length=MAX_HINTS)] | None = None
    notes: Text | None = None


class Texts(Spec):
    """A lesson's title and cards in another language."""

    title: Title
    cards: Annotated[tuple[Words, ...], Field(strict=False, max_length=MAX_CARDS)]


class Evidence(Spec):
    """How far the lesson is proved; the checker writes it."""

    seeds: Annotated[int, Field(ge=1, le=MAX_SEEDS)]
    passed: Annotated[int, Field(ge=0, le=MAX_SEEDS)] = Field(alias="pass")
    """Of these, in so many all that is checked came true and all keys were right."""

    @model_validator(mode="after")
    def _is_a_share(self) -> Self:
        if self.passed > self.seeds:
            message = f"is more than there are; allowed: up to seeds, {self.seeds}"
            raise ProblemsError([Problem(("pass",), self.passed, message)])
        return self


class LessonSpec(Spec):
    """A lesson."""

    title: Title
    minutes: Annotated[int, Field(ge=1, le=60)]
    needs: Annotated[tuple[Id, ...], Field(strict=False, max_length=MAX_NEEDS)] = ()
    """Lessons that are better taken before: advice, never a lock."""
    language: Language = "en"
    """Of what is written in the cards themselves."""
    setup: Setup
    show: Controls = ()
    """All that can be seen and used from the first card on."""
    steps: Annotated[tuple[Card, ...], Field(strict=False, min_length=1, max_length=MAX_CARDS)]
    texts: Annotated[dict[Language, Texts], Field(max_length=MAX_LANGUAGES)] = Field(
        default_factory=dict
    )
    evidence: Evidence | None = None

    @field_validator("steps")
    @classmethod
    def _each_has_an_id(cls, steps: tuple[Card, ...]) -> tuple[Card, ...]:
        return tuple(
            card if card.id else card.model_copy(update={"id": f"step_{n}"})
            for n, card in enumerate(steps, start=1)
        )

    @property
    def languages(self) -> tuple[str, ...]:
        """All that it can be read in, its own first."""
        return (self.language, *(name for name in self.texts if name != self.language))

    @property
    def titles(self) -> dict[str, str]:
        """What it is called in each of these."""
        return {
            language: self.title if language == self.language else self.texts[language].title
            for language in self.languages
        }

    @property
    def ids(self) -> tuple[str, ...]:
        """Of its cards, in their order."""
        return tuple(card.id for card in self.steps)

    def index_of(self, card_id: str) -> int:
        """Where a card stands, from 0; raises `ValueError` if there is none of that id."""
        return self.ids.index(card_id)

    def card_of(self, card_id: str) -> Card:
        """The card of an id; raises `ValueError` if there is none."""
        return self.steps[self.index_of(card_id)]

    def question_of(self, card: Card) -> Asked | None:
        """What a card asks: also what an earlier one did, where it is to be seen now."""
        return card.question if card.see is None else self.card_of(card.see.same_as).question

    def in_language(self, language: str) -> "LessonSpec":
        """The same lesson with its words in another language, or as it is if it has no such."""
        if language not in self.texts or language == self.language:
            return self
        texts = self.texts[language]
        pairs = zip(self.steps, texts.cards, strict=True)
        steps = tuple(_translated(card, words) for card, words in pairs)
        return self.model_copy(update={"title": texts.title, "steps": steps})


def _translated(card: Card, words: Words) -> Card:
    """A card with other words; what an option stands for stays as it is."""
    update: dict[str, object] = {}
    if words.text is not None:
        match card.kind:
            case "say":
                update["say"] = words.text
            case "why" if card.why is not None:
                update["why"] = card.why.model_copy(update={"text": words.text})
            case "transfer":
                pass
            case _:
                update["text"] = words.text
    if words.hints is not None:
        done = card.steps_of_help[len(card.hints) :]
        update["steps_of_help"] = (*words.hints, *done)
    if words.notes is not None:
        update["notes"] = words.notes
    if card.transfer is not None:
        update["transfer"] = card.transfer.model_copy(update=_of_question(card.transfer, words))
    elif card.ask is not None:
        update |= _of_question(card, words)
    return card.model_copy(update=update)


def _of_question(asked: Asked, words: Words) -> dict[str, object]:
    found: dict[str, object] = {"text": words.text, "unit": words.unit or asked.unit}
    if words.options is not None:
        found |= {"options": words.options, "values": asked.values or asked.options}
    return found
