"""What numbers of many runs say: estimates with intervals, and settings that were swept. Pure."""
