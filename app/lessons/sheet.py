"""A lesson on paper: what it asks, with room to write, and what came of it on pages of their own.

One HTML file without scripts, which loads nothing. It prints in black and white, on A4 as on
Letter. Whatever gives an answer away stands after the questions: what the lesson's own run and
others came to, boards of what was to be seen, explanations, and the notes for the teacher.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from app.documents.lesson_cards import Card
from app.documents.lesson_questions import Asked
from app.documents.lesson_spec import LessonSpec
from app.documents.lessons import Lesson
from app.lessons import sheet_figures as figures
from app.lessons.canon import play
from app.lessons.markup import html_of, plain_of
from app.lessons.reveals import Answer
from app.lessons.shared import Shared
from app.lessons.spread import Spread, points_of
from app.lessons.words import Words, words_of
from app.live.snapshot import take
from app.picture.layer import Extras
from app.picture.look import Look
from app.player.boards import board_sent, described, world_sent
from app.player.reel import LAYERS_SHOWN
from app.player.shapes import Picture, svg_of
from app.player.sketch import sketch
from app.util.html import Markup, element, escaped, joined
from learners.run import Run

MOST_BOARDS: Final = 12
_BOARD: Final = 320
_LINES: Final = {"see": 2, "why": 3, "free": 4}
"""Lines to write on, by the kind of a card."""


# --- What came of it -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Board:
    """A board of the lesson's own run."""

    trial: int
    picture: Markup


@dataclass(frozen=True)
class Findings:
    """What is to be known of a lesson's runs."""

    n: int
    """Runs with other seeds."""
    own: Mapping[str, Answer]
    """What the lesson's own run answers, by the id of the card."""
    others: Mapping[str, Spread]
    """What they do."""
    boards: Mapping[str, Board]
    """Of the first card, and of those on which something is to be seen."""


Tell = Callable[[str], object]


def findings_of(lesson: Lesson, seeds: Sequence[int], tell: Tell = lambda said: None) -> Findings:
    """Play a lesson with its own seed, and with others.

    Args:
        lesson: the lesson.
        seeds: of the others.
        tell: is told how far it has come.
    """
    boards: dict[str, Board] = {}

    def visit(card: Card, run: Run) -> None:
        is_wanted = not boards or card.kind == "see"
        if is_wanted and len(boards) < MOST_BOARDS:
            boards[card.id] = _board(card, run, lesson.spec.setup.preset)

    tell("its own run")
    own = play(lesson, lesson.spec.setup.seed, visit=visit)
    others: dict[str, list[Answer]] = {card_id: [] for card_id in own.answers}
    for n, seed in enumerate(seeds, start=1):
        tell(f"run {n} of {len(seeds)}")
        found = play(lesson, seed, Shared())
        for card_id, answers in others.items():
            answers.append(found.answers.get(card_id))
    spreads = {card_id: Spread(tuple(answers)) for card_id, answers in others.items()}
    return Findings(len(seeds), own.answers, spreads, boards)


def _board(card: Card, run: Run, preset: str) -> Board:
    asked = card.look.layer if card.look else None
    look = Look(layer=asked if asked in LAYERS_SHOWN else "value", trail=False, hunts=False)
    snapshot = take(run, preset, 0)
    sent = board_sent(snapshot, look, Extras(), rests=True, named=True)
    shapes = sketch(sent, world_sent(snapshot.spec.world), 0, 0, _BOARD)
    picture = Picture(_BOARD, _BOARD, tuple(shapes), described(snapshot, look))
    return Board(run.trial, svg_of(picture))


# --- The page ------------------------------------------------------------------------------------


def sheet(lesson: Lesson, language: str, findings: Findings) -> str:
    """The sheet as an HTML file.

    Args:
        lesson: the lesson.
        language: in which it is to be read; its own where it has no such.
        findings: what came of it.
    """
    spec = lesson.spec.in_language(language)
    shown = language if language in lesson.spec.languages else lesson.spec.language
    return _Sheet(spec, words_of(shown), findings, shown).page()


