"""Two elastic bodies, flat faces, thin layers, other codes' answers, and this program's own.

An elastic object's compliance is added to the finger's (facing.py), gaps are taken along y. Where
contact alone holds a body against a motion, a support takes that motion in the model, force control
finds it, and the support must come out without force.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.analysis.path import problem_at_touch
from fingerdesign.analysis.stages import condense, make_mesh
from fingerdesign.arrays import Array
from fingerdesign.checks.load import load_design, parse_design
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.gross_slip import coefficient_under
from fingerdesign.contact.increment import Workspace, solve_increment
from fingerdesign.contact.measures import measure
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion, contact_problem
from fingerdesign.contact.turning import carried_turning, turning
from fingerdesign.design.grip import weight_per_finger
from fingerdesign.design.io import parse_scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_text
from fingerdesign.fem.body import CondensedBody, condense_body
from fingerdesign.fem.reduction import reduced_model
from fingerdesign.fem.system import Body
from fingerdesign.layout.zone import candidate_zone, greatest_approach
from fingerdesign.pipeline import analyse
from fingerdesign.sensing.model import grip_problem
from fingerdesign.shapes.objects import Cylinder, Indenter, Plane
from fingerdesign_bench.accuracy import analytic
from fingerdesign_bench.accuracy.block import (
    block_section,
    both_sides,
    graded,
    near,
    rectangle,
    upside_down,
)
from fingerdesign_bench.accuracy.disc import disc, half_disc
from fingerdesign_bench.accuracy.facing import facing_compliance
from fingerdesign_bench.accuracy.uniform import (
    condense_loaded,
    face_loads,
    held,
    nearest,
    uniform_body,
)
from fingerdesign_bench.known.case import Solution
from fingerdesign_bench.known.rounds import orders

STILL = Motion(0.0, 0.0)
# The cases whose answers two other codes agree on (data/two_codes.json).
HOMOGENEOUS = """
design.name = "two-codes"
body.depth_mm = {depth}
plates.count = 0
materials.silicone.poissons_ratio = 0.3
mesh.mesher = "sweep"
"""
# Its gage is short enough to read the strain at the centre.
ONE_PLATE = """
design.name = "one-plate"
body.depth_mm = 1.0
plates.placement = [[0.0, 10.5, 45.0]]
gages.length_mm = 0.05
"""
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
_SHEARS = ("gamma_x-4", "gamma_x-2", "gamma_x0", "gamma_x2", "gamma_x4")
_INCOMPRESSIBLE = 0.499  # Layers of a higher Poisson's ratio follow the incompressible limit.


@dataclass(frozen=True)
class FromAbove:
    """The lower face of a round object of ``radius`` mm that touches (0, 0): gaps along y.

    For an elastic object on an elastic finger, where neither surface alone gives the common normal.
    """

    radius: float

    def distance(self, points: Array) -> Array:
        across = points[:, 0] ** 2
        rise = across / (self.radius + np.sqrt(self.radius**2 - across))
        return np.asarray(rise - points[:, 1])

    def normal(self, points: Array) -> Array:
        normals = np.zeros_like(points)
        normals[:, 1] = -1.0
        return normals


@dataclass(frozen=True)
class Solved:
    """The condensed lower body, its contact problem, the solved path, and the body's own nodal
    forces (n dim, 1) N at share 1."""

    body: CondensedBody
    problem: ContactProblem
    steps: tuple[Step, ...]
    loads: Array | float = 0.0

    @property
    def x(self) -> Array:
        """Places (m,) mm of the nodes along the contact."""
        return self.problem.model.points[:, 0]

    def pressure(self) -> Array:
        """Nodal contact pressures (m,) MPa of the last step."""
        return np.asarray(self.steps[-1].increment.multiplier[:, 0] / self.problem.model.areas)

    def displacement(self, place: tuple[float, float]) -> Array:
        """Displacement (2,) mm of the lower body's mesh node nearest to ``place``, last step."""
        increment = self.steps[-1].increment
        own = increment.motion.load * self.loads
        field = self.body.displacement_fields(increment.force[None], own)[0]
        return np.asarray(field[nearest(self.body.body.mesh, place)])

    def solution(self, values: dict[str, float]) -> Solution:
        """Values, and the problem that they are of."""
        return Solution(values, (self.problem, self.steps))


