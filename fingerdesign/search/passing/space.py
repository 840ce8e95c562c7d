"""Keys that a search for a passing finger may change, their ranges, and the first trials.

Roles: the section (radius and height), the plates, the gages, the plates' material, the hand. A
user keeps keys or whole tables, and frees further ones. First trials come from shipped fingers
that pass; the sampler goes on from there.
"""

import difflib
import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fingerdesign.checks.load import judge_data, load_design, with_values
from fingerdesign.design.body import Body
from fingerdesign.design.io import design_data
from fingerdesign.design.keys import leaves, set_value
from fingerdesign.design.schema import Design
from fingerdesign.design.stock import sheets_of
from fingerdesign.errors import DesignError, Fault
from fingerdesign.materials import MATERIALS
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.study.values import (
    Choice,
    Parameter,
    Range,
    is_number,
    set_keys,
    split_share,
    value_of,
)

PASSING = ("feeler", "film_tees")  # Shipped fingers that pass: the first trials are like them.
# Plates of these give a signal: polyimide is the stiffest that is sold as thin film.
_FILMS = ("polyimide",)
_THINNEST, _THICKEST = 0.025, 0.125  # mm; thinner film cannot be placed, thicker one is too stiff.
_SOFT_MPA = 2e4  # Plates of stiffer materials respond too little in rubber (bronze: a fiftieth).
# Ranges around what passed in a random search of forty fingers: flat, with short shallow plates.
# The third number is the step: nobody draws thousandths of a millimetre.
_RANGES: dict[str, tuple[float, float, float]] = {
    "plates.pitch_mm": (0.4, 1.2, 0.01),
    "plates.length_mm": (0.3, 0.9, 0.01),
    "plates.cover_mm": (0.25, 0.8, 0.01),
    "plates.angle_deg": (35.0, 55.0, 1.0),
}
# Trials near to the best one: so much of a range as standard deviation, one drawn for each trial,
# and the share of keys that change. Of fingers drawn from the whole box three of four cannot exist.
_NEAR = (0.05, 0.1, 0.2)
_CHANGED = 0.5
_TRIES = 100  # Draws of a trial until one can exist.
_COUNTS = (7, 15)
_FEWER = (9, 7, 5, 3)
_ARC = (0.6, 5.0)  # Radius over width: a half circle, and nearly flat.
_ROUND = ("arc", "dome", "revolved")  # Shapes with a radius.
_LENGTHS = (
    *("body.base_height_mm", "body.depth_mm"),
    *("plates.pitch_mm", "plates.length_mm", "plates.cover_mm", "plates.thickness_mm"),
)
_AGAIN = 4  # Trials of a shape that was given up which are made again.
_DEPTH = 0.4  # Of the width. Deep fingers follow less well: film_tees 0.97, 22 mm deep 0.70.
# What becomes smaller with the body, and with which of its measures.
_FOLLOWING = (
    ("plates.span_mm", "body.depth_mm"),
    ("body.core.depth_mm", "body.depth_mm"),
    ("body.core.height_mm", "body.base_height_mm"),
)
_SIZES = ("width", "depth", "base_height")
_HEIGHT = (0.6, 1.25)  # Times the design's own; down to that of a similar finger that passes.
_FLAT_DOME = 10.0  # Radius along z over depth: plates lie as in an arc, which can be swept.
# Of a body's depth: plates below a dome end before it falls too far. The longest that fits.
_SPANS = (0.6, 0.45, 0.3)
_FREED = (0.7, 1.4)  # A key that the user frees varies between these times its own value.
_GAGE_SHARE = 0.6  # Length of a gage over that of its plate; the ends of a plate carry no strain.
# All of [plates] that a plain row of full span needs; other layouts are replaced by such a row.
_PLAIN = ("count", "thickness_mm", "length_mm", "angle_deg", "pitch_mm", "cover_mm", "material")


