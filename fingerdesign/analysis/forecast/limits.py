"""What this machine cannot hold: refused before the work starts, with what to make coarser."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.analysis.forecast.forecast import Forecast, forecast_case, impossible
from fingerdesign.checks.load import with_values
from fingerdesign.errors import DesignError, Fault, GeometryError, MeshError
from fingerdesign.runtime import machine

if TYPE_CHECKING:
    from fingerdesign.analysis.case import Case
    from fingerdesign.design.scene import Scene

LEFT_MB = 256.0  # for everything else: of the free memory not to be used
SMALL_MB = 1024.0  # never refused: what is not free now may be in a moment
_ONE_KEY = 30.0  # times the free memory: beyond it no one size, doubled, can suffice
_DOUBLINGS, _ALONE = 6, 4  # of all sizes together and of one alone, at the most
_SIZES = ("contact_size_mm", "plate_size_mm", "far_size_mm")


def refuse(case: Case, scene: Scene) -> None:
    """Raise DesignError with every fault that design, scene and fidelity have together.

    What is sound but too large for this machine's memory is refused too, unless ``case.go_on``.
    """
    faults = impossible(case, scene)
    if not faults and case.fidelity != "auto" and not case.go_on:
        faults = memory_faults(case)
    if faults:
        raise DesignError(faults)


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
    ways = [*_fidelities(case, free), "--go-on to try all the same"]
    if found.mesher == "file":
        return [Fault("mesh.file", case.design.mesh.file, bound, f"take {' or '.join(ways)}")]
    key, value, remedy = _remedy(case, found, free)
    return [Fault(key, f"{value:g}", bound, f"{remedy}, or take {' or '.join(ways)}")]


def _remedy(case: Case, found: Forecast, free: float) -> tuple[str, float, str]:
    """A key of the mesh, its value and what to do: change it where that suffices, or several."""
    sizes = _sizes(case, found)
    key, value = next(iter(sizes.items()))
    best = _coarsened(case, found, sizes)
    if best is not None and found.memory_MB <= _ONE_KEY * max(free, SMALL_MB):
        key, value, other, less = best
        enough = (other, less) if _fits(less, free) else _further(case, key, value, other, free)
        if enough is not None:
            verb = "raise" if other > value else "lower"
            return key, value, f"{verb} it (at {enough[0]:g} about {enough[1].memory_MB:.0f} MB)"
    several = _all_coarsened(case, sizes, found, free)
    if several is None:
        return key, value, "no coarser mesh of it fits: free some memory"
    factor, layers, less = several
    *names, last = sizes
    also = f", and lower mesh.layers to {layers}" if layers else ""
    remedy = f"raise {', '.join(names)} and {last} {factor} times each{also}"
    return key, value, f"no one key suffices: {remedy} (about {less.memory_MB:.0f} MB)"


def _fidelities(case: Case, free: float) -> list[str]:
    """Other fidelities that the case can be analysed at in this memory, as options."""
    found = []
    for fidelity in ("plane-strain", "auto") if case.fidelity == "3d" else ():
        other = replace(case, fidelity=fidelity, go_on=True)
        try:
            if impossible(other, case.path_scene):
                continue
            fits = fidelity == "auto" or _fits(forecast_case(other), free)
        except (DesignError, MeshError, GeometryError):
            continue
        found += [f"--fidelity {fidelity}"] if fits else []
    return found


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


def _sizes(case: Case, found: Forecast) -> dict[str, float]:
    """The sizes of the mesh by their dotted keys."""
    flat = found.fidelity == "plane-strain"
    mesh = case.design.mesh.section if flat else case.design.mesh
    names = [*_SIZES, *(["plate_end_size_mm"] if flat else [])]
    return {f"mesh.{'section.' * flat}{name}": float(getattr(mesh, name)) for name in names}


def _changed(case: Case, values: dict[str, float]) -> Forecast | None:
    """The forecast with other keys of the mesh; None where there is no such design."""
    try:
        return forecast_case(replace(case, design=with_values(case.design, values)))
    except (DesignError, MeshError, GeometryError):
        return None


def _coarsened(
    case: Case, found: Forecast, sizes: dict[str, float]
) -> tuple[str, float, float, Forecast] | None:
    """The key of the mesh that saves most when it is changed by a factor of two: the key, its
    value, the other value, and the forecast with that."""
    others = {key: 2.0 * value for key, value in sizes.items()}
    layers = case.design.mesh.layers
    if found.mesher == "extrude" and layers > 1:
        sizes, others = sizes | {"mesh.layers": layers}, others | {"mesh.layers": layers // 2}
    tried = [
        (key, sizes[key], other, less)
        for key, other in others.items()
        if (less := _changed(case, {key: other})) is not None
    ]
    return min(tried, key=lambda each: each[3].memory_MB, default=None)


def _further(
    case: Case, key: str, value: float, other: float, free: float
) -> tuple[float, Forecast] | None:
    """A key's value that fits, changed by more than a factor of two, and the forecast; or None."""
    for doublings in range(1, _ALONE):
        new: float = other * 2**doublings if other > value else int(other) // 2**doublings
        less = _changed(case, {key: new})
        if less is None or _fits(less, free):
            return None if less is None else (new, less)
    return None


def _all_coarsened(
    case: Case, sizes: dict[str, float], found: Forecast, free: float
) -> tuple[int, int, Forecast] | None:
    """By how many times all sizes must be raised to fit, to how many layers (0: as they are), and
    the forecast with that; None: no such mesh fits."""
    # Memory falls with about the fourth power of the sizes: fewer doublings need not be tried.
    fewest = max(1, int(np.log2(found.memory_MB / max(free, SMALL_MB)) / 5.0))
    for doublings in range(fewest, _DOUBLINGS + 1):
        factor = 2**doublings
        values = {key: factor * value for key, value in sizes.items()}
        fewer = case.design.mesh.layers // factor if found.mesher == "extrude" else 0
        for layers in (0, fewer) if fewer else (0,):
            less = _changed(case, values | ({"mesh.layers": layers} if layers else {}))
            if less is None or _fits(less, free):
                return None if less is None else (factor, layers, less)
    return None
