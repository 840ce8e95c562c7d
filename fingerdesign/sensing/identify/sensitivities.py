"""Sensitivities of a bench's curves to hidden values: central differences on the design's model.

They serve every finger of the design: they are made in worker processes and cached. Plates move in
one mesh (mesh/moved.py), for the difference of two meshes would look like information.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.bench_curves import BenchCurves
from fingerdesign.control.calibration import Calibration
from fingerdesign.control.signals import NormalCalibration
from fingerdesign.design.digest import content_digest
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.runtime.cache import GARBLED, Cache, packed, unpacked
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.identify.bench import MOST_LEAN_DEG, BenchModel
from fingerdesign.sensing.identify.latents import Latent, with_latents
from fingerdesign.sensing.model import MESHED
from fingerdesign.version import __version__

_FORMAT = 1
_KINDS = {kind.__name__: kind for kind in (BenchCurves, Calibration, NormalCalibration)}


@dataclass(frozen=True)
class Difference:
    """Curves of a latent below and above the design's value, and the distance of the two values.

    Where a side has no sound finger, the design's own curves replace it.
    """

    low: BenchCurves
    high: BenchCurves
    apart: float


def sensitivities(
    model: BenchModel, latents: Sequence[Latent], lean_deg: float, workers: int, report: Report
) -> list[Difference]:
    """Differences of curves by each latent; lean_deg: the bench's lean, from which the lean's own
    steps are taken. Raises SolverError where the design's own model has no answer."""
    jobs: list[tuple[Latent | None, float]] = [(None, 0.0)]
    jobs += [(latent, side * latent.step) for latent in latents for side in (-1.0, 1.0)]
    cache = Cache("sensitivities", most=40)
    name = f"{sensitivities_key(model, latents, lean_deg)}.npz"
    found = _cached(cache, name)
    if len(found) != len(jobs):
        found = []
        with Pool(min(workers, len(jobs)), shared=(model, lean_deg)) as pool:
            for curves in pool.in_order(_curves_at, jobs):
                found.append(curves)
                report(f"sensitivities: {len(found)} of {len(jobs)}")
        if found[0] is None:
            raise SolverError("the design's own model has no answer in the moves of its bench")
        arrays: dict[str, Array] = {}
        about = packed(tuple(found), arrays)
        cache.put_arrays(name, arrays, about)
    middle = found[0]
    assert middle is not None
    differences = []
    for latent, low, high in zip(latents, found[1::2], found[2::2], strict=True):
        sides = (low is not None) + (high is not None)
        differences.append(Difference(low or middle, high or middle, sides * latent.step or 1.0))
    return differences


def _cached(cache: Cache, name: str) -> list[BenchCurves | None]:
    """The cached curves; none where there are none, or they cannot be read."""
    stored = cache.arrays(name)
    try:
        return [] if stored is None else list(unpacked(stored[1], stored[0], _KINDS))
    except GARBLED:
        return []


def _curves_at(
    model: BenchModel, lean_deg: float, latent: Latent | None, off: float
) -> BenchCurves | None:
    """Curves of one finger near the design; None where it is not sound."""
    try:
        if latent is None:
            return model.curves(lean_deg=lean_deg)
        if latent.kind == "lean":
            return model.curves(lean_deg=lean_deg + off)
        return model.curves(with_latents(model.design, [latent], np.array([off])), lean_deg)
    except (DesignError, SolverError):
        return None


def sensitivities_key(model: BenchModel, latents: Sequence[Latent], lean_deg: float) -> str:
    """SHA-256 of all that the curves of :func:`sensitivities` depend on."""
    design, fidelity = model.design, model.fidelity
    moves = [
        (
            p.kind,
            p.friction_coefficient,
            p.tilt_deg,
            p.points.approach.tolist(),
            p.points.shear.tolist(),
        )
        for p in model.phases
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
