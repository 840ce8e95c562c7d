"""The small model that hundreds of grips run on, condensed once, and its error.

Below some 150 contact nodes a control step costs what its Python costs, so the contact is meshed
for grips with :data:`CONTACT_SIZE_MM` at the crest. On ``sensitive``, compared with 0.05 mm, over a
lift's path at mu = 0.2, 0.5 and 0.8: forces to 1e-4, stick ratio 0.006 RMS (at most 0.034, where
the contact has a few nodes), readings 0.35 microstrain RMS; with 0.15 mm 0.009, 0.041 and 0.7. Of
16 grips by the paper's rule and 16 at a fixed ratio none ended otherwise than with 0.05 mm, in half
the time; with 0.15 mm two did.

Away from contact and plates the section coarsens by :data:`GRADATION`: readings change by 0.3 % of
the largest, and a variant of a study costs a third less.

In 3-D a finger that can be swept is meshed in layers of prisms: :data:`LAYERS` of them in half its
depth, more if it is deeper than 13 mm. Over eight states of approach and shear at mu = 0.5, against
seven layers of a finer section (158k equations), ``maeno2000`` has with four even layers (83k
equations, 56 Gflop) forces to 0.1 %, the stick ratio to 0.012, the mean of both faces to 1.9 % and
one face to 4.4 % of each state's largest reading; with three (29 Gflop) 0.2 %, 0.063, 2.1 and 8.2
%. Layers that are thinnest in the middle (0.75) leave 0.063 in the stick ratio: thick layers at the
free end are to blame.

Variants of a study, and fingers of a training, whose gages are read on both faces have three
layers, each 1.3 times the next one to the free end: :data:`FEWER_LAYERS`, in 0.55 of the time.
Against eight layers and contact of 0.3 mm they leave on ``maeno2000``, ``tees``, ``film_tees`` and
``sensitive``, along the fundamental case, as four even ones do, forces off by 0.3 %, the stick
ratio by 0.017, 0.028, 0.036, 0.037 (four: 0.015, 0.027, 0.036, 0.035), and means of both faces by
0.9 to 1.6 % (0.5 to 1.2). One face of ``maeno2000``, with plates of bronze, is off by 16 % (6). An
estimator of ``film_tees`` that learns from 1440 grips of 24 such fingers errs, on 480 grips of 8
fingers of four layers, by 0.117 in the friction utilisation and 0.145 in the stick ratio; one that
learns from fingers of four layers by 0.116 and 0.147.
"""

import math
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace
from typing import Any

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.forecast.forecast import forecast_case, stage_seconds
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.path import object_at_touch, touch_point
from fingerdesign.analysis.stages import condense, make_mesh
from fingerdesign.checks.load import with_values, without_plates
from fingerdesign.contact.problem import ContactProblem, contact_problem
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.fem.model import ContactOf, FiniteElementModel, reduced_onto
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone, candidate_zone
from fingerdesign.mesh.make import mesher_name
from fingerdesign.mesh.moved import with_plates_moved
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.plates import extruded_sizes
from fingerdesign.mesh.types import Mesh
from fingerdesign.reduced import ReducedModel
from fingerdesign.runtime.machine import this_machine

CONTACT_SIZE_MM = {"plane-strain": 0.1, "3d": 0.4}
GRADATION = 0.4
LAYERS, LAYERS_PER_MM, LAYER_GROWTH = 4, 0.6, 1.0  # The least number, in half the depth.
EVEN_LAYERS = LAYERS, LAYERS_PER_MM, LAYER_GROWTH
FEWER_LAYERS = 3, 0.45, 1.3  # The same where many fingers are condensed.
MESHED = (CONTACT_SIZE_MM, GRADATION, LAYERS, LAYERS_PER_MM, LAYER_GROWTH)
FIDELITIES = tuple(CONTACT_SIZE_MM)
_ROOM = 1.2  # A hanging object drags the contact beyond the zone of a pure approach.


