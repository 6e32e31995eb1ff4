"""What results say: read back, gathered while they come, and held against the thesis's findings."""
