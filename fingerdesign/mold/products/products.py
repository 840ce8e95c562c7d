"""The files that people make and buy by: 3MF, drawings, bill of materials; and what records say."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.mold.plan.legs import legs_share
from fingerdesign.mold.products.bill import (
    Item,
    Silicone,
    bill_of_materials,
    silicone_of,
    write_bill,
)
from fingerdesign.mold.products.flat_pattern import FlatPattern, flat_patterns
from fingerdesign.mold.products.notes import casting_notes
from fingerdesign.mold.products.preparation import Bench
from fingerdesign.mold.products.sheets import write_drawings
from fingerdesign.mold.products.three_mf import Posed, laid_out, write_3mf
from fingerdesign.mold.products.warnings import warnings_of
from fingerdesign.mold.record import (
    bill_data,
    checks_data,
    fixture_data,
    notes_data,
    part_data,
    pattern_data,
    placement_rows,
    silicone_data,
)

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.part import Check, MoldMeshes
    from fingerdesign.mold.plan.plan import MoldPlan

PRINT_FILE, BILL_FILE = "mold.3mf", "bill_of_materials.csv"


@dataclass(frozen=True)
class Products:
    """What was written beside the CAD files, for the record."""

    folder: Path
    patterns: tuple[FlatPattern, ...]
    posed: tuple[Posed, ...]
    silicone: Silicone
    items: tuple[Item, ...]

    def values(
        self,
        design: Design,
        plan: MoldPlan,
        meshes: MoldMeshes,
        checks: tuple[Check, ...],
        placement: dict[str, Any],
    ) -> dict[str, Any]:
        """The fields of a MoldReport that tell of parts, plates, checks, silicone and work."""
        posed = {each.name: each for each in self.posed}
        bench = Bench(design, plan, meshes.parts, self.patterns, self.silicone)
        return {
            "parts": tuple(
                part_data(part, number, posed.get(part.name), self._files(part.name))
                for number, part in enumerate(meshes.parts, start=1)
            ),
            "plates": tuple(
                pattern_data(pattern, self._files(pattern.name)) for pattern in self.patterns
            ),
            "placements": placement_rows(plan, self.patterns),
            "fixture": fixture_data(plan),
            "checks": checks_data(checks),
            "silicone": silicone_data(self.silicone),
            "placement": placement,
            "warnings": warnings_of(design, plan, legs_share(design, plan), placement),
            "notes": notes_data(casting_notes(bench)),
            "bill": bill_data(self.items),
        }

    def _files(self, name: str) -> list[str]:
        return sorted(
            path.name
            for kind in ("stl", "step", "dxf")
            if (path := self.folder / f"{name}.{kind}").is_file()
        )


def write_products(design: Design, plan: MoldPlan, meshes: MoldMeshes, folder: Path) -> Products:
    """mold.3mf, the drawings and bill_of_materials.csv; GeometryError where one is not sound."""
    patterns = flat_patterns(design, plan)
    posed = laid_out(tuple(part for part in meshes.parts if part.made == "process"))
    write_3mf(posed, folder / PRINT_FILE, f"{design.design.name}: mold")
    write_drawings(plan, meshes, patterns, folder)
    silicone = silicone_of(design, plan, meshes)
    items = bill_of_materials(design, plan, meshes, patterns, silicone)
    write_bill(items, folder / BILL_FILE)
    return Products(folder, patterns, posed, silicone, items)
