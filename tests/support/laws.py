"""Laws between the answers of two fingers, or of one finger twice, on random fingers.

Each law gives the bound of an answer's error, as :func:`any_fingers.difference` measures it, and
its reason.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.path import (
    follow_path,
    increment_result,
    object_at_touch,
    problem_at_touch,
)
from fingerdesign.analysis.stages import make_mesh, zone_of
from fingerdesign.contact.problem import ContactProblem, contact_problem
from fingerdesign.design.plates import Row
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.fem.body import condense_body
from fingerdesign.fem.model import body_of, build_model, candidate_facets, free_ends, gage_positions
from fingerdesign.fem.readout import gage_rows
from fingerdesign.fem.reduction import reduced_model
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.types import Mesh
from fingerdesign.pipeline import analyse_into, run
from fingerdesign.reduced import ReducedModel
from tests.support.any_fingers import Answer, Finger, answer_of, any_finger, difference, solved

SAME, SAME_WHY = 1e-7, "the same equations: solvers leave 1e-9 of the force, stiff gages more"
LIKE, LIKE_WHY = 1e-6, "where the object touches first is found to 1e-6 mm, and meshes follow it"
BOTH = ("plane-strain", "3d")
Wrong = Callable[[Finger], float | None]


class Law(NamedTuple):
    """What holds: wrong(finger) <= bound, and why; None: it says nothing of this finger."""

    name: str
    wrong: Wrong
    bound: float
    why: str
    fidelities: tuple[str, ...]


LAWS: dict[str, Law] = {}


def law(
    name: str, bound: float, why: str, fidelities: tuple[str, ...] = BOTH
) -> Callable[[Wrong], Wrong]:
    """Register what says how wrong a finger's answer is."""

    def add(wrong: Wrong) -> Wrong:
        LAWS[name] = Law(name, wrong, bound, why, fidelities)
        return wrong

    return add


class Known(NamedTuple):
    """What is worked out of a finger once, for all laws."""

    finger: Finger
    mesh: Mesh
    zone: Zone
    model: ReducedModel


@cache
def known(seed: int, fidelity: str) -> Known:
    """The finger of a seed, with a mesh and a model."""
    finger = any_finger(seed, fidelity)
    case, zone = finger.case, zone_of(finger.case, finger.scene)
    mesh = make_mesh(finger.design, case.fidelity, zone, case.symmetric)
    return Known(finger, mesh, zone, _model(finger, mesh, zone))


def _model(finger: Finger, mesh: Mesh, zone: Zone) -> ReducedModel:
    return build_model(finger.design, mesh, zone.half_width, None, zone.half_depth).reduced


def _known(finger: Finger) -> Known:
    return known(finger.seed, finger.fidelity)


@cache
def _own_answer(seed: int, fidelity: str) -> Answer:
    return solved(any_finger(seed, fidelity))


def answer(finger: Finger) -> Answer:
    """The whole pipeline's, of a finger as it was drawn."""
    return _own_answer(finger.seed, finger.fidelity)


def followed(finger: Finger, model: ReducedModel) -> Answer:
    """A model's answer to the finger's scene."""
    return _along(problem_at_touch(model, finger.scene.object, finger.design.body), finger)


def _along(problem: ContactProblem, finger: Finger) -> Answer:
    steps = follow_path(problem, finger.scene, finger.design)
    return answer_of([increment_result(step, finger.design.gages.face) for step in steps])


@law("mirrored in x", LIKE, f"mirror images have mirrored meshes; {LIKE_WHY}")
def mirrored(finger: Finger) -> float:
    """Plates, tilt and shear mirrored: F_t changes its sign, gages of a row their order."""
    values: dict[str, Any] = {}
    order: list[int] = []
    for number, row in enumerate(finger.design.plates.all_rows):
        even = row.count % 2 == 0
        table = "plates" if number == 0 else f"plates.rows[{number - 1}]"
        values[f"{table}.offset_mm"] = -row.offset_mm
        values[f"{table}.angle_deg"] = -row.angle_deg
        values[f"{table}.stagger_mm"] = -row.stagger_mm if even else row.stagger_mm
        order += [len(order) + place for place in reversed(range(row.count))]
    rows = [[deep, -along] for deep, along in finger.scene.path.increments_mm]
    image = finger.with_design(values).with_scene(
        object={"tilt_deg": -finger.scene.object.tilt_deg}, path={"increments_mm": rows}
    )
    found = solved(image)
    back = Answer(found.forces * [1.0, -1.0], found.stick, found.strains[:, order])
    return difference(answer(finger), back)


@law("lengths times 2.3, moduli times 3.7", SAME, SAME_WHY)
def scaled(finger: Finger) -> float:
    """Of one mesh, scaled: forces are those of 2.3 squared times 3.7, strains the same."""
    length, modulus = 2.3, 3.7
    _, mesh, zone, model = _known(finger)
    larger = replace(mesh, points=length * mesh.points)
    deep = None if zone.half_depth is None else length * zone.half_depth
    wide = replace(zone, half_width=length * zone.half_width, half_depth=deep)
    there = _stiffer(_longer(finger, length), modulus)
    found = followed(there, _model(there, larger, wide))
    found = found._replace(forces=found.forces / (length**2 * modulus))
    return difference(followed(finger, model), found)


