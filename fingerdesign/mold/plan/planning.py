"""Design -> MoldPlan: every number of a mold, or every reason why there is none."""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace

import numpy as np

from fingerdesign.checks.design import is_sound
from fingerdesign.checks.load import with_values
from fingerdesign.checks.placing import edge
from fingerdesign.design.faults import at_least
from fingerdesign.design.mold import Mold
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.frames import PlateRow, plate_rows, with_key
from fingerdesign.mold.plan import slots
from fingerdesign.mold.plan.base import base_holes_of, core_pins_of
from fingerdesign.mold.plan.fasteners import (
    Columns,
    columns_of,
    fastened,
    fastener_faults,
    limit_faults,
    pin_height,
    with_mount,
    z_bolt_height,
)
from fingerdesign.mold.plan.leg_room import Fixture
from fingerdesign.mold.plan.legs import LEAST_WIDTH_MM, fixture_of
from fingerdesign.mold.plan.open_pour import AUTO_BOLTS, open_plan
from fingerdesign.mold.plan.plan import (
    SIDES,
    Extent,
    Holding,
    Leg,
    Limits,
    MoldPlan,
    limits_of,
    refusal,
)

# Remedies for faults of room are found by planning the mold again, a value so many times as large.
_UP = (1.05, 1.1, 1.2, 1.3, 1.5, 1.75, 2.0, 2.5)
_DOWN = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)
_BOLT, _PIN, _WALL = "mold.bolt", "mold.limits.pin_mm", "mold.limits.wall_mm"
_GATE, _VENT, _HOLE = "mold.gate_mm", "mold.vent_mm", "mold.limits.hole_mm"
_HEIGHT, _WIDTH, _DEPTH = "body.base_height_mm", "body.width_mm", "body.depth_mm"
_PROCESS, _WIRE = "mold.process", "mold.wire_mm"
# Faults that one change may mend together -> the keys that are tried, the finger's own last.
_GROUPS: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = (
    ((_BOLT, _PIN, _WALL), (_PROCESS, _PIN, _WALL, _HEIGHT, _DEPTH)),
    ((_GATE, _VENT), (_HOLE, _WALL, _PROCESS, _WIDTH, _DEPTH)),
    ((_WIRE,), (_WIRE, _HOLE, _PROCESS, _WIDTH, _DEPTH)),
)


# Remedies are found by planning changed designs: so many seconds of a processor's work, a few more
# with what was begun. What is refused, and why, does not depend on it; a remedy that was not found
# in time is said in general. It is work, not waiting, so that a busy machine says the same.
REMEDIES_S = 4.0
_until: ContextVar[float] = ContextVar("until", default=math.inf)


@contextmanager
def _within(seconds: float) -> Iterator[None]:
    """Remedies that are looked for inside end so many seconds from now, or before."""
    token = _until.set(min(_until.get(), time.thread_time() + seconds))
    try:
        yield
    finally:
        _until.reset(token)


def in_time() -> bool:
    """Whether there is time left to look for a remedy."""
    return time.thread_time() < _until.get()


def _with_remedies(design: Design, faults: list[Fault]) -> list[Fault]:
    """The same faults; where one of room has a change of one key that mends it, its remedy says so.

    A change is named only if a design with it has none of the faults of its group any more, and no
    new ones.
    """
    before = {fault.key for fault in faults}
    for keys, tried in _GROUPS:
        group = {fault.key for fault in faults if fault.key in keys}
        if not group:
            continue
        found = [text for key in tried if (text := _mended(design, key, group, before))]
        if found:
            remedy = f"one of these mends it: {'; '.join(found)}"
            faults = [replace(f, remedy=remedy) if f.key in group else f for f in faults]
    return faults


