"""Parts that are sold: strain gages by their sizes, sheet by its thickness. Lengths in mm.

The catalogue is data/stock.toml, which says where its numbers are from; a design adds types of its
own as ``[[mold.gage_types]]``, which come first.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from fingerdesign.design.base import Table, bounded, key, positive, refuse

STOCK_FILE = "stock.toml"
_SAME_MM = 1e-6


class GageType(Table):
    """``[[mold.gage_types]]``: a strain gage as it is sold, or made.

    Film is made to measure: its grid is the least one, its carrier larger than any grid by what it
    is larger than that one.
    """

    name: str = Field(min_length=1, max_length=60, description="by which mold.gage takes it")
    kind: Literal["foil", "tee", "bar", "film", "fibre"] = key(
        "foil",
        "foil | tee (two grids across each other) | bar (of bare silicon) | film "
        "(made to measure) | fibre",
    )
    grid_length_mm: float = positive(..., 200, "along the strain that it reads")
    grid_width_mm: float = positive(..., 200, "across it")
    carrier_length_mm: float = positive(..., 500, "of all that lies on the plate, tabs included")
    carrier_width_mm: float = positive(..., 500, "of the same, across")
    resistance_ohm: float = bounded(120.0, 0, 1e6, "of a grid")
    gage_factor: float = positive(2.0, 500, "relative change of resistance per strain")
    transverse_sensitivity: float = bounded(0.0, -0.2, 0.2, "to strain across, share of its own")
    bend_mm: float = bounded(3.0, 0, 500, "least radius that it is bent to")
    thickness_mm: float = bounded(0.0, 0, 10, "of all that stiffens the plate; 0: not known")
    modulus_MPa: float = bounded(0.0, 0, 1e6, "mean of that along the grid; 0: not known")
    least_order: int = bounded(1, 1, 10_000, "pieces; of film: sheets")
    lead_weeks: float = bounded(0.0, 0, 200, "from order to delivery; 0: not known")
    price: Literal["low", "middle", "high", ""] = key(
        "", "of a piece: low (below 20 EUR) | middle (to 50) | high; absent"
    )
    source: str = key("", "of these numbers")
    date: str = key("", "of the source, as read", max_length=20)

    def _misfits(self) -> Iterator[PydanticCustomError]:
        for side in ("length", "width"):
            grid, carrier = (getattr(self, f"{of}_{side}_mm") for of in ("grid", "carrier"))
            if carrier < grid:
                bound = f"at least grid_{side}_mm = {grid:g}: the grid lies on its carrier"
                yield refuse(carrier, bound, "widen it", f"mold.gage_types.carrier_{side}_mm")

    @property
    def stiffness(self) -> float:
        """Modulus times thickness, N/mm: what the gage adds to a plate's own, below it."""
        return self.modulus_MPa * self.thickness_mm

    @property
    def to_measure(self) -> bool:
        """Tell whether its grid is made as long and wide as a design requires."""
        return self.kind == "film"

    def carrier(self, length: float, width: float) -> tuple[float, float]:
        """Length and width of what has to lie on a plate, for a grid (mm) that a design asks for.

        >>> film = GageType(name="f", kind="film", grid_length_mm=0.2, grid_width_mm=0.2,
        ...                 carrier_length_mm=0.5, carrier_width_mm=1.0)
        >>> [round(size, 3) for size in film.carrier(0.5, 0.1)]
        [0.8, 1.0]
        """
        if not self.to_measure:
            return self.carrier_length_mm, self.carrier_width_mm
        return (
            self.carrier_length_mm + max(length - self.grid_length_mm, 0.0),
            self.carrier_width_mm + max(width - self.grid_width_mm, 0.0),
        )


@cache
def _shipped() -> Mapping[str, Any]:
    text = (resources.files("fingerdesign") / "data" / STOCK_FILE).read_text("utf-8")
    return tomllib.loads(text)


@cache
def shipped_types() -> tuple[GageType, ...]:
    """The catalogue's gages, each with the catalogue's source."""
    source = {"source": _shipped()["source"], "date": _shipped()["date"]}
    return tuple(GageType.model_validate(source | each) for each in _shipped()["gages"])


def sheets_of(material: str) -> tuple[float, ...]:
    """Thicknesses that a material's sheet is sold in, mm, the thinnest first."""
    family = "polyimide" if "polyimide" in material else "metal"
    return tuple(_shipped()["sheets"][family])


def nearest_sheet(thickness: float, stock: Sequence[float]) -> float | None:
    """The nearest of ``stock`` to a thickness, mm; None where it is one of them.

    >>> nearest_sheet(0.12, (0.1, 0.15)), nearest_sheet(0.15, (0.1, 0.15))
    (0.1, None)
    """
    nearest = min(stock, key=lambda each: abs(each - thickness))
    return None if abs(nearest - thickness) < _SAME_MM else nearest
