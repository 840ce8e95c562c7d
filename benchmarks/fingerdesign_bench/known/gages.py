"""Gages on bonded plates under given tractions: a linear problem, without contact.

References: another program on other elements, ``references/gages.py``, whose docstring has block,
plates and tractions; its values and their uncertainty stand in ``references/gages.json``: a reading
is the strain along, of a tee with 0.33 (bronze's Poisson's ratio) times that across. A row's
tolerance is five times that uncertainty, at least 0.5 % and at most 2 %, or the
uncertainty where that is more: set before this program's value was seen.
"""

from functools import lru_cache
from typing import Any

import numpy as np

from fingerdesign.analysis.stages import make_mesh
from fingerdesign.arrays import Array
from fingerdesign.checks.load import parse_design
from fingerdesign.design.schema import Design
from fingerdesign.fem.model import build_model
from fingerdesign.layout.rows import mirrors_in_z
from fingerdesign.layout.zone import Zone
from fingerdesign_bench.known.case import Solution

SHEAR, PRESS = (0.02, -0.4, -0.3), (-0.05, 0.6, -0.4)  # MPa at the middle; slopes along X and Z
_HEIGHT = 6.0  # of the block, mm
_BLOCK = """
design.name = "bonded"
body = {{ shape = "block", width_mm = {width}, depth_mm = {depth}, base_height_mm = {height} }}
plates = {{ length_mm = 2.0, angle_deg = {angle}, {plates} }}
gages.grid = "{grid}"
mesh = {{ mesher = "{mesher}", {sizes} }}
"""
_SPACE = "contact_size_mm = 0.4, plate_size_mm = 0.15, far_size_mm = 0.8, layers = 8"
_TETRA = "contact_size_mm = 0.4, plate_size_mm = 0.15, far_size_mm = 0.8"
_PLANE = (
    "section = { contact_size_mm = 0.1, plate_size_mm = 0.05, plate_end_size_mm = 0.01, "
    "far_size_mm = 0.4 }"
)


def design_of(
    angle: float = 45.0,
    count: int = 1,
    grid: str = "axial",
    span: float | None = None,
    along: str = "x",
    plane: bool = False,
) -> Design:
    """The block: one plate next to its middle or a row of ``count``, 1.5 mm deep."""
    width, depth = 10.0 if count == 1 else 18.0, 6.0
    plates = f"count = {count}, cover_mm = 1.5, offset_mm = {0.5 if count == 1 else 0.0}"
    if span is not None:
        plates += f", span_mm = {span}"
    if along == "z":
        width, depth = depth, width
        plates += ', along = "z"'
    return parse_design(
        _BLOCK.format(
            width=width,
            depth=depth,
            height=_HEIGHT,
            angle=angle,
            plates=plates,
            grid=grid,
            mesher="tetwild" if along == "z" else "sweep",
            sizes=_PLANE if plane else _TETRA if along == "z" else _SPACE,
        )
    )


@lru_cache(maxsize=4)
def bonded(**block: Any) -> Solution:
    """Readings of the gages of a block, microstrain: "plate 0, upper" and so on, of all plates.

    block: arguments of :func:`design_of`.
    """
    design, plane = design_of(**block), block.get("plane", False)
    along = design.plates.along
    body = design.body
    reach = 0.5 * body.width_mm
    mesh = make_mesh(design, "plane-strain" if plane else "3d", Zone(reach), mirrors_in_z(design))
    model = build_model(design, mesh, reach).reduced
    first, second = (0, 2) if along == "x" else (2, 0)
    half = 0.5 * np.array([body.width_mm, 0.0, body.depth_mm])
    tent = 0.0 if plane or along == "z" else 1.0  # a tent across needs nodes in the middle
    across = np.zeros(model.nodes) if plane else np.abs(model.points[:, second]) / half[second]
    ahead = model.points[:, first] / half[first]

    def traction(value: float, slope: float, fall: float) -> Array:
        return np.asarray(value * (1.0 + slope * ahead + tent * fall * across))

    force = np.zeros(model.points.shape)
    force[:, first], force[:, 1] = traction(*SHEAR), traction(*PRESS)
    force *= model.areas[:, None]
    strains = 1e6 * model.gage_strain(force)
    faces = {"upper": strains[:, 0], "lower": strains[:, 1], "both": strains.mean(axis=1)}
    return Solution(
        {f"plate {k}, {face}": float(v) for face, vs in faces.items() for k, v in enumerate(vs)}
    )