@dataclass(frozen=True)
class Freedom:
    """Keys that the user keeps, and that he frees: dotted keys, or tables such as "plates"."""

    keep: tuple[str, ...] = ()
    free: tuple[str, ...] = ()

    def allows(self, key: str) -> bool:
        """True if none of the keys and tables to keep contains the key."""
        return not any(key == each or key.startswith(f"{each}.") for each in self.keep)

    def holds(self, key: str) -> bool:
        """True if the user keeps the key or frees it: the search sets it by no rule of its own."""
        return key in self.free or not self.allows(key)

    def faults(self, design: Design) -> list[Fault]:
        """Faults of keys that the design does not have, or that cannot vary."""
        data = design.model_dump(mode="json")
        known = dict(leaves(data))
        tables = {key.rpartition(".")[0] for key in known if "." in key}
        found = []
        options = ("--keep", self.keep, {*known, *tables}), ("--free", self.free, {*known})
        for option, keys, own in options:
            for key in (each for each in keys if each not in own):
                near = difflib.get_close_matches(key, [*known, *tables], 1)
                remedy = f"did you mean '{near[0]}'?" if near else "see docs/reference/design.md"
                found.append(Fault(option, key, "a key of the design", remedy))
        bound, remedy = "a key with a number", "only numbers can vary between bounds"
        fixed = [key for key in self.free if key in known and not is_number(known[key])]
        return found + [Fault("--free", key, bound, remedy) for key in fixed]


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
        user's own CAD an arc of its size."""
        if not self.arc_first:
            return design
        body, span = design.body, design.plates.span_mm
        arc: dict[str, object] = {"body.shape": "arc", "body.dome_radius_mm": None}
        if body.shape == "step":
            known = load_design(PASSING[0]).body
            radius = body.width_mm / known.width_mm * known.arc_radius_mm
            own = {f"body.{key}_mm": getattr(body, f"{key}_mm") for key in _SIZES}
            arc |= {"body.step": None, "body.arc_radius_mm": radius, **own}
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
        arc of its size; a core, where no trial's gages are good with it. None where that is
        nothing.

        tried: outcomes of trials; the best are the first trials again, with the same core.
        """
        base, given_up = self.base, list[str]()
        if self.arc_first and freedom.allows("body.shape"):
            arc = self.on_arc(base)
            if arc.body.shape == "arc":
                base, given_up = arc, ["body.shape"]
        good = [each for each in tried if each.metrics.get("shortfall") == 0.0]
        if base.body.core is not None and freedom.allows("body.core") and not good:
            base = with_values(base, {"body.core": None})
            given_up += ["body.core"]
        if not given_up:
            return None
        if base.body.straight and not good and freedom.allows("plates.span_mm"):
            base = with_values(base, {"plates.span_mm": None})  # Nothing falls off at their ends.
        arc_first = self.arc_first and "body.shape" not in given_up
        space = Space(base, dict(_parameters(base, freedom)), (), self.replaced, arc_first)
        own = _own_values(base, space.parameters)
        again = [{key: each.values.get(key, own[key]) for key in own} for each in good]
        starts = _sound_starts(space, [*again[:_AGAIN], *_starts(base, space.parameters)])
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
                key: _moved(each, values[key], spread, chance)
                if chance.random() < _CHANGED
                else values[key]
                for key, each in self.parameters.items()
            }
            if found != values and self.sound(found):
                break
        return found


def _moved(
    parameter: Parameter, value: Choice, spread: float, chance: np.random.Generator
) -> Choice:
    """The value moved by ``spread`` of its range as standard deviation; a choice by one place."""
    if isinstance(parameter, Range):
        width = float(parameter.high) - float(parameter.low)
        least = 1.0 if parameter.whole else parameter.step or 0.0
        move = float(chance.normal()) * max(spread * width, least)
        return _inside(parameter, float(value) + move)
    place = parameter.index(value) + int(chance.choice((-1, 1)))
    return parameter[min(max(place, 0), len(parameter) - 1)]


def space_of(design: Design, freedom: Freedom) -> Space:
    """The space of a search from a design. DesignError for keys that are unknown, or where nothing
    is left to vary."""
    if faults := freedom.faults(design):
        raise DesignError(faults, design.design.name)
    crowned, flat = _crowned(design, freedom)
    base, replaced = _plain_row(crowned, freedom)
    replaced = (*flat, *replaced)
    base = with_values(base, _fixed(base, freedom))
    flat_dome = base.body.shape == "dome" and not freedom.holds("body.dome_radius_mm")
    if flat_dome:
        radius = "body.dome_radius_mm"
        base = with_values(base, {radius: _flat(base, load_design(PASSING[0]))[radius]})
    parameters = dict(_parameters(base, freedom))
    if not parameters:
        fault = Fault("--keep", ", ".join(freedom.keep), "some key left to vary", "keep fewer keys")
        raise DesignError([fault], design.design.name)
    arc_first = flat_dome or base.body.shape in ("revolved", "step")
    space = Space(base, parameters, (), replaced, arc_first)
    return replace(space, starts=_sound_starts(space, _starts(base, parameters)))


def _starts(base: Design, parameters: Mapping[str, Parameter]) -> Iterator[dict[str, Choice]]:
    """First trials: the design's own values, then those of shipped fingers that pass."""
    yield _own_values(base, parameters)
    for similar in (True, False):
        for name in PASSING:
            yield _like(load_design(name), base, parameters, similar)


