"""The model that contact sees, of a condensed body and its readouts."""

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.body import CondensedBody, condense_body
from fingerdesign.fem.system import Body
from fingerdesign.fem.trace import ContactTrace
from fingerdesign.mesh.cells import facet_kind
from fingerdesign.reduced import ReducedModel

# The least fraction of a contact force that a body loses if it can still move as a whole.
_NOT_FIXED = 0.1
# Support against contact force: rounding leaves 1e-10 to 2e-8 (plates 27,000 times stiffer than the
# body); a model that loses force is wrong in the first digits.
_BALANCE = 1e-6


def body_model(body: Body) -> ReducedModel:
    """The reduced model of a body without plates or gages."""
    return reduced_model(condense_body(body))


def reduced_model(
    condensed: CondensedBody,
    gage_readout: Array | None = None,
    point_readout: Array | None = None,
    gage_positions: Array | None = None,
    gage_x: Array | None = None,
    free_ends: tuple[float, float] | None = None,
    depth: float | None = None,
    load_gage_strain: Array | None = None,
) -> ReducedModel:
    """Build the model that contact sees, from a condensed body and its readouts.

    gage_positions (plates, 3): the gages' centres, mm; gage_x (plates,): their places along x, NaN
    for none (None: all their x); free_ends: z (mm) below the first and above
    the second of which nodes count as at a free end (None: nowhere); depth: mm, for plane strain
    the thickness by default, in 3-D the extent in z; load_gage_strain (plates, 2): strains under
    the body's own loads. Raises SolverError where the supports do not carry every contact force.
    """
    body, trace = condensed.body, condensed.trace
    mesh, nodes = body.mesh, len(trace.nodes)
    where = mesh.points[trace.nodes]
    locked = body.fixed.reshape(mesh.points.shape)[trace.nodes]  # these cannot move
    if locked.all():
        raise SolverError("every contact node is fixed: none can yield to a contact force")
    compliance = condensed.compliance.copy()
    decouple(compliance, locked.reshape(-1))
    check_balance(condensed.reaction, locked, nodes)
    factor = 2 if mesh.symmetric else 1
    if depth is None:
        depth = body.thickness if mesh.dimension == 2 else factor * float(np.ptp(mesh.points[:, 2]))
    ends = np.zeros(nodes, dtype=bool)
    if free_ends is not None and mesh.dimension == 3:
        ends = (where[:, 2] < free_ends[0]) | (where[:, 2] > free_ends[1])
    gages = np.empty((0, 3)) if gage_positions is None else gage_positions
    none = np.empty((0, where.size))
    moved = condensed.load_displacement
    return ReducedModel(
        points=where,
        facets=trace.facets,
        facet_areas=trace.facet_areas,
        areas=trace.areas,
        compliance=compliance,
        gage_readout=none if gage_readout is None else gage_readout,
        point_readout=none if point_readout is None else point_readout,
        reaction_readout=condensed.reaction,
        surface=trace.surface,
        rim=_rim(body, trace),
        free_end=ends,
        locked=locked,
        depth=depth,
        symmetry_factor=factor,
        gage_x=gages[:, 0] if gage_x is None else gage_x,
        gage_positions=gages,
        load_displacement=None if moved is None else moved.reshape(where.shape),
        load_gage_strain=load_gage_strain,
    )


def decouple(compliance: Array, locked: BoolArray) -> None:
    """Give locked components a compliance of their own, so that their force comes out zero."""
    compliance[locked] = 0.0
    compliance[:, locked] = 0.0
    index = np.flatnonzero(locked)
    compliance[index, index] = np.diag(compliance)[~locked].mean()


def check_balance(reaction: Array, locked: BoolArray, nodes: int) -> None:
    """Check that the supports carry every unit contact force (of free components)."""
    expected = -np.tile(np.eye(reaction.shape[0]), nodes)
    free = ~locked.reshape(-1)
    error = float(np.abs(reaction - expected)[:, free].max())
    if error > _NOT_FIXED:
        raise SolverError(
            "the body can move as a whole: its supports do not carry the contact forces; "
            "fix more of it"
        )
    if not error < _BALANCE:
        raise SolverError(
            f"the condensed model loses {error:.1e} of each contact force: stiffnesses or lengths "
            "differ by more than double precision can carry; bring the moduli closer together or "
            "the body's height closer to its width"
        )


def _rim(body: Body, trace: ContactTrace) -> BoolArray:
    """Nodes that also belong to contact facets of the mesh outside the candidates."""
    mesh = body.mesh
    corners = facet_kind(body.contact).corners
    facets = mesh.facets.get("contact", body.contact)
    count_all, count_zone = (
        np.bincount(each[:, :corners].ravel(), minlength=len(mesh.points))
        for each in (facets, body.contact)
    )
    return np.asarray((count_all > count_zone)[trace.nodes])
