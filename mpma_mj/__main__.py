"""`python -m mpma_mj` is `mpma`."""

import sys

from mpma_command import main

sys.exit(main())
