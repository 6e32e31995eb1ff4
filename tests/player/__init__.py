"""What the light pages are sent of a moment."""
