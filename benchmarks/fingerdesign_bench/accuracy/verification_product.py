"""Point contact by the product's own road: a design and a scene in, a result out.

A dome of R = 20 mm both ways, or a revolved pin of that radius, meshed by fTetWild, under a plane
with force control; the contact's radius of 1.2 mm is a ninth of its height. Hertz and
Cattaneo-Mindlin are compared at the force.
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.checks.load import parse_design
from fingerdesign.design.io import parse_scene
from fingerdesign.records.result import IncrementResult
from fingerdesign_bench.accuracy import analytic

RADIUS, CONTACT, NU, FRICTION = 20.0, 1.2, 0.4999, 0.5
MODULUS = analytic.plane_strain_modulus(4.96, NU)
SHEARS, BACK = (0.4, 0.6, 0.8), (0.0, -0.3)  # of the friction limit

_SHAPES = {
    "dome": f'body.shape = "dome"\nbody.depth_mm = 20.0\nbody.dome_radius_mm = {RADIUS}',
    "pin": 'body.shape = "revolved"',
}
_DESIGN = f"""
design.name = "ball"
body.width_mm = 20.0
body.base_height_mm = 10.0
body.arc_radius_mm = {RADIUS}
plates.count = 0
materials.silicone.poissons_ratio = {NU}
"""


@dataclass(frozen=True)
class DomeErrors:
    """Per increment: relative errors of peak pressure and contact width; of c / a, absolute.

    The first increment is the normal load, the rest are sheared.
    """

    peak: tuple[float, ...]
    width: tuple[float, ...]
    stick: tuple[float, ...]


def dome_errors(contact_size_mm: float = 0.12, shape: str = "dome") -> DomeErrors:
    """Mesh, condense and load the "dome" or the "pin" as ``fingerdesign analyse`` does."""
    from fingerdesign.pipeline import analyse

    design = parse_design(f"{_DESIGN}\n{_SHAPES[shape]}\nmesh.contact_size_mm = {contact_size_mm}")
    normal = 4.0 / 3.0 * MODULUS * CONTACT**3 / RADIUS
    limit = FRICTION * normal
    rows = [[normal, 0.0], *([normal, share * limit] for share in (*SHEARS, *BACK))]
    scene = parse_scene(
        f'object.friction_coefficient = {FRICTION}\npath.control = "force"\n'
        f"path.increments_N = {rows}"
    )
    increments = analyse(design, scene, "3d").increments
    hertz = [analytic.hertz_point(each.normal_force_N, RADIUS, MODULUS) for each in increments]
    pairs = list(zip(increments, hertz, strict=True))
    return DomeErrors(
        peak=tuple(each.peak_pressure_MPa / h.peak_pressure - 1.0 for each, h in pairs),
        width=tuple(0.5 * each.contact_width_mm / h.half_width - 1.0 for each, h in pairs),
        stick=tuple(
            float(np.sqrt(each.stick_ratio or 0.0)) - _share(each, k > len(SHEARS), limit)
            for k, each in enumerate(increments)
        ),
    )


def _share(increment: IncrementResult, returned: bool, limit: float) -> float:
    """Cattaneo's and Mindlin's c / a."""
    return analytic.cattaneo_mindlin_sphere(
        increment.tangential_force_N,
        increment.normal_force_N,
        FRICTION,
        SHEARS[-1] * limit if returned else None,
    )
