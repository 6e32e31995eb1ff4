"""Lessons: what is measured, checked and predicted in them, and where somebody is in one."""
