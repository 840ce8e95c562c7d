"""Figure 3 from a real solution: rectangles near the surface, before and under a shear.

The paper draws eleven small rectangles under the contact of a homogeneous finger: pressed alone
they keep their right angles, sheared they turn into rhomboids where the surface above sticks and
"are no longer rhomboidal" where it slips. Here they are cut into the finger without plates, under
the contact's width at the scene's approach, and moved with the solved displacements:

pressed  the approach alone
sheared  the shear has grown until the surface sticks above about half of the rectangles
change   one small shear further: the paper's change "over a short period of time" (2.3)

A rectangle's shear angle is the sum of the turns of its two middle lines, in degrees: positive as
the object drags the surface toward +x.
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.measures import limits
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.errors import SolverError
from fingerdesign.fem.readout import displacement_rows
from fingerdesign.layout.surface import surface_of
from fingerdesign_bench.paper.case import PaperCase, above, follow_rows

COUNT = 11  # as in the paper's Fig. 3
_STICKING = 5  # of them, as in its Fig. 3 (b): 4 to 8
_SHEAR_STEPS = 40  # up to the scene's last shear, which ends maeno2000's in complete slip
_MOST_STEPS = 160  # for fingers that are softer in shear
_FILL = 0.72  # of the rectangles' pitch
_INSET_MM = 0.01  # under the surface: points of the mesh's curved border are not inside it
OPEN, STICK, SLIP = "open", "stick", "slip"


@dataclass(frozen=True)
class Rectangles:
    """n rectangles; corners (n, 4, 2) mm, anticlockwise from the lower left.

    moved: state -> displacements of the corners (n, 4, 2), mm. angle: state -> shear angle (n,),
    degrees; of "change" that of the small shear alone. status: what the surface above does at the
    end of the small shear. tangential_force (3,): of pressed, sheared, changed.
    """

    corners: Array
    moved: dict[str, Array]
    angle: dict[str, Array]
    status: tuple[str, ...]
    tangential_force: Array
    friction: float

    @property
    def change_per_N(self) -> Array:
        """Change of shear angle per change of tangential force (n,), degrees/N."""
        force = self.tangential_force[2] - self.tangential_force[1]
        return np.asarray(self.angle["change"] / force)

    def mean(self, state: str, status: str) -> float:
        """Mean shear angle of the rectangles under a status, degrees; NaN where there is none."""
        chosen = [a for a, s in zip(self.angle[state], self.status, strict=True) if s == status]
        return float(np.mean(chosen)) if chosen else float("nan")


def rectangles(case: PaperCase) -> Rectangles:
    """Solve the three states on the twin. Raises SolverError where no shear makes half slip."""
    pressed, sheared, changed = _states(case)
    middles, size = _places(case.twin, pressed)
    surface = surface_of(case.design.body)
    top = surface.height(middles, np.zeros_like(middles)) - _INSET_MM
    half = 0.5 * size
    corners = np.stack(
        [
            np.column_stack([middles + sx * half, top - down])
            for sx, down in ((-1, size), (1, size), (1, 0.0), (-1, 0.0))
        ],
        axis=1,
    )
    sides = 0.5 * (corners + np.roll(corners, -1, axis=1))  # bottom, right, top, left
    steps = (pressed, sheared, changed)
    fields = case.twin_model.displacement_fields(np.array([s.increment.force for s in steps]))
    at_corners, at_sides = (_displacements(case, points, fields) for points in (corners, sides))
    turned = np.degrees(
        (at_sides[:, :, 2, 0] - at_sides[:, :, 0, 0]) / size
        + (at_sides[:, :, 1, 1] - at_sides[:, :, 3, 1]) / size
    )
    return Rectangles(
        corners=corners,
        moved={"pressed": at_corners[0], "sheared": at_corners[1], "changed": at_corners[2]},
        angle={
            "pressed": turned[0],
            "sheared": turned[1],
            "added": turned[1] - turned[0],
            "change": turned[2] - turned[1],
        },
        status=_statuses(case.twin, changed, middles),
        tangential_force=np.array([s.measures.tangential_force for s in steps]),
        friction=case.friction,
    )


def _states(case: PaperCase) -> tuple[Step, Step, Step]:
    press = [(case.approach * k / 4, 0.0) for k in range(1, 5)]
    most = max(shear for _, shear in case.rows)
    shears = [(case.approach, most * k / _SHEAR_STEPS) for k in range(1, _MOST_STEPS + 1)]
    steps = list(follow_rows(case.twin, press + shears))
    pressed = steps[len(press) - 1]
    middles, _ = _places(case.twin, pressed)
    for before, now in zip(steps[len(press) :], steps[len(press) + 1 :], strict=False):
        sticking = _statuses(case.twin, now, middles).count(STICK)
        if 0 < sticking <= _STICKING:
            return pressed, before, now
    raise SolverError(
        "no shear up to four times the scene's makes half of the contact slip: no Fig. 3"
    )


def _places(problem: ContactProblem, pressed: Step) -> tuple[Array, float]:
    """Middles (n,) and size of the rectangles, mm: all under the contact."""
    contact, _ = limits(problem, pressed.increment)
    edges = np.linspace(contact[0], contact[1], COUNT + 1)
    pitch = float(edges[1] - edges[0])
    return 0.5 * (edges[1:] + edges[:-1]), _FILL * pitch


def _statuses(problem: ContactProblem, step: Step, x: Array) -> tuple[str, ...]:
    touches, sticks = above(problem, step, x)
    return tuple(STICK if s else SLIP if t else OPEN for t, s in zip(touches, sticks, strict=True))


def _displacements(case: PaperCase, points: Array, fields: Array) -> Array:
    """Displacements (k, n, 4, 2) at points (n, 4, 2) of fields (k, nodes, 2)."""
    mesh = case.twin_model.mesh
    rows = displacement_rows(mesh, points.reshape(-1, 2))
    found = rows @ fields.reshape(len(fields), -1).T
    return np.asarray(found.T).reshape(len(fields), *points.shape)
