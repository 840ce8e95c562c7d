"""The space of a search for a passing finger: what it begins with, and what the user gives up.

Roles: the body (radius, height, depth), the plates, the gages, the plates' material, the hand. A
user keeps keys or whole tables, and frees further ones.
"""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fingerdesign.checks.load import judge_data, load_design, with_values
from fingerdesign.design.body import Body
from fingerdesign.design.io import design_data
from fingerdesign.design.keys import leaves, set_value
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.rows import plate_frames
from fingerdesign.materials import MATERIALS
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.passing.freedom import Freedom
from fingerdesign.search.passing.ranges import (
    GAGE_SHARE,
    PASSING,
    flat_of,
    inside,
    moved,
    own_values,
    parameters_of,
    starts_of,
)
from fingerdesign.search.study.values import Choice, Parameter, set_keys

# Plates of it give a signal: the stiffest that is sold as thin film.
_FILM = "polyimide"
_SOFT_MPA = 2e4  # Plates of stiffer materials respond too little in rubber (bronze: a fiftieth).
# Trials near to the best one: so much of a range as standard deviation, one drawn for each trial,
# and the share of keys that change. Of fingers drawn from the whole box three of four cannot exist.
_NEAR = (0.05, 0.1, 0.2)
_CHANGED = 0.5
_TRIES = 100  # Draws of a trial until one can exist.
_AGAIN = 4  # Trials of a shape that was given up which are made again.
_SIZES = ("width", "depth", "base_height")
_FEWER = (9, 7, 5, 3)
# Of a body's depth: plates below a dome end before it falls too far. The longest that fits.
_SPANS = (0.6, 0.45, 0.3)
# All of [plates] that a plain row of full span needs; other layouts are replaced by such a row.
_PLAIN = ("count", "thickness_mm", "length_mm", "angle_deg", "pitch_mm", "cover_mm", "material")


@dataclass(frozen=True)
class Space:
    """Freedom of the search: the design it begins with, ranges, first trials, and what changed
    before it began.

    base: the design with the fixed changes. starts: values of all parameters, the design's own
    first where they lie in the ranges. arc_first: trials are made on an arc of the same section,
    and those that are good again on the body itself. given_up: keys of the user's that were given
    up, since no finger with them passed.
    """

    base: Design
    parameters: dict[str, Parameter]
    starts: tuple[dict[str, Choice], ...]
    replaced: tuple[str, ...] = ()
    arc_first: bool = False
    given_up: tuple[str, ...] = ()

    def on_arc(self, design: Design) -> Design:
        """The finger that a trial analyses: of a round body the arc of the same section, of the
        user's own CAD an arc of its size; the body itself where no such arc can exist."""
        if not self.arc_first:
            return design
        body, span = design.body, design.plates.span_mm
        arc: dict[str, object] = {"body.shape": "arc", "body.dome_radius_mm": None}
        if body.shape == "step":
            own = {f"body.{key}_mm": getattr(body, f"{key}_mm") for key in _SIZES}
            arc |= {"body.step": None, "body.arc_radius_mm": _crown_mm(body), **own}
        tries = [arc]
        if body.shape == "revolved" and span is not None:
            # A pin touches on a circle, about as wide as an arc that is as deep as its plates. Six
            # fingers of one pin rank by such arcs as they do themselves, by full ones they do not;
            # four of a dome are nearer to full ones.
            tries.insert(0, arc | {"body.depth_mm": span})
        for values in tries:
            with suppress(DesignError):  # Its core or its edges may need more depth.
                return with_values(design, values)
        return design

    def plainer(self, freedom: Freedom, tried: Sequence[Outcome] = ()) -> "Space | None":
        """The space without what the user may have to give up: a round shape or his own CAD for an
        arc of its size; a core, where there is nothing else or no trial's gages are good with it.
        None where that is nothing.

        tried: outcomes of trials; the best are the first trials again, with the same core.
        """
        base, given_up = self.base, list[str]()
        if self.arc_first and freedom.allows("body.shape"):
            arc = self.on_arc(base)
            if arc.body.shape == "arc":
                base, given_up = arc, ["body.shape"]
        good = [each for each in tried if each.metrics.get("shortfall") == 0.0]
        hinders = not (good and given_up)
        if base.body.core is not None and freedom.allows("body.core") and hinders:
            base = with_values(base, {"body.core": None})
            given_up += ["body.core"]
        if not given_up:
            return None
        if base.body.straight and not good and freedom.allows("plates.span_mm"):
            base = with_values(base, {"plates.span_mm": None})  # Nothing falls off at their ends.
        arc_first = self.arc_first and "body.shape" not in given_up
        space = Space(base, dict(parameters_of(base, freedom)), (), self.replaced, arc_first)
        own = own_values(base, space.parameters)
        again = [
            {key: inside(space.parameters[key], each.values.get(key, own[key])) for key in own}
            for each in good
        ]
        starts = _sound_starts(space, [*again[:_AGAIN], *starts_of(base, space.parameters)])
        return replace(space, starts=starts, given_up=tuple(given_up))

    def sound(self, values: Mapping[str, Choice]) -> bool:
        """True if a finger with the values can exist."""
        try:
            with_values(self.base, set_keys(self.base, dict(values)))
        except DesignError:
            return False
        return True

    def near(self, values: Mapping[str, Choice], chance: np.random.Generator) -> dict[str, Choice]:
        """A finger near to one with the values: some keys changed, the others as they are. The last
        draw where none of many can exist."""
        found = dict(values)
        for _ in range(_TRIES):
            spread = float(chance.choice(_NEAR))
            found = {
                key: moved(each, values[key], spread, chance)
                if chance.random() < _CHANGED
                else values[key]
                for key, each in self.parameters.items()
            }
            if found != values and self.sound(found):
                break
        return found


