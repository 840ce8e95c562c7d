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
import hashlib
import importlib
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from functools import cache, cached_property
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

from fingerdesign.errors import DesignError, Fault, PluginWarning
from fingerdesign.runtime.child import ALLOWED, MODULES, PARENT

PLUGINS = "fingerdesign.plugins"
REFERENCE = r"^[\w.]+:[\w.]+$"  # "package.module:Class"
LAST = 1000  # Place in lists of a kind that gives none: behind those that are shipped.


def key(default: Any, description: str, **bounds: float) -> Any:
    """A key of a kind's TOML table, as a field of a plain frozen dataclass.

    bounds: gt, ge, lt or le, in the key's unit. The design's strict table is made from it.
    """
    return field(default=default, metadata={"description": description, **bounds})


@dataclass(frozen=True, kw_only=True)
class Kind:
    """Entry of a registry.

    name: as files give it. place: its place in lists. table: the dataclass of its TOML table, made
    with :func:`key`; None where it has none. table_name: the table's key. made: the object that
    does its work.
    """

    name: str
    place: int = LAST
    table: type | None = None
    table_name: str = ""
    made: Any = None


def own_values(owner: object, kind: Any) -> Any:
    """The values of a kind's own table, as its dataclass, from the table that holds it; its
    defaults where it is absent, None where the kind has none."""
    if kind.table is None:
        return None
    values = getattr(owner, kind.table_name, None)
    if values is None:
        return kind.table()
    return kind.table(**{each.name: getattr(values, each.name) for each in fields(kind.table)})


def unknown_name(name: object, key: str, known: Sequence[str]) -> Fault:
    """The fault of a name that is none of the known ones, with the nearest of them."""
    near = get_close_matches(str(name), known, 1, 0.5)
    remedy = f"did you mean {near[0]}?" if near else "choose one of them"
    return Fault(key, name, f"one of {', '.join(known)}", remedy)


def is_reference(name: object) -> bool:
    """Tell whether a name is a reference, "package.module:Class"."""
    return isinstance(name, str) and ":" in name


def allow_code(*references: str) -> None:
    """Permit files to name these references, "package.module:Class", in this process and in those
    that it starts from now on; without any, every reference."""
    allowed = [*os.environ.get(ALLOWED, "").split(), *(references or ("*",))]
    os.environ[ALLOWED] = " ".join(dict.fromkeys(allowed))


@contextlib.contextmanager
def code_allowed(*references: str) -> Iterator[None]:
    """Permit references as :func:`allow_code` does, within the block.

    What is imported in the block stays permitted.
    """
    before = os.environ.get(ALLOWED, "")
    allow_code(*references)
    try:
        yield
    finally:
        os.environ[ALLOWED] = before
        followed = [each for registry in REGISTRIES for each in registry.followed()]
        if followed:
            allow_code(*followed)


def _refuse_forbidden(name: str, key: str) -> None:
    """Raise DesignError for a reference that nobody permitted."""
    allowed, module = os.environ.get(ALLOWED, "").split(), name.partition(":")[0]
    plugins = {point.module for point in entry_points(group=PLUGINS)}
    if not ({"*", name} & set(allowed) or module in plugins):
        bound = "a registered name, unless code that a file names may run"
        remedy = "if you trust its author, add --allow-code (in Python allow_code=True)"
        raise DesignError([Fault(key, name, bound, remedy)])


def _referred(name: str, key: str) -> Any:
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
        raise fault("package.module:Class of a module that can be imported", remedy) from None
    try:
        for part in path.split("."):
            found = getattr(found, part)
    except AttributeError:
        near = get_close_matches(path, dir(found), 1, 0.5)
        remedy = f"did you mean {module}:{near[0]}?" if near else "correct its name"
        raise fault(f"package.module:Class of what is in {module}", remedy) from None
    return found


_Made = TypeVar("_Made", bound=type[Any])


