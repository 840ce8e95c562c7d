"""``fingerdesign list``: what there is to choose from, in tables of 80 columns or as JSON."""

import inspect
import re
from collections.abc import Callable, Iterator
from typing import Any

from fingerdesign.checks.load import load_design
from fingerdesign.design.io import parse_scene
from fingerdesign.design.shipped import shipped_names, shipped_text
from fingerdesign.design.stock import shipped_types
from fingerdesign.errors import DesignError
from fingerdesign.materials import EXPANSION, MATERIALS
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.search.passing.atlas import atlas
from fingerdesign.search.study.file import parse_study
from fingerdesign.search.study.metrics import METRICS
from fingerdesign_cli.options import SHELVES
from fingerdesign_cli.terminal import WIDTH, as_json, print_json, print_table, say_marked

_Row = dict[str, Any]
# Below the table of a topic: its columns in words.
_LEGENDS = {
    "materials": "youngs modulus and published: the modulus, and the range of other sources, MPa",
    "gages": "grid: what reads the strain; with tabs: all that lies on the plate; factor: relative "
    "change of resistance per strain; microstrain per uV/V: strain that changes the bridge's "
    "signal by 1 uV per volt of supply; Et: modulus times thickness, by which it stiffens the "
    "plate; order: least pieces; weeks: to delivery; price of a piece: low (below 20 EUR), middle "
    "(to 50), high",
    "atlas": "g: mass that is lifted; sla, fdm, machined: checks passed of the mold so made",
}
# By name: what it shows in words, and its entries; in the order of their functions.
_SHELVES: dict[str, tuple[str, Callable[[], Iterator[_Row]]]] = {}


def _shelf(words: str) -> Callable[[Callable[[], Iterator[_Row]]], None]:
    """Register the function of its entries, named after it, as a topic of the list."""

    def register(entries: Callable[[], Iterator[_Row]]) -> None:
        _SHELVES[entries.__name__.removeprefix("_")] = (words, entries)

    return register


def _why(text: str) -> str:
    """The first sentence of a shipped file: why it exists."""
    comment = " ".join(line[1:].strip() for line in text.splitlines() if line.startswith("# "))
    return re.split(r"(?<=[.?!]) (?=[A-Z])", comment, maxsplit=1)[0].rstrip(".")


@_shelf("shipped fingers, to analyse or to start from")
def _designs() -> Iterator[_Row]:
    for name in shipped_names("design"):
        design = load_design(name)
        yield {
            "name": name,
            "body": design.body.shape,
            "plates": design.plates.number,
            "of": design.plates.material if design.plates.number else "-",
            "why": _why(shipped_text(name)),
        }


@_shelf("objects and paths, for --scene")
def _scenes() -> Iterator[_Row]:
    for name in shipped_names("scene"):
        text = shipped_text(name, "scene")
        scene = parse_scene(text)
        yield {
            "name": name,
            "object": scene.object.shape,
            "friction": scene.object.law.shown,
            "rows": len(scene.path.rows),
            "why": _why(text),
        }


@_shelf("searches and sweeps of many fingers")
def _studies() -> Iterator[_Row]:
    for name in shipped_names("study"):
        text = shipped_text(name, "study")
        try:
            searched = "optimise" in parse_study(text).model_fields_set
            command = "optimise" if searched else "sweep"
        except DesignError:
            command = "bench plane-strain"
        yield {"name": name, "for": command, "why": _why(text)}


@_shelf("elastomers and plate materials with their sources")
def _materials() -> Iterator[_Row]:
    for name, material in MATERIALS.items():
        published = material.published_MPa
        yield {
            "name": name,
            "youngs_modulus_MPa": material.youngs_modulus_MPa,
            "published_MPa": "–" if published is None else "{:g} to {:g}".format(*published),
            "poissons_ratio": material.poissons_ratio,
            "expansion_per_K": EXPANSION[name][0],
            "source": material.source,
        }


@_shelf("numbers that a study compares fingers by")
def _metrics() -> Iterator[_Row]:
    for metric in METRICS.values():
        words = {"max": "higher", "min": "lower"}.get(metric.better or "", "-")
        yield {
            "name": metric.name,
            "unit": metric.unit or "-",
            "better": words,
            "meaning": metric.words,
        }


@_shelf("hands that grip, for --controller")
def _controllers() -> Iterator[_Row]:
    for kind in CONTROLLERS.kinds():
        trained = "an estimator (fingerdesign train)" if kind.trained else "nothing"
        doc = inspect.getdoc(kind.make) or ""
        if doc.startswith("See the module"):
            doc = getattr(inspect.getmodule(kind.make), "__doc__", "") or ""
        yield {
            "name": kind.name,
            "needs": kind.knows or trained,
            "tuned in": ", ".join(each.key.rpartition(".")[2] for each in kind.tuned) or "-",
            "meaning": doc.split("\n\n")[0].replace("\n", " ").replace("``", "`"),
        }


@_shelf("strain gages to order or make, for gages.kind and mold.gage")
def _gages() -> Iterator[_Row]:
    for each in shipped_types():
        yield {
            "name": each.name,
            "kind": each.kind,
            "grid_mm": f"{each.grid_length_mm:g} x {each.grid_width_mm:g}",
            "with_tabs_mm": f"{each.carrier_length_mm:g} x {each.carrier_width_mm:g}",
            "ohm": each.resistance_ohm,
            "factor": each.gage_factor,
            "microstrain_per_uV_V": round(4.0 / each.gage_factor, 3),
            "Et_N_per_mm": each.stiffness,
            "order": each.least_order,
            "weeks": each.lead_weeks,
            "price": each.price or "-",
        } | ({"source": each.source, "date": each.date} if as_json() else {})


@_shelf("fingers verified in 3-D, for new --lift, --gages, --process")
def _atlas() -> Iterator[_Row]:
    for each in atlas().entries:
        yield {
            "name": each.name,
            "from": each.design,
            "g": "–".join(f"{mass:g}" for mass in each.masses_g),
            "gages": f"{each.gages}: {each.gage}",
        } | {
            process: f"{mold.passed}/{mold.checks}" if mold.checks else mold.status
            for process, mold in each.molds.items()
        }


assert tuple(_SHELVES) == SHELVES


def list_(what: tuple[str, ...]) -> None:
    """Show the entries of WHAT; without WHAT its choices, or with JSON every entry."""
    if not what and not as_json():
        rows = [[name, words] for name, (words, _) in _SHELVES.items()]
        print_table("", ["fingerdesign list ...", "shows"], rows, WIDTH)
        return
    found = {name: list(_SHELVES[name][1]()) for name in what or SHELVES}
    if as_json():
        print_json(found)
        return
    for name, entries in found.items():
        units = [key.removesuffix("_MPa").replace("uV_V", "uV/V") for key in entries[0]]
        headings = [key.replace("_per_mm", "/mm").replace("_", " ") for key in units]
        cells = [[_cell(value) for value in entry.values()] for entry in entries]
        print_table(name, headings, cells, WIDTH)
        say_marked("", _LEGENDS.get(name, ""))


def _cell(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
