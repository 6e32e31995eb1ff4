"""What does not go together in a whole lesson whose parts are each well-formed."""

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Final

from app.documents import experiments, presets
from app.documents.lesson_cards import Card
from app.documents.lesson_grammar import DIRECTIONS, SHAPES, Check, Compared, Moment, OfExperiment
from app.documents.lesson_questions import MAX_WORDS, Asked, n_words
from app.documents.lesson_spec import LessonSpec, Texts, Words
from app.metrics import NAMES
from learners.names import MAX_TRIALS, did_you_mean, listed
from learners.spec import RunSpec
from sim.spec import Problem

_CONTROLS_OF: Final[Mapping[str, str]] = {
    "introduce": "add_skill",
    "explore": "explore",
    "freeze_selection": "freeze",
    "freeze_skills": "freeze",
    "step": "step",
    "trial": "trial",
    "play": "play",
    "rewind": "scrub",
    "mark": "marks",
    "start_again": "start_again",
    "race": "side",
    "experiment": "experiments",
    "inspect": "inspect",
}
"""The control with which a command is given, where it is a single one."""

_Key = tuple[str | int, ...]


def misfits(
    spec: LessonSpec, run: RunSpec | None, starts: Mapping[str, RunSpec]
) -> Iterator[Problem]:
    """All that does not go together, by keys from the lesson's root.

    Args:
        spec: the lesson.
        run: what its setup comes to; None where that cannot be had.
        starts: what cards come to that start again, by their ids, as far as that can be had.
    """
    yield from _ids(spec)
    yield from _controls(spec)
    if run is not None:
        yield from _trials(spec, run, starts)
        yield from _skills(spec, run, starts)
    yield from _named(spec)
    for language, texts in spec.texts.items():
        if language == spec.language:
            message = "is the lesson's own language; allowed: another"
            yield Problem(("texts", language), language, message)
        else:
            yield from _translation(spec, texts, ("texts", language))


# --- Cards that name others, and controls --------------------------------------------------------


def _ids(spec: LessonSpec) -> Iterator[Problem]:
    for n, card in enumerate(spec.steps):
        if card.id in spec.ids[:n]:
            message = "is the id of an earlier card; allowed: another"
            yield Problem(("steps", n, "id"), card.id, message)
        if card.see is None:
            continue
        name = card.see.same_as
        asked = [before.id for before in spec.steps[:n] if before.question is not None]
        if name not in asked:
            hint, allowed = did_you_mean(name, asked), listed(asked) or "none, as none asks"
            message = f"is no card before it that asks{hint}; allowed: {allowed}"
            yield Problem(("steps", n, "see", "same_as"), name, message)


def _controls(spec: LessonSpec) -> Iterator[Problem]:
    there = set(spec.show)
    for n, card in enumerate(spec.steps):
        for index, control in enumerate(card.unlock):
            if there & {control, "all"}:
                message = "is there already; allowed: a control that is not"
                yield Problem(("steps", n, "unlock", index), control, message)
        there |= {*card.unlock, *(("all",) if card.free else ())}
        if card.do is None:
            continue
        needed = _CONTROLS_OF.get(card.do.command, "")
        if card.do.command == "show":
            needed = f"layer.{card.do.layer}"
        if needed and not there & {needed, "all"}:
            message = f"cannot be done without {needed}; allowed: {needed} in show, or in unlock"
            yield Problem(("steps", n, "do", "command"), card.do.command, message)


# --- Trials --------------------------------------------------------------------------------------


def _trials(spec: LessonSpec, run: RunSpec, starts: Mapping[str, RunSpec]) -> Iterator[Problem]:
    """Moments that lie behind where a card is certain to be, or beyond the end of the run."""
    start, length = spec.setup.start, run.trials
    now = start
    if start >= length:
        message = f"lies beyond the preset's trials; allowed: 0 to {length - 1}"
        yield Problem(("setup", "start"), start, message)
        return
    for n, card in enumerate(spec.steps):
        if card.do is not None and card.do.command == "start_again":
            now = 0
            length = starts[card.id].trials if card.id in starts else MAX_TRIALS
        if card.do is not None and card.do.at is not None and card.do.command != "run_to":
            yield from _not_past(card.do.at, ("steps", n, "do", "at"), length)
        for key, moment in _moments(card, ("steps", n)):
            yield from _misplaced(key, moment, now, length)
        asked_then = card.transfer.reveal if card.transfer is not None else None
        if asked_then is not None and asked_then.at is not None:
            key = ("steps", n, "transfer", "reveal", "at")
            yield from _misplaced(key, asked_then.at, start, run.trials)
        if card.do is not None and card.do.at and card.do.command in ("run_to", "rewind"):
            now = card.do.at.after(now)
        if card.run is not None:
            now = card.run.after(now)


