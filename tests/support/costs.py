"""What experiments take, found out in less time than a lab takes for it."""

import pytest

from app.experiments import cost


def try_for_a_moment(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no time go into it, where nobody asks whether what comes out is right."""
    monkeypatch.setattr(cost, "_TRIED_S", 0.01)
    monkeypatch.setattr(cost, "_TRIED_STEPS", 10_000)
    monkeypatch.setattr(cost, "_PILOT_S", 0.01)
