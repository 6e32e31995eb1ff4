"""Timed hierarchical Q-learning: options, tables, the loop that learns, and the schedule.

Knows the world, and no file, no web page and no clock.
"""
