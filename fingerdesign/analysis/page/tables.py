"""The report's tables, as text: captions, column names with units, rows of formatted cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fingerdesign.analysis.page.verdict import leaves_section, model_text, motion_text
from fingerdesign.records.result import IncrementResult, Result, TriedModel
from fingerdesign.report.numbers import cleaned, column_texts, number_text, under_load
from fingerdesign.report.table import Table, value_text
from fingerdesign.runtime.registry import SCENE_OBJECTS, Kind

SCENE = "scene."  # how the keys of the scene begin among ``Result.parameters``


def increment_table(result: Result) -> Table:
    """A row an increment."""
    columns = (
        *("increment", "approach (mm)", "shear (mm)", "normal force (N)", "tangential force (N)"),
        *("contact width (mm)", "stick ratio", "open / stick / slip nodes"),
        *("peak pressure (MPa)", "iterations", "residual"),
    )
    found = result.increments
    beside = _out_of_section(found)
    # Forces share a scale, and so do motions: without friction F_t is noise beside F_n.
    forces = [max(abs(row.normal_force_N), abs(row.tangential_force_N)) for row in found]
    most = max(forces, default=0.0)
    rows = tuple(
        zip(
            [str(number) for number in range(1, len(found) + 1)],
            column_texts(row.approach_mm for row in found),
            column_texts(row.shear_mm for row in found),
            column_texts((row.normal_force_N for row in found), scale=most),
            column_texts((row.tangential_force_N for row in found), scale=most),
            column_texts((row.contact_width_mm for row in found), 2),
            column_texts(row.stick_ratio for row in found),
            [f"{row.open_nodes} / {row.stick_nodes} / {row.slip_nodes}" for row in found],
            column_texts(row.peak_pressure_MPa for row in found),
            [str(row.iterations) for row in found],
            [f"{row.residual:.0e}" for row in found],
            *beside.values(),
            strict=True,
        )
    )
    return Table("increments", "Increments", (*columns, *beside), rows)


def _out_of_section(found: Sequence[IncrementResult]) -> dict[str, list[str]]:
    """Columns of what leaves the plane of the section, where anything does."""
    if not leaves_section(found):
        return {}
    most = max(row.normal_force_N for row in found)
    return {
        "shear z (mm)": column_texts(row.shear_z_mm for row in found),
        "twist (degrees)": column_texts(row.twist_deg for row in found),
        "force z (N)": column_texts((row.force_z_N for row in found), scale=most),
        "twist moment (N mm)": column_texts((row.twist_moment_Nmm for row in found), scale=most),
    }


def grip_table(result: Result) -> Table:
    """A row a grip, with its safety margin."""
    columns = (
        *("controller", "μ", "mass (g)", "lifted", "complete slip", "holds"),
        *("slips without the rule", "safety margin", "least stick ratio"),
        *("final F_n / F_t (N)", "steps", "how it ended"),
    )
    rows = tuple(
        (
            grip.controller,
            value_text(grip.friction_coefficient),
            value_text(grip.object_mass_g),
            _yes(grip.lifted),
            _yes(grip.gross_slip),
            str(grip.holds),
            _yes(grip.slips_without_rule),
            number_text(grip.safety_margin, 2),
            number_text(grip.minimum_stick_ratio, 2),
            f"{number_text(grip.final_normal_force_N, 2)} / "
            f"{number_text(grip.final_tangential_force_N, 2)}",
            str(grip.steps),
            grip.ending,
        )
        for grip in result.grips
    )
    return Table("grips", "Grips", columns, rows, frozenset({0, 3, 4, 6, 11}))


def model_table(result: Result) -> Table:
    """What was solved, and how good its mesh is."""
    rows = []
    if result.model is not None:
        model = result.model
        rows += [
            ("dimension", "3-D" if model.dimension == 3 else "2-D, plane strain"),
            ("element", model.element),
            ("degrees of freedom", f"{model.dofs:,}"),
            ("contact nodes", f"{model.contact_nodes:,}"),
            ("symmetry", "half model, mirrored in z = 0" if model.symmetry else "none used"),
        ]
    if result.mesh is not None:
        mesh = result.mesh
        angle = "dihedral angle" if result.fidelity == "3d" else "angle"
        rows += [
            ("mesher", mesh.mesher),
            ("elements", f"{mesh.elements:,}"),
            (f"least {angle}", f"{mesh.min_dihedral_deg:.1f}°"),
            ("body volume, relative error", f"{mesh.body_volume_error:.1e}"),
            ("worst plate volume, relative error", _small(mesh.worst_plate_volume_error)),
        ]
    return Table("model", "Model and mesh", ("what", "value"), tuple(rows), frozenset({0, 1}))


def work_table(result: Result) -> Table:
    """Seconds by stage, memory."""
    rows = [
        (stage, f"{seconds:.2f} s" if seconds else "not run")
        for stage, seconds in result.timings_s.items()
    ]
    total = sum(result.timings_s.values())
    rows.append(("all stages, without making this page", f"{total:.2f} s"))
    rows.append(("peak memory", f"{result.peak_memory_MB:,.0f} MB"))
    return Table("timings", "Time and memory", ("stage", "took"), tuple(rows), frozenset({0}))


def design_table(result: Result) -> Table:
    """Every key of the design that does something; those that the source did not give marked."""
    assumed = set(result.assumed)
    idle = _idle_keys(result.parameters)
    rows = tuple(
        (key, value_text(value), "assumed" if key in assumed else "")
        for key, value in result.parameters.items()
        if value is not None and key not in idle and not key.startswith(SCENE)
    )
    texts = frozenset({0, 1, 2})
    return Table("design", "The design, key by key", ("key", "value", "remark"), rows, texts)


def _idle_keys(keys: Mapping[str, Any]) -> set[str]:
    """Keys that have a default but do nothing beside the others."""
    idle = set()
    if keys.get("body.shape") in ("block", "step"):
        idle.add("body.arc_radius_mm")
    if keys.get("body.edge_radius_mm") is None:
        idle.add("body.edge")
    if keys.get("plates.hole_diameter_mm") is None:
        idle.add("plates.hole_pitch_mm")
    return idle


def scene_table(result: Result) -> Table:
    """Every key of the scene; without rows where the result does not hold them."""
    rows = tuple(
        (key.removeprefix(SCENE), value_text(value))
        for key, value in result.parameters.items()
        if key.startswith(SCENE) and value is not None
    )
    return Table("scene", "The scene, key by key", ("key", "value"), rows, frozenset({0, 1}))


def object_text(result: Result) -> str:
    """What touches the finger and how it is moved, in a few sentences; empty if not known."""
    keys = {
        key.removeprefix(f"{SCENE}object."): value
        for key, value in result.parameters.items()
        if key.startswith(f"{SCENE}object.")
    }
    friction = keys.get("friction_coefficient")
    if friction is None:
        return ""
    shape = str(keys.get("shape") or "plane")
    words = f"The object is a {shape}"
    if keys.get("radius_mm") is not None:
        words += f" of radius {value_text(keys['radius_mm'])} mm"
    kind: Kind | None = SCENE_OBJECTS.get(shape)
    if kind is not None and (more := kind.made.words(keys)):
        words += f" {more}"
    for name, about in (("tilt_deg", "z"), ("turn_deg", "y")):
        if keys.get(name):
            words += f", turned by {value_text(keys[name])} degrees about {about}"
    words += f"; friction coefficient μ = {value_text(friction)}."
    return " ".join(part for part in (words, motion_text(result), model_text(result)) if part)


def points_table(result: Result) -> Table:
    """Strain at the scene's readout points, at the last increment under load (else the last)."""
    parts = ("xx", "yy", "zz", "xy", "xz", "yz")
    columns = ("point", "x (mm)", "y (mm)", "z (mm)", *parts)
    loaded = under_load(result.increments)
    last = loaded[-1] if loaded else len(result.increments) - 1
    points = result.increments[last].points if result.increments else ()
    if not points:
        return Table("points", "Strain at points", columns, ())
    places = result.parameters.get(f"{SCENE}readout.points_mm") or []
    if len(places) != len(points):
        places = [(None, None, None)] * len(points)
    strains = cleaned(np.array([[getattr(point, part) for part in parts] for point in points]))
    texts = column_texts(strains.ravel().tolist(), 1)  # one format for all six
    where = [column_texts(column) for column in zip(*places, strict=True)]
    rows = zip(
        [str(number) for number in range(1, len(points) + 1)],
        *where,
        *(texts[column :: len(parts)] for column in range(len(parts))),
        strict=True,
    )
    load = "the last under load" if loaded else "without load"
    caption = f"Strain at points, microstrain, at increment {last + 1} ({load}); xy, xz and yz are "
    return Table("points", f"{caption}engineering shear", columns, tuple(rows))


