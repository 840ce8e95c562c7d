"""Interactive pictures by Plotly, in a page that fetches nothing.

A page carries plotly.js packed (gzip in base64, 2 MB instead of 4.8 MB) and unpacks it for the
first chart. Its content policy names the digests of the scripts that may run: what an outcome or a
design brings along can be no script. Of Plotly's traces all that this program draws run under such
a policy; parallel coordinates ("parcoords") do not, for they compile functions from text.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
from functools import lru_cache

from fingerdesign.errors import FingerDesignError


@lru_cache(maxsize=1)
def plotly_script() -> tuple[str, str]:
    """plotly.js as it is installed: packed for a page, and its digest for the page's policy.

    Raises FingerDesignError where the script is not where the plotly package has it.
    """
    from importlib.resources import files

    place = files("plotly") / "package_data" / "plotly.min.js"
    try:
        text = place.read_text(encoding="utf-8")
    except OSError as error:
        raise FingerDesignError(f"plotly has no script: {error}; install plotly again") from error
    return packed(text), digest(text)


def packed(text: str) -> str:
    """gzip in base64: browsers open a page of a few MB faster than one of many."""
    return base64.b64encode(gzip.compress(text.encode(), 6, mtime=0)).decode("ascii")


def digest(script: str) -> str:
    """A script's name in a content policy."""
    found = hashlib.sha256(script.encode()).digest()
    return f"'sha256-{base64.b64encode(found).decode('ascii')}'"


def content_policy(*scripts: str) -> str:
    """A policy under which a page loads nothing and runs only the scripts of these digests."""
    allowed = " ".join(scripts)
    return (
        "default-src 'none'; img-src data:; style-src 'unsafe-inline'; "
        f"script-src {allowed}; base-uri 'none'; form-action 'none'"
    )
