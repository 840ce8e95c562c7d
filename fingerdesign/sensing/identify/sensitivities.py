"""Sensitivities of a bench's curves to hidden values: central differences on the design's model.

They serve every finger of the design: they are made in worker processes and cached. Plates move in
one mesh (mesh/moved.py), for the difference of two meshes would look like information.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.bench_curves import BenchCurves, Phase
from fingerdesign.control.calibration import Calibration
from fingerdesign.control.signals import NormalCalibration
from fingerdesign.design.digest import content_digest
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.runtime.cache import GARBLED, Cache, packed, unpacked
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.identify.bench import MOST_LEAN_DEG, model_curves
from fingerdesign.sensing.identify.latents import Latent, with_latents
from fingerdesign.sensing.model import MESHED
from fingerdesign.version import __version__

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

_FORMAT = 1
_KINDS = {kind.__name__: kind for kind in (BenchCurves, Calibration, NormalCalibration)}


def sensitivities(
    design: Design,
    plan: Sequence[Phase],
    latents: Sequence[Latent],
    fidelity: str,
    workers: int,
    report: Report,
    lean_deg: float = 0.0,
) -> list[tuple[BenchCurves, BenchCurves, float]]:
    """Curves of each latent below and above the design's value, and the distance of the two.

    Where a side has no sound finger, the design's own curves replace it. lean_deg: the bench's
    lean, from which the lean's own steps are taken.
    """
    cache = Cache("sensitivities", most=40)
    name = f"{_key(design, plan, latents, fidelity, lean_deg)}.npz"
    sides = [(latent, side * latent.step) for latent in latents for side in (-1.0, 1.0)]
    found: list[BenchCurves | None] = []
    if stored := cache.arrays(name):
        try:
            found = list(unpacked(stored[1], stored[0], _KINDS))
        except GARBLED:
            found = []
    if len(found) != 1 + len(sides):
        jobs = [(None, 0.0), *sides]
        with Pool(
            min(workers, len(jobs)), shared=(design, tuple(plan), fidelity, lean_deg)
        ) as pool:
            found = []
            for each in pool.in_order(_curves_at, jobs):
                found.append(each)
                report(f"sensitivities: {len(found)} of {len(jobs)}")
        if found[0] is None:
            raise SolverError("the design's own model has no answer in the moves of its bench")
        arrays: dict[str, Array] = {}
        about = packed(tuple(found), arrays)
        cache.put_arrays(name, arrays, about)
    middle, steps = found[0], [step for _, step in sides]
    assert middle is not None
    pairs = []
    for k in range(len(latents)):
        low, high = found[1 + 2 * k], found[2 + 2 * k]
        apart = steps[2 * k + 1] * (high is not None) - steps[2 * k] * (low is not None)
        pairs.append((low or middle, high or middle, apart or 1.0))
    return pairs


def _curves_at(
    design: Design,
    plan: tuple[Phase, ...],
    fidelity: str,
    lean_deg: float,
    latent: Latent | None,
    off: float,
) -> BenchCurves | None:
    """Curves of one finger near the design; None where it is not sound."""
    try:
        if latent is None:
            return model_curves(design, plan, fidelity, lean_deg, design)
        if latent.kind == "lean":
            return model_curves(design, plan, fidelity, lean_deg + off, design)
        near = with_latents(design, [latent], np.array([off]))
        return model_curves(near, plan, fidelity, lean_deg, design)
    except (DesignError, SolverError):
        return None


def _key(
    design: Design,
    plan: Sequence[Phase],
    latents: Sequence[Latent],
    fidelity: str,
    lean_deg: float,
) -> str:
    moves = [
        (
            p.kind,
            p.friction_coefficient,
            p.tilt_deg,
            p.points.approach.tolist(),
            p.points.shear.tolist(),
        )
        for p in plan
    ]
    tables = [design.body, design.plates, design.gages, design.mesh, *design.materials.values()]
    content = [
        *(_FORMAT, __version__, fidelity, MESHED, MOST_LEAN_DEG, moves),
        [content_digest(each) for each in tables],
        sorted(design.materials),
        [(each.name, each.step) for each in latents],
        *([lean_deg] if lean_deg else []),
    ]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
