"""Standard output for a verb's result alone."""

from __future__ import annotations

import os
import sys


def own_output() -> None:
    """Keep standard output to ourselves; what libraries print there goes to standard error from now on.

    Fast DDS writes its troubles to standard output, into the midst of a JSON object.
    """
    try:
        sys.stdout.flush()
        kept = os.dup(sys.stdout.fileno())
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    except (AttributeError, OSError, ValueError):
        return  # one of them is closed, or no file: there is nothing to keep apart
    encoding, errors = sys.stdout.encoding, sys.stdout.errors
    sys.stdout = os.fdopen(kept, "w", 1 if os.isatty(kept) else -1, encoding=encoding, errors=errors)
