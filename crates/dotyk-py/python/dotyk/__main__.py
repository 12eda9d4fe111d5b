"""The command ``dotyk``, which the wheel brings."""

from __future__ import annotations

import signal
import sys

from dotyk import _dotyk


def main() -> None:
    """Runs the command with the arguments of the process, and exits with its status."""
    # nothing of Python runs meanwhile: Ctrl-C ends the process, as it ends the command
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    status = _dotyk.command(["dotyk", *sys.argv[1:]])
    sys.stdout.flush()
    sys.exit(status)


if __name__ == "__main__":
    main()
