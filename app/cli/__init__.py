"""The command ``pounce``: one file for each of its commands."""