class _Sheet:
    def __init__(self, spec: LessonSpec, words: Words, findings: Findings, language: str) -> None:
        self._spec, self._words, self._found = spec, words, findings
        self._language = language

    def page(self) -> str:
        title = self._spec.title
        cards = enumerate(self._spec.steps, start=1)
        questions = [self._card(n, card) for n, card in cards]
        answers = [self._answer(n, card) for n, card in enumerate(self._spec.steps, start=1)]
        body = joined(
            [
                element("h1", title),
                element("p", self._about(), class_="about"),
                *questions,
                element("section", joined([*self._answers_head(), *answers]), class_="answers"),
            ]
        )
        head = joined(
            [
                Markup('<meta charset="utf-8">'),
                Markup('<meta name="viewport" content="width=device-width, initial-scale=1">'),
                element("title", title),
                element("style", Markup(_STYLE)),
            ]
        )
        return (
            f'<!doctype html>\n<html lang="{escaped(self._language)}">\n<head>\n{head}\n</head>\n'
            f"<body>\n{body}\n</body>\n</html>\n"
        )

    def _about(self) -> str:
        setup = self._spec.setup
        return self._words.say(
            "sheet.about",
            minutes=self._spec.minutes,
            preset=setup.preset,
            seed=str(setup.seed),
            trial=setup.start,
        )

    # Questions

    def _card(self, n: int, card: Card) -> Markup:
        head = element("h2", f"{n}. {self._words.say(f'sheet.{card.kind}')}")
        parts: list[Markup] = [head]
        if card.why is None:
            parts.append(element("p", html_of(card.words)) if card.words else Markup(""))
        else:
            parts.append(element("p", self._words.say("sheet.own_words")))
        if card.question is not None:
            parts.append(self._room(card.question))
        elif card.see is not None:
            asked = self._spec.question_of(card)
            parts.append(Markup("") if asked is None else self._seen(asked))
        parts += [element("div", "", class_="line")] * _LINES.get(card.kind, 0)
        if n == 1:
            parts.append(self._board_of(card))
        return element("section", joined(parts), class_="card")

    def _seen(self, asked: Asked) -> Markup:
        """Room for what was seen, where a line or two will not do."""
        return (
            self._room(asked, is_first=False) if asked.ask in ("sectors", "order") else Markup("")
        )

    def _room(self, asked: Asked, is_first: bool = True) -> Markup:
        """Where the answer is written, ticked or drawn."""
        words, parts = self._words, list[Markup]()
        match asked.ask:
            case "choice" | "direction":
                boxes = [element("li", label) for _, label in asked.choices]
                parts.append(element("ul", joined(boxes), class_="boxes"))
            case "order":
                places = [
                    element("li", joined([element("span", "", class_="place"), label]))
                    for _, label in asked.choices
                ]
                parts += [
                    element("p", words.say("sheet.number_them")),
                    element("ul", joined(places)),
                ]
            case "number":
                unit = plain_of(asked.unit or "")
                blank = element("span", "", class_="blank")
                parts.append(element("p", joined([blank, unit], " ")))
            case "sectors":
                shade = words.say("sheet.shade")
                parts += [element("p", shade), figures.compass(shade)]
            case "moment":
                mark, (first, end) = words.say("sheet.mark"), self._ends(asked)
                parts += [element("p", mark), self._strip(mark, first, end, ())]
            case "sketch":
                draw = words.say("sheet.draw")
                parts += [element("p", draw), self._frame(draw, asked)]
            case _:
                pass
        if asked.confidence and is_first:
            chances = [element("li", f"{chance} %") for chance in (50, 70, 90)]
            sure = element("span", words.say("sheet.sure"))
            boxes = element("ul", joined(chances), class_="boxes sure")
            parts.append(element("div", joined([sure, boxes]), class_="confidence"))
        return joined(parts)

    def _board_of(self, card: Card) -> Markup:
        board = self._found.boards.get(card.id)
        if board is None:
            return Markup("")
        caption = self._words.say("sheet.board", trial=board.trial)
        content = joined([board.picture, element("figcaption", caption)])
        return element("figure", content, class_="board")

    # Answers

    def _answers_head(self) -> list[Markup]:
        words = self._words
        said = words.say("sheet.answers_of", n=self._found.n, seed=str(self._spec.setup.seed))
        return [
            element("h1", words.say("sheet.answers", title=self._spec.title)),
            element("p", said),
        ]

    def _answer(self, n: int, card: Card) -> Markup:
        parts: list[Markup] = []
        if card.question is not None:
            parts.append(self._outcome(card))
        if card.why is not None:
            parts.append(element("p", html_of(card.why.text)))
        if card.kind == "see":
            parts.append(self._board_of(card))
        if card.notes is not None:
            note = joined([element("b", self._words.say("sheet.note")), html_of(card.notes)], " ")
            parts.append(element("p", note, class_="note"))
        if not parts:
            return Markup("")
        head = element("h2", f"{n}. {self._words.say(f'sheet.{card.kind}')}")
        return element("section", joined([head, *parts]), class_="card")

    def _outcome(self, card: Card) -> Markup:
        """What the run came to, and what others did."""
        asked, words = card.question, self._words
        assert asked is not None
        own, spread = self._found.own.get(card.id), self._found.others.get(card.id, Spread(()))
        if asked.reveal is None:
            return element("p", element("b", self._said(asked, asked.key)))
        parts: list[Markup] = []
        if asked.ask != "sketch":
            parts.append(element("p", f"{words.say('sheet.this_run')}: {self._said(asked, own)}"))
        match asked.ask:
            case "choice" | "direction" | "order":
                parts.append(element("p", self._counted(asked, spread)))
            case "number" | "moment" if spread.band is not None:
                low, median, high = (self._number(asked, value) for value in spread.band)
                said = words.say(
                    "sheet.from_to", n=spread.n_answered, low=low, median=median, high=high
                )
                parts.append(element("p", said))
                if asked.ask == "moment":
                    first, end = self._ends(asked)
                    parts.append(self._strip(said, first, end, spread.numbers))
            case "sectors":
                said = words.say("sheet.octants", n=spread.n)
                by_octant = figures.octants_of(spread)
                parts += [element("p", said), figures.compass(said, by_octant, spread.n)]
            case "sketch":
                said = words.say("sheet.band", n=spread.n)
                parts += [element("p", said), self._frame(said, asked, own, spread)]
            case _:
                pass
        return joined(parts)

    def _said(self, asked: Asked, answer: object) -> str:
        """An answer in words."""
        labels = dict(asked.choices)
        if answer is None:
            return self._words.say("sheet.nothing")
        if asked.ask == "sectors":
            names = [self._words.octant(str(name)) for name in _texts(answer)]
            return ", ".join(names) or self._words.say("sheet.nothing")
        if isinstance(answer, int | float):
            return self._number(asked, float(answer))
        between = "; " if asked.ask == "order" else ", "
        return between.join(plain_of(labels.get(name, name)) for name in _texts(answer))

    def _counted(self, asked: Asked, spread: Spread) -> str:
        """In how many runs each answer was given, the most frequent first."""
        given = [_texts(answer) for answer in spread.answers if answer is not None]
        counts = sorted(
            {answer: given.count(answer) for answer in given}.items(), key=lambda item: -item[1]
        )
        said = "; ".join(
            f"{self._words.say('sheet.in_runs', k=count, n=spread.n)}: {self._said(asked, answer)}"
            for answer, count in counts[:4]
        )
        return said or self._words.say("sheet.nothing")

    def _number(self, asked: Asked, value: float) -> str:
        unit = plain_of(asked.unit or "")
        if asked.ask == "moment":
            return self._words.say("trial", trial=self._words.rounded(value))
        return f"{self._words.rounded(value)} {unit}".rstrip()

    def _ends(self, asked: Asked) -> tuple[int, int]:
        start = self._spec.setup.start
        first = start if asked.first is None else asked.first
        return first, asked.end or first + 10_000

    def _strip(self, about: str, first: int, end: int, marks: Sequence[float]) -> Markup:
        shown = {trial: self._words.rounded(trial) for trial in figures.trial_marks(first, end)}
        return figures.strip(about, first, end, shown, marks)

    def _frame(
        self, about: str, asked: Asked, own: Answer = None, spread: Spread | None = None
    ) -> Markup:
        trials = figures.trial_marks(asked.first or 0, asked.end or 1)
        return figures.frame(
            about,
            asked,
            {trial: self._words.rounded(trial) for trial in trials},
            {reward: self._words.rounded(reward) for reward in figures.reward_marks(asked)},
            points_of(own),
            None if spread is None else spread.curve,
        )


