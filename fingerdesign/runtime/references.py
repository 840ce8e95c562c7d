"""Code that is not shipped: references that files name, and modules that entry points name.

A file must not run code by naming it: a reference is followed only where :func:`allow_code` permits
it, or where an entry point names its module.
"""

import contextlib
import importlib
import os
import sys
import warnings
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from fingerdesign.errors import DesignError, Fault, PluginWarning
from fingerdesign.runtime.child import ALLOWED, MODULES, PARENT

PLUGINS = "fingerdesign.plugins"
REFERENCE = r"^[\w.]+:[\w.]+$"  # "package.module:Class"


def is_reference(name: object) -> bool:
    """Tell whether a name is a reference, "package.module:Class"."""
    return isinstance(name, str) and ":" in name


def allow_code(*references: str) -> None:
    """Permit files to name these references, "package.module:Class", in this process and in those
    that it starts from now on; without any, every reference."""
    allowed = [*os.environ.get(ALLOWED, "").split(), *(references or ("*",))]
    os.environ[ALLOWED] = " ".join(dict.fromkeys(allowed))


def _refuse_forbidden(name: str, key: str) -> None:
    """Raise DesignError for a reference that nobody permitted."""
    allowed, module = os.environ.get(ALLOWED, "").split(), name.partition(":")[0]
    plugins = {point.module for point in entry_points(group=PLUGINS)}
    if not ({"*", name} & set(allowed) or module in plugins):
        bound = "a registered name, unless code that a file names may run"
        remedy = "if you trust its author, add --allow-code (in Python allow_code=True)"
        raise DesignError([Fault(key, name, bound, remedy)])


def referred(name: str, key: str) -> Any:
    """Import what "package.module:Class" names. Raises DesignError, whatever the module raises, and
    without importing anything where it is not permitted."""
    _refuse_forbidden(name, key)
    module, _, path = name.partition(":")

    def fault(bound: str, remedy: str) -> DesignError:
        return DesignError([Fault(key, name, bound, remedy)])

    folders = os.environ.get(MODULES, "").split(os.pathsep)
    if PARENT not in os.environ:  # a process that works for another one runs in a folder of others
        folders.append(str(Path.cwd()))
    os.environ[MODULES] = os.pathsep.join(dict.fromkeys(filter(None, folders)))
    sys.path += [each for each in filter(None, folders) if each not in sys.path]
    importlib.invalidate_caches()
    try:
        with contextlib.redirect_stdout(sys.stderr):  # stdout is for scripts
            found = import_module(module)
    except (Exception, SystemExit) as error:
        missing = getattr(error, "name", None) if isinstance(error, ModuleNotFoundError) else None
        absent = bool(missing) and f"{module}.".startswith(f"{missing}.")
        why = " ".join(f"correct it: {type(error).__name__}: {error}".split())[:300]
        remedy = "run where its folder lies, or install it" if absent else why
        if module.endswith(".py"):
            remedy = f"write {module.removesuffix('.py')}:{path}, without .py"
        raise fault("package.module:Class of a module that can be imported", remedy) from None
    try:
        for part in path.split("."):
            found = getattr(found, part)
    except AttributeError:
        near = get_close_matches(path, dir(found), 1, 0.5)
        remedy = f"did you mean {module}:{near[0]}?" if near else "correct its name"
        raise fault(f"package.module:Class of what is in {module}", remedy) from None
    return found


@cache
def load_plugins() -> None:
    """Import, once, every module that an entry point of ``fingerdesign.plugins`` names. One that
    fails is named in a warning, and the rest is loaded."""
    for point in entry_points(group=PLUGINS):
        try:
            point.load()
        except (Exception, SystemExit) as error:  # one that exits must not end our process
            why = " ".join(f"{type(error).__name__}: {error}".split())
            text = f"the plug-in {point.name} ({point.value}) is not loaded: {why}"
            warnings.warn(text, PluginWarning, stacklevel=2)
