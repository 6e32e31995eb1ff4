"""Whether a lesson holds: each of its checks and keys, with many seeds.

A check has to come true, and what a question is held against has to be the same, in nearly all
runs (:data:`app.lessons.predictions.NEARLY_ALL`). A question whose answer hangs on the seed says so
in the file (``varies``); then its band is told, and nothing is proved of it. Of the others:

- a choice, a direction or octants: the key or, where there is none, the most frequent answer;
- a number or a moment: the key or, where there is none, the median, to within a twentieth of it;
- an order: the key or, where there is none, the most frequent one.

A curve that is sketched always hangs on the seed. A check that holds before anything is done gives
nothing to do, and what cannot be done is no lesson: both are problems as well.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any, Final, NamedTuple

from app.documents import lessons
from app.documents.lesson_questions import Asked
from app.documents.lessons import Lesson
from app.documents.tree import PresetError
from app.lessons import canon
from app.lessons.canon import Played
from app.lessons.predictions import NEARLY_ALL, OFF, is_right
from app.lessons.reveals import Answer, varies
from app.lessons.shared import Shared
from app.lessons.spread import Spread
from app.util.files import write_whole
from app.util.machine import available_cores
from app.words.plain import shortened

SEEDS: Final = 20
"""With which the shipped lessons are proved."""
_EVIDENCE: Final = re.compile(rb"^evidence[ \t]*:[^#\r\n]*", re.MULTILINE)
_WITHIN_IT: Final = re.compile(rb"(?:\r?\n[ \t]+[^\r\n]*)*")


class ProofError(ValueError):
    """The evidence cannot be written into a file; the message says why."""


class CheckProof(NamedTuple):
    """When a card's check came true."""

    card: str
    trials: tuple[int, ...]
    """In which it did, of the seeds with which it did, the least first."""
    n_seeds: int

    @property
    def holds(self) -> bool:
        """Whether it came true with nearly all of them."""
        return len(self.trials) >= NEARLY_ALL * self.n_seeds


class AnswerProof(NamedTuple):
    """What runs answer to a card's question."""

    card: str
    asked: Asked
    said: str
    """What was found, in short: the answer, or the band."""
    n_right: int
    """Seeds with which the answer is the one that is proved."""
    n_seeds: int

    @property
    def varies(self) -> bool:
        """Whether nothing is proved of it."""
        return varies(self.asked)

    @property
    def holds(self) -> bool:
        """Whether it is the same with nearly all seeds, or need not be."""
        return self.varies or self.n_right >= NEARLY_ALL * self.n_seeds


@dataclass(frozen=True)
class Proof:
    """What came of playing a lesson with many seeds."""

    lesson: Lesson
    n_seeds: int
    n_passed: int
    """Seeds with which every check came true, and every answer was the one that is proved."""
    checks: tuple[CheckProof, ...]
    answers: tuple[AnswerProof, ...]
    problems: tuple[str, ...]
    """Why it does not hold, in sentences; none if it does."""

    @property
    def holds(self) -> bool:
        """Whether it can be taught as it says."""
        return not self.problems


Progress = Callable[[int, int], object]
"""Told how many seeds are done, of how many."""


def proofs(
    wanted: Sequence[Lesson],
    n_seeds: int = SEEDS,
    told: Progress = lambda done, of: None,
    every_answer: bool = True,
) -> list[Proof]:
    """Play some lessons with the seeds from 0 on; runs are shared by all of them.

    Args:
        wanted: the lessons.
        n_seeds: with which each is played.
        told: told how far it is.
        every_answer: whether also answers are found of which nothing is proved.
    """
    played: list[list[Played]] = [[] for _ in wanted]

    def of_seed(seed: int) -> list[Played]:
        shared = Shared()
        return [canon.play(lesson, seed, shared, every_answer=every_answer) for lesson in wanted]

    with ThreadPoolExecutor(available_cores()) as pool:
        for done, found in enumerate(pool.map(of_seed, range(n_seeds)), start=1):
            for of_lesson, one in zip(played, found, strict=True):
                of_lesson.append(one)
            told(done, n_seeds)
    return [proof_of(lesson, runs) for lesson, runs in zip(wanted, played, strict=True)]