def _solved(
    body: Body,
    indenter: Indenter,
    friction: float,
    path: Sequence[Forces | Motion],
    above: Body | None = None,
) -> Solved:
    """Condense, and follow a path; ``above``: the object where it is elastic."""
    condensed = condense_body(body)
    model = reduced_model(condensed)
    yielding = None if above is None else facing_compliance(above, model)
    problem = contact_problem(model, indenter, friction, yielding)
    return Solved(condensed, problem, tuple(follow(problem, path)))


def equal_cylinders(
    size: float = 0.02, below: float = 200.0, above_modulus: float = 200.0
) -> Solved:
    """Half cylinders R = 8, nu = 0.3, crest to crest: P = 10, Q up to 0.93616, mu = 0.2.

    E = 200 of both in the published case; ``below`` and ``above_modulus`` may differ.
    """
    mesh, upper = half_disc(8.0, 1.6, size), upside_down(half_disc(8.0, 1.8, 1.25 * size))
    body = uniform_body(mesh, below, 0.3, held(mesh, "base"), 1.4)
    above = uniform_body(upper, above_modulus, 0.3, held(upper, "base"), 2.0)
    shears = [share * 0.93616 for share in (0.25, 0.5, 0.75, 1.0)]
    path = [Forces(10.0, held=STILL), *(Forces(10.0, shear) for shear in shears)]
    return _solved(body, FromAbove(8.0), 0.2, path, above)


def cylinders(size: float = 0.01) -> Solution:
    """Equal elastic cylinders: pressed, then sheared."""
    solved = equal_cylinders(size)
    pressed, sheared = solved.steps[0].measures, solved.steps[-1].measures
    values = {
        "half-width": 0.5 * pressed.contact_width,
        "peak pressure": pressed.peak_pressure,
        "stick": sheared.stick_width / sheared.contact_width,
    }
    return solved.solution(values)


def roller(friction: float, size: float = 0.1) -> Solution:
    """A steel roller R = 50 on an aluminium block 200 x 200, 35 kN per mm through its top point.

    Advanced Finite Element Contact Benchmarks (Konter, NAFEMS 2006), 1; E 210 and 70 GPa, nu 0.3,
    the block's base fixed. The top point carries the force as a support.
    """
    mesh, upper = block_section(100.0, 200.0, 9.0, size), upside_down(disc(50.0, 10.0, size))
    fixed = held(upper)
    fixed[nearest(upper, (0.0, 100.0))] = True
    fixed[nearest(upper, (0.0, 50.0)), 0] = True  # against rolling
    body = uniform_body(mesh, 70e3, 0.3, held(mesh, "base"), 9.0)
    above = uniform_body(upper, 210e3, 0.3, fixed, 12.0)
    path = [Forces(35e3 * share, held=STILL) for share in (0.25, 0.5, 0.75, 1.0)]
    solved = _solved(body, FromAbove(50.0), friction, path, above)
    measures = solved.steps[-1].measures
    values = {
        "half-width": 0.5 * measures.contact_width,
        "peak pressure": measures.peak_pressure,
        "settlement": float(solved.displacement((0.0, 0.0))[1]),
    }
    return solved.solution(values)


def pressed_plate(size: float = 0.5) -> Solved:
    """SSNV128: a plate 80 x 40 pressed on a rigid plane by 50 MPa and from its sides by 150 MPa.

    The half 0 <= x <= 40, mirrored in x = 40; E = 130 GPa, nu = 0.2, mu = 1. The plane is above
    here. Nothing but contact carries y: the support of one node takes the rigid motion.
    """
    x = graded(size, 20.0, 40.0, 1.2)
    mesh = rectangle(x, -graded(size, 8.0, 40.0, 1.2)[::-1])
    fixed = held(mesh, right=(0,))
    fixed[nearest(mesh, (40.0, -40.0)), 1] = True
    loads = face_loads(mesh, "base", (0.0, 50.0)) + face_loads(mesh, "left", (150.0, 0.0))
    condensed = condense_loaded(uniform_body(mesh, 130e3, 0.2, fixed, 41.0), loads)
    problem = contact_problem(reduced_model(condensed), Plane(0.0), 1.0)
    shares = np.linspace(0.1, 1.0, 10)
    path = [Forces(2000.0 * share, held=Motion(0.0, 0.0, load=float(share))) for share in shares]
    return Solved(condensed, problem, tuple(follow(problem, path)), loads.reshape(-1, 1))