def grip_problem(
    design: Design,
    fidelity: str = "plane-strain",
    report: Callable[[str], None] = lambda message: None,
    whole: bool = False,
) -> ContactProblem:
    """Pose the design against a plane, for the stage travel of its ``[grip]`` table.

    Its gages are those of the array that the slip rule reads; the friction is the bench's. The
    contact is no finer than :data:`CONTACT_SIZE_MM`. whole: not the half alone where the finger
    mirrors in z = 0. Raises DesignError where the design cannot be gripped with or, in plane
    strain, has no section.
    """
    case = gripped_case(design, fidelity)
    return _condensed(case, case.gage_array, report, whole)


def gripped_case(design: Design, fidelity: str) -> Case:
    """The design as grips use it. DesignError where they cannot; see grip_problem."""
    if design.plates.number < 2:
        remedy = "add plates: without gages there is nothing to measure"
        raise DesignError([Fault("plates.count", design.plates.number, "at least 2", remedy)])
    case = _case(design, fidelity)
    refuse(case, fundamental_scene())
    return case


@dataclass(frozen=True)
class BenchFinger:
    """A finger on its bench, with contact nodes for the objects that it will grip.

    fixed_keys: see meshed_for_grips. neighbour: a finger of the same body with other places of its
    flat plates. Its mesh is used and the plates in it are moved, so that both fingers compare
    without the difference of two meshes. plate_end: of the usual size of a swept section's elements
    at the plates' ends. layered: as for meshed_for_grips.
    """

    design: Design
    objects: tuple[SceneObject, ...]
    fidelity: str
    fixed_keys: Collection[str] = ()
    neighbour: Design | None = None
    plate_end: float = 1.0
    layered: tuple[int, float, float] = EVEN_LAYERS

    def _meshed(self) -> tuple[Case, Zone, Mesh]:
        case, mesh = _case(self.design, self.fidelity, self.fixed_keys, self.layered), None
        zone = _zone_of(case, self.objects)
        if self.neighbour is not None:
            near = _case(self.neighbour, self.fidelity, self.fixed_keys, self.layered)
            mesh = _mesh_of(near, zone, plate_end=self.plate_end)
            mesh = with_plates_moved(mesh, plate_frames(near.design), plate_frames(case.design))
        if mesh is None:
            mesh = _mesh_of(case, zone, plate_end=self.plate_end)
        return case, zone, mesh

    def model(self) -> tuple[FiniteElementModel, ContactProblem]:
        """Condense the finger, and pose it against the plane of its bench."""
        case, zone, mesh = self._meshed()
        return _posed(case, zone, mesh, case.gage_array)

    def onto(self, fine: ContactOf) -> ReducedModel:
        """Condense the finger onto the contact nodes of another mesh; both are swept."""
        case, _, mesh = self._meshed()
        return reduced_onto(case.design, mesh, fine).with_gages(case.gage_array)


def against_plane(model: ReducedModel, design: Design) -> ContactProblem:
    """Pose a finger against the fundamental scene's plane, with the bench's friction."""
    rigid = object_at_touch(fundamental_scene().object, design.body)
    return contact_problem(model, rigid, design.grip.bench_friction_coefficient)


def against(bench: ContactProblem, met: SceneObject, design: Design) -> ContactProblem:
    """Pose the bench's finger against another object; nothing is condensed again."""
    rigid = object_at_touch(met, design.body)
    return contact_problem(bench.model, rigid, bench.friction_coefficient)


def opposite_problem(
    design: Design,
    fidelity: str = "plane-strain",
    report: Callable[[str], None] = lambda message: None,
) -> ContactProblem | None:
    """The other finger of a lift where ``grip.opposite`` is the bare one; None: a mirror image."""
    if design.grip.opposite != "bare":
        return None
    return _condensed(_case(without_plates(design), fidelity), (), report)


def model_data(problem: ContactProblem) -> dict[str, Any]:
    """Facts about the model of grips, for records."""
    fidelity = "plane-strain" if problem.model.dimension == 2 else "3d"
    size, nodes = CONTACT_SIZE_MM[fidelity], problem.model.nodes
    return {"fidelity": fidelity, "contact_size_mm": size, "contact_nodes": nodes}


