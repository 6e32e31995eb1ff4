"""Numbers of a preset by their dotted keys, as commands and the page name them."""

from learners.spec import RunSpec


def value_of(spec: RunSpec, key: str) -> float:
    """Value of a parameter, see :data:`learners.commands.PARAMETERS`."""
    section, name = key.split(".")
    return float(getattr(getattr(spec, section), name))
