"""The report's tables, as text: captions, column names with units, rows of formatted cells."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.analysis.verdicts import QUANTITIES
from fingerdesign.records.result import ErrorEstimate, GripResult, IncrementResult, Result
from fingerdesign.records.verdict import Status
from fingerdesign.report.table import (
    NOISE,
    Table,
    column_texts,
    loaded_increments,
    number_text,
    value_text,
    without_noise,
)

# The words of the figures of this folder.
FIGURES = Path(__file__).parent / "templates" / "figures.toml"
# Of the normal force, and of it times the contact's width: less is noise of the mesh.
_ASIDE = 0.01
SCENE = "scene."  # how the keys of the scene begin among ``Result.parameters``
ERRORS = "Estimated errors of the increments, the largest of all rows"
_WITHOUT_RULE = {None: "not tried", True: "slips", False: "holds"}


def _table(key: str, caption: str, columns: dict[str, Iterable[str]], texts: str = "") -> Table:
    """A table of columns; ``texts``: the places of those that are no numbers."""
    rows = tuple(zip(*columns.values(), strict=True))
    return Table(key, caption, tuple(columns), rows, frozenset(int(each) for each in texts.split()))


def increment_table(result: Result) -> Table:
    """A row an increment."""
    found = result.increments

    def column(name: str, decimals: int = 3, scale: float = 0.0) -> list[str]:
        return column_texts([getattr(row, name) for row in found], decimals, scale)

    # Forces share a scale: without friction F_t is noise compared with F_n.
    force = max(_greatest(found, f"{way}_force_N") for way in ("normal", "tangential"))
    nodes = [f"{row.open_nodes} / {row.stick_nodes} / {row.slip_nodes}" for row in found]
    columns: dict[str, Iterable[str]] = {
        "increment": [str(number) for number in range(1, len(found) + 1)],
        "approach (mm)": column("approach_mm"),
        "shear (mm)": column("shear_mm"),
        "normal force (N)": column("normal_force_N", scale=force),
        "tangential force (N)": column("tangential_force_N", scale=force),
        "contact width (mm)": column("contact_width_mm", 2),
        "stick ratio": column("stick_ratio"),
        "open / stick / slip nodes": nodes,
        "peak pressure (MPa)": column("peak_pressure_MPa"),
        "iterations": [str(row.iterations) for row in found],
        "residual": [f"{row.residual:.0e}" for row in found],
    }
    if leaves_section(found):
        normal = max(row.normal_force_N for row in found)
        columns |= {
            "shear z (mm)": column("shear_z_mm"),
            "twist (degrees)": column("twist_deg"),
            "force z (N)": column("force_z_N", scale=normal),
            "twist moment (N mm)": column("twist_moment_Nmm", scale=normal),
        }
    return _table("increments", "Increments", columns)


def error_table(result: Result) -> Table:
    """Estimated errors by source, next to the values that they belong to; no rows of a failure."""
    reasons = {"mesh": result.mesh_error_absent, "path": ""}
    errors = {"mesh": result.mesh_error, "path": result.path_error}
    rows = tuple((name, *_error_cells(each, reasons[name])) for name, each in errors.items())
    columns = ("from the", "normal force", "tangential force", "stick ratio", "gages")
    return Table("errors", ERRORS, columns, rows if result.increments else (), frozenset({0}))


def _error_cells(error: ErrorEstimate | None, reason: str) -> tuple[str, ...]:
    if error is None:
        return (f"not estimated{': ' * bool(reason)}{reason}", "–", "–", "–")
    shares = (error.normal_force, error.tangential_force, error.gages)
    normal, tangential, gages = (f"{100.0 * each:.2g} %" for each in shares)
    return (normal, tangential, f"{error.stick_ratio:.2g}", gages)


def leaves_section(found: Sequence[IncrementResult]) -> bool:
    """True if anything is moved, or pushed, out of the plane of the section."""
    if any(row.shear_z_mm or row.twist_deg for row in found):
        return True
    names = ("normal_force_N", "contact_width_mm", "force_z_N", "twist_moment_Nmm")
    most, width, force, moment = (_greatest(found, name) for name in names)
    return force > _ASIDE * max(most, NOISE) or moment > _ASIDE * max(most * width, NOISE)


def _greatest(found: Sequence[IncrementResult], name: str) -> float:
    return max((abs(getattr(row, name)) for row in found), default=0.0)


def _grip_columns(grips: Sequence[GripResult]) -> dict[str, Iterable[str]]:
    """The columns that every table of grips begins with."""
    return {
        "controller": [grip.controller for grip in grips],
        "μ": [value_text(grip.friction_coefficient) for grip in grips],
        "mass (g)": [value_text(grip.object_mass_g) for grip in grips],
    }


def _numbers(grips: Sequence[GripResult], name: str, decimals: int) -> list[str]:
    return [number_text(getattr(grip, name), decimals) for grip in grips]


def grip_table(result: Result) -> Table:
    """A row a grip, with its safety margin."""
    grips = result.grips
    forces = [(grip.final_normal_force_N, grip.final_tangential_force_N) for grip in grips]
    columns = _grip_columns(grips) | {
        "lifted": [_status(grip.lifted) for grip in grips],
        "no complete slip": [_status(not grip.gross_slip) + _caught(grip) for grip in grips],
        "motion held (times)": [str(grip.holds) for grip in grips],
        "without the rule": [_WITHOUT_RULE[grip.slips_without_rule] for grip in grips],
        "safety margin": _numbers(grips, "safety_margin", 2),
        "least stick ratio": _numbers(grips, "minimum_stick_ratio", 2),
        "final F_n / F_t (N)": [" / ".join(number_text(x, 2) for x in pair) for pair in forces],
        "steps after the preload": [str(grip.steps) for grip in grips],
        "how it ended": [grip.ending for grip in grips],
    }
    return _table("grips", "Grips", columns, "0 3 4 6 11")


def foreseen_table(result: Result) -> Table | None:
    """A row a grip: its warnings of slip. None where no grip warns or reports a stick ratio."""
    grips = result.grips
    if {(grip.alarms, grip.stick_error) for grip in grips} <= {(None, None)}:
        return None
    slips = {"standing": "warned of", "withdrawn": "missed: withdrawn", "none": "missed"}
    shares = 100.0 * without_noise(grip.lead_force_share for grip in grips)
    columns = _grip_columns(grips) | {
        "complete slip": [slips.get(grip.slip_warning or "", "–") for grip in grips],
        "lead (s)": _numbers(grips, "lead_s", 3),
        "F_t at the warning (%)": [number_text(each, 0) for each in shares],
        "warnings": _numbers(grips, "alarms", 0),
        "false alarms": _numbers(grips, "false_alarms", 0),
        "steps": _numbers(grips, "samples", 0),
        "error of stick ratio, RMS": _numbers(grips, "stick_error", 3),
        "its samples": _numbers(grips, "stick_error_samples", 0),
    }
    return _table("foreseen", "Was slip seen before it came?", columns, "0 3")


def _caught(grip: GripResult) -> str:
    """Distance and time of an object that slid and was caught; else nothing."""
    if not grip.caught:
        return ""
    ms = "" if grip.catch_s is None else f" within {1e3 * grip.catch_s:.0f} ms"
    return f", caught after {number_text(grip.slid_mm, 2)} mm{ms}"


def _status(good: bool) -> Status:
    return "pass" if good else "fail"


def model_table(result: Result) -> Table:
    """The model, and the quality of its mesh."""
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
        mesh, worst = result.mesh, result.mesh.worst_plate_volume_error
        angle = "dihedral angle" if result.fidelity != "plane-strain" else "angle"
        volume = "volume, relative error"
        rows += [
            ("mesher", mesh.mesher),
            ("elements", f"{mesh.elements:,}"),
            (f"least {angle}", f"{mesh.min_dihedral_deg:.1f}°"),
            (f"body {volume}", f"{mesh.body_volume_error:.1e}"),
            (f"worst plate {volume}", "no plates" if worst is None else f"{worst:.1e}"),
        ]
    return Table("model", "Model and mesh", ("what", "value"), tuple(rows), frozenset({0, 1}))


def work_table(result: Result, page: str, whole: str) -> Table:
    """Seconds by stage, memory. page: what making the page took; whole: everything."""
    timings = result.timings_s.items()
    rows = [(stage, f"{each:.2f} s" if each else "not run") for stage, each in timings]
    rows += [("this page", page), ("all stages and this page", whole)]
    rows.append(("peak memory", f"{result.peak_memory_MB:,.0f} MB"))
    return Table("timings", "Time and memory", ("stage", "took"), tuple(rows), frozenset({0}))


def design_table(result: Result) -> Table:
    """Every key of the design that does something; those that the source did not give marked."""
    keys = result.parameters
    idle = {
        "body.arc_radius_mm": keys.get("body.shape") in ("block", "step"),
        "body.edge": keys.get("body.edge_radius_mm") is None,
        "plates.hole_pitch_mm": keys.get("plates.hole_diameter_mm") is None,
    }
    rows = tuple(
        (key, value_text(value), "assumed" if key in result.assumed else "")
        for key, value in keys.items()
        if value is not None and not idle.get(key) and not key.startswith(SCENE)
    )
    columns = ("key", "value", "remark")
    return Table("design", "The design, key by key", columns, rows, frozenset({0, 1, 2}))


def scene_table(result: Result) -> Table:
    """Every key of the scene; without rows where the result does not hold them."""
    rows = tuple(
        (key.removeprefix(SCENE), value_text(value))
        for key, value in result.parameters.items()
        if key.startswith(SCENE) and value is not None
    )
    return Table("scene", "The scene, key by key", ("key", "value"), rows, frozenset({0, 1}))


def points_table(result: Result) -> Table:
    """Strain at the scene's readout points, at the last increment under load (else the last)."""
    parts = ("xx", "yy", "zz", "xy", "xz", "yz")
    loaded = loaded_increments(result.increments)
    last = loaded[-1] if loaded else len(result.increments) - 1
    points = result.increments[last].points if result.increments else ()
    places: list[Any] = result.parameters.get(f"{SCENE}readout.points_mm") or []
    if len(places) != len(points):
        places = [(None, None, None)] * len(points)
    strains = without_noise(
        np.array([[getattr(point, part) for part in parts] for point in points])
    )
    texts = column_texts(strains.ravel().tolist(), 1)  # one format for all six
    columns: dict[str, Iterable[str]] = {"point": [str(k + 1) for k in range(len(points))]}
    columns |= {f"{x} (mm)": column_texts(p[k] for p in places) for k, x in enumerate("xyz")}
    columns |= {part: texts[k :: len(parts)] for k, part in enumerate(parts)}
    load = "the last under load" if loaded else "without load"
    caption = f"Strain at points, microstrain, at increment {last + 1} ({load}); xy, xz and yz are "
    return _table("points", f"{caption}engineering shear", columns)


