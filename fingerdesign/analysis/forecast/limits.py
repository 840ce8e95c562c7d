"""Models that this machine cannot hold: refused before work, with what to make coarser."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.forecast.forecast import Forecast, forecast_case, impossible
from fingerdesign.checks.design import design_faults
from fingerdesign.checks.load import with_values
from fingerdesign.design.scene import Scene
from fingerdesign.errors import DesignError, Fault, GeometryError, MeshError
from fingerdesign.runtime import machine

LEFT_MB = 256.0  # for everything else: of the free memory not to be used
SMALL_MB = 1024.0  # never refused: what is not free now may be in a moment
_ONE_KEY = 30.0  # times the free memory: beyond it no one size, doubled, can suffice
_DOUBLINGS, _FACTORS = 6, (2, 4, 8, 16)  # of all sizes together, of one alone
LAYERS = "mesh.layers"
_SIZES = ("contact_size_mm", "plate_size_mm", "far_size_mm")


def refuse(case: Case, scene: Scene) -> None:
    """Raise DesignError with every fault that design, scene and fidelity have together.

    A design changed by ``model_copy`` was judged by nothing: its geometry is judged here. What is
    sound but too large for this machine's memory is refused too, unless ``case.go_on``.
    """
    faults = impossible(case, scene) or design_faults(case.design)
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
    key = next(iter(sizes))
    once = {each: _changed(case, sizes, [each], 2) for each in sizes}
    saving = {each: less.memory_MB for each, less in once.items() if less is not None}
    if saving and found.memory_MB <= _ONE_KEY * max(free, SMALL_MB):
        key = min(saving, key=lambda each: saving[each])
        for factor in _FACTORS:
            less = _changed(case, sizes, [key], factor)
            if less is None or _fits(less, free):
                break
        if less is not None and _fits(less, free):
            verb, other = "lower" if key == LAYERS else "raise", _coarser(key, sizes[key], factor)
            remedy = f"{verb} it (at {other:g} about {less.memory_MB:.0f} MB)"
            return key, sizes[key], remedy
    return key, sizes[key], _of_several(case, found, sizes, free)


def _of_several(case: Case, found: Forecast, sizes: dict[str, float], free: float) -> str:
    """Remedy where no one key suffices: raise all sizes, and lower the layers if need be."""
    *names, last = lengths = [key for key in sizes if key != LAYERS]
    # Memory falls with about the fourth power of the sizes: fewer doublings need not be tried.
    fewest = max(1, int(np.log2(found.memory_MB / max(free, SMALL_MB)) / 5.0))
    for factor in (2**doublings for doublings in range(fewest, _DOUBLINGS + 1)):
        layers = int(sizes.get(LAYERS, 0)) // factor
        for keys in (lengths, list(sizes)) if layers else (lengths,):
            less = _changed(case, sizes, keys, factor)
            if less is None:
                break
            if _fits(less, free):
                also = f", and lower {LAYERS} to {layers}" if LAYERS in keys else ""
                remedy = f"raise {', '.join(names)} and {last} {factor} times each{also}"
                return f"no one key suffices: {remedy} (about {less.memory_MB:.0f} MB)"
    return "no coarser mesh of it fits: free some memory"


def _fidelities(case: Case, free: float) -> list[str]:
    """Other fidelities that the case can be analysed at in this memory, as options."""
    found = []
    for fidelity in ("plane-strain", "auto") if case.fidelity == "3d" else ():
        other = replace(case, fidelity=fidelity, go_on=True)
        with suppress(DesignError, MeshError, GeometryError):
            sound = not impossible(other, case.path_scene)
            if sound and (fidelity == "auto" or _fits(forecast_case(other), free)):
                found.append(f"--fidelity {fidelity}")
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
    """Values that a coarser mesh changes, by dotted keys: sizes, and layers that there are."""
    flat = found.fidelity == "plane-strain"
    mesh = case.design.mesh.section if flat else case.design.mesh
    names = [*_SIZES, *(["plate_end_size_mm"] if flat else [])]
    sizes = {f"mesh.{'section.' * flat}{name}": float(getattr(mesh, name)) for name in names}
    layers = case.design.mesh.layers or found.layers // (1 if found.half else 2)
    return sizes | ({LAYERS: float(layers)} if found.mesher == "sweep" and layers > 1 else {})


def _coarser(key: str, value: float, factor: int) -> float:
    return int(value) // factor if key == LAYERS else factor * value


def _changed(
    case: Case, sizes: dict[str, float], keys: Iterable[str], factor: int
) -> Forecast | None:
    """The forecast with some keys coarser; None where there is no such design."""
    values = {key: _coarser(key, sizes[key], factor) for key in keys}
    try:
        return forecast_case(replace(case, design=with_values(case.design, values)))
    except (DesignError, MeshError, GeometryError):
        return None
