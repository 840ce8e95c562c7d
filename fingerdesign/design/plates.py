"""The ``[plates]`` table: rows of thin metal plates that carry the gages. Lengths in mm."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from fingerdesign.design.base import Many, Named, Table, bounded, key, refuse, refuse_key
from fingerdesign.design.body import Body
from fingerdesign.runtime.registry import PLATE_LAYOUTS

MAX_PLATES = 500  # far beyond what can be cast; keeps every check and CAD step bounded
_FARTHEST_MM = 500  # no body is larger
_MOST_DEG = 180
_HOLE_PITCH_MM = 2.0
_AS_PLATES = "as in [plates], for this row"


def _three_or_four(rows: Any) -> Any:
    """Refuse places of another length or far off any body, each by its number."""
    for index, row in enumerate(rows if isinstance(rows, (list, tuple)) else ()):
        if not isinstance(row, (list, tuple)):
            continue
        key, remedy = f"plates.placement[{index}]", "give [x, y, angle_deg] or [x, y, angle_deg, z]"
        if len(row) not in (3, 4):
            raise refuse(list(row), "three or four numbers", remedy, key)
        for name, value in zip(("x", "y", "angle_deg", "z"), row, strict=False):
            most = _MOST_DEG if name == "angle_deg" else _FARTHEST_MM
            number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if number and most < abs(value) < float("inf"):
                bound = f"such that {name} is from -{most} to {most}"
                raise refuse(list(row), bound, f"{remedy} in mm and degrees", key)
    return rows


class PlateLayout:
    """Layout of a row's plates below the surface; a new one defines at least ``placed``.

    level: each keeps the row's own angle, whatever the surface. bends: plates are bent to it.
    """

    level: ClassVar[bool] = False
    bends: ClassVar[bool] = False

    def placed(
        self, body: Body, row: Plates, pace: float, middle: float
    ) -> tuple[float, float, float, float | None]:
        """Centre in the section plane, mm, the turn of its angle, degrees, and its bend radius, mm.

        pace: how far along the row from its middle, mm; middle: of its span, across the row. NaN
        where there is no surface.
        """
        raise NotImplementedError


plate_layout = PLATE_LAYOUTS.kind  # registers a PlateLayout under the name of ``plates.follow``
Layout = Annotated[str, Named(PLATE_LAYOUTS)]


class Row(Table):
    """A further row of plates: what is not given is as in ``[plates]``."""

    count: int | None = bounded(None, 0, MAX_PLATES, _AS_PLATES)
    length_mm: float | None = bounded(None, 0.05, 200, _AS_PLATES)
    angle_deg: float | None = bounded(None, -180, 180, _AS_PLATES)
    pitch_mm: float | None = bounded(None, 0.01, 200, _AS_PLATES)
    cover_mm: float | None = bounded(None, 0.01, 500, _AS_PLATES)
    offset_mm: float | None = bounded(None, -250, 250, _AS_PLATES)
    span_mm: float | None = bounded(None, 0.1, 500, _AS_PLATES)
    span_offset_mm: float | None = bounded(None, -250, 250, _AS_PLATES)
    stagger_mm: float | None = bounded(None, -250, 250, _AS_PLATES)
    along: Literal["x", "z"] | None = key(None, _AS_PLATES)
    follow: Layout | None = key(None, _AS_PLATES)


class Plates(Table):
    """The plates that carry the gages: boxes in the section, ``span_mm`` long in z.

    ``model`` says how the finite elements see them; what is built and cast stays the same.
    """

    count: int = bounded(15, 0, MAX_PLATES, "0 allowed")
    thickness_mm: float = bounded(0.1, 0.005, 10, "in the section")
    length_mm: float = bounded(2.0, 0.05, 200, "in the section")
    angle_deg: float = bounded(45.0, -180, 180, "anticlockwise from the row's axis (+x)")
    alternate: bool = key(False, "every second plate of a row lies at -angle_deg")
    pitch_mm: float = bounded(1.0, 0.01, 200, "between plate centres, along the row")
    cover_mm: float = bounded(2.0, 0.01, 500, "plate centre below the surface, along y")
    offset_mm: float = bounded(0.0, -250, 250, "of the row's middle, along the row")
    span_mm: float | None = bounded(
        None, 0.1, 500, "across the row (along z); absent: the full depth", example=8.0
    )
    span_offset_mm: float = bounded(0.0, -250, 250, "of the plates' middles, across the row")
    stagger_mm: float = bounded(
        0.0, -250, 250, "every second plate lies this far from its neighbours across the row"
    )
    along: Literal["x", "z"] = key(
        "x", "x (feels shear in x) | z: the row runs along z, its plates span x"
    )
    follow: Layout = key(
        "level",
        "level (cover along y) | turned (cover along the surface's normal, pitch along "
        "the surface, angle from its tangent) | bent (turned, and bent to the surface's curve)",
    )
    hole_diameter_mm: float | None = bounded(
        None,
        0.05,
        50,
        "perforation, through which the rubber interlocks; absent: none",
        example=0.6,
    )
    hole_pitch_mm: float = bounded(
        _HOLE_PITCH_MM, 0.1, 200, "between holes, along the plate's middle line"
    )
    material: str = key("phosphor_bronze", "a name known or in [materials]")
    rows: Many[Row] = key(
        (),
        "further rows, each as [plates] but for its own keys: count, length_mm, "
        "angle_deg, pitch_mm, cover_mm, offset_mm, span_mm, span_offset_mm, stagger_mm, along, "
        "follow; [[plates.rows]] tables say the same",
        max_length=20,
        examples=[[{"along": "z", "count": 5, "cover_mm": 4.0, "span_mm": 6.0}]],
    )
    placement: Annotated[Many[Many[float]] | None, BeforeValidator(_three_or_four)] = key(
        None,
        "[[x, y, angle_deg], ...] or [x, y, angle_deg, z]: centres one by one instead "
        "of count, pitch, cover",
        max_length=MAX_PLATES,
        examples=[[[-1.0, 10.5, 45.0], [1.0, 10.5, 45.0]]],
    )
    model: Literal["solid", "sheet", "none"] = key(
        "solid",
        "solid | sheet (membrane and bending at the mid-surface) | none (gages stay, "
        "plates are left out of the model)",
    )

    def _misfits(self) -> Iterator[PydanticCustomError]:
        if self.placement is not None and self.rows:
            yield refuse(
                f"{len(self.rows)} rows",
                "absent where plates.placement is given",
                "write every plate into plates.placement, or remove it",
                "plates.rows",
            )
        elif self.rows and self.number > MAX_PLATES:
            yield refuse(
                f"{self.number} plates in {1 + len(self.rows)} rows",
                f"such that all rows together have at most {MAX_PLATES} plates",
                "lower plates.count or the rows' own",
                "plates.rows",
            )
        idle = {"along": "x", "follow": "level", "offset_mm": 0.0, "alternate": False}
        for name, value in idle.items() if self.placement is not None else ():
            if getattr(self, name) != value:
                bound = f"{value!r} where plates.placement is given"
                remedy = "remove it: plates.placement says where each plate lies"
                yield refuse_key(self, f"plates.{name}", bound, remedy)
        if self.hole_diameter_mm is None and self.hole_pitch_mm != _HOLE_PITCH_MM:
            bound = "absent where plates.hole_diameter_mm is not given"
            remedy = "remove it or give plates.hole_diameter_mm"
            yield refuse_key(self, "plates.hole_pitch_mm", bound, remedy)

    @property
    def layout(self) -> PlateLayout:
        """Return the layout of the row's plates."""
        found: PlateLayout = PLATE_LAYOUTS.find(self.follow, "plates.follow").made
        return found

    @property
    def all_rows(self) -> tuple[Plates, ...]:
        """Each row as a table of its own, the first as it is; without ``rows``."""
        first = self.model_copy(update={"rows": ()})
        further = [first.model_copy(update=row.model_dump(exclude_none=True)) for row in self.rows]
        return (first, *further)

    def full(self, depth_mm: float) -> bool:
        """Tell whether all plates are whole and span the full depth, mm, centred on z = 0."""
        if self.placement is not None:
            rows: tuple[Plates, ...] = (self,)
            centred = not any(any(place[3:]) for place in self.placement)
        else:
            rows, centred = self.all_rows, True
        full = centred and self.hole_diameter_mm is None and all(r.spans(depth_mm) for r in rows)
        return full or self.number == 0

    def spans(self, depth_mm: float) -> bool:
        """Tell whether the row's plates lie along z, over the full depth, mm."""
        moved = self.span_offset_mm != 0.0 or self.stagger_mm != 0.0
        return self.along == "x" and self.span_mm in (None, depth_mm) and not moved

    @property
    def number(self) -> int:
        """Return the number of plates, whether placed by pitch or one by one."""
        if self.placement is not None:
            return len(self.placement)
        return self.count + sum(self.count if r.count is None else r.count for r in self.rows)