def _misplaced(key: _Key, moment: Moment, now: int, length: int) -> Iterator[Problem]:
    if moment.after(now) <= now:
        message = f"is not ahead of the card, which is at trial {now}; allowed: a later one"
        yield Problem(key, str(moment), message)
    elif moment.after(now) > length:
        message = f"lies beyond the preset's trials; allowed: up to {length}"
        yield Problem(key, str(moment), message)


def _not_past(moment: Moment, key: _Key, length: int) -> Iterator[Problem]:
    """What may have been learned by now; a certain trial, since it is gone back to."""
    if moment.is_ahead or moment.trials > length:
        message = f"is no trial that can be gone back to; allowed: 0 to {length}"
        yield Problem(key, str(moment), message)


def _moments(card: Card, at: _Key) -> Iterator[tuple[_Key, Moment]]:
    if card.run is not None:
        yield (*at, "run"), card.run
    if card.do is not None and card.do.at is not None and card.do.command == "run_to":
        yield (*at, "do", "at"), card.do.at
    for key, stated in _measured(card, at):
        if isinstance(stated, Check) and stated.by is not None:
            yield (*key, "by"), stated.by
    if card.reveal is not None and card.reveal.at is not None:
        yield (*at, "reveal", "at"), card.reveal.at


def _measured(card: Card, at: _Key) -> Iterator[tuple[_Key, Compared]]:
    """All that is measured on a card, with where it stands."""
    if card.check is not None:
        yield from _checks(card.check, (*at, "check"))
    if card.reveal is not None:
        yield (*at, "reveal"), card.reveal
    if card.transfer is not None and card.transfer.reveal is not None:
        yield (*at, "transfer", "reveal"), card.transfer.reveal


def _checks(check: Check, at: _Key) -> Iterator[tuple[_Key, Check]]:
    yield at, check
    for name, parts in (("all", check.all_of), ("any", check.any_of)):
        for n, part in enumerate(parts or ()):
            yield from _checks(part, (*at, name, n))
    if check.not_so is not None:
        yield from _checks(check.not_so, (*at, "not"))


# --- Names that stand for something else ---------------------------------------------------------


def _skills(spec: LessonSpec, run: RunSpec, starts: Mapping[str, RunSpec]) -> Iterator[Problem]:
    own, known = run.learner.skills, run.learner.known_skills
    is_one_added = False
    for n, card in enumerate(spec.steps):
        own = starts[card.id].learner.skills if card.id in starts else own
        for key, skill in _named_skills(card, ("steps", n)):
            if skill not in own:
                message = f"is no skill of the preset{did_you_mean(skill, own)}"
                yield Problem(key, skill, f"{message}; allowed: {listed(own) or 'none'}")
        is_one_added |= card.do is not None and card.do.command == "introduce"
        if card.transfer is None:
            continue
        swap, key = card.transfer.run.swap, ("steps", n, "transfer", "run", "swap")
        if swap not in known:
            message = f"is no skill{did_you_mean(swap, known)}; allowed: {listed(known)}"
            yield Problem(key, swap, message)
        elif not is_one_added:
            message = "has no skill that it could take the place of; allowed: after an introduce"
            yield Problem(key, swap, message)


def _named_skills(card: Card, at: _Key) -> Iterator[tuple[_Key, str]]:
    done = card.do
    if done is not None and done.skill is not None:
        yield (*at, "do", "skill"), done.skill
    for n, given in enumerate(() if done is None else done.then or ()):
        if given.skill is not None:
            yield (*at, "do", "then", n, "skill"), given.skill
    for key, stated in _measured(card, at):
        if stated.present is not None:
            yield (*key, "present"), stated.present


def _named(spec: LessonSpec) -> Iterator[Problem]:
    """Presets of races, and experiments."""
    for n, card in enumerate(spec.steps):
        at = ("steps", n)
        done = card.do
        for index, name in enumerate(() if done is None else done.presets or ()):
            if name not in presets.shipped():
                message = f"is no shipped preset{did_you_mean(name, presets.shipped())}"
                allowed = listed(presets.shipped())
                yield Problem((*at, "do", "presets", index), name, f"{message}; allowed: {allowed}")
        if done is not None and done.name is not None:
            yield from _no_experiment(done.name, (*at, "do", "name"))
        for key, stated in _measured(card, at):
            if stated.experiment is not None:
                ranked = key[-1] == "reveal" and (card.question or card).ask == "order"
                yield from _wrong_results(stated.experiment, (*key, "experiment"), ranked)
        if card.question is not None:
            inner = at if card.transfer is None else (*at, "transfer")
            yield from _wrong_values(card.question, inner)


