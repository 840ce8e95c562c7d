"""A mesh as files hold it: linear or quadratic simplices, regions and boundaries by name."""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.sheets import CAP, FACES

StringArray = NDArray[np.str_]

FACET_NUMBERS = {"base": 1, "contact": 2, "side": 3, "end": 4, "symmetry": 5}
FIRST_SLOT, FIRST_CAP, LAST_CAP = 1000, 4000, 5000


@dataclass(frozen=True)
class NamedMesh:
    """points (n, dim), mm; cells (c, dim + 1), or (c, 6 or 10) with mid-edge nodes; region (c,):
    its name for every cell, "" where it has none; facets: name -> (f, dim) corners of boundary
    facets."""

    points: Array
    cells: IntArray
    region: StringArray
    facets: dict[str, IntArray]

    @property
    def dimension(self) -> int:
        return int(self.points.shape[1])

    @property
    def quadratic(self) -> bool:
        """True where the cells have mid-edge nodes."""
        return int(self.cells.shape[1]) > self.dimension + 1


def region_number(name: str) -> int | None:
    """0 for "elastomer", k + 1 for "plate_k", None for other names."""
    if name == "elastomer":
        return 0
    plate = re.fullmatch(r"plate_([0-9]{1,4})", name)
    return int(plate[1]) + 1 if plate else None


def region_name(number: int) -> str:
    """The name of a region's number. MeshError for a negative one."""
    if number < 0:
        raise MeshError("there are cells in negative regions; 0 is the elastomer")
    return f"plate_{number - 1}" if number else "elastomer"


def facet_number(name: str) -> int:
    """The number of a boundary's name in files that hold no names."""
    if name in FACET_NUMBERS:
        return FACET_NUMBERS[name]
    slot = re.fullmatch(rf"plate_([0-9]+)_({'|'.join((*FACES, CAP))})", name)
    number, last = LAST_CAP, LAST_CAP
    if slot and slot[2] == CAP:
        number = FIRST_CAP + int(slot[1])
    elif slot:
        number, last = FIRST_SLOT + 3 * int(slot[1]) + FACES.index(slot[2]), FIRST_CAP
    if number >= last:
        raise MeshError(f"facet name '{name}' has no number: not in FACET_NUMBERS, no slot's face")
    return number


def facet_name(number: int) -> str:
    """The name of a facet number; "" for none."""
    if FIRST_CAP <= number < LAST_CAP:
        return f"plate_{number - FIRST_CAP}_end"
    if FIRST_SLOT <= number < FIRST_CAP:
        plate, face = divmod(number - FIRST_SLOT, 3)
        return f"plate_{plate}_{FACES[face]}"
    return next((name for name, known in FACET_NUMBERS.items() if known == number), "")