def space_of(design: Design, freedom: Freedom) -> Space:
    """The space of a search from a design. DesignError for keys that are unknown, or where nothing
    is left to vary."""
    if faults := freedom.faults(design):
        raise DesignError(faults, design.design.name)
    base, flat = _crowned(design, freedom)
    base, lost = _plain_row(base, freedom)
    base = with_values(base, _fixed(base, freedom))
    flat_dome = base.body.shape == "dome" and not freedom.holds("body.dome_radius_mm")
    if flat_dome:
        radius = "body.dome_radius_mm"
        base = with_values(base, {radius: flat_of(base, load_design(PASSING[0]))[radius]})
    parameters = dict(parameters_of(base, freedom))
    if not parameters:
        remedy = "keep fewer keys; `fingerdesign study DESIGN --tune` tunes the hand alone"
        fault = Fault("--keep", ", ".join(freedom.keep), "some size left to vary", remedy)
        raise DesignError([fault], design.design.name)
    in_row = any(frame.along == "x" for frame in plate_frames(base))
    if "plates.count" not in parameters and not in_row:
        bound = "a row of plates along x: without one no gage sees slip along x"
        fault = Fault("plates.count", base.plates.count, bound, "keep no key of [plates]")
        raise DesignError([fault], design.design.name)
    arc_first = flat_dome or base.body.shape in ("revolved", "step")
    space = Space(base, parameters, (), (*flat, *lost), arc_first)
    return replace(space, starts=_sound_starts(space, starts_of(base, parameters)))


def _sound_starts(
    space: Space, starts: Iterable[dict[str, Choice]]
) -> tuple[dict[str, Choice], ...]:
    """Those of which a finger can exist, each once; all where none can."""
    every = [each for each in starts if each]
    unique = [each for k, each in enumerate(every) if each not in every[:k]]
    return tuple(each for each in unique if space.sound(each)) or tuple(unique)


def _crown_mm(body: Body) -> float:
    """Radius of a slight crown for the body's width, mm."""
    known = load_design(PASSING[0]).body
    return body.width_mm / known.width_mm * known.arc_radius_mm