def _sound_starts(
    space: Space, starts: Iterable[dict[str, Choice]]
) -> tuple[dict[str, Choice], ...]:
    """Those of which a finger can exist, each once; all where none can."""
    unique = list[dict[str, Choice]]()
    for each in starts:
        if each and each not in unique:
            unique.append(each)
    return tuple(each for each in unique if space.sound(each)) or tuple(unique)


def _crowned(design: Design, freedom: Freedom) -> tuple[Design, tuple[str, ...]]:
    """The design with a slight crown in place of a flat top, and the key that changed.

    A flat pad touches at once, and the area that responds never changes: of 48 trials from a
    random block each had a rank correlation of 0.
    """
    if not design.body.kind.flat or not freedom.allows("body.shape"):
        return design, ()
    known = load_design(PASSING[0]).body
    radius = design.body.width_mm / known.width_mm * (known.arc_radius_mm or 0.0)
    try:
        return with_values(design, {"body.shape": "arc", "body.arc_radius_mm": radius}), (
            "body.shape",
        )
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
    values["gages.length_mm"] = _GAGE_SHARE * known.plates.length_mm
    values |= _flat(design, known)
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


def _flat(design: Design, known: Design) -> dict[str, object]:
    """The known finger's radius at the design's own size; a dome as flat along z as it may be."""
    body, found = design.body, dict[str, object]()
    if body.shape in _ROUND and body.arc_radius_mm is not None:
        size = body.width_mm / known.body.width_mm
        found["body.arc_radius_mm"] = size * (known.body.arc_radius_mm or 0.0)
    if body.shape == "dome" and body.dome_radius_mm is not None:
        found["body.dome_radius_mm"] = max(_FLAT_DOME * body.depth_mm, body.dome_radius_mm)
    return found


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
    }
    own = MATERIALS[_FILMS[0]]
    if freedom.allows("plates.material"):
        table = f"materials.{_FILMS[0]}"
        if _FILMS[0] not in design.materials:
            changes[f"{table}.youngs_modulus_MPa"] = own.youngs_modulus_MPa
            changes[f"{table}.poissons_ratio"] = own.poissons_ratio
        modulus = design.material_of("plates").youngs_modulus_MPa
        if modulus > _SOFT_MPA:
            changes["plates.material"] = _FILMS[0]
    return {key: value for key, value in changes.items() if freedom.allows(key)}


def _parameters(design: Design, freedom: Freedom) -> Iterator[tuple[str, Parameter]]:
    """Each key with its range, wide enough for the design's own value."""
    body = {key: each for key, each in _of_body(design) if freedom.allows(key)}
    yield from body.items()
    for key, parameter in _of_plates(design):
        if freedom.allows(key):
            yield key, parameter
    if freedom.allows("gages.length_mm") and freedom.allows("plates.length_mm"):
        yield "gages.length_mm / plates.length_mm", (_GAGE_SHARE,)
    for part, whole in _FOLLOWING:
        share = _value(design, f"{part} / {whole}")
        if share is not None and whole in body and freedom.allows(part):
            yield f"{part} / {whole}", (float(f"{share:.3g}"),)
    for key in freedom.free:
        value = value_of(design, key)
        if value:
            ends = sorted((_FREED[0] * value, _FREED[1] * value))
            low, high = (round(each) if isinstance(value, int) else each for each in ends)
            yield key, Range(low=low, high=high if high > low else low + 1)


def _of_body(design: Design) -> Iterator[tuple[str, Parameter]]:
    """The section's radius and height; the shape itself stays."""
    body = design.body
    if body.shape in _ROUND and body.arc_radius_mm is not None:
        yield "body.arc_radius_mm", _stepped(body.width_mm, _ARC, body.arc_radius_mm, 0.5)
    if body.shape in (*_ROUND, "block"):
        height = body.base_height_mm
        similar = min(each.base_height_mm / each.width_mm for each in _passing_bodies())
        low = min(_HEIGHT[0], similar * body.width_mm / height)
        yield "body.base_height_mm", _stepped(height, (low, _HEIGHT[1]), height, 0.1)
    shallow = math.floor((body.depth_mm - _DEPTH * body.width_mm) / 0.1)
    if body.shape in ("arc", "dome", "block") and shallow > 0:
        low = body.depth_mm - 0.1 * shallow
        yield "body.depth_mm", Range(low=round(low, 6), high=body.depth_mm, step=0.1)


