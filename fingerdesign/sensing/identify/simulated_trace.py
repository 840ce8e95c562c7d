"""A trace as a rig would record it of a perturbed finger: a press, a shear
until all slips, a hold, by another modulus, rubber that relaxes, drifting and warming gages.

Its plates lie where the design has them: only what ``identify`` fits differs.
"""

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.checks.load import with_values
from fingerdesign.control.trace import Trace
from fingerdesign.design.schema import Design
from fingerdesign.records.folder import RecordFolder
from fingerdesign.runtime.streams import stream
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.identify.trace_path import TracePath, played
from fingerdesign.sensing.model import grip_problem

TRACE_FILE, TRUTH_FILE = "trace.csv", "truth.json"
SIMULATED = RecordFolder("simulated trace", TRACE_FILE, (TRACE_FILE, TRUTH_FILE))
RATE_HZ = 50.0
_PRESS_S, _SHEAR_S, _HOLD_S = 3.0, 3.0, 30.0
_DEPTH = 0.6  # The depth of the press over the stage's travel.
# The modulus is off by this much of its logarithm and the touch by this much, either way.
_MODULUS, _FRICTION, _TOUCH_MM = 0.4, (0.3, 0.9), 0.01
_SHARE, _TIME_S = (0.05, 0.2), (0.3, 8.0)
_GAIN, _OFFSET, _DRIFT, _PER_KELVIN = 0.03, 10.0, 0.1, 2.0  # Standard deviations.
_WARMS_K = 2.0
_NOISE = (0.005, 0.5)  # N, microstrain, where the design's hardware has none


@dataclass(frozen=True)
class SimulatedTrace:
    """trace: what was recorded; truth: by the names that ``identify`` has for values."""

    trace: Trace
    truth: dict[str, float]


def simulated_trace(
    design: Design, seed: int, fidelity: str = "plane-strain", hold_s: float = _HOLD_S
) -> SimulatedTrace:
    """Draw a finger and record it. Raises SolverError where its model has no answer."""
    rng = stream(seed, "simulated trace")
    material = design.body.material
    modulus = design.material_of("body").youngs_modulus_MPa
    modulus *= float(np.exp(rng.uniform(-_MODULUS, _MODULUS)))
    friction, touch = float(rng.uniform(*_FRICTION)), float(rng.uniform(-_TOUCH_MM, _TOUCH_MM))
    terms = _terms(rng)
    own = with_values(design, {f"materials.{material}.youngs_modulus_MPa": modulus})
    problem = grip_problem(own, fidelity).with_friction(friction)
    trace = _moves(_DEPTH * design.grip.max_approach_mm, friction, hold_s)
    with one_thread():
        answers = played(problem, design.gages.face, TracePath.every(trace), terms, touch)
    truth = {"youngs_modulus": modulus, "friction_coefficient": friction, "touch": touch}
    for number, (share, time) in enumerate(terms, 1):
        truth |= {f"share_{number}": share, f"time_{number}": time}
    return _recorded(design, trace, answers, rng, truth)


def _terms(rng: np.random.Generator) -> tuple[tuple[float, float], ...]:
    """None, one or two of the Prony series, the quicker first, well apart."""
    count = int(rng.integers(0, 3))
    shares = rng.uniform(*_SHARE, 2)
    time = float(np.exp(rng.uniform(*np.log(_TIME_S))))
    return tuple(zip(shares.tolist(), (time, 8.0 * time), strict=True))[:count]


def _moves(deep: float, friction: float, hold_s: float) -> Trace:
    press, shear, hold = (round(RATE_HZ * each) for each in (_PRESS_S, _SHEAR_S, hold_s))
    way = 3.0 * friction * deep
    dy = np.repeat([deep / press, 0.0], [press, shear + hold])
    dx = np.repeat([0.0, way / shear, 0.0], [press, shear, hold])
    rows = np.arange(len(dx))
    none = np.zeros(len(dx))
    return Trace((rows + 1) / RATE_HZ, dx, dy, none, none, none[:, None], rows + 2)


def _recorded(
    design: Design, trace: Trace, answers: Array, rng: np.random.Generator, truth: dict[str, float]
) -> SimulatedTrace:
    rows, gages = answers.shape[0], answers.shape[1] - 2
    hardware = design.rig.hardware
    noise = (hardware.force_noise_N or _NOISE[0], hardware.gage_noise_microstrain or _NOISE[1])
    scales = np.array([_GAIN, _OFFSET, _DRIFT, _PER_KELVIN])
    gain, offset, drift, warm = rng.standard_normal((4, gages)) * scales[:, None]
    time = trace.time - trace.time[0]
    heated = _WARMS_K * -np.expm1(-trace.time / 20.0) + 0.02 * rng.standard_normal(rows)
    heated = np.round(20.0 + heated, 2)
    readings = answers[:, 2:] * (1.0 + gain) + offset + np.outer(time, drift)
    readings += np.outer(heated - heated[0], warm)
    forces = answers[:, :2] + noise[0] * rng.standard_normal((rows, 2))
    readings += noise[1] * rng.standard_normal((rows, gages))
    names = ("gain", "offset", "drift", "per_kelvin")
    for number, own in enumerate(np.array([1.0 + gain, offset, drift, warm]).T.tolist(), 1):
        values = zip(names, own, strict=True)
        truth |= {f"gage_{number}.{name}": value for name, value in values}
    found = replace(
        trace,
        normal_force=forces[:, 0],
        tangential_force=forces[:, 1],
        readings=readings,
        temperature=heated,
    )
    return SimulatedTrace(found, truth)
