"""Design, simulate, cast and compare elastic tactile fingers that feel incipient slip.

>>> import fingerdesign
>>> design = fingerdesign.parse_design('design.name = "mine"')
>>> design.plates.count
15

Importing this package loads no numerics, CAD kernel, VTK or mesher; each public name loads what
it needs when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fingerdesign.design.io import load_design as load_design
    from fingerdesign.design.io import load_scene as load_scene
    from fingerdesign.design.io import parse_design as parse_design
    from fingerdesign.design.io import parse_scene as parse_scene
    from fingerdesign.design.io import with_values as with_values
    from fingerdesign.design.scene import Scene as Scene
    from fingerdesign.design.schema import Design as Design
    from fingerdesign.errors import DesignError as DesignError
    from fingerdesign.errors import FingerDesignError as FingerDesignError
    from fingerdesign.errors import SolverError as SolverError
    from fingerdesign.geometry.from_python import with_body as with_body
    from fingerdesign.pipeline import analyse as analyse
    from fingerdesign.results import Result as Result

__version__ = "0.1.0"

_HOMES = {
    "Design": "fingerdesign.design.schema",
    "DesignError": "fingerdesign.errors",
    "FingerDesignError": "fingerdesign.errors",
    "Result": "fingerdesign.results",
    "Scene": "fingerdesign.design.scene",
    "SolverError": "fingerdesign.errors",
    "load_design": "fingerdesign.design.io",
    "load_scene": "fingerdesign.design.io",
    "parse_design": "fingerdesign.design.io",
    "parse_scene": "fingerdesign.design.io",
    "with_values": "fingerdesign.design.io",
    "with_body": "fingerdesign.geometry.from_python",
    "analyse": "fingerdesign.pipeline",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'fingerdesign' has no attribute '{name}'")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
