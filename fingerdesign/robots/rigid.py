"""Mass, centre and inertia of a finger from the triangles of its parts.

Of a solid with outward triangles (a, b, c), each a tetrahedron with the origin of volume
V = a . (b x c) / 6,

    mass = rho sum V,   centre = sum V (a + b + c) / 4 / sum V,
    second moment S = rho sum V / 20 (a a' + b b' + c c' + s s'),   s = a + b + c,
    inertia = tr(S) 1 - S,   shifted to the centre.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.materials import MATERIALS
from fingerdesign.mold.products.casting import DENSITIES_G_CM3, density_of

# Metals by EN 10088-1, EN 1999-1-1 and the Copper Development Association; plastics as their makers
# publish them.
_SOLIDS_G_CM3 = {
    "phosphor_bronze": 8.86,
    "spring_steel": 7.85,
    "stainless_steel": 7.9,
    "beryllium_copper": 8.25,
    "abs": 1.04,
    "pla": 1.24,
    "aluminium": 2.7,
    "polyimide": 1.42,
}

MOST_G_CM3 = 30.0  # The densest metal has 22.6.


@dataclass(frozen=True)
class RigidBody:
    """mass kg; centre (3,) m; inertia (3, 3) kg m^2 about the centre."""

    mass: float
    centre: Array
    inertia: Array


def triangles_of(path: Path) -> Array:
    """Corners (t, 3, 3), mm, of a binary STL."""
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.fromfile(path, record, offset=84)["corners"].astype(float)


def rigid_body(parts: Iterable[tuple[Array, float]]) -> RigidBody:
    """Join parts, each as corners (t, 3, 3) in mm and a density in g/cm^3.

    >>> cut = np.array([[[0, 0, 0], [0, 1, 0], [1, 0, 0]], [[0, 0, 0], [1, 0, 0], [0, 0, 1]],
    ...     [[0, 0, 0], [0, 0, 1], [0, 1, 0]], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]])
    >>> found = rigid_body([(10.0 * cut, 6.0)])
    >>> round(1e3 * found.mass, 6), (1e3 * found.centre).round(6).tolist()
    (1.0, [2.5, 2.5, 2.5])
    """
    mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for corners, density in parts:
        metres, rho = 1e-3 * corners, 1e3 * density
        volume = np.einsum("ti,ti->t", metres[:, 0], np.cross(metres[:, 1], metres[:, 2])) / 6.0
        total = metres.sum(axis=1)
        mass += rho * float(volume.sum())
        first += rho / 4.0 * volume @ total
        second += rho / 20.0 * np.einsum("t,tki,tkj->ij", volume, metres, metres)
        second += rho / 20.0 * np.einsum("t,ti,tj->ij", volume, total, total)
    centre = first / mass
    second -= mass * np.outer(centre, centre)
    return RigidBody(mass, centre, np.trace(second) * np.eye(3) - second)


def densities(design: Design, given: Mapping[str, float]) -> dict[str, float]:
    """Density of each part, g/cm^3; ``given``: by the material's name, before the usual ones.

    DesignError for a plate's or core's material without one, for a name that no part has, and for a
    number that is no density.
    """
    parts = {"body": design.body.material}
    if design.plates.number and design.plates.model != "none":
        parts["plates"] = design.plates.material
    if design.body.core is not None:
        parts["core"] = design.body.core.material
    faults = [
        Fault("--density", name, f"a material of it: {', '.join(parts.values())}", "correct it")
        for name in given
        if name not in parts.values()
    ]
    faults += [
        Fault(f"--density {name}", value, f"over 0 and at most {MOST_G_CM3:g} g/cm^3", "correct it")
        for name, value in given.items()
        if not 0.0 < value <= MOST_G_CM3
    ]
    usual = {**dict.fromkeys(MATERIALS, density_of(design)), **DENSITIES_G_CM3, **_SOLIDS_G_CM3}
    found = {"body": given.get(parts["body"], density_of(design))}
    for part in parts.keys() - {"body"}:
        name = parts[part]
        if name not in given and name not in usual:
            bound = "a material whose density is known"
            faults.append(Fault(f"{part} material", name, bound, f"add --density {name} G_CM3"))
            continue
        found[part] = given.get(name, usual.get(name, 0.0))
    if faults:
        raise DesignError(faults)
    return found
