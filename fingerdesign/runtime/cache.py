"""Where kept work lies on this machine."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder(kind: str) -> Path:
    """The folder that files of a kind are kept in; it need not exist.

    Below that of the environment variable FINGERDESIGN_CACHE, or the platform's cache folder.
    """
    given = os.environ.get("FINGERDESIGN_CACHE")
    if given:
        return Path(given) / kind
    from platformdirs import user_cache_path

    return user_cache_path("fingerdesign", appauthor=False) / kind
