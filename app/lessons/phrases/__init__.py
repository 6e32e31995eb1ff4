"""What a lesson says around its own texts, by language: a language is a module, and a line here.

English is the base: it has every phrase, and stands in for those that another language lacks. The
page's scripts have what they say themselves in the same manner (``words.js`` of ``app/web/lesson``,
``app/web/audience`` and ``app/web/time``).
"""

from collections.abc import Mapping
from typing import Final

from app.lessons.phrases.english import ENGLISH
from app.lessons.phrases.german import GERMAN
from app.lessons.phrases.language import Language

LANGUAGES: Final[Mapping[str, Language]] = {"en": ENGLISH, "de": GERMAN}
