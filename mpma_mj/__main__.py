"""`python -m mpma_mj` is `mpma`."""

import sys

from mpma_mj.cli import main

sys.exit(main())
