"""Fingers and objects as they come out: not those of the model that a controller is taught on.

A fault is drawn from a seed and set in the design's own keys, in its hardware, or in the object.
What is taught on a model and judged on the same model knows too much: plates lie where the mold
left them, the rubber is of another batch, the object leans. Sizes are those of a careful workshop:
plates to 0.1 mm and 1 degree, silicone to 15 %, gage factors to 3 %.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy.ndimage import map_coordinates

from fingerdesign.analysis.case import gage_array
from fingerdesign.arrays import Array
from fingerdesign.checks.design import tetwild_faults
from fingerdesign.checks.follow import grip_values
from fingerdesign.checks.load import with_values
from fingerdesign.design.grip import GRAVITY, Grip
from fingerdesign.design.scene import SceneObject
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.frames import plate_frames
from fingerdesign.mesh.make import mesher_name
from fingerdesign.sensing.model import CONTACT_SIZE_MM, against, bench_problem, meshed_for_grips

if TYPE_CHECKING:
    from fingerdesign.contact.problem import ContactProblem
    from fingerdesign.design.schema import Design

Keys = dict[str, object]
PATCHINESS, PATCH_MM = 0.2, 1.0
_PATCHES = 64  # along each side, then again


@dataclass(frozen=True)
class Unlike:
    """A finger with its hardware, and the object that it grips. tug: share of the object's weight
    by which it is pulled at once it hangs; 0.3 is an arm that accelerates by 3 m/s^2. patches: the
    seed of its surface's patches, None: friction is everywhere the same. said: keys of its mesh
    that grips, which mesh coarser and in layers, leave as they are."""

    design: Design
    held: SceneObject
    tug: float = 0.0
    patches: int | None = None
    said: tuple[str, ...] = ()

    def friction_shares(self, points: Array) -> Array | None:
        """Of the mean friction coefficient at ``points`` (m, 2 | 3) mm: 1 +- PATCHINESS, drawn anew
        every PATCH_MM along x and z and linear between. What moves with the object is left out."""
        if self.patches is None:
            return None
        values = np.random.default_rng(self.patches).uniform(-1.0, 1.0, (_PATCHES, _PATCHES))
        along = points[:, 2] if points.shape[1] == 3 else np.zeros(len(points))
        places = [points[:, 0] / PATCH_MM, along / PATCH_MM]
        field: Array = map_coordinates(values, places, order=1, mode="grid-wrap")
        return 1.0 + PATCHINESS * field


@dataclass(frozen=True)
class Draw:
    """What is changed: plates (p, 3) by x, y (mm), angle (degrees); keys of design and object; of
    Unlike itself."""

    plates: Array
    design: Keys
    held: Keys
    own: dict[str, Any]


Drawn = Callable[["Design", np.random.Generator, Draw], None]


def _scaled(table: Literal["body", "plates"], key: str, share: float) -> Drawn:
    """A material's key times 1 +- share."""

    def drawn(design: Design, rng: np.random.Generator, draw: Draw) -> None:
        value = getattr(design.material_of(table), key) * (1.0 + share * rng.uniform(-1.0, 1.0))
        name = getattr(design, table).material
        draw.design[f"materials.{name}.{key}"] = value

    return drawn


