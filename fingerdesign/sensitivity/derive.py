"""The derivatives of an analysed path with respect to any of its numbers.

    found = sensitivity("maeno2000", "pull", ["placement[7].y_mm", "object.friction_coefficient"])
    found.reading[3, 7]      # of gage 7 at row 3, microstrain per mm and per unit of friction

One analysis, one field of each contact dof and gage, and no solve per parameter.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.linalg import svd

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.fidelity.readings import MICRO, Readings, readings_of
from fingerdesign.analysis.forecast.forecast import impossible
from fingerdesign.analysis.path import follow_path, problem_at_touch
from fingerdesign.analysis.stages import condense, in_wide_zone, make_mesh, zone_of
from fingerdesign.arrays import Array, IntArray
from fingerdesign.checks.load import load_design
from fingerdesign.contact.increment import Increment
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import load_scene
from fingerdesign.errors import DesignError, Fault
from fingerdesign.fem.model import FiniteElementModel
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.moved import plate_weights
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensitivity.areas import OwnRates, area_rates, border_pairs, on_corner
from fingerdesign.sensitivity.change import Change
from fingerdesign.sensitivity.model import ResponseFields
from fingerdesign.sensitivity.parts import change_of, rows_of_plates
from fingerdesign.sensitivity.path import near_nodes, needed_dofs, path_rates
from fingerdesign.sensitivity.variant import Parameter, parameters_of
from fingerdesign.sensitivity.velocity import immovable_faults

_GIVEN_FORCE = Fault("path.control", "'force'", "motion", "give the motions that forces lead to")
_RANK = 1e-13  # Of the largest singular value: smaller parts of the forces are rounding.


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of k rows with P parameters, per unit of each (mm, degrees, MPa, 1).

    names (P,), values (P,); readings: the rows themselves; normal_force, tangential_force (k, P)
    N; stick_ratio (k, P), NaN without contact; gages (k, plates, 2, P): upper and lower face,
    microstrain. on_kink (k,): the greatest share of the normal force, up to each row, that stands
    on nodes between two statuses, where the derivative has two sides and this is one; or in this
    row on nodes without a tangential force at the border of stick, where the stick ratio's has.
    """

    names: tuple[str, ...]
    values: Array
    readings: Readings
    normal_force: Array
    tangential_force: Array
    stick_ratio: Array
    gages: Array
    on_kink: Array

    @property
    def reading(self) -> Array:
        """Derivatives (k, plates, P) of what ``gages.face`` reads, microstrain."""
        return face_mean(self.gages, self.readings.face)


def face_mean(gages: Array, face: str) -> Array:
    """Readings (k, plates, P) from both faces (k, plates, 2, P): one, or their mean."""
    one = {"upper": 0, "lower": 1}.get(face)
    return np.asarray(gages.mean(axis=2) if one is None else gages[:, :, one])


def sensitivity(
    design: Design | str | Path,
    scene: Scene | str | Path | None,
    parameters: Sequence[str],
    fidelity: str = "3d",
) -> Sensitivity:
    """Analyse a path and give the derivatives of its forces, stick ratios and gages.

    parameters: keys of body, plates, gages, materials and object, or places of plates
    (variant.py). Without a scene: the fundamental case. Raises DesignError for a wrong input or a
    parameter whose derivative is not known, SolverError where a row has no answer.
    """
    design = design if isinstance(design, Design) else load_design(design)
    scene = scene if isinstance(scene, Scene | None) else load_scene(scene)
    case = Case(design, scene, fidelity, grips=False, fields=False)
    own = case.path_scene if scene is None else scene
    wanted = _known_parameters(case, own, parameters)

    def work(zone: Zone) -> Sensitivity:
        mesh = make_mesh(design, fidelity, zone, case.symmetric)
        model = condense(design, mesh, zone, own)
        problem = problem_at_touch(model.reduced, own.object, design.body)
        with one_thread():
            steps = follow_path(problem, own, design)
        return derivatives(design, own, model, problem, steps, wanted)

    return in_wide_zone(design, zone_of(case, own), work)


def _known_parameters(case: Case, scene: Scene, names: Sequence[str]) -> list[Parameter]:
    """The parameters, by name. DesignError with every fault of case, scene and names."""
    faults, wanted = list[Fault](), list[Parameter]()
    if case.fidelity in ("plane-strain", "3d"):
        faults += impossible(case, scene)
    else:
        bound, remedy = "plane-strain or 3d", "derivatives are of one model at small strain"
        faults.append(Fault("fidelity", f"'{case.fidelity}'", bound, remedy))
    if not scene.object.law.is_coulomb:
        law, bound = scene.object.friction_law, "'coulomb': derivatives know no other law"
        remedy = "set object.friction_law = 'coulomb'"
        faults.append(Fault("object.friction_law", f"'{law}'", bound, remedy))
    if scene.path.control == "force":
        faults.append(_GIVEN_FORCE)
    if not names:
        faults.append(Fault("parameters", "none", "one or more", "name what varies"))
    try:
        wanted = parameters_of(case.design, scene, tuple(map(str, names)))
    except DesignError as error:
        faults += error.faults
    for each in wanted:
        faults += immovable_faults(each, 2 if case.fidelity == "plane-strain" else 3)
    if faults:
        raise DesignError(faults)
    return wanted


