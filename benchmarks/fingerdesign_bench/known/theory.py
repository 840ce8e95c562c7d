"""Known answers of more than a line: normal indentation with friction, torsion, loops.

Nothing here uses finite elements or the contact solver: half-space theory, numpy and scipy alone.
Lengths are in contact half-widths or radii. References of the suite's cases are made here.
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1

from fingerdesign.arrays import Array

_LAYERS, _RATIO = 26, 0.4  # elements shrink geometrically toward each border of stick and contact
_NEAR = (1e-5, 3e-3)  # of the stick width: where the singularity at its border is fitted
_GAUSS = np.polynomial.legendre.leggauss(10)


def spence(poissons_ratio: float, friction_coefficient: float, plane: bool) -> tuple[float, float]:
    """Normal indentation with friction of a half-space by anything rigid, fully coupled: c / a, and
    of a flat punch the pressure in the middle over that without friction.

    Under a growing load all of a wedge, cylinder, sphere or cone is alike at each instant, and the
    increment of its fields is that of a flat punch of the present width (D. A. Spence, Proc. Camb.
    Phil. Soc. 73 (1973) 249; J. Elasticity 5 (1975) 297): c / a is one number. With p pressure, q
    shear traction outward and beta = (1 - 2 nu) / (2 (1 - nu)), the punch obeys in |x| < 1

        plane:   1/pi int p(s) ln|x - s| ds - beta int_0^x q ds = const,
                 1/pi int q(s) ln|x - s| ds + beta int_0^x p ds = 0       where it sticks,
        round:   int s p(s) J00 ds - beta int_r^1 q ds = const,
                 int s q(s) J11 ds - beta / r int_0^r s p ds = 0          where it sticks,

    J00, J11: the integrals over k > 0 of J0(kr) J0(ks) and J1(kr) J1(ks); q = mu p where it slips.
    The border c is where q is bounded. Raises ValueError where no border lies in 0.02 to 0.9995.
    """
    beta = (1.0 - 2.0 * poissons_ratio) / (2.0 * (1.0 - poissons_ratio))

    def unbounded(stick: float) -> float:
        return _punch(stick, friction_coefficient, beta, plane)[0]

    stick = float(brentq(unbounded, 0.02, 0.9995, xtol=1e-6))
    _, pressure = _punch(stick, friction_coefficient, beta, plane)
    return stick, float((1.0 if plane else 2.0) * np.pi * pressure)


def _punch(stick: float, friction: float, beta: float, plane: bool) -> tuple[float, float]:
    """Strength of the singularity at the border, and the pressure in the middle."""
    edges = _edges(stick)
    middle, length = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    count, held = len(middle), int(np.searchsorted(edges, stick * (1.0 - 1e-14)))
    normal, shear, by_shear, by_normal = (_plane if plane else _round)(edges, middle, held)
    force = 2.0 * length if plane else np.pi * np.diff(edges**2)
    # Unknown: p on all elements, r = mu p - q where it sticks, the approach.
    system = np.zeros((count + held + 1, count + held + 1))
    system[:count, :count] = normal - beta * friction * by_shear
    system[:count, count:-1] = beta * by_shear[:, :held]
    system[:count, -1] = -1.0
    system[count:-1, :count] = friction * shear + beta * by_normal
    system[count:-1, count:-1] = -shear[:, :held]
    system[-1, :count] = force
    found = np.linalg.solve(system, np.eye(count + held + 1)[-1])
    inward = stick - middle[:held]
    near = (inward > _NEAR[0] * stick) & (inward < _NEAR[1] * stick)
    powers = inward[near, None] ** np.array([0.0, 1.0, 2.0])
    rest = found[count:-1][near] * np.sqrt(inward[near])
    return float(np.linalg.lstsq(powers, rest, rcond=None)[0][0]), found[0]


def _edges(stick: float) -> Array:
    shrink = _RATIO ** np.arange(_LAYERS + 1.0)
    shrink[-1] = 0.0
    half, beyond = 0.5 * stick, 0.5 * (stick + 1.0)
    coarse = np.concatenate(
        [
            np.linspace(0.0, half, 13)[:-1],
            stick - (stick - half) * shrink,
            (stick + (beyond - stick) * shrink[::-1])[1:-1],
            1.0 - (1.0 - beyond) * shrink,
        ]
    )
    return np.sort(np.concatenate([coarse, 0.5 * (coarse[1:] + coarse[:-1])]))


def _plane(edges: Array, x: Array, held: int) -> tuple[Array, Array, Array, Array]:
    """Rows of the two equations: u_y by p, u_x by q (sticking rows), and both crossed terms."""

    def log_integral(u: Array) -> Array:
        size = np.abs(u)
        return u * np.log(np.where(size == 0.0, 1.0, size)) - u

    def between(low: Array, high: Array) -> Array:
        return (log_integral(x[:, None] - low) - log_integral(x[:, None] - high)) / np.pi

    right, left = between(edges[:-1], edges[1:]), between(-edges[1:], -edges[:-1])
    length, count = np.diff(edges), len(x)
    sums = np.tril(np.ones((count, count)), -1) * length + np.diag(0.5 * length)
    return right + left, (right - left)[:held], sums, sums[:held]


def _round(edges: Array, r: Array, held: int) -> tuple[Array, Array, Array, Array]:
    """The same rows as :func:`_plane`, for rings."""
    count = len(r)
    outer = np.triu(np.ones((count, count)), 1) * np.diff(edges) + np.diag(edges[1:] - r)
    inner = np.tril(np.ones((count, count)), -1) * np.diff(0.5 * edges**2)
    inner = (inner + np.diag(0.5 * (r**2 - edges[:-1] ** 2))) / r[:, None]
    return _rings(edges, r, _j00), _rings(edges, r[:held], _j11), outer, -inner[:held]


def _j00(s: Array, r: Array | float) -> Array:
    low, high = np.minimum(s, r), np.maximum(s, r)
    return np.asarray(s * 2.0 / np.pi / high * ellipkm1((high - low) * (high + low) / high**2))


def _j11(s: Array, r: Array | float) -> Array:
    low, high = np.minimum(s, r), np.maximum(s, r)
    first = ellipkm1((high - low) * (high + low) / high**2)
    return np.asarray(s * 2.0 / np.pi / low * (first - ellipe((low / high) ** 2)))


def _rings(edges: Array, r: Array, kernel: Callable[[Array, Array | float], Array]) -> Array:
    """Integrals of the kernel over each element, with care where its logarithm is near."""
    place, weight = 0.5 * (_GAUSS[0] + 1.0), 0.5 * _GAUSS[1]
    low, length = edges[:-1], np.diff(edges)
    s = low + length * place[:, None]
    rows = [weight @ (kernel(s, each) * length) for each in r]
    toward, share = place**5, weight * 5.0 * place**4
    for i, each in enumerate(r):
        for j in range(max(0, i - 3), min(len(low), i + 4)):
            nearest = float(np.clip(each, edges[j], edges[j + 1]))
            rows[i][j] = sum(
                abs(far - nearest) * (share @ kernel(nearest + (far - nearest) * toward, each))
                for far in (edges[j], edges[j + 1])
                if far != nearest
            )
    return np.array(rows)


def lubkin(stick: float) -> tuple[float, float]:
    """Turn G a^2 beta / (mu P) and moment M / (mu P a) of a twisted sphere with c / a = stick.

    The turn is 3 / (4 pi) (K(k') - E(k')), k'^2 = 1 - stick^2 (J. L. Lubkin, J. Appl. Mech. 18
    (1951) 183). By Abel's transform h of the traction, M = 4 pi int_0^1 t h(t) dt with
    h = (3 / pi^2) t (K - E)(1 - t^2), held at its value of stick (times t) within: derived here.

    >>> round(lubkin(1e-6)[1] / (3 * np.pi / 16), 4)  # complete slip
    1.0
    """

    def share(t: Array) -> Array:
        t = np.maximum(t, stick)
        return np.asarray(ellipkm1(t * t) - ellipe(1.0 - t * t))

    x, w = np.polynomial.legendre.leggauss(400)
    t = 0.5 * (x + 1.0)
    outside, width = stick + (1.0 - stick) * t, 0.5 * (1.0 - stick)
    own = float(share(np.array(stick)))
    moment = own * stick**3 / 3.0 + float(width * (w @ (outside**2 * share(outside))))
    return 3.0 / (4.0 * np.pi) * own, 12.0 / np.pi * moment


def mindlin_shift(share: float, turned_at: float | None = None) -> float:
    """Tangential shift of a sphere's contact, in units of 3 mu P (2 - nu) / (16 G a).

    1 - (1 - Q / mu P)^(2/3), ``share`` = Q / mu P; after turning round at ``turned_at`` = Q* / mu P
    2 (1 - (Q* - Q) / (2 mu P))^(2/3) - (1 - Q* / mu P)^(2/3) - 1 (Johnson, sect. 7.4,
    after R. D. Mindlin, H. Deresiewicz, J. Appl. Mech. 20 (1953) 327).

    >>> round(mindlin_shift(-0.5, 0.5) + mindlin_shift(0.5), 12)  # a loop is symmetric
    0.0
    """
    power = 2.0 / 3.0
    if turned_at is None:
        return float(1.0 - (1.0 - share) ** power)
    back = 2.0 * (1.0 - 0.5 * (turned_at - share)) ** power
    return float(back - (1.0 - turned_at) ** power - 1.0)


def mindlin_loss(share: float) -> float:
    """Work lost in a cycle between plus and minus Q, in units of mu P times that of the shift:
    the loop's area, integrated."""
    x, w = np.polynomial.legendre.leggauss(60)
    back = np.array([mindlin_shift(float(each), share) for each in share * x])
    forth = np.array([-mindlin_shift(float(-each), share) for each in share * x])
    return float(share * (w @ (back - forth)))


