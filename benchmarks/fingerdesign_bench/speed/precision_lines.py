"""Parts of the plan of the work-precision diagrams: charts, groups, lines and references."""

from dataclasses import dataclass, replace

from fingerdesign_bench.speed.precision_run import Method, Plates

PLANE = (0.4, 0.2, 0.1, 0.05, 0.025)  # mm, contact facets
PLANE_LINEAR = (*PLANE, 0.0125)  # linear elements have a quarter of the equations
# Of shipped fingers: 2 to 4 layers in half the depth, and 6 of their reference.
SWEPT, FINE = (0.8, 0.56, 0.4), 0.26
TETRAHEDRA = (1.2, 0.8)
LOCKS = "locks"
MODEL = "the model's own error"


@dataclass(frozen=True)
class Reference:
    """A solution that errors are measured from; ``quick_size_mm`` for a short run."""

    name: str
    method: Method
    size_mm: float
    quick_size_mm: float


@dataclass(frozen=True)
class Line:
    """One method over mesh sizes; ``floor`` names what is left where it does not converge."""

    label: str
    method: Method
    sizes: tuple[float, ...]
    reference: Reference
    floor: str = ""
    quick: int = 2  # points of a short run


@dataclass(frozen=True)
class Group:
    """A row of panels; ``references``: two whose difference is drawn."""

    heading: str
    lines: tuple[Line, ...]
    references: tuple[Reference, Reference]


@dataclass(frozen=True)
class Chart:
    """One picture; ``fingers``: its groups are fingers with the same lines, in the same panels."""

    key: str
    title: str
    groups: tuple[Group, ...]
    fingers: bool = False


def elements_at(poissons_ratio: float) -> Group:
    """The elements in plane strain; mixed and quadratic ones judge each other."""
    title = f"nu = {poissons_ratio:g}"
    mixed, quadratic, linear = (
        Method("plane strain", element, poissons_ratio) for element in ("mixed", "P2", "P1")
    )
    fine = Reference(f"mixed, {title}", mixed, 0.0125, 0.05)
    other = Reference(f"P2, {title}", quadratic, 0.0125, 0.05)
    lines = (
        Line("P1", linear, PLANE_LINEAR, fine, LOCKS, quick=3),
        Line("P2", quadratic, PLANE, fine),
        Line("mixed", mixed, PLANE, other),
    )
    return Group(f"plane strain, {title}", lines, (fine, other))


def plates_lines(
    method: Method, sizes: tuple[float, ...], reference: Reference
) -> tuple[Line, ...]:
    """The same method with solid plates, sheets and none."""
    models: tuple[Plates, ...] = ("solid", "sheet", "none")
    return tuple(
        Line(name, replace(method, plates=name), sizes, reference, "" if name == "solid" else MODEL)
        for name in models
    )


def finger_group(name: str) -> Group:
    """The ways to model a shipped finger, against fine prisms."""
    plane, swept, cut, tetwild = (
        Method(kind, finger=name) for kind in ("plane strain", "extruded", "tetrahedra", "tetwild")
    )
    fine = Reference(name, swept, FINE, 0.56)
    lines = (
        Line("tetrahedra by fTetWild", tetwild, TETRAHEDRA, fine, quick=0),
        Line("swept tetrahedra", cut, SWEPT, fine, quick=1),
        Line("swept prisms", swept, SWEPT, fine, quick=1),
        Line("plane strain", plane, PLANE[1:4], fine, MODEL, quick=1),
    )
    return Group(name, lines, (fine, fine))
