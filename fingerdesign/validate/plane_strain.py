"""Errors of plane strain for a finger in a scene, before anything is run (numpy only)."""

import itertools
import json
import math
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import contact_reach, greatest_approach
from fingerdesign.report.page import paragraphs

# All errors are plane strain against 3-D at the mid-plane: forces and contact width relative
# (signed: > 0 where plane strain says more), stick ratio absolute, gage strains relative to the
# largest 3-D reading of the increment (the worst plate, pressed or sheared; ``gage_both``: the mean
# of both faces, ``gage_face``: each face alone). Those at equal force begin with ``force_``.

MOTION = (
    *("normal_force", "tangential_force", "contact_width", "stick_ratio"),
    *("gage_both", "gage_face"),
)
FORCE = ("force_contact_width", "force_stick_ratio", "force_gage_both", "force_gage_face")
QUANTITIES = MOTION + FORCE
# What the map is looked up by.
RATIOS = ("poissons_ratio", "span_over_depth", "depth_over_height", "half_width_over_height")


# The map of where plane strain holds: errors over four ratios, looked up between the models.
#
# The ratios are depth over height D/H (of the crest), contact half-width over height a/H, Poisson's
# ratio and the plates' span over the depth (0: no plates). Numpy only: the table is made once, by
# ``fingerdesign bench plane-strain``, and ships with the program.

Table = dict[str, Any]

WORDS = Path(__file__).parent / "templates" / "words.txt.j2"

SHIPPED = "plane_strain.json"
_WITHIN = 1e-9
# The forecast of the contact's half-width errs to the wide side, the more the wider: in 3-D the 63
# models of the study have 0.93 - 0.5 a/H of it, give or take 0.06.
_FORECAST, _FORECAST_WIDE, _FORECAST_LEAST = 0.93, 0.5, 0.5
# As in designs/studies/plane_strain.toml:
_STUDY_PULL = 0.4  # shear over approach
_STUDY_LENGTH = 2.0 / (30.0 - math.sqrt(300.0))  # plates' length over the crest's height
_PULLED = ("tangential_force", "stick_ratio")  # what goes on changing as the finger is pulled
_OUTSIDE = 2.0  # times the uncertainty, where the ratios lie beyond those that were computed


@dataclass(frozen=True)
class PlaneStrainMap:
    """Errors on a grid.

    poisson (p,), span (s,), depth (d,): D/H, ascending; width (p, s, d, k): log(a/H) of each
    approach, ascending; errors: by quantity (p, s, d, k), NaN where there is none; table: what was
    fixed, the one-off models, the rules, as the file holds them.
    """

    poisson: Array
    span: Array
    depth: Array
    width: Array
    errors: dict[str, Array]
    table: Table

    def error(
        self, quantity: str, poisson: float, span: float, depth: float, width: float
    ) -> float:
        """The error at one point: linear in Poisson's ratio and span, in log D/H and log a/H.

        Beyond the grid its border's value holds (see :meth:`inside`). NaN where there is none.
        """
        at = [
            _place(self.poisson, poisson),
            _place(self.span, span),
            _place(np.log(self.depth), np.log(depth)),
        ]
        total = 0.0
        for near in itertools.product(*at):
            corner = tuple(number for number, _ in near)
            share = math.prod(share for _, share in near)
            if share > _WITHIN:
                values = self.errors[quantity][corner]
                total += share * float(np.interp(np.log(width), self.width[corner], values))
        return total

    def inside(self, poisson: float, span: float, depth: float, width: float) -> bool:
        """True if a point lies within the ratios that were computed."""
        ranges = ((self.poisson, poisson), (self.span, span), (self.depth, depth))
        within = all(axis[0] - _WITHIN <= value <= axis[-1] + _WITHIN for axis, value in ranges)
        wide = np.exp([self.width[..., 0].max(), self.width[..., -1].min()])
        return bool(within and wide[0] <= width <= wide[1])


def _place(axis: Array, value: float) -> list[tuple[int, float]]:
    """Neighbours of a value on an ascending axis, and their shares."""
    place = float(np.interp(value, axis, np.arange(len(axis))))
    low = int(place)
    return [(low, low + 1.0 - place), (low + 1, place - low)]


