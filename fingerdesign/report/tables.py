"""The report's tables, as text: captions, column names with units, rows of formatted cells."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from fingerdesign.results import Result


@dataclass(frozen=True)
class Table:
    """One table. Cells are text, ready to show; ``texts`` are the columns that are no numbers."""

    key: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    texts: frozenset[int] = frozenset()


def increment_table(result: Result) -> Table:
    """A row an increment."""
    columns = (
        *("increment", "approach (mm)", "shear (mm)", "normal force (N)", "tangential force (N)"),
        *("contact width (mm)", "stick ratio", "open / stick / slip nodes"),
        *("peak pressure (MPa)", "iterations", "residual"),
    )
    rows = tuple(
        (
            str(number),
            number_text(row.approach_mm),
            number_text(row.shear_mm),
            number_text(row.normal_force_N),
            number_text(row.tangential_force_N),
            number_text(row.contact_width_mm, 2),
            number_text(row.stick_ratio),
            f"{row.open_nodes} / {row.stick_nodes} / {row.slip_nodes}",
            number_text(row.peak_pressure_MPa),
            str(row.iterations),
            f"{row.residual:.0e}",
        )
        for number, row in enumerate(result.increments, start=1)
    )
    return Table("increments", "Increments", columns, rows)


def grip_table(result: Result) -> Table:
    """A row a grip, with its safety margin."""
    columns = (
        *("controller", "friction coefficient", "mass (g)", "lifted", "complete slip", "holds"),
        *("slips without the rule", "safety margin", "least stick ratio"),
        *("final normal / tangential force (N)", "steps", "how it ended"),
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
            ("dimension", f"{model.dimension}-D ({result.fidelity})"),
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
    rows.append(("all stages", f"{sum(result.timings_s.values()):.2f} s"))
    rows.append(("peak memory", f"{result.peak_memory_MB:,.0f} MB"))
    return Table("timings", "Time and memory", ("stage", "took"), tuple(rows), frozenset({0}))


def design_table(result: Result) -> Table:
    """Every key of the design; those that the source did not give are marked."""
    assumed = set(result.assumed)
    rows = tuple(
        (key, value_text(value), "assumed" if key in assumed else "given or default")
        for key, value in result.parameters.items()
        if value is not None
    )
    texts = frozenset({0, 1, 2})
    return Table("design", "The design, key by key", ("key", "value", "where from"), rows, texts)


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


def number_text(value: float | None, decimals: int = 3) -> str:
    """Fixed decimals, so that a column lines up; a dash where there is no value.

    >>> number_text(0.123456), number_text(-1e-9), number_text(None)
    ('0.123', '-1e-09', '–')
    """
    if value is None or not math.isfinite(value):
        return "–"
    fixed = f"{value:.{decimals}f}"
    return f"{value:.0e}" if value != 0 and float(fixed) == 0 else fixed


def value_text(value: Any) -> str:
    """A design's value as TOML would have it, near enough to read."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:g}"
    if value is None:
        return "not set"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(value_text(item) for item in value) + "]"
    return str(value)


def _yes(value: bool | None) -> str:
    return "not tried" if value is None else "yes" if value else "no"


def _small(value: float | None) -> str:
    return "no plates" if value is None else f"{value:.1e}"
