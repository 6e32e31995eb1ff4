"""A lesson in one browser."""
