"""Checks of a built mold on its triangles: each with a measured number, a bound and a sentence."""

from __future__ import annotations

import numpy as np

from fingerdesign.design.schema import Design
from fingerdesign.mold.checks.assembly import assemble, sound
from fingerdesign.mold.checks.demolding import demolding_checks
from fingerdesign.mold.checks.fill import backing_check, fill_checks
from fingerdesign.mold.checks.fits import fit_checks, hole_checks, part_checks, plan_checks
from fingerdesign.mold.checks.venting import vent_checks
from fingerdesign.mold.checks.walls import wall_checks
from fingerdesign.mold.part import Check, MoldMeshes
from fingerdesign.mold.plan.plan import MoldPlan

__all__ = ["run_checks"]

SEED = 7


def run_checks(design: Design, plan: MoldPlan, meshes: MoldMeshes) -> tuple[Check, ...]:
    """Everything that is checked of a mold, its parts, its plates and its rubber.

    Parts whose triangles are not those of a solid cannot be cut with each other: then only their
    own checks are returned, and one that says so.
    """
    chord = design.mold.chord_mm
    parts = (*meshes.parts, *meshes.plates, meshes.rubber)
    found = [check for part in parts for check in part_checks(part, chord)]
    assembly = assemble(design, plan, meshes)
    broken = [name for name, solid in assembly.solids.items() if not sound(solid)]
    broken += [f"blank of {name}" for name, solid in assembly.blanks.items() if not sound(solid)]
    right = f"all {len(assembly.solids)} meshes are solids that can be cut with each other"
    words = (
        f"no solid, so fill, walls, draws and vents could not be checked: {', '.join(broken)} "
        "(first of them {0})"
    )
    found.append(Check.none("solids", "", broken, "parts", right, words))
    found += plan_checks(design, plan)
    if broken:
        return tuple(found)
    rng = np.random.default_rng(SEED)
    found += fill_checks(assembly)
    found.append(backing_check(assembly, rng))
    found += wall_checks(assembly, rng)
    found += fit_checks(assembly)
    found += demolding_checks(assembly, rng)
    found += vent_checks(assembly)
    found += hole_checks(assembly)
    return tuple(found)
