"""The loop that learns and the arrays that it works on: plain functions, compiled."""
