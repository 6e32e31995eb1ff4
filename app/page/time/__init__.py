"""The time bar of a browser: what its hand asks for, and the moment that it looks at."""
