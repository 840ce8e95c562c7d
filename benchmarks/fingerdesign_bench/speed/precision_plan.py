"""What the work-precision diagrams compare: charts, their lines, and the references of each.

A reference is of another kind than the method it judges where there is one: in plane strain a much
finer mesh of another element, in 3-D another mesher's mesh of like size. Two references of
different kinds are made for each group of lines; how far they disagree is drawn, and no error below
it means much.
"""

from dataclasses import dataclass, replace

from fingerdesign_bench.speed.precision_run import Method

PLANE = (0.4, 0.2, 0.1, 0.05, 0.025)  # mm, contact facets
PLANE_LINEAR = (*PLANE, 0.0125)  # linear elements have a quarter of the equations
SPACE = (0.8, 0.6, 0.45, 0.35, 0.28)
TETRAHEDRA = (0.8, 0.6, 0.45, 0.35)

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
    reference: str
    floor: str = ""
    quick: int = 2  # points of a short run


@dataclass(frozen=True)
class Group:
    """A row of panels; ``references``: two whose difference is drawn."""

    heading: str
    lines: tuple[Line, ...]
    references: tuple[str, str]


@dataclass(frozen=True)
class Chart:
    """One picture."""

    key: str
    title: str
    groups: tuple[Group, ...]


# At nu = 0.49 "mixed" is what the program chooses by itself.
_PLANE = Method("plane strain", "mixed")
_EXTRUDED, _TETWILD = Method("extruded", "mixed"), Method("tetwild", "mixed")


def _elements_at(poissons_ratio: float) -> tuple[tuple[Reference, Reference], Group]:
    mixed, quadratic, linear = (
        Method("plane strain", element, poissons_ratio) for element in ("mixed", "P2", "P1")
    )
    names = tuple(f"{element}, nu = {poissons_ratio:g}" for element in ("mixed", "P2"))
    references = (
        Reference(names[0], mixed, 0.0125, 0.05),
        Reference(names[1], quadratic, 0.0125, 0.05),
    )
    lines = (
        Line("P1", linear, PLANE_LINEAR, names[0], LOCKS, quick=3),
        Line("P2", quadratic, PLANE, names[0]),
        Line("mixed", mixed, PLANE, names[1]),
    )
    return references, Group(f"plane strain, nu = {poissons_ratio:g}", lines, (names[0], names[1]))


_SOFT, _SOFT_GROUP = _elements_at(0.49)
_HARD, _HARD_GROUP = _elements_at(0.4999)
_STIFF = {
    kind: Method(kind, "mixed", 0.4999, "none") for kind in ("extruded", "tetwild")
}  # in 3-D at nu = 0.4999

REFERENCES: tuple[Reference, ...] = (
    *_SOFT,
    *_HARD,
    Reference("3-D, extruded", _EXTRUDED, 0.2, 0.45),
    Reference("3-D, tetwild", _TETWILD, 0.22, 0.6),
    Reference("3-D, nu = 0.4999, extruded", _STIFF["extruded"], 0.22, 0.45),
    Reference("3-D, nu = 0.4999, tetwild", _STIFF["tetwild"], 0.28, 0.6),
)

_SPACE_GROUP = Group(
    "3-D, nu = 0.4999, no plates",
    tuple(
        Line(
            element,
            replace(_STIFF["extruded"], element=element),
            SPACE,
            "3-D, nu = 0.4999, tetwild",
            LOCKS if element == "P1" else "",
            quick=1,
        )
        for element in ("P1", "P2", "mixed")
    ),
    ("3-D, nu = 0.4999, tetwild", "3-D, nu = 0.4999, extruded"),
)

CHARTS: tuple[Chart, ...] = (
    Chart(
        "elements",
        "Elements: linear, quadratic, and quadratic with a pressure of their own",
        (_SOFT_GROUP, _HARD_GROUP, _SPACE_GROUP),
    ),
    Chart(
        "models",
        "Plane strain and 3-D, extruded and by fTetWild",
        (
            Group(
                "three plates",
                (
                    Line("plane strain", _PLANE, PLANE, _SOFT[1].name),
                    Line("plane strain against 3-D", _PLANE, PLANE, "3-D, extruded", MODEL),
                    Line("3-D, extruded", _EXTRUDED, SPACE, "3-D, tetwild"),
                    Line("3-D, tetwild", _TETWILD, TETRAHEDRA, "3-D, extruded", quick=1),
                ),
                ("3-D, extruded", "3-D, tetwild"),
            ),
        ),
    ),
    Chart(
        "plates",
        "Plates as solids, as sheets, and left out",
        (
            Group(
                "plane strain",
                tuple(
                    Line(
                        name,
                        replace(_PLANE, plates=name),
                        PLANE,
                        _SOFT[1].name,
                        "" if name == "solid" else MODEL,
                    )
                    for name in ("solid", "sheet", "none")
                ),
                (_SOFT[0].name, _SOFT[1].name),
            ),
            Group(
                "3-D, extruded",
                tuple(
                    Line(
                        name,
                        replace(_EXTRUDED, plates=name),
                        SPACE,
                        "3-D, tetwild",
                        "" if name == "solid" else MODEL,
                    )
                    for name in ("solid", "sheet", "none")
                ),
                ("3-D, extruded", "3-D, tetwild"),
            ),
        ),
    ),
)