def _mended(design: Design, key: str, group: set[str], before: set[str]) -> str:
    """The first change of a key that mends a group of faults, as in a design file; "" for none."""
    for values in _candidates(design, key):
        if not in_time():
            break
        try:
            with _within(0.0):  # the keys of its faults alone are asked for
                after = {fault.key for fault in _roomy(with_values(design, dict(values)))[1]}
        except DesignError:
            continue
        if not after & group and after <= before:
            said = (f"{v:g}" if isinstance(v, float) else repr(v) for v in values.values())
            return ", ".join(f"{name} = {value}" for name, value in zip(values, said, strict=True))
    return ""


def _candidates(design: Design, key: str) -> Iterator[Mapping[str, float | str]]:
    """Values of a key, the nearest to what it is first; a round body's width is its depth."""
    body, process = design.body, design.mold.process
    if key == _PROCESS:
        yield from ({key: name} for name in ("sla", "machined", "fdm") if name != process)
    elif key.startswith("body."):
        if body.step is not None:
            return
        if key == _DEPTH and body.kind.turned:
            return
        keys = (key, _DEPTH) if key == _WIDTH and body.kind.turned else (key,)
        now = float(getattr(body, key.removeprefix("body.")))
        values = (round(share * now, 1) for share in _UP)
        yield from (dict.fromkeys(keys, value) for value in values if value > now)
    else:
        name = key.rpartition(".")[2]
        now = float(getattr(design.mold if key == _WIRE else limits_of(design.mold), name))
        yield from ({key: round(share * now, 2)} for share in _DOWN)


CORNERS = (1.0, 0.85, 0.7, 0.5)  # of the outermost |z| at which end and side walls may meet


def plan_mold(design: Design) -> MoldPlan:
    """The plan of a sound design's mold; DesignError with every fault.

    An open one where ``mold.pour`` and the finger allow it: it has the fewest parts. A closed one
    is cast with the base up, tilted by ``base.TILT_DEG`` toward the first vent, in the corner
    +x +z: this is then the highest place of the rubber. A core that parts the base leaves more such
    places, each with a vent of its own.
    """
    with _within(REMEDIES_S):
        plan, faults = _roomy(design)
        if plan is None:
            raise DesignError(_with_remedies(design, faults), design.design.name)
    return plan


def _roomy(design: Design) -> tuple[MoldPlan | None, list[Fault]]:
    """The plan, with thin legs where others leave no room for bolts and pins, or its faults."""
    plan, faults = _planned(design)
    no_room = {fault.key for fault in faults} <= {_BOLT, _PIN, _WALL}
    if plan is None and no_room and design.mold.leg_mm is None:
        thin, _ = _planned(_with_mold(design, leg_mm=LEAST_WIDTH_MM))
        if thin is not None:
            return thin, []
    return plan, faults


def _planned(design: Design) -> tuple[MoldPlan | None, list[Fault]]:
    """The plan, or its faults, remedies of room left out."""
    mold, limits, fixture = design.mold, limits_of(design.mold), fixture_of(design)
    extent, unheld = _parted(fixture, fixture.room.extent)
    closed_for = "mold.pour asks for it"
    if mold.pour != "closed" and not unheld:
        found, why = open_plan(design, fixture, extent)
        wrong = limit_faults(mold, limits, 0.0, "open")
        if found is not None and not wrong:
            return found, []
        if isinstance(why, Fault):
            return None, [*wrong, why]
        if mold.pour == "open" and not wrong:
            return None, [refusal("not_open", "mold.pour", mold.pour, why=why)]
        closed_for = why
    plan = MoldPlan(
        **vars(extent),
        scale=fixture.scale,
        frames=fixture.frames,
        legs=fixture.legs,
        sides=tuple(fixture.side(side) for side in SIDES),
        plugs=fixture.plugs,
        top=extent.crest + mold.insert_mm,
        base=mold.base_mm,
        closed_for=closed_for,
    )
    plan = with_mount(design.body, plan)
    holes, no_room = base_holes_of(design, plan, limits)
    core_pins, no_pins = core_pins_of(design, plan, limits)
    plan = replace(plan, base_holes=holes, core_pins=core_pins)
    columns = _columns(plan, mold, limits)
    faults = [
        *limit_faults(mold, limits, columns.reach, "closed"),
        *unheld,
        *no_pins,
        *no_room,
        *fastener_faults(mold, plan, columns),
    ]
    if faults:
        return None, list({str(fault): fault for fault in faults}.values())
    if mold.wall_mm is not None:
        columns = replace(columns, wall_z=mold.wall_mm)
    return fastened(design.body, plan, columns), []


