"""A body that warms: thermal expansion as a load of its own.

    sigma = 2 mu eps + lame tr(eps) I - (3 lame + 2 mu) alpha T I

so a body that is free to move expands by alpha T without stress (in plane strain by 1 + nu times
that, its depth being held). At small strain this adds exactly to what the contact does. Source:
Timoshenko and Goodier, Theory of Elasticity (1970), art. 153.
"""

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.fem.elements import physical_gradients, strain_order
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.fem.system import Body


def thermal_loads(body: Body, expansion: Array) -> Array:
    """Nodal forces (n dim, 1), N per kelvin, of cells that expand by ``expansion`` (c,), 1/K.

    For the displacement element and the mixed one alike: the latter's pressures are those of the
    whole strain, lame div u.
    """
    mesh = body.mesh
    first, shear = lame_parameters(body.youngs_modulus, body.poissons_ratio)
    gradients, weights = physical_gradients(mesh.points, mesh.cells, strain_order(mesh.kind))
    stress = body.thickness * (3.0 * first + 2.0 * shear) * expansion
    forces = np.einsum("cq,cqna->cna", weights * stress[:, None], gradients, optimize=True)
    loads = np.zeros(mesh.points.shape)
    np.add.at(loads, mesh.cells, forces)
    return loads.reshape(-1, 1)
