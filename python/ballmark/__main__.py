"""The command ``ballmark``, carried by the package: ``python -m ballmark``, or ``ballmark`` on the path."""

import sys

from . import _ballmark


def main() -> int:
    """Runs the command with this process's arguments; returns its exit status."""
    return _ballmark.command(["ballmark", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