def _passing_bodies() -> list[Body]:
    return [load_design(name).body for name in PASSING]


def _of_plates(design: Design) -> Iterator[tuple[str, Parameter]]:
    """The row's measures, and the thicknesses that sheets of its material are sold in."""
    if design.plates.placement is None:
        for key, (low, high, step) in _RANGES.items():
            yield key, Range(low=low, high=high, step=step)
        yield "plates.count", Range(low=_COUNTS[0], high=_COUNTS[1])
    sheets = sheets_of(design.plates.material)
    sold = [each for each in sheets if _THINNEST <= each <= _THICKEST]
    if len(sold) > 1:
        yield "plates.thickness_mm", tuple(sold)


def _stepped(size: float, factors: tuple[float, float], own: float, step: float) -> Range:
    """From one factor times the size to the other, and at least to the design's own value."""
    low = max(step, math.floor(factors[0] * size / step) * step)
    high = math.ceil(max(factors[1] * size, own) / step) * step
    return Range(low=round(low, 6), high=round(high, 6), step=step)


def _own_values(design: Design, parameters: Mapping[str, Parameter]) -> dict[str, Choice]:
    """The design's own values, brought into the ranges."""
    return {key: _inside(each, _value(design, key)) for key, each in parameters.items()}


def _like(
    known: Design, design: Design, parameters: Mapping[str, Parameter], similar: bool
) -> dict[str, Choice]:
    """A finger that passes, at the design's own size.

    similar: all lengths in proportion to the width. The fundamental case presses every finger
    equally far, so that the contact is in proportion too where the radius goes with the square. The
    worst rank correlations of five such fingers, 10 to 16 mm wide, are 0.92 to 0.97; as deep as
    their designs, 8 to 14 mm, 0.46 to 0.86. Else plates, height and depth stay, which suits some
    fingers with a core: the random finger 5 has 0.75, and -0.22 with the similar height.
    """
    values = _own_values(known, parameters)
    size = design.body.width_mm / known.body.width_mm
    if similar:
        powers = dict.fromkeys(_LENGTHS, 1) | {"body.arc_radius_mm": 2}
        for key in parameters.keys() & powers.keys():
            own = float(_value(known, key))
            values[key] = _inside(parameters[key], size ** powers[key] * own)
    else:
        for key in parameters.keys() & {"body.base_height_mm", "body.depth_mm"}:
            values[key] = _value(design, key)
        flat = _flat(design, known)
        values |= {key: _inside(parameters[key], flat[key]) for key in flat if key in parameters}
    if "plates.count" in parameters:
        pitch = float(values.get("plates.pitch_mm", design.plates.pitch_mm))
        room = int(0.9 * design.body.width_mm / pitch)
        values["plates.count"] = _inside(parameters["plates.count"], min(known.plates.count, room))
    return values


def _value(design: Design, key: str) -> Any:
    part, whole = split_share(key)
    if not whole:
        return value_of(design, part)
    own = value_of(design, part)
    return None if own is None else own / value_of(design, whole)


def _inside(parameter: Parameter, value: Any) -> Choice:
    """The value, or the nearest that the parameter can take."""
    if isinstance(parameter, Range):
        low, high = parameter.low, parameter.high
        found = min(max(low if value is None else value, low), high)
        if parameter.whole:
            return round(found)
        if parameter.step is not None:
            found = low + parameter.step * round((found - low) / parameter.step)
        return float(f"{found:.12g}")
    if value in parameter:
        return value  # type: ignore[no-any-return]
    numbers = [each for each in parameter if isinstance(each, int | float)]
    if numbers and isinstance(value, int | float):
        return min(numbers, key=lambda each: abs(each - value))
    return parameter[0]


def changes_between(before: Design, after: Design) -> dict[str, tuple[Any, Any]]:
    """Keys whose values differ, with both values; names, sources, and what follows the finger left
    out."""
    old, new = (dict(leaves(design_data(each))) for each in (before, after))
    keys: Sequence[str] = [*new, *(key for key in old if key not in new)]
    return {
        key: (old.get(key), new.get(key))
        for key in keys
        if old.get(key) != new.get(key)
        and key not in ("design.name", "assumed")
        and not key.endswith(".source")
    }
