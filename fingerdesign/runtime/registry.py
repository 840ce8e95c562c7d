"""Kinds by name: controllers, scene objects, bodies, plate layouts, meshers.

A kind is one entry of a registry, made by a decorator in the one file that holds it. From the
entries come lists of names, TOML tables, choices of the command line and remedies of faults.

    CONTROLLERS.names()             every name, in the order of lists
    CONTROLLERS.find("papr", key)   DesignError: "did you mean 'paper'?"

A kind from outside the package is registered by a module that an entry point names::

    [project.entry-points."fingerdesign.plugins"]
    mine = "my_package.my_kinds"

or by any module that is imported before a file is read. A controller may also be named by a
reference, "package.module:Class", to a module in the working directory or an installed one. A file
must not run code by naming it: a reference is followed only where :func:`allow_code` permits it, or
where an entry point names its module. Files that ship kinds are loaded when a registry is first
used, entry points when a design is first read; importing this is light.
"""

import contextlib
import os
from collections.abc import Iterator

from fingerdesign.runtime.child import ALLOWED
from fingerdesign.runtime.kinds import LAST, Kind, Registry, key, own_values, unknown_name
from fingerdesign.runtime.references import REFERENCE, allow_code, is_reference, load_plugins

# Modules that register kinds, and plug-ins, import these from here.
__all__ = ["LAST", "REFERENCE", "Kind", "Registry", "allow_code", "is_reference"]
__all__ += ["key", "load_plugins", "own_values", "unknown_name"]
CONTROLLERS = Registry("controller", "fingerdesign.control.controllers", "controller")
SCENE_OBJECTS = Registry("scene object", "fingerdesign.shapes", "scene_object")
BODIES = Registry("body", "fingerdesign.layout", "body")
PLATE_LAYOUTS = Registry("plate layout", "fingerdesign.layout", "plate_layout")
MESHERS = Registry("mesher", "fingerdesign.mesh", "mesher")
REGISTRIES = (CONTROLLERS, SCENE_OBJECTS, BODIES, PLATE_LAYOUTS, MESHERS)


@contextlib.contextmanager
def code_allowed(*references: str) -> Iterator[None]:
    """Permit references as :func:`allow_code` does, within the block. What is imported in the block
    stays permitted."""
    before = os.environ.get(ALLOWED, "")
    allow_code(*references)
    try:
        yield
    finally:
        os.environ[ALLOWED] = before
        followed = [each for registry in REGISTRIES for each in registry.followed()]
        if followed:
            allow_code(*followed)


def has_plugins() -> bool:
    """Tell whether there are kinds from outside the package."""
    return any(each.names() != each.shipped_names() or each.contents() for each in REGISTRIES)
