"""Derivatives against central differences on the same moved mesh, of random fingers.

    errors_of(any_finger(3, "plane-strain"))

python -m tests.support.derivatives --fidelity plane-strain --seeds 200       prints the table
python -m tests.support.derivatives --cost maeno2000         the cost of 50 parameters in 3-D
python -m tests.support.derivatives --finite maeno2000       against changes of a fifth
"""

import argparse
import resource
import time
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fingerdesign import load_design, with_values
from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.fidelity.readings import readings_of
from fingerdesign.analysis.path import follow_path, problem_at_touch
from fingerdesign.analysis.stages import condense, in_wide_zone, make_mesh, zone_of
from fingerdesign.errors import FingerDesignError
from fingerdesign.fem.body import condense_body
from fingerdesign.fem.model import body_of, build_model
from fingerdesign.fem.readout import gage_rows
from fingerdesign.fem.reduction import reduced_model
from fingerdesign.mesh.moved import plate_weights
from fingerdesign.sensing.model import meshed_for_grips
from fingerdesign.sensitivity.derive import derivatives, sensitivity
from fingerdesign.sensitivity.variant import PLACES, parameters_of
from fingerdesign.sensitivity.velocity import node_velocity
from fingerdesign.validate.assumptions import E_BAND, nu_values
from tests.support.any_fingers import Finger, any_finger

OUTPUTS = ("normal_force", "tangential_force", "stick_ratio", "gages")
NU = "poissons_ratio"
FIVE = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}
STEPS = (0.128, 0.032, 0.008, 0.002, 0.0005)
SHARES = (1.0, 0.2, 0.04)  # Of the step: the largest one that keeps all statuses has least noise.


@dataclass
class Solved:
    """A finger with its model, path, parameters, and the derivatives to be checked."""

    design: object
    scene: object
    model: object
    steps: list
    parameters: list
    found: object
    velocities: list
    scales: np.ndarray


def names_of(finger):
    """Parameters whose joint change is a sum: friction, materials, and places of the plates."""
    names = ["object.friction_coefficient", "materials.silicone.youngs_modulus_MPa"]
    names += ["materials.silicone.poissons_ratio"]
    plates = finger.design.plates
    flat = plates.follow != "bent" and plates.model == "solid" and finger.design.body.core is None
    if plates.number and plates.model == "solid":
        names += [f"materials.{plates.material}.youngs_modulus_MPa"]
    if plates.number and flat:
        names += [f"placement[{k}].{key}" for k in (0, 1) for key in ("x_mm", "y_mm", "angle_deg")]
        names = [name for name in names if "[1]" not in name or plates.number > 1]
    return names


def solved(finger, names):
    """The finger's derivatives with parameters of these names."""
    design, scene, case = finger.design, finger.scene, finger.case

    def work(zone):
        mesh = make_mesh(design, finger.fidelity, zone, case.symmetric)
        model = condense(design, mesh, zone, scene)
        problem = problem_at_touch(model.reduced, scene.object, design.body)
        steps = follow_path(problem, scene, design)
        wanted = parameters_of(design, scene, tuple(names))
        found = derivatives(design, scene, model, problem, steps, wanted)
        weights = plate_weights(mesh, wanted[0].at(0.0).frames)
        moves = [
            node_velocity(each, mesh, weights) if each.kind not in ("object", "materials") else None
            for each in wanted
        ]
        scales = np.array([scale_of(each) for each in wanted])
        return Solved(design, scene, model, steps, wanted, found, moves, scales)

    return in_wide_zone(design, zone_of(case, scene), work)


def scale_of(parameter):
    """A change that is as usual of one parameter as of another."""
    if parameter.name.endswith("poissons_ratio"):
        return 0.5 - parameter.value
    if parameter.name.endswith("_deg"):
        return 3.0
    return 0.1 if parameter.kind in ("placement", "body", "plates", "gages") else parameter.value


