"""The world: a grid, a prey that sees only forwards, and the trials held in it.

Knows no learner, no file, no web page and no clock.
"""
