"""Small random fingers with a scene each, the same for the same seed, and their answers.

    finger = any_finger(7, "3d")
    difference(solved(finger), solved(finger.with_design({"body.depth_mm": 12.0})))

Straight bodies that a section or its sweep can mesh, of every layout that goes with that: plates
level, turned, bent, in two rows, finite, staggered, as sheets, not modelled; edges and cores;
rubber from 0.3 to 10 MPa; level and tilted planes and cylinders; friction from 0.1 to 1. They are
meshed coarsely: laws hold on any mesh.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from fingerdesign_bench.any_finger.designs import drawn

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.forecast.forecast import impossible
from fingerdesign.checks.design import is_sound
from fingerdesign.checks.load import with_values
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.layout.layers import sweepable
from fingerdesign.pipeline import run

PLATES = ("level", "turned", "bent", "two_rows", "sheet", "none", "finite", "staggered")


@dataclass(frozen=True)
class Finger:
    """A design, a scene, and the fidelity that they are solved with."""

    design: Design
    scene: Scene
    fidelity: str

    def with_design(self, values: dict[str, Any]) -> Finger:
        """With dotted keys of the design set, checked like a file."""
        return replace(self, design=with_values(self.design, values))

    def with_scene(self, **tables: dict[str, Any]) -> Finger:
        """With keys of the scene's tables set, checked like a file."""
        data = self.scene.model_dump(mode="json", exclude_unset=True)
        for name, values in tables.items():
            data[name] = data.get(name, {}) | values
        return replace(self, scene=Scene.model_validate(data))

    @property
    def seed(self) -> int:
        """The seed that it was drawn from, before any change."""
        return int(self.design.design.name.rpartition("_")[2])

    @property
    def case(self) -> Case:
        """Its path alone: without grips, fields and studies."""
        return Case(
            self.design,
            self.scene,
            self.fidelity,
            grips=False,
            fields=False,
            studied=False,
            for_page=False,
        )


class Answer(NamedTuple):
    """Of n increments: forces (n, 2) N, stick ratios (n,), strains (n, plates, 2), microstrain."""

    forces: np.ndarray
    stick: np.ndarray
    strains: np.ndarray


def any_finger(seed: int, fidelity: str) -> Finger:
    """The finger of a seed; 16 in a row have both bodies with each kind of plates."""
    chance = np.random.default_rng([20261123, seed, len(fidelity)])
    kinds = [("arc", "block")[seed % 2], PLATES[seed // 2 % len(PLATES)]]
    kinds[1:1] = [kind for kind in ("edged", "cored") if chance.random() < 0.25]
    while True:
        data = drawn(f"law_{seed:03d}", chance, tuple(kinds))
        rubber = {"youngs_modulus_MPa": 10.0 ** chance.uniform(-0.5, 1.0)}
        data["materials"] = {"silicone": rubber | {"poissons_ratio": chance.uniform(0.4, 0.495)}}
        width, plates = data["body"]["width_mm"], data["plates"]
        if fidelity == "3d":  # thin plates, and many, take layers and sections of many elements
            plates["count"] = min(plates["count"], 3)
            if plates.get("model") != "sheet":
                plates["thickness_mm"] = max(plates.get("thickness_mm", 0.0), 0.3)
        data["mesh"] = _coarse(width, plates.get("thickness_mm", 0.1))
        design = Design.model_validate(data)
        finger = Finger(design, _scene(chance, width), fidelity)
        sound = is_sound(design) and sweepable(design)
        if sound and not impossible(finger.case, finger.scene):
            return finger


def _coarse(width: float, thickness: float) -> dict[str, Any]:
    """A [mesh] of a body so wide, mm."""
    end = max(thickness, 0.1)
    section = {
        "contact_size_mm": width / 60.0,
        "plate_size_mm": 0.8,
        "plate_end_size_mm": end,
        "far_size_mm": width / 6.0,
    }
    return {
        "mesher": "sweep",
        "layers": 2,
        "contact_size_mm": width / 20.0,
        "plate_size_mm": 1.5,
        "far_size_mm": width / 4.0,
        "section": section,
    }


def _scene(chance: np.random.Generator, width: float) -> Scene:
    """Pressed in two rows, sheared, sheared back and a little eased."""
    rigid: dict[str, Any] = {"friction_coefficient": float(chance.uniform(0.1, 1.0))}
    kind = chance.integers(3)
    if kind == 1:
        rigid["tilt_deg"] = float(chance.uniform(-5.0, 5.0))
    if kind == 2:
        rigid |= {"shape": "cylinder", "radius_mm": float(chance.uniform(0.3, 3.0) * width)}
    deep, along = width * chance.uniform(0.008, 0.02), width * chance.uniform(0.001, 0.01)
    path = [[0.5, 0.0], [1.0, 0.3], [1.0, 1.0], [0.8, -0.4]]
    rows = [[deep * each, along * other] for each, other in path]
    return Scene.model_validate({"object": rigid, "path": {"increments_mm": rows}})


def solved(finger: Finger) -> Answer:
    """The answer of the whole pipeline."""
    return answer_of(run(finger.case).result.increments)


def answer_of(increments: Any) -> Answer:
    """The numbers of increments."""
    return Answer(
        np.array([[each.normal_force_N, each.tangential_force_N] for each in increments]),
        np.array([np.nan if i.stick_ratio is None else i.stick_ratio for i in increments]),
        np.array([[[gage.upper, gage.lower] for gage in each.gages] for each in increments]),
    )


def difference(one: Answer, other: Answer, stick: float = 1.0, strain: float = 1.0) -> float:
    """The largest of forces, of stick ratios and of strains: over the path's greatest force, times
    ``stick``, and over the path's greatest strain times ``strain``."""
    force = np.abs(one.forces - other.forces).max() / np.abs(one.forces).max()
    border = stick * np.nan_to_num(np.abs(one.stick - other.stick)).max()
    if not one.strains.size:
        return float(max(force, border))
    bent = np.abs(one.strains - other.strains).max() / np.abs(one.strains).max()
    return float(max(force, border, strain * bent))
