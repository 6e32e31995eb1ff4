"""What is said of a lesson around its own texts, in the language in which it is read."""

import functools
from collections.abc import Iterable
from typing import Final

from app.lessons.phrases import LANGUAGES
from app.lessons.phrases.english import ENGLISH
from app.lessons.phrases.language import Language

_MINUS: Final = "\N{MINUS SIGN}"


class Words:
    """Of one language."""

    def __init__(self, language: Language) -> None:
        self._language = language

    def say(self, key: str, **parts: object) -> str:
        """A phrase, in English where this language has none.

        Args:
            key: by which it is known.
            parts: what is filled in; numbers are written as in this language.
        """
        phrase = self._language.phrases.get(key) or ENGLISH.phrases[key]
        return phrase.format(**{name: self._part(part) for name, part in parts.items()})

    def counted(self, key: str, n: int, **parts: object) -> str:
        """A phrase on a number ``n`` of things, which has one for a single thing."""
        return self.say(f"{key}.one" if n == 1 else f"{key}.more", n=n, **parts)

    def _part(self, part: object) -> str:
        return self.number(part) if isinstance(part, int | float) else str(part)

    def number(self, value: float) -> str:
        """A number in full; of a small one that is not whole, two digits."""
        is_full = abs(value) >= 10 or value == round(value)
        return self.written(f"{value:,.0f}" if is_full else f"{value:.2g}")

    def rounded(self, value: float) -> str:
        """A number with one decimal if it has any, and is not large."""
        rounded = round(value, 1)
        is_full = rounded == int(rounded) or abs(value) >= 100
        return self.written(f"{rounded:,.0f}" if is_full else f"{rounded:,.1f}")

    def percent(self, share: float) -> str:
        """A share in whole hundredths."""
        return f"{100 * share:.0f}{self._language.percent}"

    def written(self, number: str) -> str:
        """A number that is written with commas and a point, as this language writes it."""
        whole, _, decimals = number.replace("-", _MINUS).partition(".")
        digits = whole.replace(",", "")
        is_grouped = len(digits.lstrip(_MINUS)) >= len(str(self._language.grouped_from))
        whole = whole.replace(",", self._language.thousands) if is_grouped else digits
        return whole + (f"{self._language.point}{decimals}" if decimals else "")

    def listed(self, names: Iterable[str]) -> str:
        """One name or more as a sentence lists them."""
        *before, last = names
        return f"{', '.join(before)} {self.say('and')} {last}" if before else last

    def octant(self, octant: str) -> str:
        """What people call a direction from the prey."""
        return self.say(f"octant.{octant}")


@functools.cache
def _words(language: str) -> Words:
    return Words(LANGUAGES.get(language, ENGLISH))


def words_of(language: str) -> Words:
    """Those of a language, or of what it is a kind of (``de-CH``); English where there are none."""
    name = language.partition("-")[0]
    return _words(name if name in LANGUAGES else "en")


IN_ENGLISH: Final = words_of("en")
