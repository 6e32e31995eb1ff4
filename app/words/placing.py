"""Where labels find room along a line: beside one another, and beside what is there already."""


class Room:
    """What is free of a line."""

    def __init__(self, first: float, until: float) -> None:
        self._gaps = [(first, until)]

    def take(self, first: float, until: float) -> None:
        """Let something stand there."""
        self._gaps = [
            part
            for low, high in self._gaps
            for part in ((low, min(high, first)), (max(low, until), high))
            if part[1] > part[0]
        ]

    def taken(self, first: float, until: float) -> bool:
        """Take the room there; returns whether all of it was free."""
        is_free = any(low <= first and until <= high for low, high in self._gaps)
        if is_free:
            self.take(first, until)
        return is_free

    def take_nearest(self, width: float, place: float, within: float) -> tuple[float, bool] | None:
        """Take the room nearest to a place that is so wide, at most so far from it.

        Returns:
            The edge of the room on the side of the place, and whether the room is before it; None
            if there is no such room. Of two that are as near it is the one before the place.
        """
        spots = [
            (place - high, high, True) if high <= place else (low - place, low, False)
            for low, high in self._gaps
            if high - low >= width
        ]
        near = [spot for spot in spots if spot[0] <= within]
        if not near:
            return None
        _, edge, is_before = min(near)
        self.take(*((edge - width, edge) if is_before else (edge, edge + width)))
        return edge, is_before
