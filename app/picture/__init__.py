"""From a moment to a picture: numbers on a board, colours, layers, and the timeline."""
