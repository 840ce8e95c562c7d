"""Remedies of refusals: changes of one key that were tried, by a fixed number of plans.

A remedy is searched on a fixed grid of changes, by bisection: the number of plans depends on the
refusals alone, so that an error reads the same on a slow machine.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fingerdesign.checks.design import is_sound
from fingerdesign.checks.load import with_values
from fingerdesign.checks.remedies import edge
from fingerdesign.design.body import Body
from fingerdesign.design.faults import at_least
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.layout.row_keys import PlateRow, plate_rows, with_key
from fingerdesign.mold.plan.fixture.fixture import Fixture
from fingerdesign.mold.plan.fixture.legs import fixture_of
from fingerdesign.mold.plan.fixture.refusals import high_legs, narrow_webs
from fingerdesign.mold.plan.limits import limits_of
from fingerdesign.mold.plan.planning import plan_mold, with_mold
from fingerdesign.mold.plan.refusals import MoldRefused, Refusal

# A whole plan takes up to half a second of a quiet core: all remedies of a refusal take some 5 s.
PLANS = 16
HALVINGS = 6  # of a step of a pitch or a cover: some hundredths of a millimetre are left
# A value is tried so many times as large; the factors rise, so that a bisection finds the nearest.
_UP = (1.05, 1.1, 1.2, 1.3, 1.5, 1.75, 2.0, 2.5)
_DOWN = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)
_SMALLEST_MM = 0.02  # slot or web
_BOLT, _PIN, _WALL = "mold.bolt", "mold.limits.pin_mm", "mold.limits.wall_mm"
_GATE, _VENT, _HOLE = "mold.gate_mm", "mold.vent_mm", "mold.limits.hole_mm"
_HEIGHT, _WIDTH, _DEPTH = "body.base_height_mm", "body.width_mm", "body.depth_mm"
_PROCESS, _WIRE = "mold.process", "mold.wire_mm"
# Keys at fault that one change may mend together, and the keys that are tried, the mold's first.
_GROUPS: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = (
    ((_BOLT, _PIN, _WALL), (_PROCESS, _PIN, _WALL, _HEIGHT, _DEPTH)),
    ((_GATE, _VENT), (_HOLE, _WALL, _PROCESS, _WIDTH, _DEPTH)),
    ((_WIRE,), (_WIRE, _HOLE, _PROCESS, _WIDTH, _DEPTH)),
)
# Sizes of slots and webs that a file may demand, those of combs first.
_DEMANDS = (
    *(("comb", name) for name in ("slot_mm", "web_mm", "clearance_mm")),
    *(("limits", name) for name in ("slot_mm", "feature_mm", "clearance_mm")),
)
Values = Mapping[str, float | str]
Refuse = Callable[[Fixture], list[Refusal]]


def remedied(design: Design, refused: MoldRefused) -> MoldRefused:
    """Return a design's refusals with the remedies that were found; others keep their general one.

    Slots and webs that the file itself gives are refused instead of the plates that they keep from
    being held.
    """
    found = _demanded(design, list(refused.refusals))
    found = _with_room(design, [_placed(design, refusal) for refusal in found])
    return MoldRefused(found, refused.source)


@dataclass
class _Trials:
    """Changed designs, planned at most PLANS times, for one group of refusals.

    ends    keys that must not be refused any more
    allowed keys that were refused before: no other may be
    """

    design: Design
    ends: set[str]
    allowed: set[str]
    left: int = field(default=PLANS)

    def mends(self, values: Values) -> bool:
        """Plan the design with other values: true where that ends the refusals."""
        if self.left == 0:
            return False
        self.left -= 1
        try:
            plan_mold(with_values(self.design, dict(values)))
        except MoldRefused as refused:
            after = {refusal.key for refusal in refused.refusals}
            return not after & self.ends and after <= self.allowed
        except DesignError:
            return False
        return True

    def nearest(self, changes: Sequence[Values]) -> Values | None:
        """The nearest of ``changes``, ordered by size, that mends; by bisection, which takes one
        plan more than halvings, and one where none does."""
        if not changes or not self.mends(changes[-1]):
            return None
        low, high = -1, len(changes) - 1
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if self.mends(changes[middle]) else (middle, high)
        return changes[high]


def _with_room(design: Design, refusals: list[Refusal]) -> list[Refusal]:
    """Name changes of one key that end a group of refusals of room and bring no other."""
    refused = {refusal.key for refusal in refusals}
    for keys, tried in _GROUPS:
        group = refused.intersection(keys)
        if not group:
            continue
        trials = _Trials(design, group, refused)
        found = [_text(change) for key in tried if (change := _change(trials, key))]
        if found:
            remedy = f"one of these mends it: {'; '.join(found)}"
            refusals = [replace(r, remedy=remedy) if r.key in group else r for r in refusals]
    return refusals


def _text(values: Values) -> str:
    """A change as in a design file."""
    texts = (f"{v:g}" if isinstance(v, float) else repr(v) for v in values.values())
    return ", ".join(f"{key} = {text}" for key, text in zip(values, texts, strict=True))


def _change(trials: _Trials, key: str) -> Values | None:
    """The nearest change of a key that mends; a round body's width is its depth."""
    mold = trials.design.mold
    if key == _PROCESS:
        names = (name for name in ("sla", "machined", "fdm") if name != mold.process)
        return next((value for name in names if trials.mends(value := {key: name})), None)
    if key.startswith("body."):
        return trials.nearest(_larger(trials.design.body, key))
    now = float(getattr(mold if key == _WIRE else limits_of(mold), key.rpartition(".")[2]))
    return trials.nearest([{key: round(factor * now, 2)} for factor in _DOWN])


