"""Faults of fingers, hardware and objects, each drawn from a random generator.

Sizes are those of a careful workshop: plates to 0.1 mm and 1 degree, silicone to 15 %, gage factors
to 3 %.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.arrays import Array
from fingerdesign.design.grip import GRAVITY
from fingerdesign.design.schema import Design
from fingerdesign.sensing.model import CONTACT_SIZE_MM

Keys = dict[str, object]


@dataclass(frozen=True)
class Draw:
    """Changes of a draw: plates (p, 3) by x, y (mm), angle (degrees); keys of design and object;
    fields of PerturbedFinger itself."""

    plates: Array
    design: Keys
    object: Keys
    own: dict[str, Any]


Drawn = Callable[[Design, np.random.Generator, Draw], None]


def scaled(table: Literal["body", "plates"], key: str, fraction: float) -> Drawn:
    """Multiply a material's key by 1 +- fraction."""

    def drawn(design: Design, rng: np.random.Generator, draw: Draw) -> None:
        value = getattr(design.material_of(table), key) * (1.0 + fraction * rng.uniform(-1.0, 1.0))
        name = getattr(design, table).material
        draw.design[f"materials.{name}.{key}"] = value

    return drawn


def poisson(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    """Draw a rubber's Poisson's ratio anywhere below 0.5; a foam's is off by 3 %."""
    own = design.material_of("body").poissons_ratio
    low, high = (0.47, 0.4999) if own >= 0.47 else (0.97 * own, min(1.03 * own, 0.4999))
    draw.design[f"materials.{design.body.material}.poissons_ratio"] = rng.uniform(low, high)


def moved(sizes: tuple[float, float, float], alike: bool) -> Drawn:
    """Move plates by up to ``sizes``, each by itself or all alike."""

    def drawn(design: Design, rng: np.random.Generator, draw: Draw) -> None:
        count = 1 if alike else len(draw.plates)
        draw.plates[:] += np.array(sizes) * rng.uniform(-1.0, 1.0, (count, 3))

    return drawn


def hardware(**limits: float) -> Drawn:
    """Set the worse of the rig's own values and these."""

    def drawn(design: Design, rng: np.random.Generator, draw: Draw) -> None:
        own = design.grip.hardware
        worse = {key: max(value, getattr(own, key)) for key, value in limits.items()}
        draw.design.update({f"grip.hardware.{key}": value for key, value in worse.items()})
        draw.design["grip.hardware.specimen"] = int(rng.integers(2**31))

    return drawn


def dying(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    """Let one of the gages fail within the first third of a second."""
    draw.design["grip.hardware.dying_gages"] = [int(rng.choice(gage_array(design)))]
    draw.design["grip.hardware.dying_after_s"] = rng.uniform(0.0, 0.33)


def relaxed(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.design["grip.plant"] = "lift"  # Relaxation needs a plant that lifts.
    draw.design["grip.relaxation_per_minute"] = 0.1


def accelerated(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.own["tug"] = 3.0 / GRAVITY  # An arm accelerates by 3 m/s^2.


def patchy(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.own["patches"] = int(rng.integers(2**31))


def kinetic(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.design["grip.kinetic_share"] = 1.0 - rng.uniform(0.05, 0.2)


def tilted(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.object["tilt_deg"] = 2.0 * rng.uniform(-1.0, 1.0)


def curved(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    """Draw a cylinder. It has no tilt: of objects that would have both, half have either."""
    if "tilt_deg" in draw.object:
        if rng.uniform() < 0.5:
            return
        del draw.object["tilt_deg"]
    draw.object.update(shape="cylinder", radius_mm=30.0 / rng.uniform(1e-3, 1.0))


def off_centre(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.design["grip.plant"] = "lift"  # An object turns in a plant that lifts.
    draw.design["grip.off_centre_mm"] = 10.0 * rng.uniform(-1.0, 1.0)


def falling(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    draw.design["grip.plant"] = "lift"  # The friction met depends on the weight.
    draw.own["exponent"] = 0.65 * rng.uniform()


def meshed(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    factor = rng.uniform(1.2, 2.0)
    for table, sizes in (("mesh.section", design.mesh.section), ("mesh", design.mesh)):
        draw.design[f"{table}.plate_size_mm"] = factor * sizes.plate_size_mm
        if design.plates.model == "sheet":  # The size of lines hardly changes the mesh.
            draw.design[f"{table}.contact_size_mm"] = factor * sizes.contact_size_mm


def other_mesher(design: Design, rng: np.random.Generator, draw: Draw) -> None:
    """Mesh by fTetWild in 3-D, in sizes at which it takes a minute and no two meshes are alike.

    Its facets are as long along z as across, where layers are longer: with facets as fine as theirs
    it would have three times as many contact nodes.
    """
    factor = rng.uniform(1.6, 2.0)
    contact = factor * max(CONTACT_SIZE_MM["3d"], design.mesh.contact_size_mm)
    own = {"mesher": "tetwild", "contact_size_mm": contact}
    own["plate_size_mm"] = factor * design.mesh.plate_size_mm
    draw.design.update({f"mesh.{key}": value for key, value in own.items()})
    draw.own["fixed_keys"] = ("mesh.mesher",)
