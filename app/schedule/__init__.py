"""The schedule as blocks: what happened, what is ahead, how it is edited and carried over."""
