"""Meshers by the name that ``mesh.mesher`` takes, each registered where it is written.

@mesher("mine", table=Mine)
class MyMesher(Mesher):
    def make(self, design, own, zone, symmetric):
        return Mesh(...)
"""

from typing import Any, ClassVar

from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.layout.layers import sweepable
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.types import Mesh
from fingerdesign.runtime.registry import MESHERS, own_values

AUTO = "auto"


class Mesher:
    """Maker of the tetrahedra of a finger, or of its half z >= 0; it defines at least ``make``.

    sections: it draws the section first, by the section's mesher. elements_from: where a forecast
    has its number of elements from, in words.
    """

    sections: ClassVar[bool] = False
    elements_from: ClassVar[str] = "a size field integrated over the body"

    def make(self, design: Design, own: Any, zone: Zone, symmetric: bool) -> Mesh:
        """The mesh, fine in the candidate zone. own: its own table, ``[mesh.NAME]``; symmetric:
        whether the half will do. Raises MeshError."""
        raise NotImplementedError

    def why_not(self, design: Design) -> str | None:
        """The obstacle to meshing a design so, as a clause; None without one."""
        return None

    def refusals(self, design: Design, symmetric: bool) -> list[Fault]:
        """Faults that stop it on a sound design, before any work; symmetric: of the half."""
        return []


mesher = MESHERS.kind  # registers a Mesher; its own keys are the table ``[mesh.NAME]``


def mesher_name(design: Design) -> str:
    """The mesher that a design names; "auto": layers where they can be swept, else fTetWild."""
    named = design.mesh.mesher
    if named != AUTO:
        return named
    return "sweep" if sweepable(design) else "tetwild"


def mesher_of(design: Design) -> Mesher:
    """The mesher of a design."""
    found: Mesher = MESHERS.find(mesher_name(design), "mesh.mesher").made
    return found


def mesh_finger(design: Design, zone: Zone, symmetric: bool = True) -> Mesh:
    """The finger, or its half z >= 0, by the design's mesher. Raises MeshError."""
    kind = MESHERS.find(mesher_name(design), "mesh.mesher")
    return mesher_of(design).make(design, own_values(design.mesh, kind), zone, symmetric)


@mesher("auto", place=4)
class Auto(Mesher):
    """The one that suits the finger: :func:`mesher_of` returns which."""
