"""Learners that the thesis names beside its own, for comparison: each has a loop of its own.

What a loop takes and gives is what :func:`learners.kernel.loop.advance` does; the world, the starts
of trials, the logs and the digest are the same, and all else of a run is shared.
"""
