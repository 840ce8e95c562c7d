"""What decides the numbers of a result, as a digest and as versions."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib import metadata
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design

_PACKAGES = ("numpy", "scipy", "scikit-fem", "pypardiso", "cadquery", "pytetwild", "netgen-mesher")


@cache
def _versions() -> tuple[tuple[str, str], ...]:
    from fingerdesign import __version__

    found = [("fingerdesign", __version__), ("python", platform.python_version())]
    for name in _PACKAGES:
        try:
            found.append((name, metadata.version(name)))
        except metadata.PackageNotFoundError:
            found.append((name, "absent"))
    return tuple(found)


def versions() -> dict[str, str]:
    """Versions of this package and of those that decide its numbers."""
    return dict(_versions())


def result_digest(design: Design, scene: Scene, fidelity: str) -> str:
    """SHA-256 over design, scene, fidelity and this package's version, in hexadecimal."""
    from fingerdesign import __version__

    parts = (design.digest(), scene.digest(), fidelity, __version__)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