def line_shift(share: float, turned_at: float | None = None) -> float:
    """Tangential shift of a line contact under Q = ``share`` mu P, in units of mu P / (pi E*).

    The normal approach of a half-plane is (C P - P ln P) / (pi E*), and the shift under Q is mu
    times that at P less that at P - Q / mu (Ciavarella's and Jaeger's theorem). With s = Q / mu P
    that is f(s) = (1 - s) ln(1 - s), and after turning round at s* f(s*) - 2 f((s* - s) / 2). A
    term in proportion to s is left out: it hangs on the body's depth.

    >>> round(line_shift(-0.5, 0.5) + line_shift(0.5), 12)  # a loop is symmetric
    0.0
    """
    if turned_at is None:
        return float((1.0 - share) * np.log1p(-share))
    return line_shift(turned_at) - 2.0 * line_shift(0.5 * (turned_at - share))


def line_loss(share: float) -> float:
    """Work lost by a line contact in a cycle between plus and minus Q, in (mu P)^2 / (pi E*).

    The area between the curves of :func:`line_shift`: 4 (1 - s) ln(1 - s) + 4 s - 2 s^2.

    >>> round(line_loss(1e-2) / (2.0 / 3.0 * 1e-2**3), 2)  # cubic for small forces
    1.01
    """
    return float(4.0 * (1.0 - share) * np.log1p(-share) + 4.0 * share - 2.0 * share**2)