def map_of(table: Table) -> PlaneStrainMap:
    """The map that a table holds. ValueError where its points are no full grid."""
    *names, wide = RATIOS
    points = sorted(table["points"], key=lambda each: [each[name] for name in names])
    axes = [np.unique([each[name] for each in points]) for name in names]
    shape = tuple(len(axis) for axis in axes)
    if len(points) != np.prod(shape) or len({len(each["rows"]) for each in points}) != 1:
        raise ValueError(f"{len(points)} models are no full grid of {shape}")

    def values(name: str) -> Array:
        rows = [[row[name] for row in each["rows"]] for each in points]
        return np.array(rows, dtype=float).reshape(*shape, -1)  # None: NaN

    errors = {name: values(name) for name in QUANTITIES}
    return PlaneStrainMap(axes[0], axes[1], axes[2], np.log(values(wide)), errors, table)


@cache
def shipped_map() -> PlaneStrainMap:
    file = resources.files("fingerdesign") / "data" / SHIPPED
    return map_of(json.loads(file.read_text("utf-8")))


@dataclass(frozen=True)
class PlaneStrainEstimate:
    """A forecast of plane strain against 3-D at the mid-plane, for one finger and contact.

    errors: by quantity (QUANTITIES above; "gage" and "force_gage" are those of the
    design's gages.face); signed where those are; uncertainty: by quantity, of the same unit, such
    that nine of ten one-off models lie within it. A quantity that has no value is left out.
    ratios: what it was looked up by; inside: whether the map was computed there; notes: why some
    uncertainty is wider than that.
    """

    errors: dict[str, float]
    uncertainty: dict[str, float]
    ratios: dict[str, float]
    inside: bool
    notes: tuple[str, ...] = ()

    def most(self, quantity: str) -> float:
        """The greatest error that is to be reckoned with."""
        return abs(self.errors[quantity]) + self.uncertainty[quantity]

    def least(self, quantity: str) -> float:
        """The least error that is to be reckoned with, not below 0."""
        return max(0.0, abs(self.errors[quantity]) - self.uncertainty[quantity])

    @property
    def words(self) -> str:
        return paragraphs(WORDS, "plane_strain_estimate", of=self)[0]


def plane_strain_error(
    design: Design, scene: Scene | None = None, half_width: float | None = None
) -> PlaneStrainEstimate:
    """The estimate for a straight finger whose contact is ``half_width`` (mm) half as wide, or as
    wide as ``scene`` is forecast to make it at its greatest approach. With a ``scene`` that pulls
    further than the study did the uncertainty of what the pull changes reaches the error of F_n;
    plates shorter than the study's make it reach the error without plates.

    Raises DesignError for a body or an object that no section shows: there plane strain is a sketch
    whose error no ratio tells. ValueError where neither scene nor half_width is given.
    """
    if not design.body.straight:
        raise _refused("body.shape", design.body.shape, "'arc' or 'block'")
    half_width = _half_width(design, scene) if half_width is None else half_width
    chart = shipped_map()
    height = float(crest_height(design.body))
    poisson = design.material_of("body").poissons_ratio
    depth, width = design.body.depth_mm / height, half_width / height
    place = (poisson, _span(design), depth, width)
    inside = chart.inside(*place)
    gaged = bool(design.plates.number) and design.gages.grid == "axial"  # as the map's
    errors = _errors(chart, place, gaged)
    unsure = _uncertainty(chart, errors, 1.0 if inside else _OUTSIDE)
    notes = []
    if design.plates.number and not gaged:
        grid = design.gages.grid
        notes.append(f"what it does to {grid} gages is not known: the study's are axial")
    if place[1] > 0.0 and _shortest_plate(design) < (1.0 - 1e-9) * _STUDY_LENGTH * height:
        notes.append(_widen_to_bare(errors, unsure, chart, place))
    if scene is not None and _pulls_further(scene):
        notes.append(_widen_to_slip(errors, unsure))
    errors, unsure = (_with_own_gages(design, each) for each in (errors, unsure))
    ratios = dict(zip(RATIOS, place, strict=True))
    return PlaneStrainEstimate(errors, unsure, ratios, inside, tuple(notes))


