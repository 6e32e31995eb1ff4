"""What one browser looks at: the live run or a moment of the past, and the bar by which it goes."""
