"""Bodies of one material, held on named faces: the bodies of the cases with known answers."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.fem.body import CondensedBody, condense_body
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.system import Body
from fingerdesign.mesh.cells import LINE
from fingerdesign.mesh.types import Mesh
from fingerdesign_bench.accuracy.block import near


def uniform_body(
    mesh: Mesh,
    youngs_modulus: float,
    poissons_ratio: float,
    fixed: BoolArray,
    reach: float = np.inf,
    element: Literal["P1", "P2", "mixed"] = "P2",
) -> Body:
    """A body held at ``fixed`` (n, dim), its contact facets within ``reach`` mm of the y axis."""
    count = len(mesh.cells)
    moduli, ratios = np.full(count, youngs_modulus), np.full(count, poissons_ratio)
    facets = near(mesh, "contact", reach)
    return Body(mesh, moduli, ratios, fixed.reshape(-1), facets, element=element)


def held(mesh: Mesh, *faces: str, **along: tuple[int, ...]) -> BoolArray:
    """Mask (n, dim) of what the named faces hold: all of ``faces``, some axes of ``along``.

    A half body is held by its plane of symmetry, too.
    """
    fixed = np.zeros(mesh.points.shape, dtype=bool)
    every = tuple(range(mesh.dimension))
    mirror = {"symmetry": (2,)} if mesh.symmetric else {}
    for face, axes in (dict.fromkeys(faces, every) | along | mirror).items():
        fixed[np.unique(mesh.facets[face])[:, None], list(axes)] = True
    return fixed


def nearest(mesh: Mesh, place: Sequence[float] | Array) -> int:
    """The node that is nearest to a place."""
    return int(np.argmin(np.linalg.norm(mesh.points - np.asarray(place), axis=1)))


def face_loads(mesh: Mesh, face: str, traction: Sequence[float]) -> Array:
    """Consistent nodal forces (n, 2) N of a constant ``traction`` (2,) MPa on a section's face."""
    facets = mesh.facets[face]
    table = tabulate(LINE, *quadrature(LINE, 4))
    tangents = np.einsum("fna,nbq->fqab", mesh.points[facets], table.gradient)
    stretch = np.linalg.norm(tangents[..., 0], axis=2)
    share = np.einsum("nq,fq,q->fn", table.value, stretch, table.weights)
    loads = np.zeros(mesh.points.shape)
    np.add.at(loads, facets, share[:, :, None] * np.asarray(traction))
    return loads


def condense_loaded(body: Body, loads: Array) -> CondensedBody:
    """A body condensed together with its own nodal forces (n, dim) N, at share 1 of a motion."""
    condensed = condense_body(body, [sp.csr_matrix(loads.reshape(1, -1))])
    return replace(condensed, load_displacement=condensed.readouts[0][0])