def derivatives(
    design: Design,
    scene: Scene,
    model: FiniteElementModel,
    problem: ContactProblem,
    steps: Sequence[Step],
    parameters: Sequence[Parameter],
    stick: bool = True,
) -> Sensitivity:
    """The derivatives of a path that was followed on a model; errors as of :func:`sensitivity`.

    stick: with those of the stick ratio; else NaN.
    """
    if scene.path.control == "force":
        raise DesignError([_GIVEN_FORCE])
    increments = [increment for step in steps for increment in step.row]
    nodes = near_nodes(problem, increments)
    if not len(nodes):
        bound = "motions that touch the finger"
        raise DesignError([Fault("path", "no contact", bound, "approach farther")])
    ends = np.cumsum([len(step.row) for step in steps]) - 1
    needed = needed_dofs(problem, increments, nodes)
    with ThreadPoolExecutor(1) as thread:  # PARDISO needs no Python
        here = copy_context().run  # with what the caller holds
        solved = thread.submit(here, ResponseFields, model.condensed, nodes, needed)
        changes = changes_of(design, model, parameters)
    fields = solved.result()
    found = IncrementRates(problem, fields, changes, increments, steps if stick else ())
    total, gages = found.at(ends)
    on_kink = np.maximum.accumulate(found.path.on_kink)[ends]
    return Sensitivity(
        names=tuple(parameter.name for parameter in parameters),
        values=np.array([parameter.value for parameter in parameters]),
        readings=readings_of(steps, design.gages.face),
        normal_force=-total[:, 1],
        tangential_force=total[:, 0],
        stick_ratio=found.stick_ratio() if stick else np.full(total[:, 0].shape, np.nan),
        gages=gages,
        on_kink=np.maximum(on_kink, on_corner(problem, steps)) if stick else on_kink,
    )


def changes_of(
    design: Design, model: FiniteElementModel, parameters: Sequence[Parameter]
) -> list[Change]:
    """The direct effects of parameters."""
    frames = parameters[0].at(0.0).frames if parameters else plate_frames(design)
    single = rows_of_plates(design, model.mesh, frames)
    weights = plate_weights(model.mesh, frames)
    return [change_of(each, model, single, weights) for each in parameters]


def rates_under(
    fields: ResponseFields,
    changes: Sequence[Change],
    increments: Sequence[Increment],
    pairs: tuple[Array, Array],
    rounding: float = _RANK,
) -> tuple[Array, Array]:
    """Rates (P, r, K) of what the model answers to the forces of increments, that stay as they are,
    and those (P, j) of pairs, see :meth:`ResponseFields.rates`. Forces are combined from a basis,
    to the fraction ``rounding`` of the largest."""
    forces = np.array([increment.force[fields.nodes].ravel() for increment in increments])
    left, sizes, right = svd(forces.T, full_matrices=False)
    rank = int((sizes > rounding * sizes.max(initial=0.0)).sum())
    basis, between = fields.rates(changes, left[:, :rank], pairs)
    return basis @ (sizes[:rank, None] * right[:rank]), between


