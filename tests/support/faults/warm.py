"""A program that has imported and compiled everything, and forks for each command it is given.

Each line it reads is a JSON list: at which call that changes the disk it is to fail, with which
error (0: killed), and the words of the command line. It answers with the exit code, how many such
calls there were, and what was said on standard error; with null if it was killed.
"""

import contextlib
import ctypes
import io
import json
import os
import sys

from app.cli.main import main as pounce


def main() -> None:
    """Carry out what comes, until nothing more does."""
    faults = ctypes.CDLL(sys.argv[1])
    with contextlib.redirect_stdout(io.StringIO()):
        pounce(sys.argv[2:])
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin:
        at, error, argv = json.loads(line)
        reading, writing = os.pipe()
        child = os.fork()
        if not child:
            said = io.StringIO()
            faults.fault_set(at, error)
            with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
                code = pounce(argv)
            count = faults.fault_count()
            faults.fault_set(0, 0)
            os.write(writing, json.dumps([code, count, said.getvalue()]).encode())
            os._exit(0)
        os.close(writing)
        with os.fdopen(reading, "rb") as answer:
            found = answer.read()
        os.waitpid(child, 0)
        sys.stdout.write(f"{found.decode() or 'null'}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
