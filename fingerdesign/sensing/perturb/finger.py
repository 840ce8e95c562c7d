"""Perturbed fingers and objects: different from the model that a controller is trained on.

A fault is drawn from a seed and set in the design's own keys, in its hardware, or in the object. A
controller that is trained and tested on the same model knows too much: plates lie where the mold
left them, the rubber is of another batch, the object leans.
"""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.checks.follow import grip_values
from fingerdesign.checks.load import with_values
from fingerdesign.checks.meshing import tetwild_faults
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.design.grip import Grip
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mesh.make import mesher_name
from fingerdesign.runtime.streams import stream
from fingerdesign.sensing.model import BenchFinger, against, meshed_for_grips
from fingerdesign.sensing.perturb.faults import FAULTS, TRAINING_FAULTS, Draw
from fingerdesign.shapes.friction import FrictionLaw

PATCHINESS, PATCH_MM = 0.2, 1.0
_PATCHES = 64  # The field of patches repeats after so many, along x and along z.
_ATTEMPTS = 20
_MOVING = {"plates", "row", "cover", "angle"}


@dataclass(frozen=True)
class PerturbedFinger:
    """A finger with its hardware, and the object that it grips.

    tug: fraction of the object's weight by which it is pulled as soon as it hangs; 0.3 is an arm
    that accelerates by 3 m/s^2. patches: the seed of the patches on its surface, None: friction is
    the same everywhere. exponent: n of friction that falls with the pressure p as p^-n.
    fixed_keys: keys of its mesh that stay, where grips mesh coarser.
    """

    design: Design
    object: SceneObject
    tug: float = 0.0
    patches: int | None = None
    exponent: float = 0.0
    fixed_keys: tuple[str, ...] = ()

    def friction_fractions(self, points: Array) -> Array | None:
        """Friction over its mean at ``points`` (m, 2 | 3) mm: 1 +- PATCHINESS, drawn every PATCH_MM
        along x and z and linear between. That patches move with the object is left out."""
        if self.patches is None:
            return None
        values = stream(self.patches, "patches").uniform(-1.0, 1.0, (_PATCHES, _PATCHES))
        along = points[:, 2] if points.shape[1] == 3 else np.zeros(len(points))
        places = [points[:, 0] / PATCH_MM, along / PATCH_MM]
        from scipy.ndimage import map_coordinates  # 0.1 s of each start

        field: Array = map_coordinates(values, places, order=1, mode="grid-wrap")
        return 1.0 + PATCHINESS * field


def perturb(design: Design, faults: Iterable[str], seed: int) -> PerturbedFinger:
    """Draw one finger and object with the faults from the seed alone, each from its own stream.

    A finger whose plates would overlap is drawn again. Raises DesignError for unknown names, for
    faults that cannot be drawn on this design, and where no draw is sound.
    """
    names = set(faults)
    if found := _undrawable(design, names):
        raise DesignError(found, design.design.name)
    chosen = tuple(name for name in FAULTS if name in names)
    for attempt in range(_ATTEMPTS):
        with suppress(DesignError):
            return _drawn(design, chosen, seed, attempt)
    return _drawn(design, chosen, seed, _ATTEMPTS)


def _drawn(design: Design, faults: tuple[str, ...], seed: int, attempt: int) -> PerturbedFinger:
    frames = plate_frames(design)
    before = places_of(frames)
    draw = drawn_changes(design, before, faults, seed, attempt)
    if not np.array_equal(draw.plates, before):
        keys = placement_keys(frames, draw.plates)
        rows = keys["plates.placement"]
        keys["plates.placement"] = [[float(f"{v:.6f}") for v in row] for row in rows]
        draw.design.update(keys)
    known = grip_values(design)  # The hand knows the model alone.
    if draw.design or not {f"grip.{key}" for key in design.grip.model_fields_set} >= known.keys():
        design = with_values(design, known | draw.design)
    met = SceneObject(**draw.object)  # type: ignore[arg-type]
    return PerturbedFinger(design, met, **draw.own)


