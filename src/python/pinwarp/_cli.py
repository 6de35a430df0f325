"""Entry point of the script `pinwarp`, the command line of the package."""

import signal
import sys

from ._pinwarp import main as _main


def main() -> None:
    """Runs the command line on this process's arguments and ends the process with its exit code."""
    # Python would handle Ctrl-C only after the command has ended.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_main(["pinwarp", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
