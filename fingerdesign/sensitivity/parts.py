"""From parameters to their direct effects on mesh, materials, gages and object."""

from dataclasses import replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from fingerdesign.analysis.path import object_at_touch
from fingerdesign.arrays import Array
from fingerdesign.contact.problem import local_frames, rigid_modes
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.fem.model import FiniteElementModel
from fingerdesign.fem.readout import gage_rows, pairing
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.fem.trace import contact_trace
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.surface import surface_of
from fingerdesign.mesh.types import Mesh
from fingerdesign.sensitivity.change import Change, Facing
from fingerdesign.sensitivity.variant import Parameter
from fingerdesign.sensitivity.velocity import is_rigid, node_velocity


def change_of(
    parameter: Parameter, model: FiniteElementModel, rows: sp.csr_matrix, weights: Array
) -> Change:
    """The direct effect of a parameter; rows: of :func:`rows_of_plates`; weights: plate_weights.

    DesignError where it is not known.
    """
    design = parameter.at(0.0).design
    body, mesh = model.condensed.body, model.mesh
    if body.element == "P1":
        bound, remedy = "known for quadratic elements", 'set mesh.element = "auto"'
        raise DesignError([Fault("mesh.element", "P1", bound, remedy)])
    if parameter.name == "object.friction_coefficient":
        return Change(parameter.name, friction=1.0)
    if parameter.kind == "materials":
        return _of_material(parameter, model)
    if parameter.name == "body.depth_mm" and mesh.dimension == 2:
        deep = 1.0 / design.body.depth_mm
        return Change(parameter.name, facing=_facing(parameter, model, None), stiffer=deep)
    velocity = node_velocity(parameter, mesh, weights) if parameter.kind != "object" else None
    gages = attached = None
    if parameter.kind in ("placement", "plates", "body", "gages"):
        turning = _turning(parameter, mesh)
        gages = _gage_rates(parameter, mesh, velocity, rows, turning)
        if body.attached is not None and turning is not None:  # bars turn with their plates
            half = _full(body.attached) @ turning
            attached = sp.csr_matrix(half + half.T)
    facing = None
    if parameter.kind in ("body", "object"):
        facing = _facing(parameter, model, velocity)
    some = None if velocity is None else sp.csr_matrix(velocity)  # mostly of one plate
    return Change(parameter.name, velocity=some, gages=gages, attached=attached, facing=facing)


def _of_material(parameter: Parameter, model: FiniteElementModel) -> Change:
    """Rates of both Lame parameters, and of the gages' weights where these depend on them.

    A material of most cells, as rubber is, makes the whole stiffer, and the few others softer in
    turn: of its own cells a part of the pressures at most is left.
    """
    design, _, frames = parameter.at(0.0)
    _, name, key = parameter.name.split(".")
    body, mesh = model.condensed.body, model.mesh
    young, nu = body.youngs_modulus, body.poissons_ratio
    if key == "youngs_modulus_MPa":  # relative growth of both, and of the first besides
        growth, more = 1.0 / young, np.zeros_like(young)
    elif key == "poissons_ratio":
        growth, more = -1.0 / (1.0 + nu), young / ((1.0 + nu) * (1.0 - 2.0 * nu) ** 2)
    else:
        bound, remedy = "youngs_modulus_MPa or poissons_ratio", "leave it out"
        raise DesignError([Fault("parameters", f"'{parameter.name}'", bound, remedy)])
    mine = np.zeros(len(mesh.cells))
    owners = {"elastomer": design.body, "plates": design.plates, "core": design.body.core}
    for part, owner in owners.items():
        if owner is not None and owner.material == name:
            mine[mesh.parts[part]] = 1.0
    if design.plates.model == "sheet" and design.plates.material == name and frames:
        bound, remedy = "a plate's material in solids", 'set plates.model = "solid"'
        raise DesignError([Fault("parameters", f"'{parameter.name}'", bound, remedy)])
    gages = None
    if key == "poissons_ratio" and design.plates.material == name and frames:
        weights = parameter.rate(lambda t: np.array(parameter.at(t).design.gage_weights))
        gages = gage_rows(mesh, frames, design.gages, (float(weights[0]), float(weights[1])))
    stiffer, attached, grown = 0.0, None, growth * mine
    if mine.mean() > 0.5:
        stiffer = float(growth[mine > 0.0][0])
        attached = None if body.attached is None else -stiffer * _full(body.attached)
        grown = -stiffer * (1.0 - mine)
    first, shear = lame_parameters(young, nu)
    moduli = np.array([grown * first + mine * more, grown * shear])
    return Change(parameter.name, moduli=moduli, gages=gages, attached=attached, stiffer=stiffer)


