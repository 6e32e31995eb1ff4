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
)
"""Shipped experiments, in the order in which they are run."""

BEYOND: Final[Sequence[str]] = ("beyond", "templates")
"""What goes beyond the thesis, run and reported on by itself."""

DRAWN: Final[Mapping[str, tuple[str, str]]] = {
    "figure_4_1": ("", "figure_4_1_by_trials"),
    "figure_4_2": ("", "figure_4_2_by_trials"),
    "figure_4_3": ("", "figure_4_3_by_trials"),
    "figure_4_3_selection": ("", "figure_4_3_selection_by_trials"),
    "value_spread": ("", "value_spread"),
    "readings": ("reading", "readings"),
    "timing_reward": ("timing_plane", "difference_1_horizon_reward"),
    "timing_area": ("timing_plane", "difference_1_horizon_area"),
    "timing_effects": ("timing_seven", "trends_1_horizon_area"),
    "timing_shares": ("timing_seven", "shares_1_horizon_area"),
}
"""Figures of the page by the name of their file: the experiment whose report has them, empty for
that on the thesis's together, and what they are called there."""
