"""Hidden values of drawn fingers, fitted from their benches, beside those that were drawn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.arrays import Array
from fingerdesign.checks.starter import find_design
from fingerdesign.control.bench_curves import bench_curves
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import plate_frames
from fingerdesign.runtime.machine import usable_cores
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.identify.bench import AT_REST, SimulatedBench, simulated_bench
from fingerdesign.sensing.identify.bench_fit import AXES, PRIOR, LatentFit, Noise, fit_latents
from fingerdesign_bench.check import Check

DRAWN = ("plates", "modulus", "gains")
OTHERS = (*DRAWN, "poisson", "plate_modulus", "tilt", "forces", "cross_talk")
FINGERS = 10
_ASKED = {"x": 0.02, "y": 0.01, "angle": 0.3, "modulus": 0.01, "gain": 0.015}
_UNITS = {"x": "mm", "y": "mm", "angle": "degrees"}


def latent_checks(
    fingers: int = FINGERS, name: str = "sensitive", report: Report = lambda message: None
) -> list[Check]:
    """Errors of the fit against what was drawn, and how often its deviations cover them: points of
    100 samples at rest, single samples, and with what the fit knows nothing of."""
    design = find_design(name)
    cases = (
        ("at rest", DRAWN, AT_REST),
        ("single samples", DRAWN, 1),
        ("forces, cross-talk and more besides", OTHERS, AT_REST),
    )
    checks: list[Check] = []
    for label, faults, averaged in cases:
        found: dict[str, list[Array]] = {}
        for seed in range(fingers):
            report(f"{label}: finger {seed + 1} of {fingers}")
            bench = simulated_bench(design, faults, seed, averaged=averaged)
            for kind, rows in _errors(design, bench, _fitted(design, bench)).items():
                found.setdefault(kind, []).append(rows)
        checks += _of_case(label, found)
    return checks


def _fitted(design: Design, bench: SimulatedBench) -> LatentFit:
    x = np.array([plate_frames(design)[plate].x for plate in gage_array(design)])
    hardware = design.rig.hardware
    noise = Noise(hardware.gage_noise_microstrain, hardware.force_noise_N)
    curves = bench_curves(bench.phases, x)
    return fit_latents(design, bench.phases, curves, noise, workers=usable_cores())


def _errors(design: Design, bench: SimulatedBench, fit: LatentFit) -> dict[str, Array]:
    """Of each kind (n, 2): what the fit says less what was drawn, and its deviation."""
    places = [
        np.array([[*each.centre, each.angle_deg] for each in plate_frames(own)])
        for own in (design, bench.design)
    ]
    drawn = dict(zip(AXES, (places[1] - places[0]).T, strict=True))
    rubber = [own.material_of("body").youngs_modulus_MPa for own in (design, bench.design)]
    drawn["modulus"] = np.array([rubber[1] / rubber[0] - 1.0])
    drawn["gain"] = bench.design.grip.hardware.gains(gage_array(design)) - 1.0
    return {
        kind: np.column_stack([fit.of(kind)[0] - true, fit.of(kind)[1]])
        for kind, true in drawn.items()
    }


def _of_case(label: str, found: Mapping[str, Sequence[Array]]) -> Iterator[Check]:
    for kind, rows in found.items():
        error, deviation = np.concatenate(rows).T
        before, unit = f"{PRIOR[kind]:.2g} before", _UNITS.get(kind, "")
        rms = float(np.sqrt(np.mean(error**2)))
        yield Check(f"{label}: {kind}, RMS error ({before})", _ASKED[kind], rms, unit)
        said = float(np.sqrt(np.mean((error / deviation) ** 2)))
        yield Check(f"{label}: {kind}, error over its deviation, RMS", 1.5, said)
        outside = float(np.mean(np.abs(error) > 2.0 * deviation))
        yield Check(f"{label}: {kind}, share beyond two deviations", 0.1, outside)
