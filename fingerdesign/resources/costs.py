"""What a model of a given size takes: operations, memory, seconds by stage.

Laws fitted by least squares in logarithms to whole runs of `analyse` (shipped and random designs,
plane strain and 3-D, 13k to 400k dofs), each in a process of its own. Times are those of a core
that multiplies matrices at ONE_CORE GFLOP/s, and grow as a machine is slower than that; measured
seconds were scaled by what dgemm reached right before and after each run.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fingerdesign.resources.machine import Machine

if TYPE_CHECKING:
    from fingerdesign.case import Case
    from fingerdesign.resources.counts import Counts

ONE_CORE = 60.0  # GFLOP/s of one core: what the seconds below are those of
# Operations of the factorisation with its border, n dofs, and how many times they were that:
#   plane strain   12 models of 13k to 402k dofs   exp(5.66) n^1.30 kept^0.18           0.88 to 1.09
#   extruded       22 models of 12k to 499k dofs   exp(3.40) (n / L)^1.77 L^2.68        0.62 to 1.49
#   tetrahedra     12 models of 18k to 500k dofs   exp(5.09) n^1.754, half of a finger  0.75 to 1.35
#                                                  2.25 times that, a whole one
# L: layers and a half. P1 and P2 meshes, and fingers of 1 to 21 plates, are among them.
_FLAT = (5.66, 1.30, 0.18)
_SWEPT = (3.40, 1.77, 2.68)
_TETRAHEDRA, _WHOLE = (5.09, 1.754), 2.25
# PARDISO's factors, kB: exp(a) n^b operations^c; the process, MB: base + per dof + factors.
_FACTOR_FLAT = (-2.311, 0.719, 0.253)  # 0.98 to 1.02
_FACTOR_SPACE = (-3.467, 0.546, 0.414)  # 0.93 to 1.12
_BASE_MB = 140.0  # libraries, and what the report's figures take
_PER_DOF_FLAT, _FACTORS_FLAT = -1.71e-3, 3.82  # 0.95 to 1.06
_PER_DOF_SPACE, _FACTORS_SPACE = 3.02e-3, 0.975  # 0.94 to 1.05
_OTHER_PROCESSES_MB = 500.0  # that of CAD; fTetWild's stayed below it up to 80k tetrahedra
# Entries of the upper triangle per dof, and seconds for each to be ordered and laid out.
_ENTRIES = {2: 14.6, 3: 47.0}
_ORDERING_S = 0.64e-6
_FACTOR_SHARE = 0.6  # of dgemm's speed


def operations(counts: Counts) -> float:
    """Floating-point operations of condensing."""
    if counts.dimension == 2:
        a, b, c = _FLAT
        return float(math.exp(a) * counts.dofs**b * max(counts.kept, 1.0) ** c)
    if counts.layers:
        a, b, c = _SWEPT
        layers = counts.layers + 0.5
        return float(math.exp(a) * (counts.dofs / layers) ** b * layers**c)
    a, b = _TETRAHEDRA
    return float(math.exp(a) * counts.dofs**b * (1.0 if counts.half else _WHOLE))


def peak_memory_MB(counts: Counts) -> float:
    """The process's greatest resident memory, or that of one it starts."""
    a, b, c = _FACTOR_FLAT if counts.dimension == 2 else _FACTOR_SPACE
    factors = 1e-3 * math.exp(a) * counts.dofs**b * operations(counts) ** c
    if counts.dimension == 2:
        own = _BASE_MB + _PER_DOF_FLAT * counts.dofs + _FACTORS_FLAT * factors
    else:
        own = _BASE_MB + _PER_DOF_SPACE * counts.dofs + _FACTORS_SPACE * factors
    return float(max(own, _OTHER_PROCESSES_MB))


def stage_seconds(counts: Counts, case: Case, machine: Machine) -> dict[str, float]:
    """Seconds by stage, as a result's timings_s names them."""
    entries = _ENTRIES[counts.dimension] * counts.dofs
    slow = ONE_CORE / machine.one_core
    seconds = {
        "geometry": 2.5 * slow,
        "mesh": _mesh_seconds(counts, case) * slow,
        "assemble": (9e-6 if counts.dimension == 2 else 60e-6) * counts.elements * slow,
        "condense": 0.05 * slow
        + _ORDERING_S * entries * slow
        + operations(counts) / (1e9 * _FACTOR_SHARE * machine.all_cores),
        "increments": _increments(counts, case) * slow,
    }
    grips = _grips(counts, case)
    if grips:
        seconds["grips"] = grips * slow
    seconds["report"] = (3.2 + (2.3 if grips else 0.0) + 1e-5 * counts.elements) * slow
    return seconds


def _mesh_seconds(counts: Counts, case: Case) -> float:
    """fTetWild's time goes with the root of what it makes; it scatters by 1.5 (a standard
    deviation), and by as much again where an attempt is made again."""
    if counts.known:
        return 0.3 + 5e-6 * counts.elements
    if counts.mesher == "netgen":
        return 0.1 + 52e-6 * counts.elements
    if counts.mesher == "extrude":
        return 0.15 + 10e-6 * counts.elements
    revolved = 1.35 if case.design.body.shape == "revolved" else 1.0
    return 0.13 * revolved * math.sqrt(counts.elements)


def _row(counts: Counts) -> float:
    """Seconds of one increment of contact: small dense systems of the contact's dofs."""
    contact = counts.dimension * counts.contact_nodes
    return 1e-3 + 4.6e-9 * contact**2


def _increments(counts: Counts, case: Case) -> float:
    """The path, and where no scene is given the slip study of it at further frictions."""
    path = case.path_scene.path
    rows = len(path.rows) * path.substeps
    studied = 6 if case.scene is None and len(case.gage_array) > 1 else 1
    return rows * studied * _row(counts)


def _grips(counts: Counts, case: Case) -> float:
    """Each grip with the rule and without, and the rig's calibration; 60 % of the stage's travel
    is what grips used."""
    if not (case.grips and case.scene is None and case.gage_array):
        return 0.0
    grip = case.design.grip
    travel = (grip.max_approach_mm - grip.preload_mm) / grip.approach_step_mm
    steps = min(float(grip.max_steps), 0.6 * max(travel, 1.0))
    return (2 * len(grip.friction_coefficients) + 1) * steps * _row(counts)
