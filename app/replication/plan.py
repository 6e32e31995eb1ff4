"""What the replication runs, and what of it the pages show."""

from collections.abc import Mapping, Sequence
from typing import Final

THESIS: Final = ("figure_4_1", "figure_4_2", "figure_4_3", "sentences")
"""What the findings of the thesis are read off, and reported on together."""

EXPERIMENTS: Final[Sequence[str]] = (
    *THESIS,
    "reading",
    "baselines_search",
    "baselines",
    "together",
    "ablation",
    "timing_plane",
    "timing_seven",
    "timing_test",
    "exploration_probability",
    "freeze",
)
"""Shipped experiments, in the order in which they are run."""
