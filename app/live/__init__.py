"""What runs now: one learner in its thread, and copies of its moments."""
