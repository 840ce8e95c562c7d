"""Incompressible elastic half-spaces of E* = 1 MPa under round bumps: equal cells, numpy alone.

Normal and tangential problems uncouple there, and a shear along x moves the surface as a pressure
does: one kernel serves both. Cells carry even tractions, displacements are those of their centres.
"""

import numpy as np

from tests.support.reduced import reduced_model


def half_plane(half, cells, radius, depth=30.0):
    """A cylinder of ``radius`` along |x| <= half: u = 2 / (pi E*) p ln(depth / r), integrated."""
    h = 2.0 * half / cells
    x = (np.arange(cells) + 0.5) * h - half
    ends = x[:, None] - x[None] + 0.5 * h * np.array([[[1.0]], [[-1.0]]])
    upper, lower = ends * np.log(np.abs(ends)) - ends  # the integral of ln |s|
    scalar = 2.0 / np.pi * (np.log(depth) - (upper - lower) / h)
    points = np.column_stack([x, -(x**2) / (2.0 * radius)])
    rim = np.arange(cells) % (cells - 1) == 0
    areas = {"areas": np.full(cells, h), "facet_areas": np.full(cells - 1, h)}
    return reduced_model(points, np.kron(scalar, np.eye(2)), rim=rim, **areas)


def quarter_sphere(side, cells, radius):
    """A sphere of ``radius`` on 0 <= x, z <= side, mirrored in both, in components y and x.

    Love's displacement of evenly loaded squares: u = p / (pi E*) integral dA / r.
    """
    h = side / cells
    x, z = ((grid.ravel() + 0.5) * h for grid in np.meshgrid(*2 * [np.arange(cells)]))
    scalar = sum(
        _square(x[:, None] - sx * x, z[:, None] - sz * z, h) for sx in (1, -1) for sz in (1, -1)
    )
    points = np.column_stack([x, -(x**2 + z**2) / (2.0 * radius)])
    compliance = np.kron(0.5 * (scalar + scalar.T) / (np.pi * h * h), np.eye(2))
    rim = np.maximum(x, z) > side - h
    return reduced_model(points, compliance, rim=rim, areas=np.full(cells**2, h * h))


def _square(x, z, h):
    """The integral of 1 / r over a square of side h about (-x, -z)."""
    total = np.zeros_like(x)
    for sx in (0.5, -0.5):
        for sz in (0.5, -0.5):
            a, b = x + sx * h, z + sz * h
            corner = a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / np.abs(b))
            total += np.sign(sx * sz) * corner
    return total
