"""What is drawn in the scene: the board, the names on it, and who looks at which."""