def proof_of(lesson: Lesson, played: Sequence[Played]) -> Proof:
    """What came of a lesson that was played with some seeds."""
    passed = [True] * len(played)
    checks: list[CheckProof] = []
    answers: list[AnswerProof] = []
    problems: list[str] = []
    for card in lesson.spec.steps:
        faults = [one.faults[card.id] for one in played if card.id in one.faults]
        if faults:
            problems.append(f"{card.id}: cannot be done with every seed: {faults[0]}")
        early = sum(card.id in one.too_early for one in played)
        if early:
            n = f"{early} of {len(played)}"
            problems.append(f"{card.id}: its check holds before anything is done ({n} seeds)")
        if card.check is not None:
            verdicts = [one.verdicts[card.id] for one in played]
            came = [v.state == "yes" for v in verdicts]
            trials = sorted(v.trial for v in verdicts if v.state == "yes" and v.trial is not None)
            checks.append(CheckProof(card.id, tuple(trials), len(played)))
            passed = [so_far and so for so_far, so in zip(passed, came, strict=True)]
            problems += _lacking(card.id, "its check comes true", checks[-1].holds, sum(came), came)
        question = card.question
        if question is not None and card.id in played[0].answers:
            found = [one.answers[card.id] for one in played]
            rights, said = _rights(question, found)
            proof = AnswerProof(card.id, question, said, sum(rights), len(played))
            answers.append(proof)
            if not proof.varies:
                passed = [so_far and so for so_far, so in zip(passed, rights, strict=True)]
            what = f"the answer is {said}"
            problems += _lacking(card.id, what, proof.holds, sum(rights), rights)
    n_passed = sum(passed)
    return Proof(lesson, len(played), n_passed, tuple(checks), tuple(answers), tuple(problems))


def _lacking(card: str, what: str, holds: bool, n: int, of: Sequence[bool]) -> list[str]:
    needed = f"needed: {NEARLY_ALL:.0%}"
    first = next((seed for seed, so in enumerate(of) if not so), None)
    if holds:
        return []
    return [f"{card}: {what} with {n} of {len(of)} seeds only, not with seed {first} ({needed})"]


def _rights(asked: Asked, answers: Sequence[Answer]) -> tuple[list[bool], str]:
    """For each run, whether its answer is the one that is proved; and what was found, in short."""
    spread = Spread(tuple(answers))
    if asked.ask == "sketch":
        curve = spread.curve
        ends = "" if curve is None else f"{min(curve.low):.0f} to {max(curve.high):.0f}"
        return [True] * len(answers), f"a curve between {ends}"
    if asked.ask in ("number", "moment"):
        return _numbers(asked, answers, spread)
    key = asked.key
    if key is None:
        key = Counter(answers).most_common(1)[0][0]
        rights = [answer is not None and answer == key for answer in answers]
    else:
        rights = [is_right(asked, answer) for answer in answers]
    said = ", ".join(map(str, key)) or "nothing" if isinstance(key, tuple) else str(key)
    return rights, said


def _numbers(asked: Asked, answers: Sequence[Answer], spread: Spread) -> tuple[list[bool], str]:
    band = spread.band
    if band is None:
        return [False] * len(answers), "never found"
    ends = f"{_number(band.low)} to {_number(band.high)}" if band.low < band.high else "always"
    said = f"{_number(band.median)} ({ends})"
    n_missing = spread.n - spread.n_answered
    if n_missing:
        said += f", never with {n_missing}"
    proved = asked.key if isinstance(asked.key, int | float) else band.median
    return [
        isinstance(answer, int | float) and abs(answer - proved) <= OFF * abs(proved)
        for answer in answers
    ], said


