"""What people see and use: the live page, the command line, experiments and reports."""

__version__ = "0.1.0"
