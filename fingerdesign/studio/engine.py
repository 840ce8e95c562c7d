"""From a design and a press to numbers: cached condensed sections, and 3-D in another process.

The studio's section is coarser than an analysis's: edges of twice the length at the contact and
three times along plates, which leaves a sixth of the triangles. On the paper's finger forces then
differ by less than 1 %, the stick ratio by 0.003 and the gages' change by the shear by 0.8 % of the
largest (docs/how_to/studio.md).
"""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from fingerdesign.analysis.path import problem_at_touch
from fingerdesign.analysis.stages import condense, in_wide_zone, make_mesh
from fingerdesign.checks.meshing import plane_strain_faults
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.fem.model import build_model
from fingerdesign.layout.rows import mirrors_in_z
from fingerdesign.layout.zone import Zone, candidate_zone
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.model import meshed_for_grips
from fingerdesign.studio.numbers import Numbers, numbers_of
from fingerdesign.studio.sliders import Press

CACHED = 40  # condensed sections; each under a MB
# Longer edges than the design's own section has, and how much faster they grow.
COARSER = {
    "contact_size_mm": 2.0,
    "plate_size_mm": 3.0,
    "plate_end_size_mm": 2.7,
    "far_size_mm": 4.0,
    "gradation": 1.4,
}
_LARGEST = {"far_size_mm": 100.0, "gradation": 2.0}


def coarse(design: Design) -> Design:
    """The same finger with the studio's section."""
    own = design.mesh.section
    sizes = {
        name: min(factor * getattr(own, name), _LARGEST.get(name, 50.0))
        for name, factor in COARSER.items()
    }
    mesh = design.mesh.model_copy(update={"section": SectionMesh(**sizes)})
    return design.model_copy(update={"mesh": mesh})


def flat_scene(press: Press) -> Scene:
    """The object: a plane, at the press's friction."""
    path = {"increments_mm": [(press.approach or 1e-3, press.shear)]}
    rigid = {"friction_coefficient": press.friction}
    return Scene.model_validate({"object": rigid, "path": path})


def _answer(
    design: Design, press: Press, reach: float, condensed: Callable[[Zone], ContactProblem]
) -> Numbers:
    """The numbers of a finger that is condensed in a zone for all approaches to ``reach`` (mm)."""

    def work(zone: Zone) -> Numbers:
        problem = condensed(zone)
        with one_thread():
            return numbers_of(design, problem, press)

    return in_wide_zone(design, candidate_zone(design, flat_scene(press).object, reach), work)


@dataclass
class Engine:
    """Plane strain at once, from cached sections; for one thread.

    reach: the largest approach of the slider, mm. condensed: number of condensations.
    """

    reach: float
    condensed: int = 0
    _cache: OrderedDict[str, ContactProblem] = field(default_factory=OrderedDict)

    def numbers(self, design: Design, press: Press) -> Numbers:
        """The answer in plane strain. Raises DesignError where the design has no such section,
        MeshError or SolverError where the work fails."""
        if faults := plane_strain_faults(design):
            raise DesignError(faults, design.design.name)

        with one_thread():
            return _answer(design, press, self.reach, partial(self._problem, design, press))

    def _problem(self, design: Design, press: Press, zone: Zone) -> ContactProblem:
        """The condensed section, made where it is not cached; friction comes from the press."""
        shape = design.model_copy(update={"grip": type(design.grip)()})
        name = f"{shape.digest()} {zone}"
        if name not in self._cache:
            scene, chosen = flat_scene(press), coarse(design)
            mesh = make_mesh(chosen, "plane-strain", zone)
            reduced = build_model(chosen, mesh, zone.half_width, np.empty((0, 3))).reduced
            self._cache[name] = problem_at_touch(reduced, scene.object, chosen.body)
            self.condensed += 1
            while len(self._cache) > CACHED:
                self._cache.popitem(last=False)
        self._cache.move_to_end(name)
        return self._cache[name]


def numbers_in_3d(design: Design, press: Press, reach: float) -> Numbers:
    """The answer in 3-D, by the mesh of grips; meshes and models are cached on disk."""
    design, scene = meshed_for_grips(design, "3d"), flat_scene(press)

    def condensed(zone: Zone) -> ContactProblem:
        mesh = make_mesh(design, "3d", zone, mirrors_in_z(design))
        model = condense(design, mesh, zone, scene).reduced
        return problem_at_touch(model, scene.object, design.body)

    return _answer(design, press, reach, condensed)