def along(case, way):
    """What the model answers after a joint change ``way`` (P,), and the path's statuses."""
    mesh, design, scene = case.model.mesh, case.design, case.scene
    base = frames = case.parameters[0].at(0.0).frames
    points = mesh.points.copy()
    for parameter, change, velocity in zip(case.parameters, way, case.velocities, strict=True):
        at = parameter.at(change)
        if velocity is not None:
            points += change * velocity
            frames = tuple(
                replace(f, **{n: getattr(f, n) + getattr(new, n) - getattr(old, n) for n in MOVES})
                for f, new, old in zip(frames, at.frames, base, strict=True)
            )
        if parameter.kind == "materials":
            name, key = parameter.name.split(".")[1:]
            own = design.materials[name]
            other = own.model_copy(update={key: getattr(own, key) + change})
            update = {"materials": {**design.materials, name: other}}
            design = design.model_copy(update=update)
        elif parameter.kind == "object":
            scene = at.scene
        elif parameter.kind != "placement":
            design = at.design
    body = body_of(design, replace(mesh, points=points), case.model.condensed.body.contact)
    rows = gage_rows(body.mesh, frames, design.gages, design.gage_weights)
    condensed = condense_body(body, [rows])
    own = condensed.readouts[0]
    reduced = reduced_model(condensed, gage_readout=own, depth=design.body.depth_mm)
    steps = follow_path(problem_at_touch(reduced, scene.object, design.body), scene, design)
    return steps, [increment.status for step in steps for increment in step.row]


MOVES = ("place", "y", "angle_deg", "length", "thickness")


def outputs(steps):
    """All outputs (outputs,) of a path, each kind one after the other."""
    found = readings_of(steps)
    return {name: getattr(found, name).ravel() for name in OUTPUTS}


def slopes(case, way, shares=SHARES):
    """Derivatives along ``way`` (P,) by five points; None where statuses change at any step."""
    kept = [increment.status for step in case.steps for increment in step.row]
    for share in shares:
        sides = {}
        for k in FIVE:
            steps, status = along(case, k * share * way)
            if not all(np.array_equal(a, b) for a, b in zip(status, kept, strict=True)):
                break
            sides[k] = outputs(steps)
        else:
            return {name: sum(FIVE[k] * sides[k][name] for k in FIVE) / share for name in OUTPUTS}
    return None


def steadiest_slopes(case, way):
    """Derivatives along ``way`` (P,), each output's with the step at which differences agree best.

    A large step has the error of the formula, a small one the rounding of the condensation (1e-8
    to 1e-7 of a reading where plates are of metal, divided by the step). Of two neighbouring steps
    that agree best the smaller one is taken. The derivatives to be checked play no part in this.
    """
    found = [
        {name: each[name] / step for name in OUTPUTS}
        for step in STEPS
        if (each := slopes(case, step * way, shares=(1.0,))) is not None
    ]
    if len(found) < 2:
        return None
    gaps = {n: [np.abs(a[n] - b[n]).max(initial=0.0) for a, b in pairwise(found)] for n in OUTPUTS}
    return {name: found[1 + int(np.argmin(gaps[name]))][name] for name in OUTPUTS}


def errors_of(finger, names=None, step=2e-3, chance=None):
    """Errors by kind of direction: of each output, relative to its largest scaled derivative.

    step: of the differences; None: the steadiest of STEPS.

    The scale of an output is the largest over all parameters and rows; coordinates, two random
    directions, and the gradient of the last row's tangential force and of its largest reading.
    """
    case = solved(finger, names or names_of(finger))
    chance = chance or np.random.default_rng(0)
    exact = {name: np.nan_to_num(getattr(case.found, name)) * case.scales for name in OUTPUTS}
    exact = {name: value.reshape(-1, len(case.scales)) for name, value in exact.items()}
    most = {name: float(np.abs(value).max(initial=0.0)) for name, value in exact.items()}
    ways = {"coordinate": list(np.eye(len(case.scales)))}
    ways["random"] = [chance.standard_normal(len(case.scales)) for _ in range(2)]
    rows = [exact["tangential_force"][-1]]
    if exact["gages"].size:
        rows += [exact["gages"][np.abs(exact["gages"]).max(axis=1).argmax()]]
    if len(case.scales) > 1:  # the gradient by one parameter is its coordinate
        ways["gradient"] = [row / max(np.linalg.norm(row), 1e-300) for row in rows]
    errors, skipped = [], 0
    for kind, each in ways.items():
        for way in each:
            if step is None:
                found = steadiest_slopes(case, way * case.scales)
            else:
                found = slopes(case, step * way * case.scales)
                found = found and {name: found[name] / step for name in OUTPUTS}
            if found is None:
                skipped += 1
                continue
            for name in OUTPUTS:
                if most[name] > 0.0:
                    error = np.abs(found[name] - exact[name] @ way).max() / most[name]
                    errors.append((kind, name, float(error)))
    return errors, skipped, case.found


