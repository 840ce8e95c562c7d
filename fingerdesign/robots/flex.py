"""The rubber of a finger as a MuJoCo flex: tetrahedra that collide and show, and follow a lattice.

A millimetre of rubber weighs milligrams: with each corner free, MuJoCo 4 is unstable at any usual
step. So corners follow quadratic functions of 27 nodes in the finger's box ("dof = quadratic"), the
nine at the base pinned; with the integrator "discrete" that runs at 2 ms. It has one material:
plates and a core do not stiffen it. Forces and gages are the pad's (robots/pad.py).
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.analysis.stages import make_mesh
from fingerdesign.arrays import Array, IntArray
from fingerdesign.checks.load import with_values, without_plates
from fingerdesign.design.schema import Design
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.types import in_tetrahedra

PINNED = "0 1 2 9 10 11 18 19 20"  # Nodes 9 x + 3 y + z of the lattice, x, y, z = 0, 1, 2: y = 0.


@dataclass(frozen=True)
class Flex:
    """points (n, 3) m; cells (c, 4); mass kg; youngs_modulus Pa."""

    points: Array
    cells: IntArray
    mass: float
    youngs_modulus: float
    poissons_ratio: float


def flex_of(design: Design, size_mm: float, mass: float) -> Flex:
    """Mesh the body without its plates by tetrahedra of about ``size_mm``; mass: kg, of its rubber.

    Raises MeshError.
    """
    sizes = dict.fromkeys(("mesh.contact_size_mm", "mesh.far_size_mm"), size_mm)
    meshed = {"mesh.mesher": "auto", "mesh.layers": None, **sizes}
    bare = with_values(without_plates(design), meshed)
    mesh = in_tetrahedra(make_mesh(bare, "3d", Zone(0.5 * size_mm), symmetric=False))
    used, cells = np.unique(mesh.corners, return_inverse=True)
    rubber = design.material_of("body")
    modulus = 1e6 * rubber.youngs_modulus_MPa
    points = 1e-3 * mesh.points[used]
    return Flex(points, cells.reshape(-1, 4), mass, modulus, rubber.poissons_ratio)
