"""How often something may happen: so often in the long run, and some of it at once."""


class Turnstile:
    """Lets through so much a second. Times are in seconds, of any clock."""

    def __init__(self, per_s: float, at_once: float) -> None:
        """After a rest, ``at_once`` may come together."""
        self._per_s, self._at_once = per_s, at_once
        self._left, self._counted_s = at_once, -1.0

    def wait_s(self, now_s: float, cost: float = 1.0) -> float:
        """Count one more; returns for how long it has to wait."""
        if self._counted_s < 0:
            self._counted_s = now_s
        grown = self._left + max(now_s - self._counted_s, 0.0) * self._per_s
        self._left, self._counted_s = min(grown, self._at_once) - cost, now_s
        return max(-self._left / self._per_s, 0.0)
