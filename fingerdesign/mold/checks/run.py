"""Checks of a built mold on its triangles: each with a measured number, a bound and a sentence."""

from collections.abc import Callable

import numpy as np

from fingerdesign.mold.checks.assembly import Assembly, assemble
from fingerdesign.mold.checks.cavity import cavity_checks
from fingerdesign.mold.checks.demolding import demolding_checks
from fingerdesign.mold.checks.shells import part_checks
from fingerdesign.mold.checks.venting import vent_checks
from fingerdesign.mold.checks.walls import clearance_checks, wall_checks
from fingerdesign.mold.part import Check, MoldMeshes
from fingerdesign.mold.plan.patterns import flat_patterns
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.solids import sound

SEED = 7
# Every check of the assembled parts, in this order, since they draw points from one generator.
CHECKS: tuple[Callable[[Assembly, np.random.Generator], list[Check]], ...] = (
    cavity_checks,
    wall_checks,
    demolding_checks,
    vent_checks,
    clearance_checks,
)


def run_checks(plan: MoldPlan, meshes: MoldMeshes) -> tuple[Check, ...]:
    """Everything that is checked of a mold, its parts, one plate of each kind and its rubber.

    Parts whose triangles are not those of a solid cannot be cut with each other: then only their
    own checks are returned, and one that says so.
    """
    assembly, chord = assemble(plan, meshes), plan.design.mold.chord_mm
    kinds = {f"plate_{pattern.plates[0]}" for pattern in flat_patterns(plan)}
    plates = (plate for plate in meshes.plates if plate.name in kinds)
    found = [
        check
        for part in (*meshes.parts, *plates, meshes.rubber)
        for check in part_checks(part, assembly.solids[part.name], chord)
    ]
    broken = [name for name, solid in assembly.solids.items() if not sound(solid)]
    right = f"all {len(assembly.solids)} meshes are solids that can be cut with each other"
    words = (
        f"no solid, so cavity, walls, draws and vents could not be checked: {', '.join(broken)} "
        "(first of them {0})"
    )
    found.append(Check.none("solids", "", broken, "parts", right, words))
    if broken:
        return tuple(found)
    rng = np.random.default_rng(SEED)
    for check in CHECKS:
        found += check(assembly, rng)
    return tuple(found)
