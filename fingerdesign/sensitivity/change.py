"""The direct effect of one parameter on mesh, materials, readouts, object: all rates per unit."""

from dataclasses import dataclass

import scipy.sparse as sp

from fingerdesign.arrays import Array


@dataclass(frozen=True)
class Facing:
    """Rates of what faces the object, at the m contact nodes.

    trace (m dim, n dim) of the contact trace, None where no contact node moves; gap (m,) mm;
    frames (m, dim, dim); modes (5, m, dim); areas (m,), facet_areas (f,) mm^2.
    """

    trace: sp.csr_matrix | None
    gap: Array
    frames: Array
    modes: Array
    areas: Array
    facet_areas: Array


@dataclass(frozen=True)
class Change:
    """Rates of a model's parts with one parameter; None and 0: the part does not change.

    velocity (n, dim) of the mesh's nodes, mm; moduli (2, c): of both Lame parameters of each cell,
    MPa; gages (2 plates, n dim) of the gage rows, 1/mm; attached (n dim, n dim) of leads and gages
    as bars, N/mm; facing; friction: of the coefficient; stiffer: of the whole stiffness, relative
    to it, before the changes of its parts.
    """

    name: str
    velocity: sp.csr_matrix | None = None
    moduli: Array | None = None
    gages: sp.csr_matrix | None = None
    attached: sp.csr_matrix | None = None
    facing: Facing | None = None
    friction: float = 0.0
    stiffer: float = 0.0
