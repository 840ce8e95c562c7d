"""From solved increments to what a result holds: microstrain, tables, histories."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.contact.path import Step
from fingerdesign.control.signals import gage_readings
from fingerdesign.result_arrays import ContactHistory
from fingerdesign.results import GageResult, IncrementResult, PointStrain

if TYPE_CHECKING:
    from fingerdesign.contact.problem import ContactProblem
    from fingerdesign.reduced import ReducedModel

MICRO = 1e6


def increment_result(step: Step, face: str) -> IncrementResult:
    """One row of ``increments`` in result.json."""
    measures, increment = step.measures, step.increment
    readings = gage_readings(measures.gages, face)
    return IncrementResult(
        approach_mm=increment.motion.approach,
        shear_mm=increment.motion.shear,
        normal_force_N=measures.normal_force,
        tangential_force_N=measures.tangential_force,
        contact_width_mm=measures.contact_width,
        stick_ratio=measures.stick_ratio,
        open_nodes=measures.open_nodes,
        stick_nodes=measures.stick_nodes,
        slip_nodes=measures.slip_nodes,
        peak_pressure_MPa=measures.peak_pressure,
        iterations=increment.iterations,
        residual=increment.residual,
        gages=tuple(
            GageResult(
                plate,
                upper=float(upper),
                lower=float(lower),
                membrane=float(0.5 * (upper + lower)),
                bending=float(0.5 * (upper - lower)),
                reading=float(reading),
            )
            for plate, ((upper, lower), reading) in enumerate(
                zip(measures.gages * MICRO, readings, strict=True)
            )
        ),
        points=tuple(PointStrain(*map(float, strain)) for strain in measures.points * MICRO),
        shear_z_mm=increment.motion.shear_z,
        twist_deg=increment.motion.twist_deg,
        force_z_N=measures.force_z,
        twist_moment_Nmm=measures.twist_moment,
    )


def contact_history(problem: ContactProblem, steps: Sequence[Step]) -> ContactHistory:
    """Nodal status, tractions (MPa) and slip (mm) of all increments."""
    model: ReducedModel = problem.model
    force = np.array([problem.to_global(step.increment.multiplier) for step in steps])
    normal = np.array([step.increment.multiplier[:, 0] for step in steps])
    plane = [0] if model.dimension == 2 else [0, 2]
    return ContactHistory(
        points=model.points,
        areas=model.areas / (model.depth if model.dimension == 2 else 1.0),
        facets=model.facets,
        status=np.array([step.increment.status for step in steps]),
        normal_traction=normal / model.areas,
        tangential_traction=force[:, :, plane] / model.areas[None, :, None],
        slip=np.array([step.increment.state.slip for step in steps]),
        symmetric=model.symmetry_factor == 2,
    )
