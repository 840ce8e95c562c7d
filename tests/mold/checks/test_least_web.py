"""The least distance between slots, against distances known by hand."""

from math import hypot, inf, sqrt

import pytest

from fingerdesign.mold.plan.plan import Slot
from fingerdesign.mold.plan.slots import webs


def slot(place, y, angle=0.0, length=2.0, width=0.4):
    return Slot(0, "+z", place, y, angle, length, width, 0.0, 0.0)


@pytest.mark.parametrize(
    ("slots", "wanted"),
    [
        ([slot(0, 0)], inf),
        ([slot(0, 0), slot(0, 1)], 0.6),
        ([slot(0, 0), slot(3, 1)], hypot(1.0, 0.6)),
        ([slot(0, 0), slot(1.0, 0.1)], 0.0),
        ([slot(0, 0, 45), slot(1, 0, 45)], 1 / sqrt(2) - 0.4),
        ([slot(0, 0), slot(0, 2, 90)], 0.8),
        ([slot(0, 0), slot(0, 0, 90)], 0.0),
        ([slot(0, 5), slot(0, 0), slot(40, 0), slot(0, 1)], 0.6),
    ],
)
def test_least_web(slots, wanted):
    assert webs(slots, exact=True)[2].min(initial=inf) == pytest.approx(wanted)