def plate() -> Solution:
    """SSNV128: how far its foot slides, mm."""
    solved = pressed_plate()
    places = (0.0, 1.25, 5.0, 7.5, 11.25)
    return solved.solution({f"at {x:g}": float(solved.displacement((x, 0.0))[0]) for x in places})


def punch(size: float = 0.02) -> Solution:
    """A rigid flat punch |x| <= 1 without friction on a block 100 deep, P = 1 per mm, E = 1.

    The worst error in |x| < 0.9 of it, and the pressure in the middle.
    """
    mesh = block_section(100.0, 100.0, 1.0, size)
    ends = {**mesh.facets, "contact": near(mesh, "contact", 1.0)}  # the punch ends, not the zone
    mesh = replace(mesh, facets=ends)
    body = uniform_body(mesh, 1.0, 0.3, held(mesh, "base"), 1.0)
    solved = _solved(body, Plane(0.0), 0.0, [Forces(1.0, held=STILL)])
    inner = np.abs(solved.x) < 0.9
    x, found = solved.x[inner], solved.pressure()[inner]
    known = analytic.flat_punch_pressure(x, 1.0, 1.0)
    values = {
        "pressure, off": float(np.abs(found / known - 1.0).max()),
        "middle": float(solved.pressure()[np.argmin(np.abs(solved.x))] * np.pi),
    }
    return solved.solution(values)


@lru_cache(maxsize=8)
def layer(poissons_ratio: float, half_width: float = 40.0) -> Solution:
    """A frictionless cylinder, R = 1e6, on a bonded layer 1 mm thick, to a given half-width.

    E = 1. Values are over the thin limit, in which the approach is half_width^2 / (6 R) of an
    incompressible layer, / (2 R) of a compressible one.
    """
    radius = 1e6
    x = both_sides(graded(0.3, 1.1 * half_width, half_width + 10.0, 1.2))
    mesh = rectangle(x, np.linspace(-1.0, 0.0, 11))
    body = uniform_body(mesh, 1.0, poissons_ratio, held(mesh, "base"), 1.1 * half_width, "mixed")
    if poissons_ratio > _INCOMPRESSIBLE:
        sinking = 6.0
        force, peak = analytic.bonded_incompressible_layer(half_width, radius, 1.0, 1.0)
    else:
        sinking = 2.0
        force, peak = analytic.bonded_compressible_layer(half_width, radius, poissons_ratio, 1.0)
    motion = Motion(half_width**2 / (sinking * radius), 0.0)
    solved = _solved(body, Cylinder(radius, radius), 0.0, [motion])
    measures = solved.steps[-1].measures
    values = {
        "force": measures.normal_force / force,
        "peak pressure": measures.peak_pressure / peak,
    }
    return solved.solution(values)


def layer_rates(poissons_ratio: float) -> Solution:
    """Order in b / a at which the force nears the thin limit."""
    widths = np.array([10.0, 20.0, 40.0])
    errors = np.array([layer(poissons_ratio, a).values["force"] - 1.0 for a in widths])
    return orders(1.0 / widths, {"force": errors})


def pushed_block(slope: float = 0.1, friction_coefficient: float = 0.3) -> Solved:
    """NAFEMS CGS-4: a block pushed up a rigid slope tan a, far enough to slide everywhere."""
    mesh = block_section(1.0, 1.0, 1.0, 0.2)
    body = uniform_body(mesh, 1.0, 0.3, held(mesh, "base"), 1.0)
    angle = np.arctan(slope)
    plane = Plane(0.0, (float(np.sin(angle)), -float(np.cos(angle)), 0.0))
    return _solved(body, plane, friction_coefficient, [Motion(0.15, 0.0), Motion(0.15, 1.0)])


def wedge(friction: float = 0.3, slope: float = 0.1) -> Solution:
    """CGS-4: F / G of a sliding block."""
    solved = pushed_block(slope, friction)
    measures = solved.steps[-1].measures
    return solved.solution({"force": measures.tangential_force / measures.normal_force})


