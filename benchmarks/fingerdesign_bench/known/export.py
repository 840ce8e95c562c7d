"""Contact problems as plain arrays, so that any solver can be judged by them, and the judging.

A file NAME.npz holds one path of one problem in local components: at node i, 0 along the object's
normal toward the finger, 1 (and 2) in its tangent plane; mm, N.

    compliance (3m, 3m)   in the plane (2m, 2m); symmetric, node by node
    offset (k, m, 3)      gap and tangential place of the undeformed finger, a row an increment
    friction (1,)         Coulomb's coefficient
    area (m,)             of each node, mm^2: traction is force over area
    multiplier (k, m, 3)  this program's answer: forces on the finger, pressing > 0

To be found are forces f with u = C f and, in each row, for gap g = offset_0 + u_0 and the slip s
since the row before (or since no force and no offset), along offset_t + u_t:

    g >= 0,   f_0 >= 0,   f_0 g = 0,   |f_t| <= mu f_0,   f_t against s where s is not 0

:func:`judged` measures how far any (k, m, 3) is from that. On the plane of symmetry of a half
(``locked``, (m, 3)) tangential components are held: their compliance is 0.
"""

from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem


def write_problem(path: Path, problem: ContactProblem, steps: tuple[Step, ...]) -> None:
    """The arrays above, compressed."""
    nothing = np.zeros((problem.shape[0], problem.shape[1] - 1))
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(
        path,
        compliance=problem.compliance,
        offset=np.array([problem.offset(step.increment.motion, nothing) for step in steps]),
        friction=np.array([problem.friction_coefficient]),
        area=problem.model.areas,
        multiplier=np.array([step.increment.multiplier for step in steps]),
    )


def judged(given: dict[str, Array], multiplier: Array) -> Array:
    """The worst violation of the laws in each row (k,), over the row's largest force.

    Lengths count by each node's own compliance; numbers under 1e-6 are what a good solver leaves.
    """
    count, nodes, dim = given["offset"].shape
    compliance = given["compliance"]
    scale = np.diag(compliance).reshape(nodes, dim)[:, 0]
    moved = (multiplier.reshape(count, -1) @ compliance).reshape(count, nodes, dim)
    place = given["offset"] + moved
    slip = np.diff(place[:, :, 1:], axis=0, prepend=0.0 * place[:1, :, 1:])
    normal, shear = multiplier[..., 0], multiplier[..., 1:]
    bound = float(given["friction"][0]) * np.maximum(normal, 0.0)
    # The laws hold where both projections are fixed.
    trial = shear - slip / scale[:, None]
    length = np.maximum(np.linalg.norm(trial, axis=2), 1e-300)
    back = trial * np.minimum(1.0, bound / length)[..., None]
    opens = np.abs(normal - np.maximum(0.0, normal - place[..., 0] / scale))
    slides = np.linalg.norm(shear - back, axis=2)
    worst = np.maximum(opens, slides).max(axis=1)
    return np.asarray(worst / np.maximum(np.abs(normal).max(axis=1), 1e-300))
