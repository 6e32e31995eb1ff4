"""A page on results that stands for itself, with its pictures as files."""