def cost_of(name, contact_mm=None):
    """Print seconds, those of processors, and memory of an analysis in 3-D (swept), and of
    derivatives of its rows with 50 parameters."""
    design = with_values(load_design(name), {"mesh.mesher": "sweep"})
    if contact_mm:
        design = meshed_for_grips(design, "3d", contact_mm)
    scene = fundamental_scene(design)
    case = Case(design, scene, "3d", grips=False, fields=False)
    zone, seconds = zone_of(case, scene), []

    def clock():
        return np.array([time.perf_counter(), time.process_time()])

    def lap(words, start):
        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        waited, worked = clock() - start
        seconds.append([waited, worked])
        print(f"{words}: {waited:.1f} s ({worked:.1f} of processors), {most:.2f} GB at most")

    start = clock()
    mesh = make_mesh(design, "3d", zone, case.symmetric)
    model = build_model(design, mesh, zone.half_width, zone_half_depth=zone.half_depth)
    problem = problem_at_touch(model.reduced, scene.object, design.body)
    steps = follow_path(problem, scene, design)
    lap(f"analysis, {model.dofs} equations, {model.reduced.nodes} candidates", start)
    names = [f"placement[{k}].{key}" for key in PLACES for k in range(design.plates.number)]
    others = ("object.friction_coefficient", "body.base_height_mm", "plates.thickness_mm")
    names += [*others, *names_of(Finger(design, scene, "3d"))[1:4]]
    wanted = parameters_of(design, scene, tuple(dict.fromkeys(names))[:50])
    start = clock()
    found = derivatives(design, scene, model, problem, steps, wanted)
    lap(f"{len(wanted)} parameters, {found.readings.rows} rows", start)
    print("ratio {:.2f} ({:.2f} of processors)".format(*np.divide(seconds[1], seconds[0])))


def finite_of(name):
    """Print how a path in plane strain changes with the rubber's values as far as `validate` varies
    them, by derivatives and by new analyses: largest, relative to the path's largest."""
    design = load_design(name)
    keys = [f"materials.{design.body.material}.{each}" for each in ("youngs_modulus_MPa", NU)]
    found = sensitivity(design, None, keys, "plane-strain")
    modulus = found.values[0]
    varied = [(0, (1.0 - E_BAND) * modulus), (0, (1.0 + E_BAND) * modulus)]
    for k, value in varied + [(1, value) for value in nu_values(design)]:
        other = sensitivity(with_values(design, {keys[k]: value}), None, keys[:1], "plane-strain")
        print(f"{keys[k]} = {value:g}")
        for output in OUTPUTS:
            before = getattr(found.readings, output)
            most = 1.0 if output == "stick_ratio" else np.abs(before).max()
            new = np.abs(getattr(other.readings, output) - before).max() / most
            linear = np.abs(getattr(found, output)[..., k] * (value - found.values[k])).max() / most
            print(f"    {output:17} analyses {new:.4f}   derivatives {linear:.4f}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--cost", metavar="DESIGN", help="the cost in 3-D instead")
    parser.add_argument("--finite", metavar="DESIGN", help="changes as large as `validate` makes")
    parser.add_argument("--contact-mm", type=float, help="with --cost: size of contact facets")
    parser.add_argument("--fidelity", default="plane-strain")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--plates-MPa", type=float, help="modulus of the plates: 50 hardly rounds")
    given = parser.parse_args()
    if given.cost:
        cost_of(given.cost, given.contact_mm)
        return
    if given.finite:
        finite_of(given.finite)
        return
    every, skipped, fingers, kinks = [], 0, 0, 0
    for seed in range(given.first, given.first + given.seeds):
        try:
            finger = any_finger(seed, given.fidelity)
            if given.plates_MPa:
                key = f"materials.{finger.design.plates.material}.youngs_modulus_MPa"
                finger = finger.with_design({key: given.plates_MPa})
            errors, out, found = errors_of(finger, step=None)
        except FingerDesignError as error:
            print(seed, "refused:", error, flush=True)
            continue
        fingers, skipped = fingers + 1, skipped + out
        # There the stick ratio's derivative has two sides.
        sided = found.on_kink.any()
        kinks += bool(sided)
        errors = [each for each in errors if not (sided and each[1] == "stick_ratio")]
        every += errors
        worst = max(errors, key=lambda each: each[2], default=("-", "-", 0.0))
        print(seed, len(errors), out, *worst, f"kink {found.on_kink.max():.2g}", flush=True)
    print(f"{fingers} fingers, {len(every)} derivatives, {skipped} ways over a change of status")
    print(f"{kinks} on a kink: their stick ratios are left out")
    for kind in ("coordinate", "random", "gradient"):
        for name in OUTPUTS:
            own = np.array([e for k, n, e in every if (k, n) == (kind, name)])
            if len(own):
                low, high, most = np.quantile(own, [0.5, 0.95, 1.0])
                print(f"{kind:10} {name:17} {low:.1e} {high:.1e} {most:.1e}")


if __name__ == "__main__":
    main()
