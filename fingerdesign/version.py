"""The version, which stored work and written files name."""

from functools import cache

__version__ = "0.1.0"

# Those of packages that decide the numbers of a result.
_PACKAGES = ("numpy", "scipy", "scikit-fem", "pypardiso", "cadquery", "pytetwild", "netgen-mesher")


@cache
def versions() -> dict[str, str]:
    """Versions of this package and of those that decide its numbers."""
    import platform  # this module is imported by every command
    from importlib import metadata

    found = {"fingerdesign": __version__, "python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "absent"
    return found