def _poisson(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    """Of a rubber; a foam's is off by 3 %."""
    own = design.material_of("body").poissons_ratio
    low, high = (0.47, 0.4999) if own >= 0.47 else (0.97 * own, min(1.03 * own, 0.4999))
    draw.design[f"materials.{design.body.material}.poissons_ratio"] = rng.uniform(low, high)


def _moved(sizes: tuple[float, float, float], alike: bool) -> Drawn:
    """Plates off by up to ``sizes``, each for itself or all alike."""

    def drawn(design: Design, rng: np.random.Generator, draw: Draw) -> None:
        count = 1 if alike else len(draw.plates)
        draw.plates[:] += np.array(sizes) * rng.uniform(-1.0, 1.0, (count, 3))

    return drawn


def _hardware(**spreads: float) -> Drawn:
    """The worse of the rig's own and this."""

    def drawn(design: Design, rng: np.random.Generator, draw: Draw) -> None:
        own = design.grip.hardware
        worse = {key: max(value, getattr(own, key)) for key, value in spreads.items()}
        draw.design.update({f"grip.hardware.{key}": value for key, value in worse.items()})
        draw.design["grip.hardware.specimen"] = int(rng.integers(2**31))

    return drawn


def _dying(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    """One of the gages, within the first third of a second."""
    draw.design["grip.hardware.dying_gages"] = [int(rng.choice(gage_array(design)))]
    draw.design["grip.hardware.dying_after_s"] = rng.uniform(0.0, 0.33)


def _relaxed(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.design["grip.plant"] = "lift"  # fingers that are judged lift
    draw.design["grip.relaxation_per_minute"] = 0.1


def _accelerated(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.own["tug"] = 3.0 / GRAVITY  # m/s^2


def _patchy(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.own["patches"] = int(rng.integers(2**31))


def _kinetic(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.design["grip.kinetic_share"] = 1.0 - rng.uniform(0.05, 0.2)


def _tilted(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.held["tilt_deg"] = 2.0 * rng.uniform(-1.0, 1.0)


def _curved(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    """A cylinder has no tilt to speak of: of objects that would have both, half have either."""
    if "tilt_deg" in draw.held:
        if rng.uniform() < 0.5:
            return
        del draw.held["tilt_deg"]
    draw.held.update(shape="cylinder", radius_mm=30.0 / rng.uniform(1e-3, 1.0))


def _meshed(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    factor = rng.uniform(1.2, 2.0)
    for table, sizes in (("mesh.section", design.mesh.section), ("mesh", design.mesh)):
        draw.design[f"{table}.plate_size_mm"] = factor * sizes.plate_size_mm
        if design.plates.model == "sheet":  # lines, which their size hardly changes
            draw.design[f"{table}.contact_size_mm"] = factor * sizes.contact_size_mm


def _other_mesher(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    """fTetWild in 3-D, in sizes at which it takes a minute and no two meshes are alike.

    Its facets are as long along z as across, where layers are longer: as fine as those it would
    have three times as many contact nodes.
    """
    factor = rng.uniform(1.6, 2.0)
    contact = factor * max(CONTACT_SIZE_MM["3d"], design.mesh.contact_size_mm)
    own = {"mesher": "tetwild", "contact_size_mm": contact}
    own["plate_size_mm"] = factor * design.mesh.plate_size_mm
    draw.design.update({f"mesh.{key}": value for key, value in own.items()})
    draw.own["said"] = ("mesh.mesher",)


# Each with its size; drawn evenly between both signs.
FAULTS: Mapping[str, Drawn] = {
    "modulus": _scaled("body", "youngs_modulus_MPa", 0.15),
    "poisson": _poisson,  # 0.47 to 0.4999
    "plates": _moved((0.1, 0.1, 1.0), alike=False),  # mm, mm, degrees
    "row": _moved((0.1, 0.0, 0.0), alike=True),
    "cover": _moved((0.0, 0.1, 0.0), alike=True),
    "angle": _moved((0.0, 0.0, 2.0), alike=True),
    "plate_modulus": _scaled("plates", "youngs_modulus_MPa", 0.2),
    "gains": _hardware(gain_spread=0.03),
    "drift": _hardware(drift_microstrain_per_s=0.5),
    "delay": _hardware(delay_samples=2),
    "tilt": _tilted,  # 2 degrees
    "radius": _curved,  # 30 mm to flat
    "mesh": _meshed,
    "cross_talk": _hardware(gage_cross_talk=0.02),
    "forces": _hardware(force_gain_spread=0.01, force_cross_talk=0.01),
    "temperature": _hardware(warming_microstrain=10.0),  # 10 K at 1 microstrain/K
    "conversion": _hardware(quantisation_microstrain=1.0),  # 12 bits of +-2000 microstrain
    "dying": _dying,
    "relaxation": _relaxed,
    "arm": _accelerated,
    "patches": _patchy,  # friction +-20 % over 1 mm
    "kinetic": _kinetic,  # friction 5 to 20 % less in motion
    "mesher": _other_mesher,  # in 3-D
}
APART = frozenset({"mesher"})  # each of its fingers takes a minute: only where it is asked for
ALL = tuple(name for name in FAULTS if name not in APART)
OF_OBJECTS = frozenset({"tilt", "radius"})  # no finger's own
_ATTEMPTS = 20
_MOVING = {"plates", "row", "cover", "angle"}
# Taught on. The others are kept out: they are what a rig meets that nobody thought of.
TAUGHT = ("modulus", "poisson", "plates", "cover", "tilt", "radius")


def unlike(design: Design, faults: Iterable[str], seed: int) -> Unlike:
    """One finger and object with the faults, drawn from the seed alone, each from its own part.

    One whose plates would overlap is drawn anew. Raises DesignError for unknown names, for what
    cannot be drawn on this design, and where no draw is sound.
    """
    wanted = set(faults)
    if found := _undrawable(design, wanted):
        raise DesignError(found, design.design.name)
    chosen = tuple(name for name in FAULTS if name in wanted)
    for attempt in range(_ATTEMPTS):
        with suppress(DesignError):
            return _drawn(design, chosen, (seed, attempt))
    return _drawn(design, chosen, (seed, _ATTEMPTS))


def _drawn(design: Design, faults: tuple[str, ...], seed: tuple[int, int]) -> Unlike:
    frames = plate_frames(design)
    before = np.array([[*frame.centre, frame.angle_deg] for frame in frames]).reshape(-1, 3)
    draw = Draw(before.copy(), grip_values(design), {}, {})  # the hand knows the model alone
    numbers = {name: number for number, name in enumerate(FAULTS)}
    for name in faults:
        again = [seed[1]] if seed[1] else []
        FAULTS[name](design, np.random.default_rng([seed[0], numbers[name], *again]), draw)
    if not np.array_equal(draw.plates, before):
        places = draw.plates
        if any(frame.middle for frame in frames):
            places = np.column_stack([places, [frame.middle for frame in frames]])
            draw.design.update({"plates.stagger_mm": 0.0, "plates.span_offset_mm": 0.0})
        draw.design["plates.placement"] = [[float(f"{v:.6f}") for v in row] for row in places]
        draw.design["plates.offset_mm"] = 0.0
    held = SceneObject(**draw.held)  # type: ignore[arg-type]
    return Unlike(with_values(design, draw.design), held, **draw.own)


def unlike_problems(
    found: Unlike, fidelity: str = "plane-strain"
) -> tuple[ContactProblem, ContactProblem]:
    """A finger against the plane of its bench, and against what it grips; condensed once.

    The last finger is kept: where only hardware differs, draws share it.
    """
    design, grip = found.design, found.design.grip
    stage = Grip(
        max_approach_mm=grip.max_approach_mm,
        bench_friction_coefficient=grip.bench_friction_coefficient,
    )
    bench = _last_bench(
        design.model_copy(update={"grip": stage}), (found.held,), fidelity, found.said
    )
    return bench, facing(bench, found)


def facing(bench: ContactProblem, found: Unlike) -> ContactProblem:
    """A bench's finger against what it grips, patches and all: nothing is condensed anew."""
    held = against(bench, found.held, found.design)
    shares = found.friction_shares(held.model.points)
    return held if shares is None else held.patchy(shares)


_last_bench = lru_cache(maxsize=1)(bench_problem)


def taught_faults(design: Design) -> tuple[str, ...]:
    """Those of TAUGHT that can be drawn on a design."""
    return tuple(name for name in TAUGHT if not _undrawable(design, [name]))


def refuse_unlike(design: Design, names: Iterable[str], fidelity: str = "plane-strain") -> None:
    """DesignError, with every fault: unknown names; what cannot be drawn on this design or in this
    fidelity; a bare opposite finger."""
    chosen = set(names)
    found = _undrawable(design, chosen)
    if "mesher" in chosen:
        found += _no_other_mesher(design, fidelity)
    if design.grip.opposite != "mirror":
        bound = "'mirror' on unlike fingers: both are alike"
        found.append(Fault("grip.opposite", design.grip.opposite, bound, "set it to 'mirror'"))
    if found:
        raise DesignError(found, design.design.name)


def _no_other_mesher(design: Design, fidelity: str) -> list[Fault]:
    if fidelity != "3d":
        bound = "another fault in plane strain: netgen alone meshes sections"
        return [Fault("--fault", "mesher", bound, "take --fidelity 3d, or leave it out")]
    if mesher_name(meshed_for_grips(design, fidelity)) == "tetwild":
        bound = "another fault on this finger: no layers sweep it, so fTetWild meshes it anyway"
        return [Fault("--fault", "mesher", bound, "leave it out")]
    return tetwild_faults(design, symmetric=True)


def _undrawable(design: Design, names: Iterable[str]) -> list[Fault]:
    chosen, plates = set(names), design.plates
    found = [
        Fault("--fault", name, f"one of {', '.join(FAULTS)}", "correct it")
        for name in sorted(chosen - set(FAULTS))
    ]
    moved = ", ".join(sorted(chosen & _MOVING))
    if moved and (plates.rows or plates.along != "x" or plates.follow != "level"):
        bound = f"one level row along x where plates are moved one by one ({moved})"
        found.append(Fault("plates", "several rows, or bent", bound, "choose other faults"))
    shared = plates.number and design.body.material == plates.material
    if shared and chosen & {"modulus", "plate_modulus"}:
        bound = "another material than the body's where moduli are drawn apart"
        remedy = "give the plates' material a name of its own"
        found.append(Fault("plates.material", plates.material, bound, remedy))
    return found
