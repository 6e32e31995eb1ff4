"""Yardsticks for the compiled loop: the same learning in C, in plain numba, and in Python."""

from sim import sources

sources.adopt(__name__)
