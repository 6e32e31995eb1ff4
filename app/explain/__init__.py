"""What is going on, in words: the sentence, and why one cell has its value."""