def two_codes_path(design: Design, fidelity: str) -> tuple[ContactProblem, tuple[Step, ...]]:
    """Mesh, condense and load a design along the shipped sixteen increments."""
    scene = parse_scene(shipped_text("reference_plane_strain", "scene"))
    if fidelity != "plane-strain":
        scene = scene.model_copy(update={"readout": type(scene.readout)()})
    zone = candidate_zone(design, scene.object, greatest_approach(design, scene))
    model = condense(design, make_mesh(design, fidelity, zone), zone, scene).reduced
    problem = problem_at_touch(model, scene.object, design.body)
    return problem, tuple(follow(problem, [Motion(*row) for row in scene.path.rows]))


def homogeneous(fidelity: str) -> Solution:
    """The finger of rubber alone that two other codes solved, per mm of depth or of depth 10."""
    flat = fidelity == "plane-strain"
    design = parse_design(HOMOGENEOUS.format(depth=1.0 if flat else 10.0))
    problem, steps = two_codes_path(design, fidelity)
    values = {}
    for number, step in enumerate(steps, start=1):
        measures = step.measures
        values[f"normal force at {number}"] = measures.normal_force
        values[f"tangential force at {number}"] = measures.tangential_force
        values[f"peak pressure at {number}"] = measures.peak_pressure
        for k, name in enumerate(_SHEARS if flat else ()):
            values[f"{name} at {number}"] = float(measures.points[k, 3])
    return Solution(values, (problem, steps))


def one_plate() -> Solution:
    """The finger with one plate: strains at its centre, microstrain."""
    problem, steps = two_codes_path(parse_design(ONE_PLATE), "plane-strain")
    gages = 1e6 * np.array([step.measures.gages[0] for step in steps])
    faces = {"upper": gages[:, 0], "lower": gages[:, 1], "middle": gages.mean(axis=1)}
    values = {
        f"{name} at {k}": float(each)
        for name, readings in faces.items()
        for k, each in enumerate(readings, start=1)
    }
    return Solution(values, (problem, steps))


def finger(name: str) -> Solution:
    """A shipped finger through the fundamental case in plane strain, one increment a row."""
    scene = fundamental_scene()
    path = scene.path.model_copy(update={"substeps": 1})
    scene = scene.model_copy(update={"path": path})
    rows = analyse(load_design(name), scene, "plane-strain").increments
    last, sheared = rows[-1], rows[4]
    return Solution(
        {
            "normal force": last.normal_force_N,
            "tangential force": last.tangential_force_N,
            "stick at 5": sheared.stick_ratio or 0.0,
            "largest reading at 5": max(gage.reading for gage in sheared.gages),
        }
    )


def off_centre(name: str, mass_g: float, friction: float) -> Solution:
    """Least forces, N, of a shipped finger that hold an object off the middle, and a slide by small
    steps, 20 mm off, over what limit analysis gives for its normal forces."""
    whole = grip_problem(load_design(name), "3d", whole=True).with_friction(friction)
    weight, values = weight_per_finger(mass_g), {}
    for off in (3.0, 20.0):
        problem = turning(whole, off, weight)
        values[f"least force {off:g} mm off"] = weight / coefficient_under(problem, weight)
    state, workspace = ContactState.untouched(problem), Workspace()
    for shear in np.linspace(0.0, 1.0, 41):
        motion = replace(state.motion, approach=0.1, shear=float(shear))
        found = solve_increment(problem, state, motion, workspace)
        state = found.state
    _, most = carried_turning(problem, found.multiplier[:, 0])
    values["slide over limit analysis"] = measure(problem, found).tangential_force / most
    return Solution(values)


def grip_path(slope: float, friction: float = 0.5) -> Solution:
    """A finger gripped as the product does: preload, then N and T together, dT/dN = slope mu."""
    preload, rise = 0.04, 0.04 * np.linspace(0.0, 1.0, 11)
    rows = [[preload + n, slope * friction * n] for n in rise.tolist()]
    scene = parse_scene(
        f'object.friction_coefficient = {friction}\npath.control = "force"\n'
        f"path.increments_N = {rows}\npath.substeps = 1"
    )
    last = analyse(parse_design(RAMP), scene, "plane-strain").increments[-1]
    return Solution({"stick": last.stick_ratio or 0.0})
