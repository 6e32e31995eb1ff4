"""How things are said, and how what people type is understood: plain words, and numbers."""
