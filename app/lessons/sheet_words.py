"""The words of a printed sheet around those of the lesson itself, by language."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from app.documents.lesson_grammar import OCTANTS
from app.picture.octants import NAMES

_MINUS: Final = "\N{MINUS SIGN}"


@dataclass(frozen=True)
class Words:
    """What a sheet says; texts with braces are filled in."""

    thousands: str
    """Between the thousands of a number."""
    point: str
    """Before its decimals."""
    verbs: Mapping[str, str]
    """By the kind of a card: what is done on it."""
    octant_names: Mapping[str, str]
    about: str
    own_words: str
    number_them: str
    shade: str
    mark: str
    draw: str
    sure: str
    board: str
    answers: str
    answers_of: str
    this_run: str
    in_runs: str
    from_to: str
    octants: str
    band: str
    trial: str
    nothing: str
    note: str

    def number(self, value: float) -> str:
        """A number as it is written in this language, with one decimal if it has any."""
        rounded = round(value, 1)
        text = (
            f"{rounded:,.0f}" if rounded == int(rounded) or abs(value) >= 100 else f"{rounded:,.1f}"
        )
        whole, _, decimals = text.replace("-", _MINUS).partition(".")
        whole = whole.replace(",", self.thousands)
        return whole + (f"{self.point}{decimals}" if decimals else "")


_ENGLISH: Final = Words(
    thousands=",",
    point=".",
    verbs={
        "say": "Read",
        "ask": "Predict",
        "do": "Do",
        "see": "What do you see?",
        "why": "Why?",
        "transfer": "And now?",
        "free": "Try it",
    },
    octant_names=NAMES,
    about="{minutes} minutes, beside the board; preset {preset}, seed {seed}, from trial {trial}.",
    own_words="Explain it in your own words, before you go on.",
    number_them="Number them, 1 for the first.",
    shade="The prey is in the middle and looks to the right. Shade the directions.",
    mark="Mark the trial.",
    draw="Draw the reward per trial (up) along the trials (to the right).",
    sure="How sure are you?",
    board=(
        "The board at trial {trial}. Pale is near to a catch, dark is far from one; what is dotted"
        " is known only in part, and grey is not known."
    ),
    answers="Answers: {title}",
    answers_of=(
        "From the lesson's own run, which has seed {seed}, and from {n} runs that differ by their"
        " seeds, so by luck alone. Nobody is wrong who is within what these do."
    ),
    this_run="This run",
    in_runs="In {k} of {n} runs",
    from_to="In {n} runs from {low} to {high}, half of them below {median}.",
    octants="In how many of {n} runs each direction is among them:",
    band="The line is this run; the grey band lies between the lowest and the highest of {n} runs.",
    trial="trial {trial}",
    nothing="none",
    note="For the teacher:",
)

_GERMAN: Final = Words(
    thousands="\N{NARROW NO-BREAK SPACE}",
    point=",",
    verbs={
        "say": "Lies",
        "ask": "Sag voraus",
        "do": "Tu es",
        "see": "Was siehst du?",
        "why": "Warum?",
        "transfer": "Und jetzt?",
        "free": "Probier es aus",
    },
    octant_names=dict(
        zip(
            OCTANTS,
            (
                "vorn",
                "vorn links",
                "linke Seite",
                "hinten links",
                "hinten",
                "hinten rechts",
                "rechte Seite",
                "vorn rechts",
            ),
            strict=True,
        )
    ),
    about="{minutes} Minuten, neben dem Feld. Preset {preset}, Seed {seed}, ab Versuch {trial}.",
    own_words="Erkläre es in eigenen Worten, bevor du weitermachst.",
    number_them="Nummeriere sie, 1 für das Erste.",
    shade="Die Beute ist in der Mitte und schaut nach rechts. Schraffiere die Richtungen.",
    mark="Markiere den Versuch.",
    draw="Zeichne die Belohnung pro Versuch (nach oben) über den Versuchen (nach rechts).",
    sure="Wie sicher bist du?",
    board=(
        "Das Feld in Versuch {trial}. Hell ist nah an einem Fang, dunkel fern davon; Gepunktetes"
        " ist nur zum Teil bekannt, Graues nicht."
    ),
    answers="Antworten: {title}",
    answers_of=(
        "Aus dem Lauf der Lektion, der Seed {seed} hat, und aus {n} Läufen, die sich durch ihre"
        " Seeds unterscheiden, also nur durch Glück. Wer im Bereich dieser Läufe liegt, liegt nicht"
        " falsch."
    ),
    this_run="Dieser Lauf",
    in_runs="In {k} von {n} Läufen",
    from_to="In {n} Läufen von {low} bis {high}, die Hälfte davon unter {median}.",
    octants="In wie vielen von {n} Läufen jede Richtung dabei ist:",
    band="Die Linie ist dieser Lauf; das graue Band liegt zwischen dem niedrigsten und dem höchsten"
    " von {n} Läufen.",
    trial="Versuch {trial}",
    nothing="keine",
    note="Für die Lehrkraft:",
)

_BY_LANGUAGE: Final[Mapping[str, Words]] = {"en": _ENGLISH, "de": _GERMAN}


def words_of(language: str) -> Words:
    """Those of a language, or of what it is a kind of (``de-CH``); English where there are none."""
    return _BY_LANGUAGE.get(language.partition("-")[0], _ENGLISH)
