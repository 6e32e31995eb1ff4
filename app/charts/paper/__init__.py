"""Charts on paper, by matplotlib: figures with small print, and their numbers, as files."""
