"""Finite strain beside GetFEM: one mesh, a neo-Hookean finger under a plane, pressed and pulled."""

import time
from collections.abc import Sequence

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.finite_path import finite_steps
from fingerdesign.analysis.path import problem_at_touch, targets
from fingerdesign.analysis.stages import condense, make_mesh, one_thread, zone_of
from fingerdesign.arrays import Array
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.contact.path import Step, follow
from fingerdesign.design.io import parse_scene
from fingerdesign.fem.finite.gage_lines import gage_lines
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.rows import plate_frames
from fingerdesign_bench.speed.peers import MESHES, Row, work

_DEEP = 0.12  # of the crest's height: small strain is off by a tenth there
_ROWS = 6  # pressing, and as many pulling
_PULL = 0.5  # of the depth
_FRICTION = 0.5


def finite_row() -> Row:
    """Ours and GetFEM's: processor seconds of the path, largest differences of the forces and of
    one gage (the mean of its faces, by the elongation of its lines), of each one's largest; and
    what small strain on the mesh is off by."""
    values = {"mesh.element": "P2", "plates.count": 1, **MESHES["3d"]}
    design = with_values(load_design("maeno2000"), values)
    deep = _DEEP * float(crest_height(design.body))
    shares = [k / _ROWS for k in range(1, _ROWS + 1)]
    path = [[deep * each, 0.0] for each in shares]
    path += [[deep, _PULL * deep * each] for each in shares]
    object_line = f"[object]\nfriction_coefficient = {_FRICTION}\n"
    scene = parse_scene(f"{object_line}[path]\nincrements_mm = {path}\n")
    zone = zone_of(Case(design, scene, "finite"), scene)
    mesh = make_mesh(design, "finite", zone)
    model = condense(design, mesh, zone, scene)
    begin = time.process_time()
    steps = finite_steps(design, model.condensed, scene)
    ours = time.process_time() - begin
    with one_thread():
        problem = problem_at_touch(model.reduced, scene.object, design.body)
        small = list(follow(problem, targets(scene.path)))
    lines = gage_lines(mesh, plate_frames(design), design.gages, (1.0, 0.0))
    inside = lines.parts[0].places.copy()
    inside[:, 2] = np.abs(inside[:, 2])  # half of the finger: the other half mirrors
    body = model.condensed.body
    given = {key: getattr(body, key) for key in ("fixed", "contact", "thickness")}
    given |= {"points": mesh.points, "cells": mesh.cells, "friction": _FRICTION, "finite": True}
    given |= {"young": body.youngs_modulus, "poisson": body.poissons_ratio}
    given |= {"crest": crest_height(design.body), "path": np.array(path), "points_read": inside}
    answer = work("full", given)
    mine, linear = _forces(steps), _forces(small)
    read = np.array([each.measures.gages.mean() for each in steps])
    other = np.array([lines.parts[0].elongation(each).mean() for each in answer["moved"]])
    return {
        "problem": f"1 plate, {model.dofs} dofs, {_DEEP:.0%} deep",
        "theirs s": float(answer["seconds"].sum()),
        "ours s": ours,
        "ratio": float(answer["seconds"].sum()) / ours,
        "failed": f"{int((~answer['converged']).sum())} of {len(path)}",
        **_apart("", answer["forces"], mine),
        "gage": float(np.abs(other - read).max() / np.abs(read).max()),
        **_apart("small strain: ", linear, mine),
    }


def _forces(steps: Sequence[Step]) -> Array:
    """On the modelled half (rows, 3), N."""
    return np.array([step.increment.force.sum(axis=0) for step in steps])


def _apart(what: str, found: Array, own: Array) -> Row:
    """Largest difference of the forces, of their own largest."""
    share = np.abs(found - own).max(axis=0) / np.abs(own).max(axis=0)
    return {f"{what}normal": float(share[1]), f"{what}tangential": float(share[0])}