def ladder_table(result: Result) -> Table | None:
    """A row a model that --fidelity auto tried; None where it did not choose."""
    if result.ladder is None:
        return None
    ladder, models = result.ladder, result.ladder.models
    columns: dict[str, Iterable[str]] = {
        "model": [each.name for each in models],
        "equations": [f"{each.dofs:,}" for each in models],
        "seconds": [number_text(each.seconds, 2) for each in models],
    }
    for key, name in QUANTITIES.items():
        errors = [(each.error_estimates or {}).get(key) for each in models]
        columns[f"{name}, %"] = ["-" if e is None else f"{100.0 * e:.2g}" for e in errors]
    columns["why"] = [each.why for each in models]
    caption = (
        f"Models tried for a tolerance of {100 * ladder.tolerance:g} %, with their estimated "
        f"errors; chosen: {ladder.chosen}"
    )
    return _table("ladder", caption, columns, "0 7")


def assumed_values(result: Result) -> list[tuple[str, str]]:
    """The assumed keys with their values; a table of the design is given by its keys."""

    def text(key: str) -> str:
        if key in (known := result.parameters):
            return value_text(known[key])
        inside = {k: v for k, v in known.items() if k.startswith(f"{key}.")}
        texts = (f"{k[len(key) + 1 :]} = {value_text(v)}" for k, v in inside.items())
        return ", ".join(texts) or "see the design"

    return [(key, text(key)) for key in result.assumed]


