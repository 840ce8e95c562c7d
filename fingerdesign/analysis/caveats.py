"""What a reader must know before believing the numbers of an analysis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.contact.increment import ContactState
from fingerdesign.contact.laws import OPEN
from fingerdesign.contact.measures import completely_slips, measure
from fingerdesign.contact.uniqueness import other_solutions
from fingerdesign.layout.frames import crest_height

if TYPE_CHECKING:
    from fingerdesign.analysis.case import Case
    from fingerdesign.contact.path import Step
    from fingerdesign.contact.problem import ContactProblem
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design


_SMALL_STRAIN = 0.1  # approach over height where the paper's linearity has gone by any measure
_ENOUGH_NODES = {2: 10, 3: 40}  # in contact: about five facets across half of it
# Searched for other answers above it: on the shipped finger none was found even at 5.
_UNUSUAL_FRICTION = 1.0
_LOCKING = 0.4  # Poisson's ratio from which linear elements are too stiff to be believed


def caveats(case: Case, scene: Scene, problem: ContactProblem, steps: list[Step]) -> list[str]:
    """What a reader must know before believing the numbers, a sentence each."""
    design, model, found = case.design, problem.model, list[str]()
    if not design.plates.number and case.scene is None:
        found.append("no plates, hence no gages: the slip study and the grips are left out")
    elif not case.gage_array and case.scene is None:
        found.append(
            "no row of plates along x: gages of plates along z do not feel shear in x, so the slip "
            "study and the grips are left out"
        )
    height = crest_height(design.body)
    deepest = max(step.increment.motion.approach for step in steps)
    if deepest > _SMALL_STRAIN * height:
        found.append(
            f"the approach of {deepest:g} mm is {deepest / height:.0%} of the body's height: "
            "strains are not small, and the linear model is only a sketch there"
        )
    closed = np.array([step.increment.status != OPEN for step in steps])
    if closed[:, _at_side(design, model.points)].any():
        found.append("the contact reaches the body's edge, where the pressure is singular")
    touched = closed.any(axis=1)
    first = int(np.argmax(touched)) if touched.any() else len(steps)
    pressed = [k for k in range(first) if steps[k].increment.motion.approach > 0.0]
    if pressed:
        rows = f"{len(pressed)} row{'s' * (len(pressed) > 1)} from row {pressed[0] + 1} on"
        found.append(
            f"in {rows} the object is past first touch, but the mesh does not feel it yet: its "
            "facets are longer than the contact is wide; make contact_size_mm of [mesh] or "
            "[mesh.section], or the layers, finer"
        )
    most = int(closed.sum(axis=1).max())
    enough = _ENOUGH_NODES[model.dimension]
    if 0 < most < enough:
        table = "mesh.section" if model.dimension == 2 else "mesh"
        found.append(
            f"the contact holds {most} nodes at most: pressures and stick ratios are coarse; make "
            f"{table}.contact_size_mm smaller"
        )
    if case.scene is None and not completely_slips(steps[-1].measures, model.dimension):
        ratio = steps[-1].measures.stick_ratio
        found.append(
            f"the fundamental path, made for maeno2000, ends at a stick ratio of "
            f"{ratio or 0.0:.2f} on this finger, not in complete slip; --scene takes your own"
        )
    return [*found, *_choices(case, scene), *_other_answers(scene, problem, steps)]


def _at_side(design: Design, points: Array) -> BoolArray:
    """Which contact nodes lie on the edge between contact surface and sides."""
    away = np.abs(points[:, 0])
    if design.body.shape == "revolved" and points.shape[1] == 3:
        away = np.hypot(points[:, 0], points[:, 2])
    return np.asarray(away >= 0.5 * design.body.width_mm - 1e-6)


def _choices(case: Case, scene: Scene) -> list[str]:
    """Keys of the design and the scene that may not mean, or not do, what their writer thinks."""
    design, found = case.design, list[str]()
    ratio = design.material_of("body").poissons_ratio
    if design.mesh.element == "P1" and ratio >= _LOCKING:
        found.append(
            f"linear elements lock at nu = {ratio:g}: forces and strains are off by ten percent "
            "and more; leave mesh.element at auto"
        )
    if design.plates.model == "none" and design.plates.number:
        found.append(
            'plates.model = "none": the plates are left out, so the readings are the rubber\'s own '
            "strains, thousands of times a plate's, and verdicts and grips on them mean nothing"
        )
    seen = design.plates.model != "none" or design.body.core is not None or not design.body.straight
    if case.fidelity == "plane-strain" and not design.extruded and seen:
        found.append(_section_caveat(design))
    if scene.path.control == "force" and scene.path.increments_mm:
        found.append(
            'path.increments_mm was read as newtons, as path.control = "force" says; '
            "path.increments_N is the plainer key"
        )
    return found


def _section_caveat(design: Design) -> str:
    """What plane strain gets wrong of a finger that its section z = 0 is not drawn straight from.

    Measured on a turned pin at an approach of 0.1 mm: 5.19 N in plane strain, 1.23 N in 3-D.
    """
    named = {"revolved": "the turned body", "dome": "the domed body"}.get(design.body.shape)
    if named is not None:
        return (
            f"plane strain draws the section z = 0 of {named} straight along the whole depth: it "
            "touches along a line, not in a spot, so forces come out several times too large "
            "(about four times for a pin) and stick ratios are another contact's; take "
            "--fidelity 3d"
        )
    return (
        "plane strain takes plates and core as they are in the section z = 0, as if they went "
        "through the whole depth unbroken; here they do not, so the finger comes out too stiff "
        "and the readings are only a sketch; take --fidelity 3d"
    )


def _other_answers(scene: Scene, problem: ContactProblem, steps: list[Step]) -> list[str]:
    """Whether the last increment has answers besides its own, where friction is unusually high."""
    if problem.friction_coefficient <= _UNUSUAL_FRICTION or scene.path.substeps > 1:
        return []
    last = steps[-1].increment
    before = steps[-2].increment.state if len(steps) > 1 else ContactState.untouched(problem)
    others = other_solutions(problem, before, last.motion, last, starts=2)
    if not others:
        return []
    forces = [measure(problem, other) for other in others]
    listed = "; ".join(f"F_n {m.normal_force:.3g}, F_t {m.tangential_force:.3g} N" for m in forces)
    return [
        f"at friction {problem.friction_coefficient:g} the laws have more than one answer for the "
        f"last increment: besides the one given, {listed}. Nothing in them prefers one"
    ]
