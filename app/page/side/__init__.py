"""Runs side by side in one browser: what its frame is sent, and what comes back from it."""
