"""Outcomes that no analysis made, the same for the same seed: what the comparison is tried with.

The designs are real: variants of the shipped maeno2000. Their forces, contacts and gages are closed
forms (Hertz, Cattaneo and Mindlin) with some noise, in the size that a study's outcomes have. They
are for tests and benchmarks of the report, never a result.
"""

import copy
import hashlib
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.design.shipped import file_text
from fingerdesign.records.outcome import Failure, GripOutcome, Outcome, Traces, Validity

INCREMENTS, POINTS, DEEP = 24, 121, 9  # of the path; contact points along x, and along z in 3-D
GRIP_POINTS = 60
FRICTIONS = (0.2, 0.5, 0.8)
FAILURES = (
    Failure("invalid", "plates.cover_mm = 0.31: must be at least 0.4; raise the cover"),
    Failure("refused", "the candidate zone would be wider than the body"),
    Failure("failed", "No mesh passed the acceptance gate after 3 attempts."),
    Failure("crashed", "its process died (signal 11) twice"),
    Failure("timeout", "not done after 300 s"),
    Failure("memory", "needed more than 4000 MB"),
)
HOSTILE = (
    "</script><script>fetch('http://127.0.0.1:9/')</script>",
    '<img src=x onerror="noSuchFunction()">',
    "../../etc/passwd",
    "a\u2028b\u0007\x00c",
    "<!--<script>",
    "=1+1",
    '" onmouseover="noSuchFunction()" x="',
    "\u202egnp.exe",
)


def any_outcomes(count, seed=0, failed=0.08, deep=False, hostile=False):
    """``count`` outcomes; a share ``failed`` of them with a failure of each kind in turn.

    deep: 3-D instead of plane strain. hostile: the first names (and values) are an attacker's.
    """
    chance = np.random.default_rng([20261122, seed])
    base = tomllib.loads(file_text(Path("maeno2000")))
    made = [_outcome(number, chance, base, failed, deep) for number in range(count)]
    if hostile:
        for number, name in enumerate(HOSTILE[:count]):
            made[number] = _renamed(made[number], name)
    return tuple(made)


def _renamed(outcome, name):
    values = {**outcome.values, "plates.material": name}
    failure = outcome.failure and Failure(outcome.failure.kind, f"{name} went wrong")
    return replace(outcome, name=name, values=values, failure=failure, warnings=(name,))


def _outcome(number, chance, base, failed, deep):
    values = {
        "body.arc_radius_mm": round(float(chance.uniform(20, 80)), 2),
        "plates.count": int(chance.integers(4, 9)) * 2 - 1,
        "plates.angle_deg": round(float(chance.uniform(0, 90)), 1),
        "plates.cover_mm": round(float(chance.uniform(0.6, 2.0)), 3),
        "plates.material": str(chance.choice(["phosphor_bronze", "polyimide"])),
    }
    design = copy.deepcopy(base)
    name = f"any_{number:04d}"
    design["design"]["name"] = name
    for key, value in values.items():
        table, _, last = key.partition(".")
        design[table][last] = value
    common: dict[str, Any] = {
        "digest": hashlib.sha256(f"{name} {values}".encode()).hexdigest(),
        "name": name,
        "values": values,
        "design": design,
        "scene": "fundamental",
        "fidelity": "3d" if deep else "plane-strain",
        "versions": {"fingerdesign": "0.1.0", "numpy": np.__version__},
        "seeds": {"plant": 0},
    }
    luck = float(chance.uniform())
    if luck < failed:
        failure = FAILURES[number % len(FAILURES)]
        return Outcome(**common, status="failed", failure=failure, seconds=3.0)
    traces, normal, tangential = _traces(values, chance, deep)
    grips = tuple(_grip(friction, values, chance) for friction in FRICTIONS)
    core = round(float(chance.uniform(0.7, 2.0)), 3)
    return Outcome(
        **common,
        status="ok",
        metrics=_metrics(values, grips, normal, tangential, core, chance),
        traces=traces,
        grips=grips,
        validity=Validity(
            round(float(chance.uniform(0.02, 0.2)), 4),
            round(float(chance.uniform(0.002, 0.02)), 4),
            ("plane strain overstates F_n by about a tenth at equal motion",),
        ),
        warnings=("the contact comes near the edge",) if luck > 0.97 else (),
        seconds=round(core * 1.1, 3),
        core_seconds=core,
        peak_memory_MB=round(float(chance.uniform(200, 400)), 1),
    )