def meshed_for_grips(
    design: Design,
    fidelity: str,
    contact_size_mm: float | None = None,
    fixed_keys: Collection[str] = (),
    layered: tuple[int, float, float] = EVEN_LAYERS,
) -> Design:
    """The design as grips use it: coarser, and swept in layers where it can be.

    Its mesh is no finer than its own file requests; ``fixed_keys`` keep the file's values. layered:
    the layers that are enough, their least number, number in a mm of half the depth, and growth.
    """
    size = CONTACT_SIZE_MM.get(fidelity, 0.0) if contact_size_mm is None else contact_size_mm
    mesh = design.mesh
    coarse: dict[str, object] = {"mesh.section.gradation": max(GRADATION, mesh.section.gradation)}
    if fidelity == "3d":
        coarse["mesh.contact_size_mm"] = max(size, mesh.contact_size_mm)
        least, per_mm, growth = layered
        layers = max(least, math.ceil(per_mm * 0.5 * design.body.depth_mm))
        own = "mesh.layers" in fixed_keys or (mesh.layers or math.inf) <= layers
        coarse["mesh.layers"] = mesh.layers if own else layers
        even = own or growth <= LAYER_GROWTH
        coarse["mesh.layer_growth"] = min(LAYER_GROWTH, mesh.layer_growth) if even else growth
        if mesh.mesher == "tetwild":
            coarse["mesh.mesher"] = "auto"
    else:
        coarse["mesh.section.contact_size_mm"] = max(size, mesh.section.contact_size_mm)
    return with_values(design, {key: v for key, v in coarse.items() if key not in fixed_keys})


def layers_for_many(design: Design) -> tuple[int, float, float]:
    """Layers that are enough where many fingers like this one are condensed."""
    return FEWER_LAYERS if design.gages.face == "both" else EVEN_LAYERS


def seconds_of_many(design: Design, fidelity: str) -> float:
    """Forecast of the seconds in which one core makes the model of one finger of many."""
    machine = this_machine()
    one_core = replace(machine, all_cores=machine.one_core)
    case = _case(design, fidelity, layered=layers_for_many(design))
    # The design's own mesh may be in the cache; those of the others are not.
    counts = replace(forecast_case(case, one_core), mesh_kept=False)
    seconds = stage_seconds(counts, case, one_core)
    return seconds["mesh"] + seconds["assemble"] + seconds["condense"]


def _case(
    design: Design,
    fidelity: str,
    fixed_keys: Collection[str] = (),
    layered: tuple[int, float, float] = EVEN_LAYERS,
) -> Case:
    design = meshed_for_grips(design, fidelity, fixed_keys=fixed_keys, layered=layered)
    return Case(design, None, fidelity, fields=False, go_on=True)


def _mesh_of(case: Case, zone: Zone, whole: bool = False, plate_end: float = 1.0) -> Mesh:
    """The mesh of a case's half where it mirrors, or of the whole finger."""
    design, symmetric = case.design, case.symmetric and not whole
    if plate_end == 1.0 or case.fidelity != "3d" or mesher_name(design) != "sweep":
        return make_mesh(design, case.fidelity, zone, symmetric)
    sizes = extruded_sizes(design, zone.half_width)
    end = plate_end * sizes.plate_end_size_mm
    sizes = sizes.model_copy(update={"plate_end_size_mm": end})
    return extrude(design, zone, symmetric, sizes)


def _condensed(
    case: Case, gages: tuple[int, ...], report: Callable[[str], None], whole: bool = False
) -> ContactProblem:
    zone = _zone_of(case)
    report("meshing")
    mesh = _mesh_of(case, zone, whole)
    report(f"condensing {len(mesh.cells)} elements")
    return _posed(case, zone, mesh, gages)[1]


def _zone_of(case: Case, objects: Iterable[SceneObject] = ()) -> Zone:
    """The zone that covers the fundamental scene's plane and each of ``objects``."""
    design, reach = case.design, case.design.grip.max_approach_mm
    zones = [candidate_zone(design, fundamental_scene().object, reach)]
    zones += [candidate_zone(design, o, reach, touch_point(o, design.body)) for o in objects]
    return max(zones, key=lambda each: each.half_width).widened(_ROOM, design)


def _posed(
    case: Case, zone: Zone, mesh: Mesh, gages: tuple[int, ...]
) -> tuple[FiniteElementModel, ContactProblem]:
    """Condense a mesh, and pose it against the fundamental scene's plane."""
    model = condense(case.design, mesh, zone, fundamental_scene())
    return model, against_plane(model.reduced.with_gages(gages), case.design)
