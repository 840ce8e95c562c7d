"""Boxes of simplices or prisms, and elastic blocks made of them."""

import numpy as np
import skfem

from fingerdesign.fem.system import Body
from fingerdesign.mesh.cells import boundary_facets, quadratic
from fingerdesign.mesh.measures import oriented
from fingerdesign.mesh.section.extrude import prisms_over
from fingerdesign.mesh.types import Mesh


def simplices(*axes):
    """Points (n, d) and positively oriented linear cells of a tensor grid."""
    made = (skfem.MeshTri if len(axes) == 2 else skfem.MeshTet).init_tensor(*axes)
    points = made.p.T.copy()
    return points, oriented(points, made.t.T.astype(np.int64))


def box(dimension, n, jitter=0.0, seed=1):
    """Quadratic simplices of the unit square or cube; inner nodes moved by ``jitter`` of h.

    dimension "prisms": those of the cube, inner nodes moved in the section.
    """
    if dimension == "prisms":
        return prisms(*box(2, n, jitter, seed), np.linspace(0.0, 1.0, n + 1))
    points, cells = simplices(*[np.linspace(0, 1, n + 1)] * dimension)
    inside = ((points > 1e-9) & (points < 1 - 1e-9)).all(axis=1)
    move = np.random.default_rng(seed).uniform(-1, 1, points.shape)
    points[inside] += jitter / n * move[inside]
    return quadratic(points, cells)


def prisms(points, triangles, heights):
    """Quadratic prisms over quadratic triangles (t, 6) of points (n, 2) between heights."""
    levels = np.interp(np.arange(2 * len(heights) - 1), np.arange(0, 2 * len(heights), 2), heights)
    nodes = np.column_stack([np.tile(points, (len(levels), 1)), np.repeat(levels, len(points))])
    layers = [prisms_over(triangles, len(points), k) for k in range(len(heights) - 1)]
    return nodes, np.vstack(layers)


def mesh_of(points, cells, facets=None):
    return Mesh(points, cells, np.zeros(len(cells), dtype=np.int64), facets or {}, "box")


def block_mesh(counts, size, contact_y):
    """A box |x| <= size_x / 2, 0 <= y <= size_y(, 0 <= z <= size_z); "contact" at y = contact_y."""
    axes = [np.linspace(0.0, s, n + 1) for s, n in zip(size, counts, strict=True)]
    nodes, cells = quadratic(*simplices(axes[0] - 0.5 * size[0], *axes[1:]))
    facets = boundary_facets(cells)

    def on(y):
        return facets[(np.abs(nodes[facets[:, : len(size)], 1] - y) < 1e-9).all(axis=1)]

    other = 0.0 if contact_y else size[1]
    return mesh_of(nodes, cells, {"base": on(other), "contact": on(contact_y)})


def held(mesh, name="base"):
    """Dofs (n dim,) of the nodes of some facets."""
    fixed = np.zeros(mesh.points.shape, dtype=bool)
    fixed[np.unique(mesh.facets[name])] = True
    return fixed.ravel()


def body_of(mesh, young=5.0, poisson=0.4, fixed=None, **more):
    """An even elastic body on a mesh, held at its base."""
    count = len(mesh.cells)
    return Body(
        mesh=mesh,
        youngs_modulus=np.full(count, young),
        poissons_ratio=np.full(count, poisson),
        fixed=held(mesh) if fixed is None else fixed,
        contact=mesh.facets["contact"],
        **more,
    )


def block(counts, size, contact_y, **more):
    return body_of(block_mesh(counts, size, contact_y), **more)