def _parted(fixture: Fixture, extent: Extent) -> tuple[Extent, list[Fault]]:
    """The extent with end and side walls parted where legs leave through the right ones, and the
    faults that are left: a round or tapering body may be parted at any of several |z|."""
    held = fixture_faults(fixture)
    shares = (1.0,) if extent.continued or not fixture.legs else CORNERS
    found = []
    for share in shares:
        parted = replace(extent, corner=share * extent.corner)
        found.append((parted, with_walls(fixture, held, parted.corner)))
        if not found[-1][1]:
            break
    return min(found, key=lambda each: len(each[1]))


def _columns(plan: MoldPlan, mold: Mold, limits: Limits) -> Columns:
    """Columns for the given bolts, or for the largest of ``AUTO_BOLTS`` that fit along z."""
    plugged = plan.plug("z") is not None
    sizes = AUTO_BOLTS if mold.bolt == "auto" else (mold.bolt,)
    tried = [columns_of(plan, mold, limits, size, plugged) for size in sizes]
    columns = next((c for c in tried if z_bolt_height(plan, c) is not None), tried[-1])
    low = pin_height(plan, columns) is None and plan.plug("x") is None
    return columns_of(plan, mold, limits, columns.size, plugged or low)


# What of a design's legs and slots is worst, and changed designs that are tried for remedies.

CLOSE = 2e-6  # mm; rounding
TRIALS = 9  # halvings: a pitch to some hundredths of a millimetre

Web = tuple[Holding, int, int, float, float]  # how they are held, two plates, web, least web


def row_of(design: Design, plate: int) -> PlateRow:
    """The row that a plate stands in."""
    return next(row for row in plate_rows(design) if plate in (f.index for f in row.frames))


def least_value(
    design: Design, key: str, low: float, high: float, holds: Callable[[Design], bool]
) -> float | None:
    """About the least value of a key in (low, high] from which a sound design ``holds``."""

    def does(value: float) -> bool:
        trial = with_key(design, key, value) if in_time() else None
        return trial is not None and holds(trial)

    found = next((v for v in np.linspace(low, high, 9)[1:].tolist() if does(v)), None)
    if found is None:
        return None
    over = float(at_least(edge(does, found, found - (high - low) / 8.0, TRIALS - 3)))
    trial = with_key(design, key, over) if in_time() else None
    return over if trial is not None and holds(trial) and is_sound(trial) else None


def worst_exit(fixture: Fixture) -> tuple[Leg, float] | None:
    """The leg that leaves most too near to the contact zone, its nearest exit; None: none does."""
    lacks = [fixture.room.least_exit(leg.side) - nearest for leg, nearest in fixture.high]
    worst = int(np.argmax(lacks)) if lacks else 0
    return fixture.high[worst] if lacks and lacks[worst] > CLOSE else None


def worst_web(fixture: Fixture) -> Web | None:
    """The two slots that lack most of a web; None: all webs are held."""
    worst: Web | None = None
    for side in SIDES:
        openings, holding = fixture.slots(side), fixture.holding(side)
        web = slots.least_web(fixture.design, holding, fixture.limits)
        first, second, distance = slots.webs(openings)
        if not len(distance):
            continue
        k = int(np.argmin(distance))
        lack = web - distance[k]
        if lack > CLOSE and (worst is None or lack > worst[4] - worst[3]):
            one, two = openings[first[k]].plate, openings[second[k]].plate
            worst = (holding, one, two, float(distance[k]), web)
    return worst


_SMALLEST_MM = 0.02  # slot or web


