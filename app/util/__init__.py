"""What any program might need, and nothing that knows of learners: files, signals, texts."""
