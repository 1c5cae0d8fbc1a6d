"""Agents, which act and learn by observations alone.

Names are imported when they are used first, so that configs load without networks.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
