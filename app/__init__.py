"""What people see and use: the live page, the command line, presets and headless runs."""

__version__ = "0.1.0"
