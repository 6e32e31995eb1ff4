"""The world: a grid, a prey that sees only forwards, and the trials held in it.

Knows no learner, no file, no web page and no clock; but for how its own code comes to be run, in
``sources``, ``compiled`` and ``compile_cache``.
"""

# Before any module whose text it is to read.
from sim import sources as sources
