"""The controls: which keys of a design can be moved, how far, and what the object does."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Self

from pydantic.fields import FieldInfo

from fingerdesign.checks.scene import MOST_MOTION
from fingerdesign.design.base import described
from fingerdesign.design.schema import Design
from fingerdesign.design.stock import sheets_of
from fingerdesign.layout.bodies import crest_height
from fingerdesign.materials import MATERIALS

_STEPS = 60  # of a slider, before rounding
_REACH = 0.05  # of the finger's height: approach and shear at least
_FRICTION = (0.05, 1.2)
_MOST_PLATES = 21.0  # The paper's row has 15.
_LEAST_PLATE_MPA = 1e3  # Softer materials of the library are rubbers.
_WEIGHT = (10.0, 1000.0)  # g: what two fingers of this size lift.

_GROUPS = {
    "": "Object",
    "body": "Body",
    "materials": "Body",
    "plates": "Plates",
    "gages": "Gages",
    "grip": "Lift",
}

Value = float | str


@dataclass(frozen=True)
class Slider:
    """One value that can be changed: a number between ends, or one of ``options``.

    key: dotted for a design's key, plain for the object's. value: where it starts.
    """

    key: str
    label: str
    unit: str
    tip: str
    value: Value
    low: float = 0.0
    high: float = 0.0
    step: float = 1.0
    options: tuple[Value, ...] = ()

    @property
    def of_design(self) -> bool:
        """True for a key of the finger."""
        return "." in self.key

    def data(self) -> dict[str, Any]:
        """For the page, with the heading that it is shown below."""
        table = self.key.partition(".")[0] if self.of_design else ""
        return {**asdict(self), "group": _GROUPS[table]}

    def allowed(self, value: object) -> Value | None:
        """The value, brought between the ends; None where it is none of this control's."""
        if self.options:
            return next((each for each in self.options if each == value), None)
        if not isinstance(value, int | float) or not -math.inf < value < math.inf:
            return None
        found = min(max(value, self.low), self.high)
        return round(found) if isinstance(self.value, int) else float(found)


@dataclass(frozen=True)
class Press:
    """Motion of the object: pressed by ``approach`` (mm), then drawn by ``shear`` (mm)."""

    approach: float
    shear: float
    friction: float

    @classmethod
    def of(cls, values: dict[str, Any]) -> Self:
        """The sliders' part that is the object's."""
        return cls(*(float(values[key]) for key in ("approach", "shear", "friction")))


def sliders_of(design: Design) -> tuple[Slider, ...]:
    """The object's three, and the keys of the design that it has and that can be moved."""
    crest = float(crest_height(design.body))
    most = min(max(design.grip.max_approach_mm, _REACH * crest), MOST_MOTION * crest)
    step = _round_step(most / _STEPS)
    most = round(step * round(most / step), 9)
    first, half = (round(step * round(most / part / step), 9) for part in (4, 8))
    down = "how deep the object is pressed into the finger"
    across = "how far the object is then drawn along x"
    found = [
        Slider("approach", "approach", "mm", down, first, 0.0, most, step),
        Slider("shear", "shear", "mm", across, half, 0.0, most, step),
        Slider("friction", "friction", "", "between object and finger", 0.5, *_FRICTION, 0.01),
        *_of_body(design),
        *_of_plates(design),
        *_of_gages(design),
    ]
    key, mass = "grip.object_mass_g", design.grip.object_mass_g
    if not isinstance(mass, tuple):  # A range of masses stays as its file has it.
        low, high = min(_WEIGHT[0], mass), max(_WEIGHT[1], mass)
        found.append(Slider(key, "weight to lift", "g", _tip(key), mass, low, high, 10.0))
    return tuple(found)


def renewed(old: Sequence[Slider], new: Sequence[Slider]) -> tuple[Slider, ...]:
    """New sliders with the ends of the old ones, where these hold the new value."""
    known = {each.key: each for each in old if not each.options}
    return tuple(
        was
        if (was := known.get(each.key)) is not None and was.allowed(each.value) == each.value
        else each
        for each in new
    )