def drawn_changes(
    design: Design, places: Array, faults: Iterable[str], seed: int, attempt: int = 0
) -> Draw:
    """Draw the faults' changes, which need not be sound together. places (p, 3): the design's."""
    draw = Draw(places.copy(), {}, {}, {})
    for name in faults:
        FAULTS[name](design, stream(seed, "fault", name, attempt), draw)
    return draw


def places_of(frames: Sequence[PlateFrame]) -> Array:
    """Centre (mm) and angle (degrees) of each plate, (p, 3)."""
    return np.array([[*frame.centre, frame.angle_deg] for frame in frames]).reshape(-1, 3)


def placement_keys(frames: Sequence[PlateFrame], places: Array) -> dict[str, Any]:
    """Keys of a design that put its plates at other places (p, 3), each at its own middle."""
    rows: list[list[float]] = places.tolist()
    keys: dict[str, Any] = {"plates.offset_mm": 0.0}
    if any(frame.middle for frame in frames):
        rows = [[*row, frame.middle] for row, frame in zip(rows, frames, strict=True)]
        keys |= {"plates.stagger_mm": 0.0, "plates.span_offset_mm": 0.0}
    return keys | {"plates.placement": rows}


@lru_cache(maxsize=1)
def _last_bench(bench: BenchFinger) -> ContactProblem:
    return bench.model()[1]


def perturbed_problems(
    found: PerturbedFinger, fidelity: str = "plane-strain"
) -> tuple[ContactProblem, ContactProblem]:
    """Pose the finger against the plane of its bench, and against its object; condensed once.

    The last finger is cached: draws that differ in hardware alone share it.
    """
    design = found.design.model_copy(update={"grip": bench_grip(found.design.grip)})
    bench = _last_bench(BenchFinger(design, (found.object,), fidelity, found.fixed_keys))
    return bench, facing(bench, found)


def bench_grip(grip: Grip) -> Grip:
    """The keys of a ``[grip]`` table on which a finger's model depends; the rest by default."""
    return Grip(
        max_approach_mm=grip.max_approach_mm,
        bench_friction_coefficient=grip.bench_friction_coefficient,
        plant=grip.plant,
        off_centre_mm=grip.off_centre_mm,  # it takes a whole finger
    )


def facing(bench: ContactProblem, found: PerturbedFinger) -> ContactProblem:
    """Pose a bench's finger against its object, with its patches and the exponent of its friction
    (gross_slip.meeting takes it over); nothing is condensed again."""
    problem = against(bench, found.object, found.design)
    if found.exponent:
        law = FrictionLaw(problem.friction_coefficient, exponent=found.exponent)
        problem = problem.with_friction(law)
    fractions = found.friction_fractions(problem.model.points)
    return problem if fractions is None else problem.patchy(fractions)


def training_faults(design: Design) -> tuple[str, ...]:
    """The faults of TRAINING_FAULTS that can be drawn on a design."""
    return tuple(name for name in TRAINING_FAULTS if not _undrawable(design, [name]))


def refuse_faults(design: Design, names: Iterable[str], fidelity: str = "plane-strain") -> None:
    """Raise a DesignError for unknown names, for faults that cannot be drawn on this design or in
    this fidelity, and for a bare opposite finger."""
    chosen = set(names)
    found = _undrawable(design, chosen)
    if "mesher" in chosen:
        found += _no_other_mesher(design, fidelity)
    if "off_centre" in chosen and fidelity != "3d":
        bound = "another fault in plane strain: an object turns about the normal in 3-D alone"
        found.append(Fault("--fault", "off_centre", bound, "take --fidelity 3d, or leave it out"))
    if design.grip.opposite != "mirror":
        bound = "'mirror' on perturbed fingers: both are alike"
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
