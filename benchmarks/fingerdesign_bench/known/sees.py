"""Which rows of the suite would see a fault: a gage's sign, a modulus 2 %, a friction 1 % off.

    python -m fingerdesign_bench.known.sees [--all | --write]

The quick rows, or all, are computed with each fault put into the program. A row sees it where its
verdict is neither "met" nor "known miss". Caches are off: faults must not be stored. --write: the
record of docs/reference, sees.csv, too; it takes three minutes, so `make records` does not.
"""

import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from importlib import import_module
from pkgutil import resolve_name
from typing import Any
from unittest.mock import patch

from fingerdesign.records.base import csv_text
from fingerdesign.runtime.files import write_whole
from fingerdesign_bench.known.case import Case, load_cases
from fingerdesign_bench.known.run import run_cases
from fingerdesign_bench.known.table import FILE

HEADINGS = ("fault", "quick rows that see it", "of", "date")
_MODULES = ("bodies", "gages", "histories", "measured", "patches", "rounds")


@contextmanager
def _changed(places: list[str], change: Callable[[Any], Any]) -> Iterator[None]:
    """Replace a function at every place where it is looked up; caches of the cases are emptied."""
    _forget()
    try:
        with ExitStack() as stack:
            for place in (f"fingerdesign.{each}" for each in places):
                stack.enter_context(patch(place, change(resolve_name(place))))
            yield
    finally:
        _forget()


def _forget() -> None:
    for name in _MODULES:
        for each in vars(import_module(f"fingerdesign_bench.known.{name}")).values():
            if hasattr(each, "cache_clear"):
                each.cache_clear()


def _signed(own: Any) -> Any:
    return lambda *given, **more: -own(*given, **more)


def _stiffer(own: Any) -> Any:
    return lambda young, poisson: own(1.02 * young, poisson)


def _rougher(own: Any) -> Any:
    def changed(law: Any, *others: Any) -> Any:
        steeper = {"coefficient": 1.01 * law.coefficient} if law.is_coulomb else {}
        return own(replace(law, **steeper), *others)

    return changed


FAULTS: dict[str, tuple[list[str], Callable[[Any], Any]]] = {
    "a gage's sign": (["fem.model.gage_rows"], _signed),
    "a modulus 2 % off": (
        ["fem.stiffness.lame_parameters", "fem.system.lame_parameters"],
        _stiffer,
    ),
    "a friction 1 % off": (["contact.problem.friction_at"], _rougher),
}


def sees(cases: list[Case]) -> dict[str, list[str]]:
    """The rows that see each fault, in words."""
    found = {}
    for what, (places, change) in FAULTS.items():
        with (
            tempfile.TemporaryDirectory() as folder,
            patch.dict(os.environ, FINGERDESIGN_CACHE=folder),
            _changed(places, change),
        ):
            found[what] = [each.case.words for each in run_cases(cases).outcomes if each.fails]
    return found


def main(every: bool, write: bool) -> None:
    """Print how many rows see each fault, and how many there are; or write the quick ones' too."""
    cases = [case for case in load_cases() if case.quick or (every and not write)]
    found = {what: len(rows) for what, rows in sees(cases).items()}
    for what, count in found.items():
        print(f"{what}: {count} of {len(cases)}")
    if write:
        date = datetime.now(UTC).date().isoformat()
        rows = [(what, count, len(cases), date) for what, count in found.items()]
        print(write_whole(FILE.with_name("sees.csv"), csv_text(HEADINGS, rows)))


if __name__ == "__main__":
    main("--all" in sys.argv[1:], "--write" in sys.argv[1:])