def _of_body(design: Design) -> list[Slider]:
    body, found = design.body, list[Slider]()
    if body.step is None:
        names = {"width_mm": "width", "base_height_mm": "base height"}
        names |= {"arc_radius_mm": "arc radius"} if body.shape == "arc" else {}
        names |= {} if body.kind.turned else {"depth_mm": "depth"}
        for name, label in names.items():
            if value := getattr(body, name):
                found.append(_around(f"body.{name}", label, "mm", float(value)))
    own = design.materials.get(body.material)
    if own is not None and "." not in body.material:  # a dotted key would lead elsewhere
        key = f"materials.{body.material}.youngs_modulus_MPa"
        found.append(_around(key, "modulus of the body", "MPa", own.youngs_modulus_MPa))
    return found


def _of_plates(design: Design) -> list[Slider]:
    plates = design.plates
    if not plates.number or plates.model == "none":
        return []
    found = [_one_of("plates.material", "plate material", "", plates.material, _foils(design))]
    sold = sheets_of(plates.material)
    found.append(_one_of("plates.thickness_mm", "plate thickness", "mm", plates.thickness_mm, sold))
    if not plates.count or plates.placement is not None:
        return found
    key, most = "plates.count", max(_MOST_PLATES, 2.0 * plates.count)
    found.append(Slider(key, "plates", "", f"{key}: in the row", plates.count, 2.0, most, 1.0))
    key = "plates.angle_deg"
    tip, angle = _tip(key), plates.angle_deg
    found.append(Slider(key, "plate angle", "°", tip, angle, -90.0, 90.0, 1.0))
    names = {"length_mm": "plate length", "pitch_mm": "plate pitch", "cover_mm": "cover"}
    for name, label in names.items():
        found.append(_around(f"plates.{name}", label, "mm", float(getattr(plates, name))))
    return found


def _of_gages(design: Design) -> list[Slider]:
    gages = design.gages
    if not design.plates.number or design.plates.model == "none":
        return []
    grids = dict.fromkeys(("axial", "tee", gages.grid))  # Pairs need plates made for them.
    return [
        _one_of("gages.grid", "gage grid", "", gages.grid, tuple(grids)),
        _around("gages.length_mm", "gage length", "mm", gages.length_mm),
    ]


def _foils(design: Design) -> tuple[str, ...]:
    """The materials of the library that plates are made of, and the design's own."""
    known = (name for name, each in MATERIALS.items() if each.youngs_modulus_MPa > _LEAST_PLATE_MPA)
    stiff = (k for k, m in design.materials.items() if m.youngs_modulus_MPa > _LEAST_PLATE_MPA)
    return tuple(dict.fromkeys((*known, *stiff)))


def _one_of(key: str, label: str, unit: str, value: Value, options: Sequence[Value]) -> Slider:
    if value not in options:
        numbers = all(isinstance(each, float) for each in options)
        options = sorted((*options, value)) if numbers else (*options, value)
    return Slider(key, label, unit, _tip(key), value, options=tuple(options))


def _around(key: str, label: str, unit: str, value: float) -> Slider:
    """From half of a value to one and a half times it; the value itself lies on a step."""
    step = _round_step(value / _STEPS)
    down = step * math.floor(0.5 * value / step)
    low, high = round(value - down, 9), round(value + down, 9)
    return Slider(key, label, unit, _tip(key), value, low, high, step)


def _tip(key: str) -> str:
    """The key and its meaning, as the schema has it."""
    table, _, name = key.rpartition(".")
    if table.startswith("materials."):
        return f"{key}: small-strain modulus"
    model = Design.model_fields[table].annotation
    assert model is not None
    fields: dict[str, FieldInfo] = vars(model)["__pydantic_fields__"]
    return f"{key}: {described(fields[name])}"


def _round_step(rough: float) -> float:
    """1, 2 or 5 times a power of ten, at most ``rough``.

    >>> _round_step(0.0068), _round_step(0.37), _round_step(2.0)
    (0.005, 0.2, 2.0)
    """
    power = math.floor(math.log10(rough) + 1e-9)
    share = rough / 10.0**power
    first = max(each for each in (1, 2, 5) if each <= share + 1e-9)
    return round(first * 10.0**power, max(0, -power))
