"""The live page: one session, many browsers, their widgets, and the loop that draws."""
