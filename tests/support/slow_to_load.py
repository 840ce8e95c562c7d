"""What takes long to load in another process."""

import time


def load():
    """A second."""
    time.sleep(1.0)