def _stiffer(finger: Finger, factor: float) -> Finger:
    data = finger.design.model_dump(mode="json", exclude_unset=True)
    data["materials"] = finger.design.model_dump(mode="json")["materials"]
    for material in data["materials"].values():
        material["youngs_modulus_MPa"] *= factor
    return replace(finger, design=Design.model_validate(data))


def _longer(finger: Finger, factor: float) -> Finger:
    """All lengths of the finger and its scene."""
    data = finger.design.model_dump(mode="json", exclude_none=True)
    if finger.design.body.shape == "block":
        del data["body"]["arc_radius_mm"]  # refused where there is no arc
    del data["plates"]["hole_pitch_mm"], data["grip"], data["mold"]
    scene = finger.scene.model_dump(mode="json", exclude_unset=True)
    design, scene = (_lengthened(each, factor) for each in (data, scene))
    return replace(finger, design=Design.model_validate(design), scene=Scene.model_validate(scene))


def _lengthened(value: Any, factor: float, key: str = "") -> Any:
    if isinstance(value, dict):
        return {name: _lengthened(each, factor, name) for name, each in value.items()}
    if isinstance(value, list):
        return [_lengthened(each, factor, key) for each in value]
    return factor * value if key.endswith("_mm") else value


@dataclass(frozen=True)
class Moved:
    """An object ``way`` mm further along x."""

    rigid: Any
    way: float

    def distance(self, points: np.ndarray) -> np.ndarray:
        return self.rigid.distance(self._back(points))

    def normal(self, points: np.ndarray) -> np.ndarray:
        return self.rigid.normal(self._back(points))

    def _back(self, points: np.ndarray) -> np.ndarray:
        return points - self.way * np.eye(points.shape[1])[0]


@law("all moved by 13 mm in x", SAME, SAME_WHY)
def moved(finger: Finger) -> float:
    """Mesh, plates and object elsewhere: nothing changes."""
    _, mesh, zone, own_model = _known(finger)
    design, way = finger.design, 13.0
    step = way * np.eye(mesh.dimension)[0]
    body = body_of(design, mesh, candidate_facets(mesh, zone.half_width, zone.half_depth))
    project = body.project
    mesh = replace(mesh, points=mesh.points + step)
    body = replace(body, mesh=mesh, project=lambda points: project(points - step) + step)
    frames = [replace(each, place=each.place + way) for each in plate_frames(design)]
    condensed = condense_body(body, [gage_rows(mesh, frames, design.gages, design.gage_weights)])
    model = reduced_model(
        condensed,
        gage_readout=condensed.readouts[0],
        point_readout=np.empty((0, len(condensed.compliance))),
        gage_positions=gage_positions(frames, design.gages),
        free_ends=free_ends(design.body, mesh),
        depth=design.body.depth_mm,
    )
    rigid = Moved(object_at_touch(finger.scene.object, design.body), way)
    problem = contact_problem(model, rigid, finger.scene.object.friction_coefficient)
    return difference(followed(finger, own_model), _along(problem, finger))


@law("rows in another order", SAME, f"one section is drawn of both; {SAME_WHY}")
def reordered(finger: Finger) -> float | None:
    """Each plate a row of its own, the last one first: the same, gages in that order."""
    frames = plate_frames(finger.design)
    if len(frames) < 2:
        return None
    keys = set(Row.model_fields)
    rows = []
    for row in finger.design.plates.all_rows:
        for place in range(row.count):
            pace = row.offset_mm + (place - 0.5 * (row.count - 1)) * row.pitch_mm
            own = {"count": 1, "offset_mm": pace, "stagger_mm": 0.0}
            own["span_offset_mm"] = frames[len(rows)].middle
            rows.append(row.model_dump(include=keys, exclude_none=True) | own)
    first, *others = rows[::-1]
    values = {f"plates.{key}": value for key, value in first.items()}
    found = solved(finger.with_design(values | {"plates.rows": others}))
    return difference(answer(finger), found._replace(strains=found.strains[:, ::-1]))


@law("no friction, no history", SAME, f"a row alone is one convex problem; {SAME_WHY}")
def without_history(finger: Finger) -> float:
    """Without friction, on one mesh, the last row's answer is that of the row alone."""
    rows = finger.scene.path.increments_mm
    smooth = finger.with_scene(object={"friction_coefficient": 0.0})
    alone = smooth.with_scene(path={"increments_mm": rows[-1:]})
    model = _known(finger).model
    return difference(_end(followed(smooth, model)), _end(followed(alone, model)), stick=0.0)


