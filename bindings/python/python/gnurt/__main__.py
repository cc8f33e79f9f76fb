# SPDX-License-Identifier: GPL-3.0-or-later
"""The program `gnurt`, also as `python -m gnurt`."""

import signal
import sys


def main():
    """Runs the program with the words of this process; its exit status."""
    from ._gnurt import program

    # Ctrl-C is the program's business, which saves the picture so far.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    name = "gnurt" if sys.argv[0].endswith("__main__.py") else sys.argv[0]
    return program([name, *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