def _larger(body: Body, key: str) -> list[Values]:
    """Larger values of a key of the body, in their order; a round body has no depth of its own."""
    if body.step is not None or (key == _DEPTH and body.kind.turned):
        return []
    keys = (key, _DEPTH) if key == _WIDTH and body.kind.turned else (key,)
    now = float(getattr(body, key.removeprefix("body.")))
    values = (round(factor * now, 1) for factor in _UP)
    return [dict.fromkeys(keys, value) for value in values if value > now]


def _placed(design: Design, refusal: Refusal) -> Refusal:
    """Add the remedy of plates too close or too high: a pitch, a cover, another fixture."""
    plates = {"high_legs": "plate", "no_web": "two"}
    if refusal.kind not in plates:
        return refusal
    plate = refusal.numbers[plates[refusal.kind]]
    row = next(r for r in plate_rows(design) if plate in (f.index for f in r.frames))
    cover, found = row.table.cover_mm, list[str]()
    if refusal.kind == "no_web":
        found = _apart(design, row, refusal)
    elif not row.placed:
        found = _raised(design, refusal, cover, cover + row.frames[0].y, high_legs)
    return replace(refusal, remedy=" or ".join(found))


def _raised(design: Design, refusal: Refusal, low: float, high: float, refuse: Refuse) -> list[str]:
    """About the least value in (low, high] to which the key at fault must be raised, such that the
    design is sound and its likeliest legs are not refused, in words; none where there is none."""

    def does(value: float) -> bool:
        trial = with_key(design, refusal.key, value)
        return trial is not None and not refuse(_quick(trial))

    found = next((v for v in np.linspace(low, high, 9)[1:].tolist() if does(v)), None)
    if found is None:
        return []
    over = float(at_least(edge(does, found, found - (high - low) / 8.0, HALVINGS)))
    trial = with_key(design, refusal.key, over)
    ends = trial is not None and does(over) and is_sound(trial)
    return [f"raise {refusal.key} to at least {over:g}"] if ends else []


def _apart(design: Design, row: PlateRow, refusal: Refusal) -> list[str]:
    mold, key, one = design.mold, refusal.key, refusal.numbers["one"]
    found = [f"move the rows apart by {key}"]
    if row.placed:
        found = [f"move it away from plate {one}"]
    elif any(frame.index == one for frame in row.frames):
        pitch = row.table.pitch_mm
        found = _raised(design, refusal, pitch, 3.0 * pitch + 1.0, narrow_webs)
    combless = mold.plate_fixture != "comb" and refusal.numbers["name"] != "mold.comb.web_mm"
    text = "set mold.plate_fixture = 'comb', whose slots are cut finer"
    changes = [(text, with_mold(design, plate_fixture="comb"))] if combless else []
    if mold.leg_mm is not None:
        changes.append(("remove mold.leg_mm", with_mold(design, leg_mm=None)))
    return found + [text for text, changed in changes if not narrow_webs(fixture_of(changed))]


def _quick(design: Design) -> Fixture:
    """The fixture of a changed design, of the likeliest legs alone."""
    return fixture_of(design, thorough=False)


def _demanded(design: Design, refusals: list[Refusal]) -> list[Refusal]:
    """Refuse the slot or web that the file gives, where plates could be held without it."""
    of_plates = [refusal for refusal in refusals if refusal.kind in ("high_legs", "no_web")]
    if not of_plates:
        return refusals
    for table, name in _DEMANDS if design.mold.plate_fixture == "comb" else _DEMANDS[3:]:
        given = getattr(design.mold, table)
        if name not in given.model_fields_set or getattr(given, name) is None:
            continue
        value = float(getattr(given, name))
        most = _most(design, table, name, value)
        if most is None:
            continue
        numbers = {**of_plates[-1].numbers, "most": most}
        kind = "much_for_webs" if of_plates[-1].kind == "no_web" else "much_for_height"
        refusal = Refusal(kind, f"mold.{table}.{name}", value, numbers)
        return [r for r in refusals if r not in of_plates] + [refusal]
    return refusals


def _most(design: Design, table: str, name: str, high: float) -> float | None:
    """The greatest of one of the mold's sizes at which its plates are held; None: at none."""

    def holds(size: float) -> bool:
        changed = getattr(design.mold, table).model_copy(update={name: size})
        fixture = _quick(with_mold(design, **{table: changed}))
        return not narrow_webs(fixture) and not high_legs(fixture)

    low = min(_SMALLEST_MM, 0.5 * high)
    return edge(holds, low, high, HALVINGS + 3) if holds(low) else None