def _no_experiment(name: str, key: _Key) -> Iterator[Problem]:
    shipped = experiments.shipped()
    if name not in shipped:
        message = f"is no shipped experiment{did_you_mean(name, shipped)}"
        yield Problem(key, name, f"{message}; allowed: {listed(shipped)}")


def _wrong_results(asked: OfExperiment, key: _Key, ranked: bool) -> Iterator[Problem]:
    unknown = list(_no_experiment(asked.name, (*key, "name")))
    yield from unknown
    if asked.quantity not in NAMES:
        message = f"is not measured{did_you_mean(asked.quantity, NAMES)}"
        yield Problem((*key, "quantity"), asked.quantity, f"{message}; allowed: {listed(NAMES)}")
    if unknown:
        return
    labels = _labels(asked.name)
    for name, label in (("variant", asked.variant), ("against", asked.against)):
        if label is None:
            continue
        if ranked and name == "variant":
            message = "does not belong to a ranking, which is of all; allowed: nothing"
            yield Problem((*key, name), label, message)
        elif label not in labels:
            message = f"is no variant of it{did_you_mean(label, labels)}"
            yield Problem((*key, name), label, f"{message}; allowed: {listed(labels)}")
    if asked.variant is None and not ranked:
        yield Problem((*key, "variant"), ..., f"is missing; allowed: {listed(labels)}")


def _wrong_values(asked: Asked, key: _Key) -> Iterator[Problem]:
    """Options that stand for nothing which the measure could say."""
    if asked.reveal is None or not asked.options:
        return
    reading, compares = asked.reveal.reading, bool(asked.reveal.operators)
    if reading.answers == "yes" or compares:
        possible = ("yes", "no")
    elif reading.name == "spread_direction":
        possible = DIRECTIONS
    elif reading.name == "shape":
        possible = SHAPES
    elif reading.name == "leader":
        possible = tuple(presets.shipped())
    elif reading.name == "experiment" and reading.args.name in experiments.shipped():
        possible = _labels(reading.args.name)
    else:
        return
    where = "options" if asked.values is None else "values"
    for n, (value, _) in enumerate(asked.choices):
        if value not in possible:
            message = f"is nothing that {reading.name} says{did_you_mean(value, possible)}"
            hint = "; what people read may be another, with values" if where == "options" else ""
            yield Problem((*key, where, n), value, f"{message}; allowed: {listed(possible)}{hint}")


@lru_cache(maxsize=32)
def _labels(experiment: str) -> tuple[str, ...]:
    """Of the variants of a shipped experiment."""
    return tuple(variant.label for variant in experiments.load(experiment).variants)


# --- Translations --------------------------------------------------------------------------------


def _translation(spec: LessonSpec, texts: Texts, at: _Key) -> Iterator[Problem]:
    if len(texts.cards) != len(spec.steps):
        message = f"has {len(texts.cards)} cards; allowed: one for each of the {len(spec.steps)}"
        yield Problem((*at, "cards"), ..., message)
    for n, (card, words) in enumerate(zip(spec.steps, texts.cards, strict=False)):
        yield from _words(card, words, (*at, "cards", n))


def _words(card: Card, words: Words, at: _Key) -> Iterator[Problem]:
    question = card.question
    texts: dict[str, tuple[str | None, str | None]] = {
        "text": (card.words or None, words.text),
        "unit": (question and question.unit, words.unit),
        "notes": (card.notes, words.notes),
    }
    lists: dict[str, tuple[tuple[str, ...] | None, tuple[str, ...] | None]] = {
        "options": (question and question.options, words.options),
        "hints": (card.hints or None, words.hints or None),
    }
    for name, (original, translated) in (texts | lists).items():
        if original is not None and translated is None:
            yield Problem((*at, name), ..., f"is missing; allowed: {name} as in {card.id}")
        elif original is None and translated is not None:
            message = f"is not in the lesson itself; allowed: what {card.id} has"
            yield Problem((*at, name), _stated(translated), message)
    for name, (original, translated) in lists.items():
        if original and translated and len(original) != len(translated):
            message = f"has {len(translated)} items; allowed: {len(original)} as in {card.id}"
            yield Problem((*at, name), list(translated), message)
    if words.text is not None and n_words(words.text) > MAX_WORDS:
        message = f"has {n_words(words.text)} words; allowed: up to {MAX_WORDS} on a card"
        yield Problem((*at, "text"), words.text, message)


def _stated(value: str | tuple[str, ...]) -> object:
    """As the file has it."""
    return list(value) if isinstance(value, tuple) else value