def _texts(answer: object) -> tuple[str, ...]:
    """The names in an answer, of which there are several or one."""
    if isinstance(answer, tuple):
        return tuple(str(item) for item in answer)  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
    return (str(answer),)


_STYLE: Final = """
@page { margin: 16mm 15mm; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 46rem; padding: 1rem; color: #000; background: #fff;
  font: 11.5pt/1.45 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { font-size: 1.5em; line-height: 1.2; margin: 0 0 0.2em; }
h2 { font-size: 1em; margin: 0 0 0.2em; }
p { margin: 0 0 0.5em; }
.about { color: #333; margin-bottom: 1.2em; }
.card { break-inside: avoid; margin: 0 0 1.2em; }
.line { border-bottom: 1px solid #777; height: 2em; }
.boxes { list-style: none; display: flex; flex-wrap: wrap; gap: 0.3em 2em; margin: 0.4em 0;
  padding: 0; }
.boxes li::before { content: ""; display: inline-block; width: 0.85em; height: 0.85em;
  border: 1.3px solid #000; margin-right: 0.5em; vertical-align: -0.08em; }
ul:not(.boxes) { list-style: none; margin: 0.4em 0; padding: 0; }
ul:not(.boxes) li { margin: 0.45em 0; }
.place { display: inline-block; width: 1.7em; height: 1.7em; border: 1.3px solid #000;
  margin-right: 0.7em; vertical-align: middle; }
.blank { display: inline-block; width: 7em; border-bottom: 1.3px solid #000; height: 1.6em; }
.confidence { display: flex; align-items: baseline; gap: 1.5em; }
.figure { display: block; width: 100%; height: auto; font-family: inherit; }
.board { margin: 0.6em 0; }
.board svg { width: 7cm; height: auto; border: 1px solid #777; display: block; }
figcaption { font-size: 0.85em; color: #333; }
.note { font-size: 0.9em; border-left: 3px solid #777; padding-left: 0.7em; }
.answers { break-before: page; }
@media screen { .answers { margin-top: 3rem; border-top: 2px solid #000; padding-top: 2rem; } }
"""
