"""The page of a class: what the presenter shows, on phones that can only look."""