def no_web(fixture: Fixture, worst: Web) -> Fault:
    """The fault of two slots between which no web can stand."""
    design = fixture.design
    holding, one, two, distance, web = worst
    row = row_of(design, two)
    same = any(frame.index == one for frame in row.frames)
    key, value = row.blame(two, "pitch_mm" if same else "cover_mm")
    of = {"holding": holding, "one": one, "two": two, "distance": distance, "web": web}
    least = slots.least_slot(design, holding, fixture.limits)
    changes = _wider(design, row, holding, same, one, key)
    return refusal("no_web", key, value, least=least, changes=changes, **of)


def _wider(
    design: Design, row: PlateRow, holding: Holding, same: bool, other: int, key: str
) -> list[str]:
    """The remedies of slots that lack webs: changes that were tried."""

    def holds(trial: Design, thorough: bool = False) -> bool:
        return worst_web(fixture_of(trial, thorough)) is None

    found = []
    if row.placed:
        found.append(f"move it away from plate {other}")
    elif same:
        pitch = row.table.pitch_mm
        wider = least_value(design, key, pitch, 3.0 * pitch + 1.0, holds)
        if wider is not None:
            found.append(f"raise {key} to at least {wider:g}")
    else:
        found.append(f"move the rows apart by {key}")
    mold = design.mold
    finer = "set mold.plate_fixture = 'comb', whose slots are cut finer"
    changes: tuple[tuple[bool, str, object, str], ...] = (
        ("comb" not in (holding, mold.plate_fixture), "plate_fixture", "comb", finer),
        (mold.leg_mm is not None, "leg_mm", None, "remove mold.leg_mm"),
    )
    for possible, name, value, words in changes:
        if possible and in_time() and holds(_with_mold(design, **{name: value}), thorough=True):
            found.append(words)
    return found


def _with_mold(design: Design, **values: object) -> Design:
    """The design with other values in its [mold] table."""
    return design.model_copy(update={"mold": design.mold.model_copy(update=values)})


def demanded(design: Design, worst: Web | None, high: tuple[Leg, float] | None) -> Fault | None:
    """The slot or web that the file itself asks for, if that is why plates cannot be held.

    None: they could not be held without it either.
    """
    comb = [f"comb.{name}_mm" for name in ("slot", "web", "clearance")]
    limits = [f"limits.{name}_mm" for name in ("slot", "feature", "clearance")]
    for key in (*(comb if design.mold.plate_fixture == "comb" else ()), *limits):
        where, name = key.split(".")
        table = getattr(design.mold, where)
        value = getattr(table, name) if name in table.model_fields_set else None
        most = None if value is None else _most(design, where, name, float(value))
        if most is not None:
            of = {"most": most, "worst": worst, "high": high}
            return refusal("too_much", f"mold.{key}", value, **of)
    return None


def _most(design: Design, where: str, name: str, high: float) -> float | None:
    """The greatest value of one of the mold's sizes at which its plates are held; None: at none."""
    table = getattr(design.mold, where)

    def holds(size: float) -> bool:
        changed = _with_mold(design, **{where: table.model_copy(update={name: size})})
        fixture = fixture_of(changed, thorough=False)
        return worst_web(fixture) is None and worst_exit(fixture) is None

    low = min(_SMALLEST_MM, 0.5 * high)
    if not in_time():
        return None
    return edge(holds, low, high, TRIALS) if holds(low) else None


def fixture_faults(fixture: Fixture) -> list[Fault]:
    """Every fault of a design's legs and slots but for walls in their way, the worst of each
    kind."""
    given = fixture.design.mold.leg_mm
    least = min((row.table.length_mm for row in plate_rows(fixture.design)), default=math.inf)
    found = _crossings(fixture)
    if given is not None and given > least:
        found.insert(0, refusal("wide_legs", "mold.leg_mm", given, least=least))
    worst, high = worst_web(fixture), worst_exit(fixture)
    fault = None if high is None else _draft(fixture, *high)
    if fault is None and (worst is not None or high is not None):
        fault = demanded(fixture.design, worst, high)
    if fault is not None:
        found.append(fault)
    else:
        found += [] if high is None else [_too_high(fixture, *high)]
        found += [] if worst is None else [no_web(fixture, worst)]
    return found


