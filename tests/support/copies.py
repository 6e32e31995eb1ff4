"""Copies of the process that tests are in, which may die."""

import os
import traceback
from collections.abc import Callable


def in_a_process_of_its_own(do: Callable[[], object]) -> int:
    """Do something in a copy of this process; returns 0 if it came to its end."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            do()
            code = 0
        finally:
            if code:
                traceback.print_exc()
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
