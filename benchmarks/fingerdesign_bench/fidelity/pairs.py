"""Thirty seeded pairs of a finger and a scene, each with a tolerance.

Fifteen fingers: eight narrow (3 to 6 mm deep, up to three plates), four wide (12 to 24 mm, up to
one plate), three very wide (40 to 60 mm, homogeneous); arcs of 10 to 40 mm radius, 12 to 22 mm
wide, gages read on one face or on both. Each is pressed by a plane, once along a path of motions
and once of forces, to partial slip. Tolerances 1, 2, 5 and 10 % take turns.
"""

import hashlib
import json
import math
from dataclasses import dataclass

import numpy as np

from fingerdesign.checks.load import parse_design
from fingerdesign.design.io import parse_scene
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height

SEED, FINGERS = 20261120, 15
KINDS = ((3.0, 6.0, 3), (12.0, 24.0, 1), (40.0, 60.0, 0))  # depths, mm; plates at the most
TOLERANCES = (0.01, 0.02, 0.05, 0.1)


@dataclass(frozen=True)
class Pair:
    """A finger, a scene, and how accurate the answer shall be."""

    number: int
    finger: int
    control: str
    design: Design
    scene: Scene
    tolerance: float

    @property
    def name(self) -> str:
        """A few words: "finger 3, force"."""
        return f"finger {self.finger}, {self.control}"

    def digest(self) -> str:
        """SHA-256, in hexadecimal, of finger and scene; keys that are left at their defaults do
        not count, so that new ones make no reference another's, nor does the single increment of
        each row, which all references have."""
        finger = {"body", "plates", "gages", "materials"}
        content = [
            self.design.model_dump(mode="json", include=finger, exclude_defaults=True),
            self.scene.model_dump(
                mode="json", exclude_defaults=True, exclude={"path": {"substeps"}}
            ),
        ]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def pairs(fingers: int = FINGERS, seed: int = SEED) -> list[Pair]:
    """The pairs, always the same for a seed."""
    found: list[Pair] = []
    for finger in range(fingers):
        rng = np.random.default_rng([seed, finger])
        design = random_finger(rng, finger)
        for control in ("motion", "force"):
            number = len(found)
            scene = random_scene(rng, design, control)
            tolerance = TOLERANCES[(number + finger // 2) % len(TOLERANCES)]
            found.append(Pair(number, finger, control, design, scene, tolerance))
    return found


def random_finger(rng: np.random.Generator, number: int) -> Design:
    """One finger of the ranges above, to be extruded."""
    low, high, most_plates = KINDS[(0, 1, 0, 2)[number % 4]]
    width = float(rng.uniform(12.0, 22.0))
    depth = float(rng.uniform(low, high))
    radius = float(rng.uniform(max(10.0, 0.55 * width), 40.0))
    count = int(rng.integers(0, most_plates + 1))
    cover = float(rng.uniform(1.2, 2.5))
    text = f"""
design.name = "finger_{number}"
body.width_mm = {width:.2f}
body.depth_mm = {depth:.2f}
body.base_height_mm = {rng.uniform(5.0, 11.0):.2f}
body.arc_radius_mm = {radius:.2f}
plates.count = {count}
plates.pitch_mm = {rng.uniform(1.2, 2.5):.2f}
plates.cover_mm = {cover:.2f}
plates.length_mm = {rng.uniform(1.2, 2.0):.2f}
plates.thickness_mm = {rng.choice([0.1, 0.15, 0.2]):.2f}
plates.angle_deg = {rng.choice([30.0, 45.0, 60.0]):.0f}
gages.face = "{rng.choice(["both", "upper", "lower"])}"
gages.length_mm = 0.8
gages.width_mm = 1.0
materials.silicone.poissons_ratio = {rng.uniform(0.45, 0.495):.4f}
mesh.mesher = "sweep"
"""
    if count == 0:
        lines = (line for line in text.splitlines() if not line.startswith(("plates.", "gages.")))
        text = "\n".join([*lines, "plates.count = 0"])
    return parse_design(text)


def random_scene(rng: np.random.Generator, design: Design, control: str) -> Scene:
    """A plane pressed 0.08 to 0.25 mm, or with about the force of that, then pulled to slip."""
    approach, friction = float(rng.uniform(0.08, 0.25)), float(rng.uniform(0.3, 0.8))
    pull = float(rng.uniform(0.5, 0.8))
    steps = (0.35, 0.7, 1.0)
    if control == "motion":
        key, most, pull = "increments_mm", approach, 1.2 * pull
    else:
        key, most = "increments_N", force_at(design, approach)
    rows = [[0.5 * most, 0.0], [most, 0.0]]
    rows += [[most, pull * friction * most * step] for step in steps]
    shown = [[round(value, 5) for value in row] for row in rows]
    return parse_scene(
        f"[object]\nfriction_coefficient = {friction:.3f}\n"
        f'[path]\nsubsteps = 1\ncontrol = "{control}"\n{key} = {shown}\n'
    )


def force_at(design: Design, approach: float) -> float:
    """About the force, N, that presses so far, by Johnson's formula of a layer (eq. 5.56).

    It is part of what the references were made for, and stays as it is.
    """
    material, body = design.material_of("body"), design.body
    modulus = material.youngs_modulus_MPa / (1.0 - material.poissons_ratio**2)
    across = body.kind.curvatures(body)[0]
    height, nu = float(crest_height(body)), material.poissons_ratio

    def approach_of(force: float) -> float:
        half = math.sqrt(4.0 * force / (body.depth_mm * math.pi * modulus * across))
        layer = 2.0 * math.log(max(2.0 * height / half, 1.0 + 1e-9)) - nu / (1.0 - nu)
        return min(half * half * across / 4.0 * max(layer, 0.5), 0.5 * height)

    low, high = 1e-3, 1e3
    for _ in range(60):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if approach_of(middle) < approach else (low, middle)
    return low
