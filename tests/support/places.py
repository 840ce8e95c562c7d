"""Errors of a finger's hidden values from its bench: true, stated, and the bound by noise alone.

    python -m tests.support.places            # sensitive in 3-D, fingers 1 and 2: minutes
    python -m tests.support.places 3 4 5      # other drawn fingers
    python -m tests.support.places --finer 1  # measured on a finer mesh than the fit's

Plates, moduli, gains and the lean of the bench are drawn. The bound (Cramer-Rao): the deviation
that remains where the model is exact and the sensors' noise alone is left. The pull: how far the
deviations before the fit draw places to the design; the rest of the error is the mesh's. CPU
seconds are those of the fit, of the first finger with the design's fine model.

The finer mesh is finer at the contact, along the plates, at their singular ends and in z.
"""

import sys
import time
from unittest.mock import patch

import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.arrays import Array
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.control.bench_curves import bench_curves
from fingerdesign.layout.rows import plate_frames
from fingerdesign.sensing.identify import bench_fit
from fingerdesign.sensing.identify.bench import BenchMesh, SimulatedBench, simulated_bench
from fingerdesign.sensing.identify.latents import AXES
from fingerdesign.sensing.perturb.finger import places_of

FAULTS = ("modulus", "poisson", "plates", "gains", "tilt")
# The truth's: 0.075 mm at the contact, six layers, an eighth of the usual size at plates' ends.
FINER = BenchMesh(0.1875, 1.5, 0.125)


def fitted(measured: bench_fit.Measured, off: Array) -> tuple[bench_fit.LatentFit, Array, Array]:
    """The fit; of its latents the deviations (k,) by noise alone, and the pull (k,) to the design.

    off (plates, 3): true places less the design's."""
    finish = bench_fit._fitted
    with patch.object(bench_fit, "_fitted", side_effect=finish) as seen:
        fit = bench_fit.fit_latents(measured)
    problem, x, _, alive, _ = seen.call_args.args
    with patch.dict(bench_fit.MESH, {measured.fidelity: (0.0, 0.0, 0.0)}):
        noise = bench_fit._Data(measured, alive)
    ratios = [
        (problem.data.strain_deviation / noise.strain_deviation).ravel(),
        problem.data.scalar_deviation / noise.scalar_deviation,
    ]
    usual = problem.jacobian(x)[: -len(x)]
    jacobian = np.concatenate(ratios)[:, None] * usual
    bound = np.linalg.inv(jacobian.T @ jacobian + np.eye(len(x)))
    true = np.zeros(len(x))
    for k, each in enumerate(problem.latents):
        if each.kind in AXES:
            true[k] = off[each.number, AXES.index(each.kind)] / problem.scale[k]
    pull = -np.linalg.solve(usual.T @ usual + np.eye(len(x)), true)
    return fit, np.sqrt(np.diag(bound)) * problem.scale, pull * problem.scale


def drawn_bench(seed: int, finer: bool) -> SimulatedBench:
    """The simulated measurement of a drawn finger."""
    design = load_design("sensitive")
    if not finer:
        return simulated_bench(design, FAULTS, seed, "3d")
    finer = with_values(design, {"mesh.plate_size_mm": 0.2})
    return simulated_bench(finer, FAULTS, seed, "3d", FINER)


def show(seed: int, bench: SimulatedBench) -> None:
    """Print a line for each axis of the plates' places, and one for the row and the bench."""
    design = load_design("sensitive")
    frames = plate_frames(design)
    x = np.array([frames[plate].x for plate in gage_array(design)])
    curves = bench_curves(bench.phases, x)
    start = time.process_time()
    measured = bench_fit.Measured(design, bench.phases, curves, bench_fit.Noise(0.5, 0.005), "3d")
    off = places_of(plate_frames(bench.design)) - places_of(frames)
    fit, bound, pull = fitted(measured, off)
    spent = time.process_time() - start
    print(f"finger {seed}: {spent:.0f} s, misfit {fit.misfit:.2f}, lean off by ", end="")
    print(f"{float(fit.of('lean')[0][0]) - bench.lean_deg:+.3f} degrees")
    for axis, true in zip(AXES, off.T, strict=True):
        values, deviations = fit.of(axis)
        own = [each.kind == axis for each in fit.latents]
        errors = values - true
        each_size = (errors, deviations, bound[own], pull[own])
        sizes = [float(np.sqrt(np.mean(each**2))) for each in each_size]
        shown = "error {:.4f}, stated {:.4f}, bound by noise {:.4f}, pull {:.4f}".format(*sizes)
        print(f"  {axis:5} {shown}; among the others {errors.std():.4f}", flush=True)


def main() -> None:
    """Show the fingers of the seeds given."""
    words = sys.argv[1:]
    seeds = [int(word) for word in words if word != "--finer"] or [1, 2]
    for seed in seeds:
        show(seed, drawn_bench(seed, "--finer" in words))


if __name__ == "__main__":
    main()
