"""A quality report as readable lines."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fingerdesign.mesh.quality import QualityReport


MODELLED = {
    "section": "the section z = 0",
    "half z >= 0": "the half z >= 0 of the finger, which mirrors in z = 0",
    "whole": "the whole finger",
}


def quality_text(report: QualityReport) -> str:
    """The report in plain words, one measure a line; lengths in mm, angles in degrees."""
    percentiles = ", ".join(f"{k} % {v:.1f}" for k, v in report.dihedral_percentiles_deg.items())
    aspect = ", ".join(f"{k} % {v:.1f}" for k, v in report.aspect_percentiles.items())
    edge = report.contact_edge_mm
    in_space = report.dimension == 3
    angle, volume = ("dihedral angle", "volume") if in_space else ("angle", "area")
    lines = [
        f"mesher                   {report.mesher} ({report.dimension}-D, quadratic"
        f"{_tries(report)})",
        *([f"attempts that failed     {report.failed_attempts}"] if report.failed_attempts else []),
        f"modelled                 {MODELLED[report.modelled]}",
        f"elements, nodes, dofs    {report.elements}, {report.nodes}, {report.dofs}",
        f"{'least ' + angle:<24} {report.min_dihedral_deg:.2f} deg (percentiles {percentiles})",
        f"greatest aspect          {report.max_aspect:.1f} (1 = regular; percentiles {aspect})",
        f"inverted elements        {report.inverted_elements}",
        f"least Jacobian ratio     {report.least_jacobian_ratio:.3f} (curved over straight cell)",
        f"{'body ' + volume + ' error':<24} {report.body_volume_error:.1e} by curved cells, "
        f"{report.body_volume_error_straight:.1e} by straight ones",
        f"{'worst plate ' + volume + ' error':<24} {report.worst_plate_volume_error:.1e} by curved "
        "cells",
        *([f"worst face area error    {report.worst_face_area_error:.1e}"] if in_space else []),
        f"contact residual         {report.contact_residual_mm:.1e} mm",
        f"edges at the contact     mean {edge['mean']:.3f}, greatest {edge['max']:.3f} mm",
    ]
    for name, values in report.regions.items():
        lines.append(
            f"{name + ':':<24} {values['elements']:.0f} elements, edges "
            f"{values['edge_min_mm']:.3f} to {values['edge_max_mm']:.3f} mm, least angle "
            f"{values['min_dihedral_deg']:.1f} deg"
        )
    if report.size_ratio:
        lines.append("edges over the size asked for (5 %, mean, 95 % of the elements):")
    for name, values in report.size_ratio.items():
        where = {"contact": "at the contact", "rest": "elsewhere"}.get(name, f"in {name}")
        lines.append(
            f"  {where + ':':<22} {values['p5']:.2f}, {values['mean']:.2f}, {values['p95']:.2f}; "
            f"asked {values['asked_mm']:.3f} mm on the mean"
        )
    lines += [f"  {reason}" for reason in report.size_reasons]
    unit = "mm^3" if in_space else "mm^2"
    of_half = " of the half z >= 0" if report.modelled.startswith("half") else ""
    lines.append(f"{volume}s by curved cells{of_half}, {unit}:")
    for name, values in _few(report.volumes, "error").items():
        lines.append(
            f"  {name + ':':<22} {values['volume']:.6g} of {values['wanted']:.6g} "
            f"(error {values['error']:.1e})"
        )
    lines.append("greatest distance of the nodes to their CAD face, mm:")
    distances = {name: {"mm": value} for name, value in report.surface_distance_mm.items()}
    for name, values in _few(distances, "mm").items():
        lines.append(f"  {name + ':':<22} {values['mm']:.1e}")
    lines += report.remarks
    if report.worst:
        lines.append("elements of least angle:")
    for row in report.worst[:5]:
        place = ", ".join(f"{value:.3f}" for value in row["place_mm"])
        lines.append(f"  {row['min_dihedral_deg']:>5.1f} deg at ({place}) mm in {row['region']}")
    return "\n".join(lines)


def _tries(report: QualityReport) -> str:
    number = report.attempts
    return "" if number is None else f", {number} attempt{'s' * (number != 1)}"


def _few(rows: dict[str, dict[str, float]], key: str) -> dict[str, dict[str, float]]:
    """All rows but the plates', and of these the worst: quality.json has them all."""
    plates = {name: row for name, row in rows.items() if name.startswith("plate_")}
    found = {name: row for name, row in rows.items() if name not in plates}
    if plates:
        worst = max(plates, key=lambda name: plates[name][key])
        label = worst if len(plates) == 1 else f"{worst} (worst of {len(plates)})"
        found[label] = plates[worst]
    return found
