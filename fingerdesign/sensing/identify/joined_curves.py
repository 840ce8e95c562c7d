"""A finger's curves from its bench and its fitted model together: as good as the better of both.

Measured curves are noisy where points are single samples, and end where the bench did. The fitted
model's (bench_fit.py) are smooth, go on to the end of the stage, and are wrong by what meshes
differ by, or by what the fit leaves. With m measured and f fitted, of deviations s and e,

    curve(F) = f(F) + w (m - f)(F),     w = e^2 / (e^2 + s^2),

and past either end of what was measured its last difference goes on.
"""

from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.signals import Calibration, NormalCalibration
from fingerdesign.sensing.identify.bench import BenchModel, protocol
from fingerdesign.sensing.identify.bench_fit import MESH, LatentFit, Measured, small_pulls

_SPARSE = 0.02  # A fitted point is added if no measured one is nearer, over the largest force.


def joined_calibration(bench: Measured, fit: LatentFit) -> Calibration:
    """The measured curves, mended by the fitted finger's; gains and dead gages are the finger's.

    Raises SolverError where the fitted model has no answer in the bench's moves.
    """
    design, measured = bench.design, bench.curves.calibration
    tilts = [each.tilt_deg for each in bench.phases if each.kind == "tilt"]
    lean, touch = (float(fit.of(kind)[0].sum()) for kind in ("lean", "touch"))
    whole = BenchModel(design, protocol(design, tilts), bench.fidelity)  # The fit has condensed it.
    model = whole.curves(fit.design, lean).calibration
    alive = ~np.isin(np.arange(1, len(fit.gages_after) + 1), fit.dead)
    gains = np.where(alive, 1.0 + fit.of("gain")[0], 0.0)
    noise = bench.mean_noise
    mesh = max(1.0, fit.misfit) ** 0.5 * np.array(MESH[bench.fidelity])
    pulls, shears = small_pulls(bench.phases, len(measured.stiffness))

    played = fit.curves.calibration  # The same finger in the bench's own moves.
    own, other = measured.normal, _merged(played.normal, model.normal, gains)
    forces = _reaching(own.normal_force, other.normal_force)
    weight = _weight(mesh[0], np.full(len(own.normal_force), noise.gage))
    pressed = _joined(forces, own, other, weight)
    approach = _column(model.normal.normal_force, model.approach - touch)
    closed = _joined(forces, _column(own.normal_force, measured.approach), approach)
    closed = np.maximum.accumulate(closed, axis=0)

    own, other = measured.sticking, _merged(played.sticking, model.sticking, gains)
    sheared = _reaching(own.normal_force, other.normal_force)
    weight = _weight(mesh[1], 2.0**0.5 * noise.gage / pulls)
    sticking = _joined(sheared, own, other, weight)
    weight = _weight(mesh[2] * measured.stiffness, 2.0**0.5 * noise.force / shears)
    one, two = (_column(each.sticking.normal_force, each.stiffness) for each in (played, model))
    own = _column(own.normal_force, measured.stiffness)
    stiffness = _joined(sheared, own, _merged(one, two), weight)[:, 0]
    return replace(
        measured,
        normal=NormalCalibration(forces, pressed),
        approach=closed[:, 0],
        sticking=NormalCalibration(sheared, sticking),
        stiffness=stiffness,
        full_stick=np.abs(sticking[0]),
        tangential_stiffness=float(stiffness[0]),
    )


def _merged(
    first: NormalCalibration, second: NormalCalibration, gains: Array | float = 1.0
) -> NormalCalibration:
    """Two curves of one finger as one, the second's points where the first has none near."""
    forces = _reaching(first.normal_force, second.normal_force)
    own = np.isin(forces, first.normal_force)
    rows = [(first if mine else second).at(float(f)) for f, mine in zip(forces, own, strict=True)]
    return NormalCalibration(forces, gains * np.array(rows))


def _reaching(own: Array, other: Array) -> Array:
    """``own`` forces, and ``other`` ones beyond them and where they are sparse."""
    away = np.abs(other[:, None] - own).min(axis=1)
    return np.asarray(np.sort(np.concatenate([own, other[away > _SPARSE * other[-1]]])))


def _column(force: Array, values: Array) -> NormalCalibration:
    return NormalCalibration(force, values[:, None])


def _weight(model: float | Array, noise: Array) -> Array:
    """The weight of the measured points (k,), by the deviations of both."""
    return np.asarray(model**2 / (model**2 + noise**2))


def _joined(
    forces: Array, own: NormalCalibration, other: NormalCalibration, weight: Array | float = 1.0
) -> Array:
    """Both curves (n, columns) at ``forces``; weight (k,) of own's points."""
    difference = own.readings - np.array([other.at(float(force)) for force in own.normal_force])
    difference = np.broadcast_to(weight, (len(difference),))[:, None] * difference
    columns = [np.interp(forces, own.normal_force, each) for each in difference.T]
    fitted = np.array([other.at(float(force)) for force in forces])
    return np.asarray(fitted + np.column_stack(columns))