@law("friction to zero", 0.01, "answers are smooth in friction but where a node turns: rarely so")
def little_friction(finger: Finger) -> float:
    """On one mesh: a friction of 1e-5 changes half of what 2e-5 does, and none changes nothing."""
    model = _known(finger).model
    none, one, two = (
        followed(finger.with_scene(object={"friction_coefficient": mu}), model)
        for mu in (0.0, 1e-5, 2e-5)
    )
    changed = [Answer(*(a - b for a, b in zip(each, none, strict=True))) for each in (one, two)]
    twice_one = Answer(2.0 * changed[0].forces, none.stick, 2.0 * changed[0].strains)
    return difference(changed[1], twice_one, stick=0.0)


@law(
    "finer increments",
    0.004,
    "the contract's 0.4 %, on paths that never turn; strains to 2 %, on the facets in space to 5 %",
)
def finer(finger: Finger) -> float:
    """Pressed and sheared, never back: four increments a row, or eight; on one mesh.

    A node that sticks for a row and slips in its pieces is a hundredth of a coarse contact's
    force, and more of what the gage below it reads; the next halvings change less and less. (One of
    fifteen in space: 6.6, 3.8, 2.0, 0.8, 0.7 % of a gage from 2 increments a row to 64.)
    """
    rows, model = finger.scene.path.increments_mm[:3], _known(finger).model
    found = [
        followed(finger.with_scene(path={"increments_mm": rows, "substeps": pieces}), model)
        for pieces in (4, 8)
    ]
    strain = 0.004 / (0.02 if model.dimension == 2 else 0.05)
    return difference(_end(found[0]), _end(found[1]), stick=0.0, strain=strain)


def _end(found: Answer) -> Answer:
    """That of the last increment."""
    return Answer(*(each[-1:] for each in found))


@law("depth doubled", LIKE, f"per depth nothing changes; {LIKE_WHY}", ("plane-strain",))
def deeper(finger: Finger) -> float | None:
    """In plane strain: twice the forces, the same strains."""
    if not finger.design.extruded:
        return None
    deep = 2.0 * finger.design.body.depth_mm
    found = solved(finger.with_design({"body.depth_mm": deep, "plates.span_mm": None}))
    return difference(answer(finger), found._replace(forces=found.forces / 2.0))


@law("depth doubled, with ends", 0.0, "the least energy: less is free in the deeper one", ("3d",))
def deeper_with_ends(finger: Finger) -> float | None:
    """At least as stiff as two, and no stiffer than plane strain: pressed, without friction."""
    if not finger.design.extruded:
        return None
    rows = [[row[0], 0.0] for row in finger.scene.path.increments_mm[:2]]
    finger = finger.with_scene(object={"friction_coefficient": 0.0}, path={"increments_mm": rows})
    finger = finger.with_design({"mesh.layer_growth": 1.0, "plates.span_mm": None})
    depth, layers = finger.design.body.depth_mm, finger.design.mesh.layers
    twice = finger.with_design({"body.depth_mm": 2.0 * depth, "mesh.layers": 2 * layers})
    flat = replace(finger, fidelity="plane-strain")
    one, two, most = (solved(each).forces[:, 0] for each in (finger, twice, flat))
    return float(max((2.0 * one / two).max(), (two / (2.0 * most)).max()) - 1.0)


class Whole(Case):
    """A case that meshes the whole finger, though half of it would do."""

    symmetric = False


@law(
    "half and whole",
    1e-6,
    "one mesh mirrors the other, but two systems are solved; stick to 1 %",
    ("3d",),
)
def whole(finger: Finger) -> float | None:
    """Half a finger says all where design and scene mirror in z.

    Where between nodes stick ends is interpolated by a node's own compliance, which in a half is
    that of the node and its image together: a share of a facet.
    """
    if not finger.case.symmetric:
        return None
    case = finger.case
    found = run(Whole(**{each.name: getattr(case, each.name) for each in fields(case)})).result
    assert found.model.contact_nodes > _known(finger).model.nodes
    return difference(answer(finger), answer_of(found.increments), stick=SAME / 0.01)


@contextmanager
def _empty_cache() -> Iterator[Path]:
    """A cache folder of its own; that of before comes back."""
    before = os.environ.get("FINGERDESIGN_CACHE")
    with tempfile.TemporaryDirectory(prefix="fingerdesign-laws-") as folder:
        os.environ["FINGERDESIGN_CACHE"] = folder
        try:
            yield Path(folder)
        finally:
            os.environ.pop("FINGERDESIGN_CACHE")
            os.environ.update({} if before is None else {"FINGERDESIGN_CACHE": before})


@law("cached and fresh", 0.0, "nothing depends on a cache, on chance or on threads: not a bit")
def cached(finger: Finger) -> float:
    """With nothing cached; with the answer cached; with mesh and model cached; run again."""
    with _empty_cache() as folder, tempfile.TemporaryDirectory() as out:

        def made() -> Any:
            return analyse_into(finger.case, Path(out), page=False, cad=False).increments

        found = [made(), made()]
        shutil.rmtree(folder / "answers", ignore_errors=True)  # what was quick is not stored
        found.append(made())
    found.append(run(finger.case).result.increments)
    return float(any(each != found[0] for each in found))