def _number(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 100 or value == round(value) else f"{value:.3g}"


# --- In words, and as JSON -----------------------------------------------------------------------

_MOST_SAID: Final = 60
"""Characters of what was found, in the table."""
COLUMNS: Final = ("card", "what is proved", "seeds", "earliest", "median", "latest")
"""Of the table of a proof."""


def rows_of(proof: Proof) -> list[tuple[str, ...]]:
    """The table of a proof, in the order of the cards."""
    checks = {check.card: check for check in proof.checks}
    answers = {answer.card: answer for answer in proof.answers}
    rows: list[tuple[str, ...]] = []
    for card in proof.lesson.spec.steps:
        if card.id in checks:
            check = checks[card.id]
            trials = tuple(f"{trial:,.0f}" for trial in _ends(check.trials)) or ("", "", "")
            rows.append(
                (card.id, "its check comes true", _share(len(check.trials), proof), *trials)
            )
        if card.id in answers:
            answer = answers[card.id]
            seeds = "varies" if answer.varies else _share(answer.n_right, proof)
            rows.append((card.id, shortened(answer.said, _MOST_SAID), seeds, "", "", ""))
    return rows


def _share(n: int, proof: Proof) -> str:
    return f"{n}/{proof.n_seeds}"


def _ends(trials: Sequence[int]) -> Iterable[float]:
    return (trials[0], median(trials), trials[-1]) if trials else ()


def headline_of(proof: Proof) -> str:
    """What came of it, in one sentence."""
    verdict = "holds" if proof.holds else "does not hold"
    return f"{proof.lesson.name} {verdict}: {proof.n_passed} of {proof.n_seeds} seeds pass."


def as_json(proof: Proof) -> dict[str, Any]:
    """A proof as plain values."""
    return {
        "lesson": proof.lesson.name,
        "digest": proof.lesson.digest,
        "seeds": proof.n_seeds,
        "pass": proof.n_passed,
        "holds": proof.holds,
        "checks": [
            {
                "card": check.card,
                "seeds": len(check.trials),
                **dict(zip(("earliest", "median", "latest"), _ends(check.trials), strict=False)),
                "holds": check.holds,
            }
            for check in proof.checks
        ],
        "answers": [
            {
                "card": answer.card,
                "ask": answer.asked.ask,
                "found": answer.said,
                "seeds": answer.n_right,
                "varies": answer.varies,
                "holds": answer.holds,
            }
            for answer in proof.answers
        ],
        "problems": list(proof.problems),
    }


# --- The evidence in a file ----------------------------------------------------------------------


def with_evidence(proof: Proof, folder: Path | None = None) -> bytes:
    """A lesson's file with what was proved of it, and all else of it as it was, byte for byte.

    Args:
        proof: of the lesson as the file has it.
        folder: where the path of a preset starts.

    Raises:
        ProofError: it is written in a way in which that cannot be done.
    """
    lesson = proof.lesson
    text = lesson.text
    line = f"evidence: {{seeds: {proof.n_seeds}, pass: {proof.n_passed}}}".encode()
    ending = b"\r\n" if b"\r\n" in text else b"\n"
    there = _EVIDENCE.search(text)
    if there is None:
        begun = text if text.endswith((b"\n", b"\r")) else text + ending
        after = begun + line + ending
    else:
        within = _WITHIN_IT.match(text, there.end())
        end = there.end() if within is None else within.end()
        is_followed = text[there.end() : there.end() + 1] == b"#"
        space = b" " if is_followed else b""
        after = (
            text[: there.start()] + line + space + text[end if not is_followed else there.end() :]
        )
    try:
        read = lessons.parse(after, lesson.name, folder)
    except PresetError as error:
        raise ProofError(f"the evidence cannot be written into this file: {error}") from None
    evidence = read.spec.evidence
    if evidence is None or (evidence.seeds, evidence.passed) != (proof.n_seeds, proof.n_passed):
        raise ProofError("the evidence cannot be written into this file; allowed: a key of its own")
    if read.digest != lesson.digest:
        raise ProofError("the evidence cannot be written into this file without changing it")
    return after


def write_evidence(path: Path, proof: Proof) -> bool:
    """Write what was proved into the lesson's file; returns whether that changed it.

    Raises:
        ProofError: it is written in a way in which that cannot be done.
        OSError: it cannot be written.
    """
    path = path.resolve()
    if path.read_bytes() != proof.lesson.text:
        raise ProofError("the file has changed meanwhile; check it again")
    after = with_evidence(proof, path.parent)
    if after == proof.lesson.text:
        return False
    write_whole(path, after)
    return True
