"""`python -m magbench`."""

import sys

from magbench.cli import main

sys.exit(main())