def detail_tables(result: Result) -> tuple[Table, ...]:
    """The tables of ``--details``, most important first; some may have no rows."""
    makers = (study_table, signal_table, grip_table, increment_table, error_table, model_table)
    return tuple(make(result) for make in makers)


def study_table(result: Result) -> Table:
    """A row a friction coefficient: how well the gage area follows the stick area."""
    studies = result.slip_studies
    ranks = {
        "rank correlation": [each.rank_correlation for each in studies],
        "raw": [each.rank_correlation_raw for each in studies],
        "of the step index": [each.step_correlation for each in studies],
    }
    columns: dict[str, Iterable[str]] = {
        "μ": [value_text(each.friction_coefficient) for each in studies],
        **{name: [number_text(each, 2) for each in values] for name, values in ranks.items()},
        "gage area (mm)": [_ends(each.gage_area_mm, ".1f") for each in studies],
        "stick length (mm)": [_ends(each.stick_length_mm, ".1f") for each in studies],
        "threshold (microstrain/N)": [f"{x.threshold_microstrain_per_N:.3g}" for x in studies],
    }
    return _table("studies", "Gage area and stick area", columns)


def signal_table(result: Result) -> Table:
    """A row a mass and friction coefficient: what one sample of the gages shows of slip."""
    found = result.measurability
    states = found.states if found is not None else ()
    noise = "" if found is None else f", noise {found.noise_microstrain:g} microstrain"
    columns: dict[str, Iterable[str]] = {
        "μ": [value_text(each.friction_coefficient) for each in states],
        "mass (g)": [f"{each.object_mass_g:.3g}" for each in states],
        "normal force (N)": [f"{each.normal_force_N:.3g}" for each in states],
        "response (microstrain/N)": [f"{x.response_microstrain_per_N:.2g}" for x in states],
        "smallest change of stick": [f"{each.smallest_stick_change:.2g}" for each in states],
        "smallest change of F_t (N)": [f"{x.smallest_force_change_N:.2g}" for x in states],
    }
    return _table("signal", f"Gage signal, three standard deviations of one sample{noise}", columns)


def _ends(values: Sequence[float], form: str) -> str:
    return f"{values[0]:{form}} to {values[1]:{form}}"
