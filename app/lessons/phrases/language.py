"""A language in which lessons are read: how it writes numbers, and what it says."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Language:
    """All that a lesson has to be told in it."""

    thousands: str
    """Between the thousands of a number."""
    grouped_from: int
    """The least number that has that."""
    point: str
    """Before decimals."""
    percent: str
    """After a number of hundredths."""
    phrases: Mapping[str, str]
    """By their keys; what stands in braces is filled in. Of what is counted there are two, which
    end in ``.one`` and ``.more``."""
