"""What is seen of a moment, as data that the light pages of `app/web/player` draw."""
