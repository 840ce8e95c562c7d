"""Condensed against full, and what condensing costs over the factorisation alone."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.bench.check import Check
from fingerdesign.design.io import load_design, parse_design, with_values
from fingerdesign.design.schema import Design
from fingerdesign.fem.factor import Condensation, factorise
from fingerdesign.fem.model import build_model, candidate_facets, fixed_dofs, stiffness_of
from fingerdesign.fem.trace import contact_trace

if TYPE_CHECKING:
    from fingerdesign.mesh.types import Mesh

Array = NDArray[np.float64]

LARGE = """
design.name = "large"
plates.count = 0
[mesh]
mesher = "extrude"
contact_size_mm = 0.17
far_size_mm = 0.85
layers = 14
"""
_ZONE = 2.75  # mm: about 1400 kept dofs on the large mesh


def exactness_checks(design: Design, mesh: Mesh, zone: float, label: str) -> list[Check]:
    """Contact displacements by the compliance against those of a full solution.

    The full solution comes from a factorisation of its own, without the border.
    """
    built = build_model(design, mesh, zone)
    model = built.reduced
    force = np.random.default_rng(0).normal(size=model.points.shape)
    force[model.locked] = 0.0
    system = built.condensed.system
    trace = built.trace.operator @ system.lift
    load = trace.T @ force.reshape(-1, 1)
    full = trace @ Condensation(system.stiffness, system.support[:1], system.pressures).solve(load)
    full = full.reshape(force.shape)
    difference = np.abs(model.displacement(force) - full)[~model.locked]
    asymmetry = np.abs(model.compliance - model.compliance.T).max()
    return [
        Check(
            f"{label}: condensed against full, relative",
            1e-9,
            float(difference.max() / np.abs(full).max()),
        ),
        Check(
            f"{label}: asymmetry of the compliance, relative",
            1e-10,
            float(asymmetry / np.abs(model.compliance).max()),
        ),
    ]


def cost_checks(repeats: int = 3) -> list[Check]:
    """Time of condensing 200k dofs onto about 1400 over that of factoring them, in one run."""
    from fingerdesign.mesh.extrude import extrude

    design = parse_design(LARGE)
    mesh = extrude(design, _ZONE)
    free = ~fixed_dofs(mesh)
    stiffness = stiffness_of(design, mesh)[free][:, free].tocsr()
    stiffness.sort_indices()
    trace = contact_trace(mesh.points, candidate_facets(mesh, _ZONE))
    rows = sp.csr_matrix(trace.operator[:, free])
    rows = rows[np.diff(rows.indptr) > 0]
    alone, whole = [], []
    for _ in range(repeats):
        alone.append(_seconds(lambda: factorise(stiffness)))
        whole.append(_seconds(lambda: Condensation(stiffness, rows)))
    label = f"condensing {int(free.sum())} dofs onto {rows.shape[0]}"
    return [
        Check(
            f"{label}: time over factorisation alone ({min(alone):.1f} s)",
            1.5,
            min(whole) / min(alone),
        )
    ]


def condensation_checks() -> list[Check]:
    """Exactness on the reference finger in the section and extruded, and the cost."""
    from fingerdesign.design.starter import shipped_path
    from fingerdesign.mesh.extrude import extrude
    from fingerdesign.mesh.section import mesh_section

    design = load_design(shipped_path("maeno2000"))
    coarse = with_values(design, {"mesh.mesher": "extrude", "mesh.layers": 6})
    return [
        *exactness_checks(design, mesh_section(design, 3.0), 3.0, "plane strain"),
        *exactness_checks(coarse, extrude(coarse, 3.0), 3.0, "3-D"),
        *cost_checks(),
    ]


def _seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start