class IncrementRates:
    """Rates of a path's increments with all parameters; fields: of the nodes that touch.

    steps: rows whose stick ratios are wanted; under: what :func:`rates_under` gives for the forces
    of these increments, where it is known; path: of the contact; explicit (K, n, dim, P): of local
    displacements under fixed forces; readings (P, K, 2 plates): of strains under them; frames (n,
    dim, dim, P).
    """

    def __init__(
        self,
        problem: ContactProblem,
        fields: ResponseFields,
        changes: Sequence[Change],
        increments: Sequence[Increment],
        steps: Sequence[Step] = (),
        under: tuple[Array, Array] | None = None,
    ) -> None:
        self._problem, self._fields, self._increments = problem, fields, increments
        self._changes, self._steps = changes, steps
        nodes = fields.nodes
        count, dim, size, past = len(nodes), problem.shape[1], len(changes), len(increments)
        self._pairs = border_pairs(problem, steps, nodes)
        if under is None:
            under = rates_under(fields, changes, increments, self._along_normals())
        rates, self._between = under
        free = ~problem.model.locked[nodes].reshape(-1)  # on the mirror plane z does not yield
        moved = rates[:, : fields.contact] * free[:, None]
        moved = moved.reshape(size, count, dim, past)
        self.readings = rates[:, fields.contact :].transpose(0, 2, 1).copy()
        self.explicit = np.einsum("nab,pnbk->knap", problem.frames[nodes], moved)
        del rates, under, moved  # as large as what stays
        self._compliance = fields.values[: fields.contact, : fields.contact]
        self.frames = np.zeros((count, dim, dim, size))
        amplitudes = np.array([increment.motion.amplitudes for increment in increments])
        for p, change in enumerate(changes):
            if (facing := change.facing) is not None:
                self.frames[..., p] = facing.frames[nodes]
                self.explicit[:, :, 0, p] += facing.gap[nodes]
                self.explicit[..., p] += np.tensordot(amplitudes, facing.modes[:, nodes], 1)
        turns = np.flatnonzero(self.frames.any(axis=(0, 1, 2)))
        if len(turns):
            self.explicit[..., turns] += self._turned(self.frames[..., turns])
        self._friction = np.array([change.friction for change in changes])
        self.path = path_rates(problem, increments, nodes, self.explicit, self._friction)

    def _turned(self, frames: Array) -> Array:
        """Rates (K, n, dim, P) of local displacements as the frames turn, and forces with them."""
        nodes, compliance = self._fields.nodes, self._compliance
        force = np.array([increment.force[nodes] for increment in self._increments])
        past, count, dim = force.shape
        yielded = (force.reshape(past, -1) @ compliance.T).reshape(force.shape)
        found = np.einsum("nabp,knb->knap", frames, yielded)
        local = np.array([increment.multiplier[nodes] for increment in self._increments])
        turned = np.einsum("nabp,kna->knbp", frames, local).reshape(past, count * dim, -1)
        back = (compliance @ turned).reshape(past, count, dim, -1)
        return np.asarray(found + np.einsum("nab,knbp->knap", self._problem.frames[nodes], back))

    def at(self, ends: IntArray) -> tuple[Array, Array]:
        """Rates of the whole finger's force (k, dim, P) N on it, less its sign along y, and of its
        gages (k, plates, 2, P) microstrain, at some increments."""
        problem, fields = self._problem, self._fields
        nodes, contact = fields.nodes, fields.contact
        force = np.einsum("nab,knap->knbp", problem.frames[nodes], self.path.multiplier[ends])
        for k, end in enumerate(ends):
            local = self._increments[end].multiplier[nodes]
            force[k] += np.einsum("nabp,na->nbp", self.frames, local)
        total = problem.model.symmetry_factor * force.sum(axis=1)
        flat = force.reshape(len(ends), contact, -1)
        strain = fields.values[contact:, :contact] @ flat
        strain += self.readings[:, ends].transpose(1, 2, 0)
        return total, MICRO * strain.reshape(len(ends), -1, 2, flat.shape[2])

    def stick_ratio(self) -> Array:
        """Rates (rows, P) of the stick ratio at each row's end, NaN without contact."""
        model, size = self._problem.model, len(self._changes)
        areas, facets = np.zeros((model.nodes, size)), np.zeros((len(model.facets), size))
        for p, change in enumerate(self._changes):
            if change.facing is not None:
                areas[:, p], facets[:, p] = change.facing.areas, change.facing.facet_areas
        own = OwnRates(self._pairs, self._by_pair(), areas, facets, self._friction)
        areas = area_rates(self._problem, self._steps, self.path, own)
        contact, stick = (
            np.array([getattr(step.measures, name) for step in self._steps])[:, None]
            for name in ("contact_area", "stick_area")
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray((areas[:, 1] - areas[:, 0] * (stick / contact)) / contact)

    def _along_normals(self) -> tuple[Array, Array]:
        """Unit normal forces (contact, pairs) on the first and on the second node of each pair."""
        normals = self._problem.frames[self._fields.nodes, 0]
        unit = np.zeros((2, *normals.shape, len(self._pairs[0])))
        for k, own in enumerate(self._pairs):
            unit[k, own, :, np.arange(len(own))] = normals[own]
        first, second = unit.reshape(2, self._fields.contact, -1)
        return first, second

    def _by_pair(self) -> Array:
        """Rates (pairs, P) of normal displacements of near nodes by normal forces on others."""
        found, (first, second) = self._between.T, self._pairs
        normals = self._problem.frames[self._fields.nodes, 0]
        crossed = self._compliance.reshape(*normals.shape, *normals.shape)
        for one, two in ((first, second), (second, first)):
            block = crossed[one, :, two]  # of the displacement of one by forces on two
            found = found + np.einsum("kbp,kbc,kc->kp", self.frames[one, 0], block, normals[two])
        return np.asarray(found)