def _crowned(design: Design, freedom: Freedom) -> tuple[Design, tuple[str, ...]]:
    """The design with a slight crown in place of a flat top, and the key that changed.

    A flat pad touches at once, and the area that responds never changes: of 48 trials from a
    random block each had a rank correlation of 0.
    """
    if not design.body.kind.flat or not freedom.allows("body.shape"):
        return design, ()
    crown = {"body.shape": "arc", "body.arc_radius_mm": _crown_mm(design.body)}
    try:
        return with_values(design, crown), ("body.shape",)
    except DesignError:
        return design, ()  # Its plates or its core do not fit below a crown.


def _plain_row(design: Design, freedom: Freedom) -> tuple[Design, tuple[str, ...]]:
    """The design with one row of solid plates of full span, and sentences on what that replaced."""
    own = design_data(design)["plates"]
    lost = {k: v for k, v in own.items() if k not in _PLAIN and not _is_default(k, v, design)}
    if not freedom.allows("plates.rows") or not (lost or design.plates.count == 0):
        return design, ()
    known = load_design(PASSING[0])
    values: dict[str, object] = {f"plates.{key}": getattr(known.plates, key) for key in _PLAIN}
    values["gages.length_mm"] = GAGE_SHARE * known.plates.length_mm
    values |= flat_of(design, known)
    depth = design.body.depth_mm
    spans = [None] if design.body.straight else [float(f"{by * depth:.2g}") for by in _SPANS]
    words = tuple(f"plates.{key}" for key in lost) or ("plates.count = 0",)
    # A row that is too wide or too deep for the body does not fit below its surface.
    for count, span in itertools.product(_FEWER, spans):
        row = {"plates.count": count} | ({} if span is None else {"plates.span_mm": span})
        found = judge_data(_replaced(design, freedom, values | row))
        if not found.faults:
            return found.sound(design.design.name), words
    return design, ()  # Such plates fit only a flatter body than this one can be.


def _replaced(design: Design, freedom: Freedom, values: dict[str, object]) -> dict[str, Any]:
    """The design's tables with values in place of what makes its plates no plain row."""
    data = design_data(design)
    data["plates"] = {key: value for key, value in data["plates"].items() if key in _PLAIN}
    data.pop("assumed", None)
    for key, value in values.items():
        if freedom.allows(key):
            set_value(data, key, value)
    return data


def _is_default(key: str, value: Any, design: Design) -> bool:
    default = type(design.plates).model_fields[key].get_default(call_default_factory=True)
    full = key == "span_mm" and value == design.body.depth_mm
    return full or value in (default, [], ()) or key == "hole_pitch_mm"


def _fixed(design: Design, freedom: Freedom) -> dict[str, object]:
    """Changes that every trial has: rosettes on both faces, whose area follows the stick area."""
    film = load_design(PASSING[0]).mold
    changes: dict[str, object] = {
        "gages.grid": "tee",
        "gages.face": "both",
        "gages.transverse_weight": None,
        # No gage that is sold fits plates of half a millimetre: film is made on them, its traces on
        # their legs.
        "mold.gage": film.gage,
        "mold.leads": film.leads,
        "gages.kind": design.gages.kind if design.gages.kind == film.gage else None,
    }
    if freedom.allows("plates.material"):
        if _FILM not in design.materials:
            for key in ("youngs_modulus_MPa", "poissons_ratio"):
                changes[f"materials.{_FILM}.{key}"] = getattr(MATERIALS[_FILM], key)
        if design.material_of("plates").youngs_modulus_MPa > _SOFT_MPA:
            changes["plates.material"] = _FILM
    return {key: value for key, value in changes.items() if freedom.allows(key)}


def changes_between(before: Design, after: Design) -> dict[str, tuple[Any, Any]]:
    """Keys whose values differ, with both values; names, sources, and what follows the finger left
    out."""
    old, new = (dict(leaves(design_data(each))) for each in (before, after))
    return {
        key: (old.get(key), new.get(key))
        for key in new | old
        if old.get(key) != new.get(key)
        and key not in ("design.name", "assumed")
        and not key.endswith(".source")
    }
