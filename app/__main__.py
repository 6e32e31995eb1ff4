"""The program ``pounce``, from its first moment on; ``python -m app`` is the same."""

import os
import sys

_INTERRUPTED = 130


def main() -> int:
    """Do what the command line says; returns the exit code."""
    try:
        from app.util import interrupts

        interrupts.end_the_program()
        # This takes long.
        from app.cli.main import main as answer

        return answer()
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        return _INTERRUPTED


if __name__ == "__main__":
    if not sys.flags.safe_path:
        # Python put the current folder there, where other things may have names of our packages.
        sys.path[0] = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    sys.exit(main())
