"""Condensed against full, and what condensing costs over factoring and over the machine's limit."""

import time
import timeit

import numpy as np

from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.design.schema import Design
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.model import build_model
from fingerdesign.fem.system import assemble_system
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.types import Mesh
from fingerdesign_bench.check import Check

LARGE = """
design.name = "large"
plates.count = 0
[mesh]
mesher = "sweep"
contact_size_mm = 0.17
far_size_mm = 0.85
layers = 14
"""
_ZONE = 2.75  # mm: about 1400 retained dofs on the large mesh


def exactness_checks(design: Design, mesh: Mesh, zone: float, label: str) -> list[Check]:
    """Contact displacements by the compliance against those of a full solution.

    The full solution comes from a factorisation of its own, without the border.
    """
    built = build_model(design, mesh, zone)
    model = built.reduced
    force = np.random.default_rng(0).normal(size=model.points.shape)
    force[model.locked] = 0.0
    system = assemble_system(built.condensed.body)
    trace = built.condensed.trace.operator @ system.lift
    load = trace.T @ force.reshape(-1, 1)
    full = trace @ Condensation(system.stiffness, system.support[:1], system.pressures).solve(load)
    full = full.reshape(force.shape)
    difference = np.abs(model.displacement(force) - full)[~model.locked]
    asymmetry = np.abs(model.compliance - model.compliance.T).max()
    exact, symmetric = f"{label}: condensed against full", f"{label}: asymmetry of the compliance"
    return [
        Check(f"{exact}, relative", 1e-9, float(difference.max() / np.abs(full).max())),
        Check(f"{symmetric}, relative", 1e-10, float(asymmetry / np.abs(model.compliance).max())),
    ]


def cost_checks() -> list[Check]:
    """Times at 200k dofs over those of the factorisation, and over what the machine allows.

    The machine's limit is the operations of the factorisation that condenses, border and all (as
    PARDISO counts them), over the rate of a large product of dense matrices in the same run, on all
    cores. Each time is the least of three, the rate the greatest, taken in turn so that other work
    disturbs all alike. Meshing is not included; the element is the one that the material asks for.
    """
    design = parse_design(LARGE)
    mesh = extrude(design, Zone(_ZONE))
    alone, condense, whole, rates = [], [], [], []
    operations = plain = float("nan")
    for _ in range(3):
        rates.append(dense_rate())
        start = time.perf_counter()
        built = build_model(design, mesh, _ZONE)
        whole.append(time.perf_counter() - start)
        condense.append(built.timings["condense"])
        system = assemble_system(built.condensed.body)
        operations = built.condensed.factors()[1].operations
        label = f"{built.dofs} dofs ({built.element}) onto {built.reduced.points.size}"
        del built
        start = time.perf_counter()
        plain = Condensation(system.stiffness, system.support[:1], system.pressures).operations
        alone.append(time.perf_counter() - start)
    limit = operations / max(rates)
    bound = f"{1e-9 * operations:.0f} GFLOP at {1e-9 * max(rates):.0f} GFLOP/s; without the border "
    bound += f"{1e-9 * plain:.0f}"
    return [
        Check(
            f"condensing {label}: time over factorisation alone ({min(alone):.1f} s)",
            1.2,
            min(condense) / min(alone),
        ),
        Check(f"the same over the machine's limit ({bound})", 2.5, min(condense) / limit),
        Check("assembly and condensation over that limit", 3.5, min(whole) / limit),
        Check("assembly and condensation", 20.0, min(whole), "s"),
    ]


def dense_rate(size: int = 4000) -> float:
    """Floating-point operations per second of a product of two dense matrices, best of three."""
    left = np.random.default_rng(0).normal(size=(size, size))
    return 2.0 * size**3 / min(timeit.repeat(lambda: left @ left, number=1, repeat=3))


def condensation_checks() -> list[Check]:
    """Exactness on the reference finger in the section and extruded, and the cost."""
    design = load_design("maeno2000")
    coarse = with_values(design, {"mesh.mesher": "sweep", "mesh.layers": 6})
    return [
        *exactness_checks(design, mesh_section(design, 3.0), 3.0, "plane strain"),
        *exactness_checks(coarse, extrude(coarse, Zone(3.0)), 3.0, "3-D"),
        *cost_checks(),
    ]
