"""One kind, and the registry of the kinds of one sort."""

import contextlib
import hashlib
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from functools import cached_property
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.references import is_reference, load_plugins, referred

LAST = 1000  # Place in lists of a kind that gives none: behind those that are shipped.
_Made = TypeVar("_Made", bound=type[Any])


def key(default: Any, description: str, **bounds: float) -> Any:
    """A key of a kind's TOML table, as a field of a plain frozen dataclass. bounds: gt, ge, lt or
    le, in the key's unit. The design's strict table is made from it."""
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
        """Register a class under a name; an instance of it answers for the kind. table: a dataclass
        of the keys that it alone has."""

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
                found = self._adopt(str(name), referred(str(name), key), key)
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
        own = ["module:Class of your own"] if self.refers else []
        return unknown_name(name, key, [*self.names(), *own])

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
