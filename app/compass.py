"""Names of the eight directions, as headings and as moves."""

from sim import geometry

HEADING_NAMES = (
    "east",
    "north-east",
    "north",
    "north-west",
    "west",
    "south-west",
    "south",
    "south-east",
)
_TOWARDS = dict(zip(map(tuple, geometry.HEADINGS.tolist()), HEADING_NAMES, strict=True))
MOVE_NAMES = tuple(_TOWARDS.get(tuple(way), "staying") for way in geometry.MOVES.tolist())