def _crossings(fixture: Fixture) -> list[Fault]:
    near = [
        (float(gap), leg.plate, "other plates or the core")
        for leg, gap in zip(fixture.legs, fixture.gaps(), strict=True)
        if gap < fixture.least_gap - CLOSE
    ]
    for one, two, distance in fixture.crossings():
        near.append((distance, two.plate, f"the legs of plate {one.plate}"))
    if not near:
        return []
    distance, plate, what = min(near, key=lambda each: each[0])
    key, value = row_of(fixture.design, plate).blame(plate, "cover_mm")
    of = {"least": fixture.least_gap, "what": what, "plate": plate, "distance": distance}
    return [refusal("crossing_legs", key, value, **of)]


def _draft(fixture: Fixture, leg: Leg, nearest: float) -> Fault | None:
    """The draft that alone makes a plug narrower than the contact zone."""
    draft = fixture.room.greatest_draft(leg.side, nearest)
    if draft is None:
        return None
    zone, most = fixture.room.zone(leg.side), math.floor(100.0 * draft) / 100.0
    key, value = "mold.draft_deg", fixture.design.mold.draft_deg
    return refusal("seam_in_contact", key, value, most=most, leg=leg, zone=zone)


def _too_high(fixture: Fixture, leg: Leg, nearest: float) -> Fault:
    design, room = fixture.design, fixture.room
    row = row_of(design, leg.plate)
    key, value = row.blame(leg.plate, "cover_mm")

    def holds(trial: Design) -> bool:
        return worst_exit(fixture_of(trial, thorough=False)) is None

    deeper = None
    if not row.placed:
        cover = row.table.cover_mm
        deeper = least_value(design, key, cover, cover + row.frames[0].y, holds)
    of = {"leg": leg, "zone": room.zone(leg.side), "room": room, "nearest": nearest}
    return refusal("high_legs", key, value, key=key, deeper=deeper, **of)


def with_walls(fixture: Fixture, found: list[Fault], corner: float | None = None) -> list[Fault]:
    """What :func:`fixture_faults` found, and legs in the way of walls that meet at |z| =
    ``corner`` (absent: as extent.py has it); the worst of each key."""
    unique: dict[str, Fault] = {}
    for fault in (*found, *_blocked(fixture, corner)):
        unique.setdefault(fault.key, fault)
    return list(unique.values())


def _blocked(fixture: Fixture, corner: float | None) -> list[Fault]:
    """Legs that would run through a wall which is drawn across them, or too near to the base."""
    design, loose, room = fixture.design, fixture.loose, fixture.room
    if not loose:
        return []
    if corner is not None:
        room = replace(room, extent=replace(room.extent, corner=corner))
    exits, openings = fixture.exits, fixture.openings
    found = []
    sunk = room.sunk(openings)
    worst = int(np.argmax(sunk))
    if sunk[worst] > CLOSE:
        plate = loose[worst].plate
        key, value = row_of(design, plate).blame(plate, "cover_mm")
        of = {"web": room.web, "plate": plate, "bottom": float(openings.bottom[worst])}
        found.append(refusal("low_slots", key, value, **of))
    into = room.blocked([leg.side for leg in loose], openings, exits)
    worst = int(np.argmax(into))
    if into[worst] > CLOSE:
        leg = loose[worst]
        row = row_of(design, leg.plate)
        key, value = row.blame(leg.plate, "pitch_mm" if len(row.frames) > 1 else "offset_mm")
        deep = float(into[worst])
        corner = room.extent.corner
        found.append(refusal("legs_in_walls", key, value, leg=leg, corner=corner, into=deep))
    return found