def _errors(
    chart: PlaneStrainMap, place: tuple[float, float, float, float], gaged: bool
) -> dict[str, float]:
    """The errors that the map knows at a place; those of gages where the design's are the map's."""
    names = [name for name in chart.errors if gaged or "gage" not in name]
    errors = {name: chart.error(name, *place) for name in names}
    return {name: value for name, value in errors.items() if math.isfinite(value)}


def _with_own_gages(design: Design, values: dict[str, float]) -> dict[str, float]:
    """The values and those of the design's own gages, which read one face or the mean of both."""
    kind = "both" if design.gages.face == "both" else "face"
    own = {"gage": f"gage_{kind}", "force_gage": f"force_gage_{kind}"}
    return values | {name: values[source] for name, source in own.items() if source in values}


def _refused(key: str, value: str, bound: str) -> DesignError:
    """The refusal of a body or an object that no section shows."""
    why = f"{bound} for an estimate of what plane strain gets wrong"
    return DesignError([Fault(key, value, why, "compare with 3-D")])


def _uncertainty(
    chart: PlaneStrainMap, errors: dict[str, float], factor: float
) -> dict[str, float]:
    """The uncertainty of each error: an absolute part and one relative to it, times a factor."""
    known, found = chart.table.get("uncertainty", {}), {}
    for name, value in errors.items():
        own = known.get(name, {"relative": 0.5, "absolute": 0.05})
        found[name] = (own["absolute"] + own["relative"] * abs(value)) * factor
    return found


def _shortest_plate(design: Design) -> float:
    """Length of the shortest plate along x, mm."""
    return min(frame.length for frame in plate_frames(design) if frame.along == "x")


def _widen_to_bare(
    errors: dict[str, float],
    unsure: dict[str, float],
    chart: PlaneStrainMap,
    place: tuple[float, float, float, float],
) -> str:
    """Let the uncertainty reach the errors without plates, gages apart: those are on plates."""
    poisson, _, depth, width = place
    for quantity, value in errors.items():
        bare = chart.error(quantity, poisson, 0.0, depth, width)
        if "gage" not in quantity and math.isfinite(bare):
            unsure[quantity] = max(unsure[quantity], abs(bare - value))
    return (
        "plates shorter than the study's hold the rubber less: the errors lie between those with "
        "and without plates"
    )


def _widen_to_slip(errors: dict[str, float], unsure: dict[str, float]) -> str:
    """Let the uncertainty reach the error of F_n: at complete slip F_t is friction times F_n."""
    most = abs(errors["normal_force"]) + unsure["normal_force"]
    for quantity in _PULLED:
        if quantity in errors:
            unsure[quantity] = max(unsure[quantity], most - abs(errors[quantity]))
    return (
        f"pulled further than {_STUDY_PULL:g} of the approach: the errors of F_t and stick ratio "
        f"may grow to that of F_n, {100.0 * most:.0f} %"
    )


def _pulls_further(scene: Scene) -> bool:
    """True if some row shears more than the study; forces with a pull do not tell, and may."""
    if scene.path.control == "force":
        return any(any(row[1:]) for row in scene.path.rows)
    return any(
        math.hypot(*row[1:3]) > (1.0 + 1e-9) * _STUDY_PULL * row[0]
        for row in scene.path.rows
        if row[0] > 0.0
    )


def _half_width(design: Design, scene: Scene | None) -> float:
    if scene is None:
        raise ValueError("give a scene or a half_width")
    if not scene.object.plane_in_z:
        raise _refused("object.shape", scene.object.shape, "the same in every section")
    reach = contact_reach(design, scene.object, greatest_approach(design, scene))[0]
    if not design.body.kind.flat or not scene.object.flat:  # a flat touches at once
        wide = reach / float(crest_height(design.body))
        reach *= max(_FORECAST - _FORECAST_WIDE * wide, _FORECAST_LEAST)
    return min(reach, 0.5 * design.body.width_mm)


def _span(design: Design) -> float:
    """The plates' mean span over the depth; 0 where there are none in the model."""
    spans = [frame.span for frame in plate_frames(design) if frame.along == "x"]
    if not spans or design.plates.model == "none":
        return 0.0
    return sum(spans) / len(spans) / design.body.depth_mm
