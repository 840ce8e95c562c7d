"""Two elastic bodies, flat faces, thin layers, other codes' answers, and this program's own."""

from functools import lru_cache

import numpy as np

from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.checks.load import load_design, parse_design
from fingerdesign.design.io import parse_scene
from fingerdesign.pipeline import analyse
from fingerdesign_bench.accuracy import analytic, reference
from fingerdesign_bench.accuracy import verification_bodies as bodies
from fingerdesign_bench.check import two_codes
from fingerdesign_bench.known.case import Curve, Picture, Solution, compare_curves
from fingerdesign_bench.known.rounds import orders


def _pressures(solved: bodies.Solved, known: np.ndarray, step: int = -1) -> Picture:
    model = solved.problem.model
    found = solved.steps[step].increment.multiplier[:, 0] / model.areas
    return compare_curves("x (mm)", "pressure (MPa)", model.points[:, 0], known, found)


def cylinders(size: float = 0.01) -> Solution:
    """Equal elastic cylinders: pressed, then sheared."""
    solved = bodies.equal_cylinders(size)
    pressed, sheared = solved.steps[0].measures, solved.steps[-1].measures
    values = {
        "half-width": 0.5 * pressed.contact_width,
        "peak pressure": pressed.peak_pressure,
        "stick": sheared.stick_width / sheared.contact_width,
    }
    known = analytic.Hertz(0.6808, 9.351).pressure(solved.problem.model.points[:, 0])
    return Solution(values, _pressures(solved, known, 0), (solved.problem, solved.steps))


def roller(friction: float, size: float = 0.1) -> Solution:
    """NAFEMS' roller."""
    solved = bodies.nafems_roller(size, friction)
    measures = solved.steps[-1].measures
    values = {
        "half-width": 0.5 * measures.contact_width,
        "peak pressure": measures.peak_pressure,
        "settlement": float(solved.displacement(np.zeros(2))[1]),
    }
    known = analytic.Hertz(6.215, 3585.0).pressure(solved.problem.model.points[:, 0])
    return Solution(values, _pressures(solved, known), (solved.problem, solved.steps))


def plate() -> Solution:
    """SSNV128: how far its foot slides, mm."""
    solved = bodies.pressed_plate()
    known = {0.0: 2.86e-2, 1.25: 2.72e-2, 5.0: 2.28e-2, 7.5: 1.98e-2, 11.25: 1.50e-2}
    values = {f"at {x:g}": float(solved.displacement(np.array([x, 0.0]))[0]) for x in known}
    x = np.array(list(known))
    found = np.array(list(values.values()))
    picture = compare_curves(
        "x (mm)", "displacement (mm)", x, np.array(list(known.values())), found
    )
    return Solution(values, picture, (solved.problem, solved.steps))


def punch(size: float = 0.02) -> Solution:
    """A flat punch: the worst error in |x| < 0.9 of it, and the pressure in the middle."""
    solved = bodies.flat_punch(size)
    x = solved.problem.model.points[:, 0]
    inner = np.abs(x) < 0.9
    known = analytic.flat_punch_pressure(x[inner], 1.0, 1.0)
    found = solved.pressure[inner]
    values = {
        "pressure, off": float(np.abs(found / known - 1.0).max()),
        "middle": float(solved.pressure[np.argmin(np.abs(x))] * np.pi),
    }
    picture = compare_curves("x / a", "pressure (MPa)", x[inner], known, found)
    return Solution(values, picture, (solved.problem, solved.steps))


@lru_cache(maxsize=8)
def layer(poissons_ratio: float, half_width: float = 40.0) -> Solution:
    """A bonded layer ``half_width`` times thinner than the contact: over the thin limit."""
    thin = 6.0 if poissons_ratio > 0.499 else 2.0
    solved = bodies.bonded_layer(half_width, poissons_ratio=poissons_ratio, sinking=thin)
    x = solved.problem.model.points[:, 0]
    inside = np.maximum(0.0, 1.0 - (x / half_width) ** 2)
    if poissons_ratio > 0.499:
        force, peak, _ = analytic.bonded_incompressible_layer(half_width, 1e6, 1.0, 1.0)
        known = peak * inside**2
    else:
        force, peak = analytic.bonded_compressible_layer(half_width, 1e6, poissons_ratio, 1.0)
        known = peak * inside
    measures = solved.steps[-1].measures
    values = {
        "force": measures.normal_force / force,
        "peak pressure": measures.peak_pressure / peak,
    }
    return Solution(values, _pressures(solved, known), (solved.problem, solved.steps))


def layer_rates(poissons_ratio: float) -> Solution:
    """How the force nears the thin limit as the layer gets thinner: order in b / a."""
    widths = np.array([10.0, 20.0, 40.0])
    errors = np.array([layer(poissons_ratio, a).values["force"] - 1.0 for a in widths])
    return orders(1.0 / widths, {"force": errors}, "log10 of b / a")


