"""What the replication runs, and what of it the pages show."""

from collections.abc import Sequence
from typing import Final

FIGURES: Final = ("figure_4_1", "figure_4_2", "figure_4_3")
"""The thesis's own experiments, reported on together."""

EXPERIMENTS: Final[Sequence[str]] = (
    *FIGURES,
    "exploration_probability",
    "reading",
    "baselines_search",
    "baselines",
    "timing_plane",
    "timing_seven",
    "timing_test",
    "together",
    "ablation",
    "freeze",
)
"""Shipped experiments, in the order in which they are run."""
