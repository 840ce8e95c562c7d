"""Plan of the work-precision diagrams: charts, their lines, and the references of each.

A reference is of another kind than the method it judges where there is one: in plane strain a much
finer mesh of another element, in 3-D another mesher's mesh of like size; of a shipped finger finer
prisms. Two references of different kinds are made for each other group of lines; how far they
disagree is drawn, and no error below it means much.
"""

from dataclasses import replace

from fingerdesign_bench.speed.precision_lines import (
    LOCKS,
    PLANE,
    Chart,
    Group,
    Line,
    Reference,
    elements_at,
    finger_group,
    plates_lines,
)
from fingerdesign_bench.speed.precision_run import Method

SPACE = (0.8, 0.6, 0.45, 0.35, 0.28)
FINGERS = ("maeno2000", "sensitive", "tees", "fine_tees")

# At nu = 0.49 "mixed" is what the program chooses by itself.
_PLANE = Method("plane strain", "mixed")
_EXTRUDED, _TETWILD = Method("extruded", "mixed"), Method("tetwild", "mixed")
_SOFT = elements_at(0.49)
_SWEPT = Reference("3-D, extruded", _EXTRUDED, 0.2, 0.45)
_CUT = Reference("3-D, tetwild", _TETWILD, 0.22, 0.6)
_HARD_SWEPT = Reference(
    "3-D, nu = 0.4999, extruded", Method("extruded", "mixed", 0.4999, "none"), 0.22, 0.45
)
_HARD_CUT = Reference(
    "3-D, nu = 0.4999, tetwild", Method("tetwild", "mixed", 0.4999, "none"), 0.28, 0.6
)
_HARD_SPACE = Group(
    "3-D, nu = 0.4999, no plates",
    tuple(
        Line(
            element,
            replace(_HARD_SWEPT.method, element=element),
            SPACE,
            _HARD_CUT,
            LOCKS if element == "P1" else "",
            quick=1,
        )
        for element in ("P1", "P2", "mixed")
    ),
    (_HARD_CUT, _HARD_SWEPT),
)

CHARTS: tuple[Chart, ...] = (
    Chart(
        "elements",
        "Elements: linear, quadratic, and quadratic with a pressure of their own",
        (_SOFT, elements_at(0.4999), _HARD_SPACE),
    ),
    Chart(
        "cells",
        "Four shipped fingers: tetrahedra, prisms and plane strain",
        tuple(finger_group(name) for name in FINGERS),
        fingers=True,
    ),
    Chart(
        "plates",
        "Plates as solids, as sheets, and left out",
        (
            Group(
                "plane strain", plates_lines(_PLANE, PLANE, _SOFT.references[1]), _SOFT.references
            ),
            Group("3-D, extruded", plates_lines(_EXTRUDED, SPACE, _CUT), (_SWEPT, _CUT)),
        ),
    ),
)