def wedge(friction: float = 0.3, slope: float = 0.1) -> Solution:
    """CGS-4: F / G of a sliding block."""
    solved = bodies.wedge(slope, friction)
    measures = solved.steps[-1].measures
    ratio = measures.tangential_force / measures.normal_force
    x, across = solved.problem.model.points[:, 0], solved.steps[-1].increment.force
    known = analytic.sliding_wedge(slope, friction)
    found = across[:, 0] / np.minimum(across[:, 1], -1e-30)
    found = -found
    picture = compare_curves(
        "x (mm)", "traction along over across", x, np.full(len(x), known), found
    )
    return Solution({"force": ratio}, picture, (solved.problem, solved.steps))


_SHEARS = ("gamma_x-4", "gamma_x-2", "gamma_x0", "gamma_x2", "gamma_x4")


def homogeneous(fidelity: str) -> Solution:
    """The finger of rubber alone that two other codes solved, per mm of depth or of depth 10."""
    flat = fidelity == "plane-strain"
    text = reference.HOMOGENEOUS.format(depth=1.0 if flat else 10.0, mesher="extrude")
    solved = reference.solve_reference(parse_design(text), fidelity)
    rows = two_codes()["plane_strain" if flat else "three_d_depth_10"]
    values, known, found = {}, [], []
    for number, (row, step) in enumerate(zip(rows, solved.steps, strict=True), start=1):
        measures = step.measures
        values[f"normal force at {number}"] = measures.normal_force
        values[f"tangential force at {number}"] = measures.tangential_force
        values[f"peak pressure at {number}"] = measures.peak_pressure
        for k, name in enumerate(_SHEARS if flat else ()):
            values[f"{name} at {number}"] = float(measures.points[k, 3])
        known.append(row["Ft"] or 0.0)
        found.append(measures.tangential_force)
    place = np.arange(1.0, len(rows) + 1.0)
    picture = compare_curves(
        "increment", "tangential force (N)", place, np.array(known), np.array(found)
    )
    return Solution(values, picture, (solved.problem, tuple(solved.steps)))


def one_plate() -> Solution:
    """The finger with one plate: strains at its centre, microstrain."""
    solved = reference.solve_one_plate()
    gages = 1e6 * np.array([step.measures.gages[0] for step in solved.steps])
    values = {f"upper at {k}": float(each[0]) for k, each in enumerate(gages, start=1)}
    values |= {f"lower at {k}": float(each[1]) for k, each in enumerate(gages, start=1)}
    values |= {f"middle at {k}": float(each.mean()) for k, each in enumerate(gages, start=1)}
    rows = two_codes()["one_plate"]
    place = np.arange(1.0, len(gages) + 1.0)
    curves = (
        Curve("upper, two codes", *_columns(rows, "upper"), known=True),
        Curve("lower, two codes", *_columns(rows, "lower"), known=True),
        Curve("upper", place, gages[:, 0], False),
        Curve("lower", place, gages[:, 1], False),
    )
    picture = Picture("increment", "strain (microstrain)", curves)
    return Solution(values, picture, (solved.problem, tuple(solved.steps)))


def _columns(rows: list[dict[str, float]], name: str) -> tuple[np.ndarray, np.ndarray]:
    return np.array([row["increment"] for row in rows]), np.array([row[name] for row in rows])


def finger(name: str) -> Solution:
    """A shipped finger through the fundamental case in plane strain, as ``analyse`` has it."""
    rows = analyse(load_design(name), fundamental_scene(), "plane-strain").increments
    last, sheared = rows[-1], rows[4]
    values = {
        "normal force": last.normal_force_N,
        "tangential force": last.tangential_force_N,
        "stick at 5": sheared.stick_ratio or 0.0,
        "largest reading at 5": max(gage.reading for gage in sheared.gages),
    }
    force = np.array([[each.normal_force_N, each.tangential_force_N] for each in rows])
    curve = Curve("found", force[:, 0], force[:, 1], False)
    return Solution(values, Picture("normal force (N)", "tangential force (N)", (curve,)))


RAMP = """
design.name = "ramp"
body.width_mm = 120.0
body.base_height_mm = 60.0
body.arc_radius_mm = 100.0
body.depth_mm = 1.0
plates.count = 0
materials.silicone.poissons_ratio = 0.4999
mesh.section.contact_size_mm = 0.025
mesh.section.far_size_mm = 6.0
"""


def grip_path(slope: float, friction: float = 0.5) -> Solution:
    """A finger gripped as the product does: preload, then N and T together, dT/dN = slope mu."""
    preload, rise = 0.04, 0.04 * np.linspace(0.0, 1.0, 11)
    rows = [[preload + n, slope * friction * n] for n in rise.tolist()]
    scene = parse_scene(
        f'object.friction_coefficient = {friction}\npath.control = "force"\n'
        f"path.increments_N = {rows}"
    )
    found = analyse(parse_design(RAMP), scene, "plane-strain").increments[1:]
    stick = np.array([each.stick_ratio or 0.0 for each in found])
    known = np.ones(len(stick))
    if slope > 1.0:  # c / a: the root of (N - T / mu) / N
        force = np.array(rows[1:])
        known = np.sqrt(np.maximum(0.0, 1.0 - force[:, 1] / friction / force[:, 0]))
    picture = compare_curves("increment", "stick ratio", np.arange(1.0, 11.0), known, stick)
    return Solution({"stick": float(stick[-1])}, picture)
