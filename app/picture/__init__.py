"""From a moment to a picture: numbers on a board, colours and layers."""
