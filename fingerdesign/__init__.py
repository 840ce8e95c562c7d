"""Design, simulate, cast and compare elastic tactile fingers that detect incipient slip.

>>> import fingerdesign
>>> design = fingerdesign.parse_design('design.name = "mine"')
>>> design.plates.count
15

Importing this package loads no numerics, CAD kernel, VTK or mesher; each public name loads what
it needs when it is first used.
"""

from typing import TYPE_CHECKING, Any

from fingerdesign.version import __version__ as __version__

if TYPE_CHECKING:
    from fingerdesign.analysis.analysed import load_result as load_result
    from fingerdesign.cad.from_python import with_body as with_body
    from fingerdesign.checks.load import load_design as load_design
    from fingerdesign.checks.load import parse_design as parse_design
    from fingerdesign.checks.load import with_values as with_values
    from fingerdesign.design.io import parse_scene as parse_scene
    from fingerdesign.design.scene import Scene as Scene
    from fingerdesign.design.schema import Design as Design
    from fingerdesign.design.shipped import load_scene as load_scene
    from fingerdesign.errors import DesignError as DesignError
    from fingerdesign.errors import FingerDesignError as FingerDesignError
    from fingerdesign.errors import SolverError as SolverError
    from fingerdesign.pipeline import analyse as analyse
    from fingerdesign.records.result import Result as Result
    from fingerdesign.runtime.registry import allow_code as allow_code


_HOMES = {
    "Design": "fingerdesign.design.schema",
    "DesignError": "fingerdesign.errors",
    "FingerDesignError": "fingerdesign.errors",
    "Result": "fingerdesign.records.result",
    "Scene": "fingerdesign.design.scene",
    "SolverError": "fingerdesign.errors",
    "allow_code": "fingerdesign.runtime.registry",
    "load_result": "fingerdesign.analysis.analysed",
    "load_design": "fingerdesign.checks.load",
    "load_scene": "fingerdesign.design.shipped",
    "parse_design": "fingerdesign.checks.load",
    "parse_scene": "fingerdesign.design.io",
    "with_values": "fingerdesign.checks.load",
    "with_body": "fingerdesign.cad.from_python",
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
