"""Slopes of a bench's curves with hidden values: derivatives of a finger's model (sensitivity/).

One condensation gives those of every place and modulus. Points of each phase are moved along their
slopes, and what comes of the points, curves, is taken again: of closed forms a difference will do.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.analysis.case import fundamental_scene, gage_array
from fingerdesign.analysis.fidelity.readings import readings_of
from fingerdesign.arrays import Array
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.control.bench_curves import BenchCurves, Phase, bench_curves
from fingerdesign.design.schema import Design
from fingerdesign.runtime.progress import Report
from fingerdesign.runtime.threads import in_threads
from fingerdesign.sensing.identify.bench import LEAN_STEP, ROUGH, BenchModel, bench_finger, leaning
from fingerdesign.sensing.identify.latents import AXES, Latent, material_value
from fingerdesign.sensitivity.derive import IncrementRates, changes_of, face_mean, rates_under
from fingerdesign.sensitivity.model import ResponseFields
from fingerdesign.sensitivity.path import near_nodes, needed_dofs
from fingerdesign.sensitivity.variant import PLACES, differentiable, parameters_of

_ROUNDING = 1e-3  # Of forces, next to the largest: a third of the rates' work less.
_SHARE = 0.01  # Of a latent's step: so near, curves between points keep their pieces.


@dataclass(frozen=True)
class Difference:
    """Curves of a latent below and above the finger's value, and the distance of the two values."""

    low: BenchCurves
    high: BenchCurves
    apart: float


def differences(
    model: BenchModel, finger: Design, latents: Sequence[Latent], lean_deg: float, report: Report
) -> list[Difference]:
    """Differences of a finger's curves by each latent, in the design's rough mesh: that of the lean
    by playing the moves at two, the others by derivatives.

    lean_deg: the bench's lean. Raises SolverError where the model has no answer."""
    report("sensitivities")
    design = differentiable(finger)
    phases = model.moved
    rough = bench_finger(design, phases, model.fidelity, model.design, ROUGH)
    condensed, bench = rough.model()
    problems = leaning(bench, design, phases, lean_deg)

    def followed(of: tuple[Phase, ContactProblem]) -> list[Step]:
        moves = zip(of[0].points.approach.tolist(), of[0].points.shear.tolist(), strict=True)
        return [*follow(of[1], [Motion(*each) for each in moves], 1)]

    paths = [*in_threads(followed, zip(phases, problems, strict=True))]
    every = [step.increment for steps in paths for step in steps]
    nodes = near_nodes(problems[0], every)
    # What touches in one phase and what is normal to the surface of another.
    needed = np.any([needed_dofs(problem, every, nodes) for problem in problems], axis=0)
    smooth = [latent for latent in latents if latent.kind != "lean"]
    fields = ResponseFields(condensed.condensed, nodes, needed)
    names, factors = zip(*(_parameter_of(design, latent) for latent in smooth), strict=True)
    scene = fundamental_scene(design)
    changes = changes_of(design, condensed, parameters_of(design, scene, names))
    report("sensitivities: rates of the model")
    none = np.zeros((fields.contact, 0))
    rates, between = rates_under(fields, changes, every, (none, none), _ROUNDING)
    moved: list[tuple[Phase, tuple[Array, Array, Array]]] = []
    parts = np.split(rates, np.cumsum([len(steps) for steps in paths])[:-1], axis=2)
    for phase, problem, steps, part in zip(phases, problems, paths, parts, strict=True):
        own = [step.increment for step in steps]
        found = IncrementRates(problem, fields, changes, own, under=(part, between))
        slopes = _slopes(found, design, len(steps), factors)
        read = readings_of(steps, design.gages.face)
        played = _with(phase, read.normal_force, read.tangential_force, read.reading)
        moved.append((played, slopes))
    leaning_by = model.played_on(bench, design)
    gages = problems[0].model.gage_x

    def next_to(latent: Latent) -> Difference:
        if latent.kind == "lean":
            step = LEAN_STEP[model.fidelity]
            return Difference(leaning_by(lean_deg - step), leaning_by(lean_deg + step), 2.0 * step)
        step, k = _SHARE * latent.step, smooth.index(latent)
        sides = [[_shifted(*each, k, off) for each in moved] for off in (-step, step)]
        low, high = (bench_curves(side, gages) for side in sides)
        return Difference(low, high, 2.0 * step)

    return [next_to(latent) for latent in latents]


def _parameter_of(design: Design, latent: Latent) -> tuple[str, float]:
    """The parameter that a latent is, and by how much it changes with one unit of the latent."""
    if latent.kind in AXES:
        return f"placement[{latent.number}].{PLACES[AXES.index(latent.kind)]}", 1.0
    key, own = material_value(design, latent.kind)
    return key, 1.0 if latent.kind == "poisson" else own


def _with(phase: Phase, normal: Array, tangential: Array, readings: Array) -> Phase:
    """The phase with other forces and readings at its points, by a model."""
    points = replace(
        phase.points,
        normal_force=normal,
        tangential_force=tangential,
        readings=readings,
        samples=np.full(len(normal), np.inf),
    )
    return replace(phase, points=points, trace=None)


def _slopes(
    rates: IncrementRates, design: Design, moves: int, factors: Sequence[float]
) -> tuple[Array, Array, Array]:
    """Slopes, by latents, of F_n and F_t (k, P), N, and readings (k, g, P), microstrain."""
    total, gages = rates.at(np.arange(moves))
    readings = face_mean(gages, design.gages.face)[:, list(gage_array(design))]
    return -total[:, 1] * factors, total[:, 0] * factors, readings * factors


def _shifted(phase: Phase, slopes: tuple[Array, Array, Array], k: int, off: float) -> Phase:
    """A phase whose points went along the slopes of latent k."""
    normal, tangential, readings = (off * each[..., k] for each in slopes)
    at = phase.points
    forces = at.normal_force + normal, at.tangential_force + tangential
    return _with(phase, *forces, at.readings + readings)
