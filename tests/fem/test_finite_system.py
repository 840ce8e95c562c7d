"""The neo-Hookean body: its stiffness is the forces' derivative, known states come out right."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from fingerdesign.errors import SolverError
from fingerdesign.fem.body import condense_body
from fingerdesign.fem.finite.body import finite_body
from fingerdesign.fem.finite.law import Inverted, deformation, second_piola, second_piola_change
from fingerdesign.fem.finite.system import finite_system
from fingerdesign.fem.stiffness import lame_parameters
from tests.support import boxes
from tests.support.boxes import block_mesh

COUNTS = {2: ((3, 2), (3.0, 2.0)), 3: ((2, 2, 1), (3.0, 2.0, 1.0))}
KINDS = [(2, "P2"), (2, "mixed"), (3, "P2"), (3, "mixed")]
YOUNG, POISSON = 5.0, 0.45


def body_of(dim, element, poisson=POISSON, fixed=None):
    mesh = block_mesh(*COUNTS[dim], COUNTS[dim][1][1])
    if fixed is not None:
        fixed = fixed(mesh.points).ravel()
    return boxes.body_of(mesh, YOUNG, poisson, fixed, element=element)


def whole(upper):
    return (upper + sp.triu(upper, k=1).T).toarray()


def pressures_for(system, log_volume, poisson=POISSON):
    """The unknowns that make p = -lame ln J everywhere."""
    first = lame_parameters(YOUNG, poisson)[0]
    return np.full(system.pressures, -first * log_volume / system.scale)


def homogeneous(system, gradient, poisson=POISSON):
    """Values of the motion x = F X, with the pressure that belongs to it."""
    points = system.body.mesh.points
    moved = points @ (gradient - np.eye(len(gradient))).T
    log = np.log(np.linalg.det(gradient))
    return np.concatenate([moved.ravel(), pressures_for(system, log, poisson)])


@pytest.mark.parametrize(("dim", "element"), KINDS)
def test_stiffness_is_the_derivative_of_the_forces(dim, element):
    system = finite_system(body_of(dim, element, poisson=0.3))
    random = np.random.default_rng(1)
    values = 0.05 * random.normal(size=system.count)
    values[: system.body.mesh.points.size][system.body.fixed] = 0.0
    forces, upper = system.tangent(values)
    assert np.allclose(forces, system.forces(values), rtol=1e-12, atol=1e-13)
    matrix, step = whole(upper), 1e-6
    for _ in range(4):
        way = np.zeros(system.count)
        way[system.free] = random.normal(size=system.dofs)
        change = system.forces(values + step * way) - system.forces(values - step * way)
        wanted = change[system.free] / (2.0 * step)
        assert np.abs(matrix @ way[system.free] - wanted).max() < 1e-7 * np.abs(wanted).max()


def first_piola(at, first, shear):
    """P = F S (..., d, d), MPa."""
    return at.gradient @ second_piola(at, np.asarray(first), np.asarray(shear))


def energy(displacement_gradient, first, shear):
    """W (...), MPa: mu/2 (tr F^T F - d - 2 ln J) + lame/2 (ln J)^2."""
    found = deformation(displacement_gradient)
    stretch = np.sum(found.gradient**2, axis=(-2, -1)) - found.gradient.shape[-1]
    log = found.log_volume
    return 0.5 * shear * (stretch - 2.0 * log) + 0.5 * first * log**2


@pytest.mark.parametrize("dim", [2, 3])
def test_stresses_are_the_energys_derivative_and_their_change_is_theirs(dim):
    at, way = 0.2 * np.random.default_rng(2).normal(size=(2, 5, dim, dim))
    first, shear, step = np.full(5, 4.0), np.full(5, 1.5), 1e-6
    ends = [at + s * step * way for s in (1, -1)]
    up, down = (energy(end, first, shear) for end in ends)
    piola = first_piola(deformation(at), first, shear)
    assert np.allclose(np.sum(piola * way, axis=(1, 2)), (up - down) / (2 * step), rtol=1e-7)
    up, down = (second_piola(deformation(end), first, shear) for end in ends)
    found = second_piola_change(deformation(at), way, first, shear)
    assert np.allclose(found, (up - down) / (2 * step), rtol=1e-6, atol=1e-8)


def test_a_step_predicts_its_own_end_where_it_is_none():
    system = finite_system(body_of(2, "P2"))
    values = 0.05 * np.random.default_rng(6).normal(size=system.count)
    plain, predicted = system.tangent(values)[1], system.tangent(values, values)[1]
    assert np.abs((plain - predicted).data).max(initial=0.0) < 1e-12 * np.abs(plain.data).max()
    other = system.tangent(values, 0.5 * values)[1]
    assert np.abs((plain - other).data).max() > 1e-6 * np.abs(plain.data).max()


@pytest.mark.parametrize(("dim", "element"), KINDS)
def test_at_rest_it_is_the_small_strain_model(dim, element):
    body = body_of(dim, element)
    finite = finite_body(body)
    tangent = finite.linearised(finite.system.at_rest)
    wanted = condense_body(body).compliance
    assert np.abs(tangent.compliance - wanted).max() < 1e-10 * np.abs(wanted).max()
    # zero but for the rounding of F^-T, which differs between processors
    assert np.abs(tangent.forces).max() < 1e-14 * YOUNG


@pytest.mark.parametrize(("dim", "element"), KINDS)
def test_a_turned_body_resists_nothing_and_turns_its_forces(dim, element):
    """Rotation: no force. Objectivity: the forces of a turned, deformed body are turned."""
    system = finite_system(body_of(dim, element))
    turn = rotation(dim)
    assert np.abs(system.forces(homogeneous(system, turn))).max() < 1e-12
    random = np.random.default_rng(3)
    values = 0.05 * random.normal(size=system.count)
    size, shape = system.body.mesh.points.size, system.body.mesh.points.shape
    places = system.body.mesh.points + values[:size].reshape(shape)
    turned = values.copy()
    turned[:size] = (places @ turn.T - system.body.mesh.points).ravel()
    plain, there = system.forces(values), system.forces(turned)
    assert np.allclose(
        plain[:size].reshape(shape) @ turn.T, there[:size].reshape(shape), atol=1e-11
    )
    assert np.allclose(plain[size:], there[size:], atol=1e-11)


def rotation(dim):
    return Rotation.from_euler("zx", [0.7, 1.1 * (dim - 2)]).as_matrix()[:dim, :dim]


@pytest.mark.parametrize(("dim", "element"), KINDS)
@pytest.mark.parametrize("kind", ["uniaxial", "shear"])
def test_homogeneous_states_come_out_to_rounding(dim, element, kind):
    """Boundary nodes moved by x = F X: the inside follows, with the forces of the closed form.

    Uniaxial stress: the lateral stretch makes mu (b^2 - 1) + lame ln J = 0 (J = a b^(dim-1) and,
    in plane strain, out of plane 1); simple shear: J = 1, sigma_xy = mu gamma.
    """
    first, shear = lame_parameters(YOUNG, POISSON)
    if kind == "shear":
        gradient = np.eye(dim)
        gradient[0, 1] = 0.6
    else:
        stretch, side = 0.7, 1.0
        for _ in range(50):  # Newton
            power = dim - 1
            value = shear * (side**2 - 1.0) + first * np.log(stretch * side**power)
            side -= value / (2.0 * shear * side + first * power / side)
        gradient = np.diag([side, stretch, side][:dim])
    system = finite_system(body_of(dim, element, fixed=lambda p: outside(p, dim)))
    wanted = homogeneous(system, gradient)
    values = wanted.copy()
    values[system.free] = 0.0  # the inside starts at rest, the boundary is moved
    values = bent_toward(values, wanted, system)
    assert np.abs(values - wanted).max() < 1e-10
    at = deformation(gradient - np.eye(dim))
    piola = first_piola(at, first, shear)
    stress = piola @ at.gradient.T / np.exp(at.log_volume)  # Cauchy's
    if kind == "shear":
        assert stress[0, 1] == pytest.approx(shear * 0.6)
        assert stress[1, 1] == pytest.approx(0.0, abs=1e-12)
    else:
        assert np.abs(stress - np.diag([0, stress[1, 1], 0][:dim])).max() < 1e-12
        assert stress[1, 1] == pytest.approx(  # both closed forms, of J = a b^(dim - 1)
            (shear * (stretch**2 - 1) + first * at.log_volume) / np.linalg.det(gradient)
        )
    mesh = system.body.mesh
    top = np.unique(mesh.facets["contact"])
    force = system.forces(values)[: mesh.points.size].reshape(mesh.points.shape)[top].sum(axis=0)
    area = np.prod(np.ptp(mesh.points, axis=0)[[0, 2][: dim - 1]])
    # nodes of the top's rim also bear on the sides; in uniaxial stress nothing acts there
    if kind == "uniaxial":
        assert np.allclose(force, area * piola[:, 1], atol=1e-11)


def outside(points, dim):
    low, high = points.min(axis=0), points.max(axis=0)
    edge = ((points < low + 1e-9) | (points > high - 1e-9)).any(axis=1)
    return np.repeat(edge[:, None], dim, axis=1)


def bent_toward(values, wanted, system, steps=8):
    """Newton for the free unknowns with the held ones moved in steps to where they should be."""
    held = np.setdiff1d(np.arange(system.count), system.free)
    for part in range(1, steps + 1):
        values[held] = wanted[held] * part / steps
        for _ in range(12):
            forces, stiffness = system.tangent(values)
            left = forces[system.free]
            if np.abs(left).max() < 1e-13:
                break
            values[system.free] -= np.linalg.solve(whole(stiffness), left)
    return values


def test_what_it_cannot_do_is_refused():
    body = body_of(2, "P2")
    system, size = finite_system(body), body.fixed.size
    values = system.at_rest
    values[2 * np.unique(body.mesh.facets["contact"]) + 1] = -5.0
    with pytest.raises(Inverted, match="inside out"):
        system.forces(values)
    for change, words in (
        ({"element": "P1"}, "P1"),
        ({"attached": sp.csr_matrix((size, size))}, "sheets"),
    ):
        with pytest.raises(SolverError, match=words):
            finite_system(replace(body, **change))


def annulus(around, across, inner, outer):
    """A quarter of a ring: curved quadratic triangles, every node on its circle."""
    square = block_mesh((across, around), (1.0, 1.0), 1.0)
    share = square.points + np.array([0.5, 0.0])
    radius = inner * (outer / inner) ** share[:, 0]
    angle = 0.5 * np.pi * share[:, 1]
    points = np.stack([radius * np.sin(angle), radius * np.cos(angle)], axis=1)
    points = points * [-1.0, 1.0]  # keeps the cells' orientation
    return share, replace(square, points=points)


@pytest.mark.parametrize("poisson", [0.49, 0.4999])
def test_a_tube_widened_far_has_the_closed_form_pressure(poisson):
    """Thick tube, inner radius A made a, outer B free, plane strain, incompressible neo-Hookean:
    r^2 = R^2 + a^2 - A^2, sigma_theta - sigma_r = mu (r^2/R^2 - R^2/r^2), so

    pressure = integral_a^b (sigma_theta - sigma_r) / r dr.
    """
    inner, outer, now = 1.0, 2.0, 1.4
    share, mesh = annulus(8, 6, inner, outer)
    on_inner, low, high = share[:, 0] < 1e-9, share[:, 1] < 1e-9, share[:, 1] > 1 - 1e-9
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[on_inner] = True
    held[low, 0] = True
    held[high, 1] = True
    young = 3.0
    system = finite_system(boxes.body_of(mesh, young, poisson, held.ravel(), element="mixed"))
    size = mesh.points.size
    at_rest = np.hypot(*mesh.points.T)
    grown = np.sqrt(at_rest**2 + now**2 - inner**2) / at_rest - 1.0
    wanted = system.at_rest
    wanted[:size] = (grown[:, None] * mesh.points).ravel()  # to start from; held at the inside
    wanted[:size][held.ravel() & ~np.repeat(on_inner, 2)] = 0.0
    values = bent_toward(wanted.copy(), wanted, system, steps=1)
    forces = system.forces(values)[:size].reshape(mesh.points.shape)
    along = mesh.points[on_inner] / inner
    pushed = np.sum(forces[on_inner] * along, axis=1)
    # sum of f . e_r over the quarter of the deformed circle is p a pi/2 (P2 loads are consistent)
    found = pushed.sum() / (now * 0.5 * np.pi)
    shear = young / (2.0 * (1.0 + poisson))
    outside_now = np.sqrt(outer**2 + now**2 - inner**2)
    r = np.linspace(now, outside_now, 20001)
    radius = np.sqrt(r**2 - now**2 + inner**2)
    integrand = shear * (r**2 / radius**2 - radius**2 / r**2) / r
    exact = np.trapezoid(integrand, r)
    # compressible by mu / lame: 4 % at 0.49, 4e-4 at 0.4999
    first = lame_parameters(young, poisson)[0]
    assert found == pytest.approx(exact, rel=1e-3 + 1.5 * shear / first)
    moved = np.hypot(*(mesh.points + values[:size].reshape(mesh.points.shape)).T)
    free = share[:, 0] > 1 - 1e-9
    assert np.allclose(moved[free], outside_now, rtol=2e-4 + shear / first)


def test_a_free_face_under_dead_pressure_gives_way_at_twice_the_shear_modulus():
    """Why a row fails where a flat contact is pressed far: contact forces are held in the tangent.

    A half-plane of incompressible rubber under a uniform pressure p, its face displaced by A cos kx
    across and B sin kx along: the rubber takes mu k (A^2 + B^2) / 2 a length, the pressure, whose
    way does not turn with the face, gives p k A B / 2. The sum is positive for p < 2 mu only,
    whatever the wavelength: finer meshes do not help.
    """
    for count in (6, 12):
        mesh = block_mesh((count, count), (2.0, 2.0), 2.0)
        x, y = mesh.points.T
        sides = (np.abs(x - x.min()) < 1e-9) | (np.abs(x - x.max()) < 1e-9)
        fixed = np.column_stack([sides | (y < 1e-9), y < 1e-9]).ravel()
        system = finite_system(boxes.body_of(mesh, YOUNG, 0.4999, fixed, element="mixed"))
        shear, values = YOUNG / 3.0, system.at_rest
        for share, gives_way in ((1.9, False), (2.1, True)):
            values[mesh.points.size :] = share * shear / system.scale
            upper = system.tangent(values)[1]
            below = (np.linalg.eigvalsh(whole(upper)) < 0.0).sum()
            assert (below > system.pressures) == gives_way
