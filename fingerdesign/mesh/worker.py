"""Run a module of this package in a process of its own; how it failed is a MeshError."""

from __future__ import annotations

from pathlib import Path

from fingerdesign.errors import MeshError
from fingerdesign.runtime import process
from fingerdesign.runtime.process import die_with_parent, environment

__all__ = ["die_with_parent", "environment", "run_module"]


def run_module(module: str, arguments: list[str], folder: Path, time_limit_s: float) -> None:
    """Run ``python -m module arguments`` in ``folder``; MeshError says how it failed."""
    try:
        process.run_module(module, arguments, folder, time_limit_s)
    except process.ProcessError as error:
        raise MeshError(str(error)) from error
