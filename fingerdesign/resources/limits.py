"""What this machine cannot hold: refused before the work starts, with what to make coarser."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from fingerdesign.errors import Fault, GeometryError, MeshError
from fingerdesign.resources import machine
from fingerdesign.resources.forecast import Forecast, forecast_case

if TYPE_CHECKING:
    from fingerdesign.case import Case
    from fingerdesign.design.schema import Design

LEFT_MB = 256.0  # for everything else: of the free memory not to be used
SMALL_MB = 1024.0  # never refused: what is not free now may be in a moment
_HELPS = 0.95  # a doubled size that saves less is no remedy
_SIZES = ("contact_size_mm", "plate_size_mm", "far_size_mm")


def memory_faults(case: Case) -> list[Fault]:
    """The fault of a case whose forecast memory is more than the machine has free, or none.

    A mesh read from a file is what it is: its key is the fault's. Nothing is refused where the
    system does not tell what is free, nor what takes less than SMALL_MB.
    """
    free = machine.available_memory_MB()
    if free is None:
        return []
    try:
        found = forecast_case(case)
    except (MeshError, GeometryError):
        return []  # a mesh file or a body that is wrong: the work says so, and how
    if _fits(found, free):
        return []
    bound = (
        f"coarser for this machine: about {found.dofs} equations would take {found.memory_MB:.0f} "
        f"MB, and {free:.0f} MB are free"
    )
    ways = ["--go-on to try all the same"]
    if found.fidelity == "3d" and case.design.body.shape != "step":
        ways.insert(0, "--fidelity plane-strain")
    if found.mesher == "file":
        return [Fault("mesh.file", case.design.mesh.file, bound, f"take {' or '.join(ways)}")]
    key, value, other, less = _coarsened(case, found)
    verb = "raise" if other > value else "lower"
    remedy = f"{verb} it (at {other:g} about {less.memory_MB:.0f} MB), or take "
    if less.memory_MB > _HELPS * found.memory_MB:
        remedy = "free some memory, or take "
    return [Fault(key, f"{value:g}", bound, remedy + " or ".join(ways))]


def _fits(found: Forecast, free: float) -> bool:
    return found.memory_MB <= max(free - LEFT_MB, SMALL_MB)


def too_large(found: Forecast) -> str:
    """A note on a forecast that this machine has not the memory for; empty where it has."""
    free = machine.available_memory_MB()
    if free is None or _fits(found, free):
        return ""
    return (
        f"--fidelity {found.fidelity} would take about {found.memory_MB:.0f} MB, and {free:.0f} MB "
        "are free: it is refused without --go-on"
    )


def _coarsened(case: Case, found: Forecast) -> tuple[str, float, float, Forecast]:
    """The key of the mesh that saves most when it is changed by a factor of two: the key, its
    value, the other value, and the forecast with that."""
    flat = found.fidelity == "plane-strain"
    mesh = case.design.mesh
    names = [*_SIZES, *(["plate_end_size_mm"] if flat else [])]
    names += ["layers"] if found.mesher == "extrude" and mesh.layers > 1 else []
    tried = []
    for name in names:
        value = getattr(mesh.section if flat else mesh, name)
        other = value // 2 if name == "layers" else 2.0 * value
        coarser = replace(case, design=_changed(case.design, name, other, flat))
        key = f"mesh.section.{name}" if flat else f"mesh.{name}"
        tried.append((key, float(value), float(other), forecast_case(coarser)))
    return min(tried, key=lambda each: each[3].memory_MB)


def _changed(design: Design, name: str, value: float, flat: bool) -> Design:
    """The design with another size of its mesh."""
    mesh = design.mesh
    changed = (mesh.section if flat else mesh).model_copy(update={name: value})
    whole = mesh.model_copy(update={"section": changed}) if flat else changed
    return design.model_copy(update={"mesh": whole})
