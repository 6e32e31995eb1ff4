"""What twenty runs answer to a lesson's questions, found while its cards are read.

A thread of its own plays the lesson, seed by seed, and gives way to the learner. The newest wish
wins; what is not wished any more is given up within milliseconds. What was found stays in memory,
and in a folder on disk where there is one.
"""

import logging
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from app.documents.lessons import Lesson
from app.lessons import canon, kept
from app.lessons.beside import specs_beside
from app.lessons.kept import Folder
from app.lessons.reveals import Answer
from app.lessons.shared import GivenUpError, Shared
from app.lessons.spread import Spread
from app.util.machine import be_modest

log = logging.getLogger(__name__)

SEEDS: Final = tuple(range(20))
_MOST_KEPT: Final = 8
"""Lessons whose answers stay in memory."""
_FAREWELL_S: Final = 2.0
_NOTHING: Final = Spread(())


@dataclass(frozen=True)
class Spreads:
    """What is known so far of what runs answer to a lesson's questions."""

    by_card: Mapping[str, Spread]
    """By the ids of cards that ask by themselves."""
    own: Mapping[str, Answer]
    """What the lesson's own seed answers where all is done as the cards say: for what no live run
    answers, such as a question that is revealed by a run of its own."""
    n: int
    """Runs so far."""
    is_whole: bool
    """Whether these are all."""

    def of(self, card_id: str) -> Spread:
        """Of one card; of no runs if that asks nothing, or nothing is known yet."""
        return self.by_card.get(card_id, _NOTHING)


class Twenty:
    """Finds them. Public methods may be called from any thread."""

    def __init__(
        self, told: Callable[[], object] = lambda: None, folder: Path | None = None
    ) -> None:
        """Prepare; the thread begins with the first wish.

        Args:
            told: called in that thread when more is known.
            folder: in which answers are kept; None for nowhere. See :func:`kept.default_folder`.
        """
        self._told = told
        self._folder = None if folder is None else Folder(folder)
        self._changed = threading.Condition()
        self._found: OrderedDict[str, Spreads] = OrderedDict()
        self._failed: set[str] = set()
        self._wished: Lesson | None = None
        self._stopping = False
        self._thread: threading.Thread | None = None

    def want(self, lesson: Lesson) -> None:
        """Have them found for a lesson, and for no other any more."""
        with self._changed:
            self._wished = lesson
            if self._thread is None and not self._stopping:
                self._thread = threading.Thread(target=self._work, name="twenty runs", daemon=True)
                self._thread.start()
            self._changed.notify_all()

    def leave(self) -> None:
        """Have nothing found any more; what is known stays."""
        with self._changed:
            self._wished = None

    def found(self, lesson: Lesson) -> Spreads | None:
        """What is known of a lesson so far; None if nothing is."""
        with self._changed:
            return self._found.get(lesson.digest)

    def settle(self, timeout_s: float) -> bool:
        """Wait until all that is wished is known; returns whether it is."""
        with self._changed:
            return self._changed.wait_for(lambda: self._next() is None, timeout_s)

    def stop(self) -> None:
        """End the thread, and wait for that."""
        with self._changed:
            self._stopping, self._wished = True, None
            self._changed.notify_all()
            thread = self._thread
        if thread is not None:
            thread.join(_FAREWELL_S)

    # The thread

    def _next(self) -> Lesson | None:
        """What is to be found next, if anything is."""
        lesson = self._wished
        if lesson is None or lesson.digest in self._failed:
            return None
        found = self._found.get(lesson.digest)
        return None if found is not None and found.is_whole else lesson

    def _work(self) -> None:
        be_modest()
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._stopping or self._next() is not None)
                lesson = self._next()
            if self._stopping or lesson is None:
                if self._stopping:
                    return
                continue
            try:
                self._find(lesson)
            except GivenUpError:
                continue
            except Exception:
                # A page can do without: it tells of the one run that is there.
                log.exception("%s cannot be played", lesson.name)
                with self._changed:
                    self._failed.add(lesson.digest)
            with self._changed:
                self._changed.notify_all()

    def _find(self, lesson: Lesson) -> None:
        own_seed = lesson.spec.setup.seed
        seeds = SEEDS if own_seed in SEEDS else (*SEEDS, own_seed)
        digest = kept.digest_of(lesson, specs_beside(lesson), seeds)
        answers = None if self._folder is None else self._folder.read(digest, len(seeds))
        if answers is not None:
            self._keep(lesson, answers, seeds)
            return
        found: dict[str, list[Answer]] = {}
        # The lesson's own first: it is the one that is waited for.
        order = [own_seed, *(seed for seed in seeds if seed != own_seed)]
        for place, seed in enumerate(order, start=1):
            shared = Shared(lambda: self._wished is lesson and not self._stopping)
            played = canon.play(lesson, seed, shared)
            for card, answer in played.answers.items():
                found.setdefault(card, []).append(answer)
            self._keep(lesson, {c: tuple(a) for c, a in found.items()}, order[:place])
        by_seed = {
            card: tuple(of[order.index(seed)] for seed in seeds) for card, of in found.items()
        }
        self._keep(lesson, by_seed, seeds)
        if self._folder is not None:
            self._folder.write(digest, by_seed)

    def _keep(self, lesson: Lesson, answers: kept.Answers, seeds: Sequence[int]) -> None:
        """Take in what is known of runs with some seeds, in their order."""
        own_seed = lesson.spec.setup.seed
        own = {card: of[seeds.index(own_seed)] for card, of in answers.items()}
        others = [place for place, seed in enumerate(seeds) if seed in SEEDS]
        spreads = {
            card: Spread(tuple(of[place] for place in others)) for card, of in answers.items()
        }
        is_whole = len(others) == len(SEEDS)
        with self._changed:
            self._found[lesson.digest] = Spreads(spreads, own, len(others), is_whole)
            self._found.move_to_end(lesson.digest)
            while len(self._found) > _MOST_KEPT:
                self._found.popitem(last=False)
        self._told()
