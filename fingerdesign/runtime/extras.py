"""Extras: libraries that some work alone needs, and the line that names the way to get them."""

from importlib.util import find_spec

from fingerdesign.errors import FingerDesignError


class MissingExtra(FingerDesignError, ImportError):
    """A library of an extra is not installed; the message names the remedy."""


def needs(extra: str, *libraries: str) -> None:
    """Raise MissingExtra where a library of an extra is not installed; nothing is imported."""
    lacking = [name for name in libraries if not _found(name)]
    if lacking:
        remedy = f'pip install "fingerdesign[{extra}]"; in a copy of the repository: '
        remedy += f'pip install --editable ".[{extra}]"'
        names = " and ".join(lacking)
        raise MissingExtra(f"this needs the extra {extra} (missing: {names}): {remedy}")


def _found(library: str) -> bool:
    try:
        return find_spec(library) is not None
    except ValueError:  # its place in sys.modules is blocked
        return False
