"""Speeds against their targets, each measured in a process of its own, cold and warm.

Cold: the first run of a new process, its imports done and the mesher's process up, no cache. Warm:
the least of the runs after it. Whole runs go from the design to the last increment; models to the
condensed compliance (mesh, assembly, condensation).
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.errors import SolverError
from fingerdesign.runtime.isolate import ProcessError, call
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Check, Shown, Table
from fingerdesign_bench.machine import machine
from fingerdesign_bench.speed.condensation import condensation_checks
from fingerdesign_bench.speed.coupling import FULL, QUICK, Coupled, coupled
from fingerdesign_bench.speed.growth import Size, draw_growth, fit
from fingerdesign_bench.speed.speed_worker import GRIP_SPACE, timed_grip, timed_path

PLANE, SPACE = "plane strain", "3-D"
# Contact and far sizes, mm: the third has 33k dofs.
_PLANE_SIZES = ((0.2, 1.1), (0.1, 0.56), (0.05, 0.30), (0.025, 0.14))
# The same and layers: the fourth has 100k dofs and about 500 contact nodes, the fifth 200k.
_SPACE_SIZES = ((0.48, 2.4, 5), (0.36, 1.8, 7), (0.27, 1.35, 9), (0.2, 1.8, 12), (0.174, 0.87, 14))
_FLAT = "{kind}, {dofs} dofs, nu = 0.49"
_DEEP = "{kind}, {dofs} dofs, {contact_nodes} contact nodes"
_LARGE = "{kind}, {dofs} dofs"
_PEAK = ("memory_MB", "base_MB")
Case = dict[str, Any]
# Series, its mesh, name, target, unit, factor to the unit, quantities of a Size that are added.
Target = tuple[str, int, str, float, str, float, tuple[str, ...]]
TARGETS: tuple[Target, ...] = (
    (PLANE, 2, f"{_FLAT}: mesh to last of 16 increments, warm", 1.0, "s", 1.0, ("total_s",)),
    (PLANE, 2, f"{_FLAT}: the same, cold", 1.0, "s", 1.0, ("cold_s",)),
    (PLANE, 2, f"{_FLAT}: mean increment, warm", 2.0, "ms", 1e3, ("increment_s",)),
    (SPACE, 3, f"{_DEEP}: model, warm", 8.0, "s", 1.0, ("model_s",)),
    (SPACE, 3, f"{_DEEP}: mean increment, warm", 30.0, "ms", 1e3, ("increment_s",)),
    (SPACE, 4, f"{_LARGE}: model, warm", 20.0, "s", 1.0, ("model_s",)),
    (SPACE, 4, f"{_LARGE}: peak memory of the process", 5120.0, "MB", 1.0, _PEAK),
)
# On the same work, measured once on two quiet cores (not by this program).
OTHER_CODES = (
    "Other codes on such work, measured once on two quiet cores: plane strain, 33k dofs, "
    "nu = 0.49, 16 increments: GetFEM 5.4 13.5 s; Siconos 3.0 s, 20 ms an increment; CalculiX "
    "2.20 unfinished after 360 s at 25k dofs. 3-D: Siconos at 102k dofs 86 CPU s and 0.3 CPU s an "
    "increment; GetFEM at 40k dofs 16 CPU s an increment."
)
_TIME_LIMIT_S = 1800.0  # for one case
# Kind, fidelity, runs, and the design's keys of a grip.
_GRIPS: tuple[tuple[str, str, int, dict[str, Any]], ...] = (
    (PLANE, "plane-strain", 3, {}),
    (SPACE, "3d", 2, GRIP_SPACE),
)


def measure_speed(folder: Path, report: Report, quick: bool = False) -> Shown:
    """Measure all cases, and draw their growth.

    quick: the series up to the target size in plane strain and up to 50k dofs in 3-D, and the grip
    and the pads inside MuJoCo in plane strain. The pads are left out where there is no MuJoCo.
    Raises SolverError where a case's process fails.
    """
    begun = machine()
    sizes: list[Size] = []
    for contact, far in _PLANE_SIZES[: 3 if quick else None]:
        report(f"{PLANE}, facets of {contact:g} mm")
        sizes.append(_size(PLANE, contact, far, 1, 3 if quick else 5))
    for contact, far, layers in _SPACE_SIZES[: 2 if quick else None]:
        report(f"{SPACE}, facets of {contact:g} mm")
        sizes.append(_size(SPACE, contact, far, layers, 2))
    grips = dict[str, Case]()
    for kind, fidelity, runs, values in _GRIPS[: 1 if quick else None]:
        report(f"a grip, {kind}")
        grips[kind] = run_case(timed_grip, {"fidelity": fidelity, "runs": runs, "values": values})
    checks, tables = target_checks(sizes, grips), list[Table]()
    if find_spec("mujoco") is not None:
        report("two pads inside MuJoCo")
        found = Coupled(**run_case(coupled, QUICK if quick else FULL))
        checks, tables = checks + found.checks(), [found.table()]
    if not quick:
        report("condensing against its limits")
        checks += condensation_checks()
    laws = [law for kind in (PLANE, SPACE) for law in fit(kind, sizes)]
    return Shown(
        "Speed",
        checks,
        begun,
        {
            "quick": quick,
            "growth": [asdict(law) for law in laws],
            "grips": grips,
            "other_codes": OTHER_CODES,
        },
        tables=tables,
        rows=[asdict(each) for each in sizes],
        paths=[draw_growth(sizes, laws, begun, folder / "speed.png", [OTHER_CODES])],
        after=[
            f"{law.kind}: {law.quantity} grows with {law.against}: power {law.exponent:.2f}"
            for law in laws
        ],
    )


def run_case(work: Callable[[Case], Case], case: Case) -> Case:
    """``work(case)`` in a process of its own. Raises SolverError."""
    try:
        found: Case = call(work, case, time_s=_TIME_LIMIT_S)
    except ProcessError as error:
        raise SolverError(f"the case {case}: {error}") from error
    return found


def _size(kind: str, contact: float, far: float, layers: int, runs: int) -> Size:
    fidelity = "plane-strain" if kind == PLANE else "3d"
    case = {"fidelity": fidelity, "contact": contact, "far": far, "layers": layers, "runs": runs}
    found = run_case(timed_path, case)
    cold, *more = found["runs"]
    warm = more or [cold]
    best = min(warm, key=lambda run: float(run["model_s"]))
    parts = ("dofs", "contact_nodes", "mesh_s", "assemble_s", "condense_s", "model_s")
    increments = min((run["increments_s"] for run in warm), key=sum)
    return Size(
        kind=kind,
        **{name: best[name] for name in parts},
        increment_s=float(np.mean(increments)),
        worst_increment_s=max(increments),
        total_s=min(run["total_s"] for run in warm),
        cold_s=cold["total_s"],
        memory_MB=found["memory_MB"] - found["base_MB"],
        base_MB=found["base_MB"],
    )


def target_checks(sizes: Sequence[Size], grips: dict[str, dict[str, Any]]) -> list[Check]:
    """Compare the series and the grips with their targets, where these have been measured."""
    checks = []
    for kind, place, name, target, unit, factor, quantities in TARGETS:
        series = [each for each in sizes if each.kind == kind]
        if len(series) > place:
            case = asdict(series[place])
            measured = factor * sum(case[quantity] for quantity in quantities)
            checks.append(Check(name.format(**case), target, measured, unit))
    for kind, target in ((PLANE, 0.4), (SPACE, 6.0)):
        if kind in grips:
            best = min(run["per_200"] for run in grips[kind]["runs"])
            label = f"{kind}, maeno2000, {grips[kind]['contact_nodes']} contact nodes"
            name = f"{label}: 200 steps of a grip (model apart), warm"
            checks.append(Check(name, target, best, "s"))
    return checks