def _traces(values, chance, deep):
    """The fundamental case's path: pressed, then sheared at a constant approach."""
    radius, friction, modulus, depth = values["body.arc_radius_mm"], 0.5, 4.96 / 0.76, 10.0
    step = np.linspace(1 / INCREMENTS, 1, INCREMENTS)
    approach = 0.3 * np.minimum(1, 2 * step)
    shear = 0.4 * np.maximum(0, 2 * step - 1)
    normal = (18 + 0.1 * radius) * approach**1.1
    tangential = friction * normal * (1 - np.exp(-6 * shear))
    half = np.sqrt(4 * normal / depth * radius / (np.pi * modulus))
    stick = np.sqrt(1 - tangential / (friction * normal))
    x = np.linspace(-1.2 * half[-1], 1.2 * half[-1], 41 if deep else POINTS)
    z = np.linspace(-depth / 2, depth / 2, DEEP) if deep else np.zeros(1)
    flat, across = (grid.ravel() for grid in np.meshgrid(x, z, indexing="ij"))
    near = np.abs(flat) * (1 + 0.002 * across**2)
    status = tuple(
        "".join(np.where(near > a, ".", np.where(near <= a * held, "#", "/")))
        for a, held in zip(half, stick, strict=True)
    )
    place = (np.arange(values["plates.count"]) - (values["plates.count"] - 1) / 2) * 0.75
    kernel = np.exp(-((place[None, :] / (half[:, None] + values["plates.cover_mm"])) ** 2))
    angle = np.radians(values["plates.angle_deg"])
    gages = 40 * kernel * (tangential[:, None] * np.sin(2 * angle) - normal[:, None])
    gages += chance.normal(0, 0.5, gages.shape)
    traces = Traces(
        approach_mm=_numbers(approach),
        shear_mm=_numbers(shear),
        normal_force_N=_numbers(normal),
        tangential_force_N=_numbers(tangential),
        stick_ratio=_numbers(stick),
        contact_width_mm=_numbers(2 * half),
        gage_x_mm=_numbers(place),
        gages=tuple(_numbers(row) for row in gages),
        contact_x_mm=_numbers(flat),
        contact_z_mm=_numbers(across) if deep else (),
        status=status,
    )
    return traces, float(normal[-1]), float(tangential[-1])


def _grip(friction, values, chance):
    step = np.linspace(0, 1, GRIP_POINTS)
    weight = 0.5 * 9.80665 * 0.5
    margin = float(chance.uniform(0.9, 1.8)) * (1 + 0.001 * values["body.arc_radius_mm"])
    tangential = weight * step**1.5
    normal = 0.4 + margin * weight / friction * step
    lifted = margin > 1
    return GripOutcome(
        controller="regulator",
        friction_coefficient=friction,
        object_mass_g=500.0,
        lifted=lifted,
        gross_slip=not lifted,
        safety_margin=margin if lifted else None,
        peak_normal_force_N=float(normal[-1]),
        minimum_stick_ratio=round(float(np.sqrt(max(0.0, 1 - 1 / margin))), 4),
        normal_force_N=_numbers(normal),
        tangential_force_N=_numbers(tangential),
    )


def _metrics(values, grips, normal, tangential, core_seconds, chance):
    margins = [grip.safety_margin for grip in grips if grip.safety_margin is not None]
    weight = 0.5 * 9.80665 * 0.5
    # Better with more plates near the surface: so that the objectives pull against each other.
    error = 0.02 + 0.25 / values["plates.count"] + 0.03 * values["plates.cover_mm"]
    ratios = [grip.peak_normal_force_N * grip.friction_coefficient / weight for grip in grips]
    stiff = 1.0 if values["plates.material"] == "polyimide" else 2.0
    return {
        "grip_success": sum(grip.lifted for grip in grips) / len(grips),
        "safety_margin": float(np.median(margins)) if margins else None,
        "least_margin": min(margins) if margins else None,
        "peak_force_N": max(grip.peak_normal_force_N for grip in grips),
        "peak_ratio": max(ratios),
        "stick_error": error * float(chance.uniform(0.9, 1.3)),
        "gage_response": 40.0 / values["plates.cover_mm"] / stiff,
        "normal_force_N": normal,
        "tangential_force_N": tangential,
        "plates": float(values["plates.count"]),
        "cost": stiff * values["plates.count"] + 0.05 * values["body.arc_radius_mm"],
        "rubber_volume_ml": 1.5 + 0.01 * values["body.arc_radius_mm"],
        "core_seconds": core_seconds,
    }


def _numbers(values):
    return tuple(float(f"{value:.6g}") for value in values)
