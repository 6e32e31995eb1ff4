"""Pieces of the loop that choose what to do next in other ways than the thesis's."""
