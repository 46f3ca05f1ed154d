"""`python -m swarmproof` is the command line."""

import sys

from swarmproof.cli import main

sys.exit(main())
