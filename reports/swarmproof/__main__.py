"""The program: `swarmproof`, or `python -m swarmproof`. Its import lets Ctrl-C end it silently until it can speak."""

import signal
import sys

if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # which would show a traceback
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def main() -> int:
    """Run the command line and return the exit code."""
    from swarmproof import cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