def assumed_values(result: Result) -> list[tuple[str, str]]:
    """The assumed keys with their values; a table of the design is given by its keys."""
    pairs = []
    for key in result.assumed:
        if key in result.parameters:
            pairs.append((key, value_text(result.parameters[key])))
            continue
        inside = {k: v for k, v in result.parameters.items() if k.startswith(f"{key}.")}
        text = ", ".join(f"{k[len(key) + 1 :]} = {value_text(v)}" for k, v in inside.items())
        pairs.append((key, text or "see the design"))
    return pairs


def _yes(value: bool | None) -> str:
    return "not tried" if value is None else "yes" if value else "no"


def _small(value: float | None) -> str:
    return "no plates" if value is None else f"{value:.1e}"


# The fidelity ladder as a table of the report: what was tried, what it cost, why it ended.

QUANTITIES = {
    "normal_force": "F_n",
    "tangential_force": "F_t",
    "stick_ratio": "stick ratio",
    "gage": "gages",
}


def ladder_table(result: Result) -> Table | None:
    """A row a model that --fidelity auto tried; None where it did not choose."""
    if result.ladder is None:
        return None
    ladder = result.ladder
    columns = (
        *("model", "equations", "seconds"),
        *(f"{name}, %" for name in QUANTITIES.values()),
        "why",
    )
    rows = tuple(
        (each.name, f"{each.dofs:,}", number_text(each.seconds, 2), *_errors(each), each.why)
        for each in ladder.models
    )
    caption = (
        f"Models tried for a tolerance of {100 * ladder.tolerance:g} %, with their estimated "
        f"errors; chosen: {ladder.chosen}"
    )
    return Table("ladder", caption, columns, rows, frozenset({0, 7}))


def _errors(tried: TriedModel) -> list[str]:
    found = tried.error_estimates
    if found is None:
        return ["-"] * len(QUANTITIES)
    return [f"{100.0 * found[name]:.2g}" if name in found else "-" for name in QUANTITIES]
