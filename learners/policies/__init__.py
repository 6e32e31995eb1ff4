"""Pieces of the loop that choose otherwise than its own: each is left out where it is not used."""