class Registry:
    """The kinds of one sort. what: the sort in words; home: the package in whose files kinds are
    shipped; decorator: the name under which they register there."""

    def __init__(self, what: str, home: str, decorator: str) -> None:
        self.what, self.home = what, home
        self._form = re.compile(rf'^@{decorator}\(\s*"([^"]+)",\s*place=(\d+)', re.MULTILINE)
        self._kinds: dict[str, Any] = {}
        self._references: dict[str, Any] = {}
        self._adopt: Callable[[str, Any, str], Any] | None = None
        self._watchers: list[Callable[[Any], None]] = []

    def add(self, kind: Any) -> None:
        """Register a :class:`Kind`. Raises ValueError where its name is another's."""
        homes = [module for _, known, module in self._shipped if known == kind.name]
        to_come = any(module not in sys.modules for module in homes)
        if kind.name in self._kinds or to_come:
            raise ValueError(f"there already is a {self.what} called {kind.name!r}")
        for watcher in self._watchers:
            watcher(kind)
        self._kinds[kind.name] = kind

    def kind(
        self, name: str, *, place: int = LAST, table: type | None = None
    ) -> Callable[[_Made], _Made]:
        """Register a class under a name; an instance of it answers for the kind.

        table: a dataclass of the keys that it alone has.
        """

        def register(made: _Made) -> _Made:
            self.add(Kind(name=name, place=place, table=table, table_name=name, made=made()))
            return made

        return register

    def watch(self, watcher: Callable[[Any], None]) -> None:
        """Call ``watcher`` with every kind that is there, and from now on with every new one."""
        for kind in tuple(self._kinds.values()):
            watcher(kind)
        self._watchers.append(watcher)

    def adopt(self, adopt: Callable[[str, Any, str], Any]) -> None:
        """Take references, too: ``adopt(reference, what it names, key)`` gives the kind, or raises
        DesignError."""
        self._adopt = adopt

    def content_of(self, reference: str) -> str:
        """SHA-256 of the file that a reference leads to, in hexadecimal."""
        self.find(reference, "")
        file = Path(sys.modules[reference.partition(":")[0]].__file__ or "")
        return hashlib.sha256(file.read_bytes()).hexdigest()

    @property
    def refers(self) -> bool:
        """Tell whether references are accepted."""
        return self._adopt is not None

    def followed(self) -> list[str]:
        """List the references whose classes were imported."""
        return sorted(self._references)

    def contents(self) -> list[str]:
        """Return the digests of the files of every reference that was followed."""
        return [self.content_of(each) for each in self.followed()]

    def load(self) -> None:
        """Import the files that ship kinds."""
        for module in dict.fromkeys(module for _, _, module in self._shipped):
            import_module(module)

    def loaded(self) -> tuple[Any, ...]:
        """The kinds that are there already."""
        return tuple(self._kinds.values())

    def kinds(self) -> tuple[Any, ...]:
        """Every kind, in the order of lists."""
        self.load()
        load_plugins()
        return tuple(sorted(self._kinds.values(), key=lambda kind: kind.place))

    def names(self) -> tuple[str, ...]:
        """Every name, in the order of lists."""
        load_plugins()
        shipped = self.shipped_names()
        others = [kind for kind in self._kinds.values() if kind.name not in shipped]
        return (*shipped, *(kind.name for kind in sorted(others, key=lambda kind: kind.place)))

    def knows(self, name: object) -> bool:
        """Tell whether there is a kind of that name."""
        if not isinstance(name, str):
            return False
        if is_reference(name):
            with contextlib.suppress(DesignError):
                self.find(name, "")
            return name in self._references
        return name in self._kinds or name in self.shipped_names() or name in self.names()

    def find(self, name: object, key: str) -> Any:
        """The kind of a name. Raises DesignError, with the nearest name, for an unknown one, and
        for a reference that leads to no such kind."""
        if is_reference(name) and name not in self._references:
            self.load()
            if self._adopt is not None:
                found = self._adopt(str(name), _referred(str(name), key), key)
                self._references[str(name)] = found
        if name in self._references:
            return self._references[str(name)]
        if name not in self._kinds:
            for _, known, module in self._shipped:
                if known == name:
                    import_module(module)
        if name not in self._kinds:
            load_plugins()
        if name not in self._kinds:
            raise DesignError([self.fault(name, key)])
        return self._kinds[str(name)]

    def get(self, name: object) -> Any:
        """The kind of a name, None for an unknown one: a record may be another machine's, and what
        it refers to is not imported."""
        if is_reference(name):
            return self._references.get(str(name))
        return self.find(name, "") if self.knows(name) else None

    def fault(self, name: object, key: str) -> Fault:
        """The fault of an unknown name."""
        return unknown_name(name, key, self.names())

    def shipped_names(self) -> tuple[str, ...]:
        """Names of the shipped kinds, in the order of lists, without importing them."""
        return tuple(name for _, name, _ in self._shipped)

    @cached_property
    def _shipped(self) -> list[tuple[int, str, str]]:
        """Place, name and module of every kind that a file of the home registers, read from their
        text: importing the files would take long, and ``--help`` lists the names."""
        spec = find_spec(self.home)
        if spec is None or spec.origin is None:
            return []
        root, found = Path(spec.origin).parent, []
        for file in sorted(root.rglob("*.py")):
            module = ".".join([self.home, *file.relative_to(root).with_suffix("").parts])
            registered = self._form.findall(file.read_text("utf-8"))
            found += [(int(place), name, module) for name, place in registered]
        return sorted(found)


CONTROLLERS = Registry("controller", "fingerdesign.control.controllers", "controller")
SCENE_OBJECTS = Registry("scene object", "fingerdesign.shapes", "scene_object")
BODIES = Registry("body", "fingerdesign.layout", "body")
PLATE_LAYOUTS = Registry("plate layout", "fingerdesign.layout", "plate_layout")
MESHERS = Registry("mesher", "fingerdesign.mesh", "mesher")
REGISTRIES = (CONTROLLERS, SCENE_OBJECTS, BODIES, PLATE_LAYOUTS, MESHERS)


def has_plugins() -> bool:
    """Tell whether there are kinds from outside the package."""
    return any(each.names() != each.shipped_names() or each.contents() for each in REGISTRIES)


@cache
def load_plugins() -> None:
    """Import, once, every module that an entry point of ``fingerdesign.plugins`` names.

    One that fails is named in a warning, and the rest is loaded.
    """
    for point in entry_points(group=PLUGINS):
        try:
            point.load()
        except (Exception, SystemExit) as error:  # one that exits must not end our process
            why = " ".join(f"{type(error).__name__}: {error}".split())
            text = f"the plug-in {point.name} ({point.value}) is not loaded: {why}"
            warnings.warn(text, PluginWarning, stacklevel=2)