def rows_of_plates(design: Design, mesh: Mesh, frames: tuple[PlateFrame, ...]) -> sp.csr_matrix:
    """Gage rows (2 plates, n dim) plate by plate, also where the bridges have two plates each."""
    gages = design.gages
    if gages.grid == "double_axial":
        gages = gages.model_copy(update={"grid": "axial"})
    return gage_rows(mesh, frames, gages, design.gage_weights)


def _gage_rates(
    parameter: Parameter,
    mesh: Mesh,
    velocity: Array | None,
    own_rows: sp.csr_matrix,
    turning: sp.csr_matrix | None,
) -> sp.csr_matrix | None:
    """Rates of the gage rows: turned with plates that move as rigid bodies, else differences."""
    design, _, frames = parameter.at(0.0)
    if not frames:
        return None
    if is_rigid(parameter, mesh.dimension):
        if turning is None:
            return None
        found = own_rows @ turning
        pairs = pairing(frames, design.gages)
        return sp.csr_matrix(found if pairs is None else pairs @ found)

    def rows(change: float) -> sp.csr_matrix:
        varied = parameter.at(change)
        points = mesh.points if velocity is None else mesh.points + change * velocity
        own = varied.design
        return gage_rows(replace(mesh, points=points), varied.frames, own.gages, own.gage_weights)

    return sp.csr_matrix(parameter.rate(rows))


def _turning(parameter: Parameter, mesh: Mesh) -> sp.csr_matrix | None:
    """Matrix (n dim, n dim): rows of plates times it are the rates of rows that turn with them;
    None where no plate turns."""

    def angles(change: float) -> Array:
        return np.radians([frame.angle_deg for frame in parameter.at(change).frames])

    spins, rates = np.zeros(len(mesh.points)), parameter.rate(angles)
    if not rates.any():
        return None
    for frame, spin in zip(parameter.at(0.0).frames, rates, strict=True):
        spins[mesh.cells[mesh.regions == frame.index + 1]] = spin
    turn = np.zeros((mesh.dimension, mesh.dimension))
    turn[0, 1], turn[1, 0] = 1.0, -1.0  # rows times this: vectors turned anticlockwise
    return sp.csr_matrix(sp.kron(sp.diags_array(spins), turn))


def _full(upper: sp.csr_matrix) -> sp.csr_matrix:
    return sp.csr_matrix(upper + upper.T - sp.diags_array(upper.diagonal()))


def _facing(parameter: Parameter, model: FiniteElementModel, velocity: Array | None) -> Facing:
    """Rates of trace, gap and frames, by differences of their closed forms."""
    reduced, body, mesh = model.reduced, model.condensed.body, model.mesh

    def parts(change: float) -> list[Any]:
        design, scene, _ = parameter.at(change)
        points = mesh.points if velocity is None else mesh.points + change * velocity
        depth = design.body.depth_mm if mesh.dimension == 2 else 1.0
        trace = contact_trace(points, body.contact, depth)
        surface = replace(
            trace.surface, points=surface_of(design.body).project(trace.surface.points)
        )
        rigid = object_at_touch(scene.object, design.body)
        gap = surface.mean(rigid.distance(surface.points), reduced.nodes)
        moved = replace(reduced, points=points[trace.nodes])
        frames = local_frames(rigid.normal(moved.points))
        modes = np.einsum("mab,kmb->kma", frames, rigid_modes(moved))
        return [gap, frames, modes, trace.areas, trace.facet_areas, trace.operator]

    *rates, trace = parameter.rates(parts)
    return Facing(None if velocity is None else sp.csr_matrix(trace), *rates)
