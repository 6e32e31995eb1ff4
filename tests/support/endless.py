"""An experiment that is not over before a test has looked, however long that stands still."""

from collections.abc import Mapping
from typing import Final

WORLD: Final[Mapping[str, float]] = {
    "world.size": 400,
    "world.step_limit": 100_000,
    "world.vision_radius": 0,
    "learner.alpha": 0,
}
"""In which nobody ever learns where the prey is."""

ENDLESS: Final = "\n".join(
    [
        "presets: [standard_q]",
        "set:",
        *(f"  {name}: {value}" for name, value in WORLD.items()),
        "trials: 2000000",
        "seeds: 5",
    ]
)
"""Each of its runs takes half an hour."""
