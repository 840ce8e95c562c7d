"""A quality report as readable lines, one measure each; lengths in mm, angles in degrees."""

from collections.abc import Iterator, Mapping

from fingerdesign.mesh.quality import QualityReport

MODELLED = {
    "section": "the section z = 0",
    "half z >= 0": "the half z >= 0 of the finger, which mirrors in z = 0",
    "whole": "the whole finger",
}
ZONES = {"contact": "at the contact", "rest": "elsewhere"}
WORST_SHOWN = 5
Rows = Mapping[str, Mapping[str, float]]


def quality_text(report: QualityReport) -> str:
    """The report as text."""
    return "\n".join(_lines(report))


def _lines(report: QualityReport) -> Iterator[str]:
    in_space = report.dimension == 3
    volume = "volume" if in_space else "area"
    yield from (f"{label:24} {words}" for label, words in _measures(report, volume))
    for name, part in report.regions.items():
        yield (
            f"{name + ':':24} {part['elements']:.0f} elements, edges {part['edge_min_mm']:.3f} to "
            f"{part['edge_max_mm']:.3f} mm, least angle {part['min_dihedral_deg']:.1f} deg"
        )
    yield from _sizes(report)
    yield from (f"  {reason}" for reason in report.size_reasons)
    half = " of the half z >= 0" if report.modelled.startswith("half") else ""
    yield f"{volume}s by curved cells{half}, {'mm^3' if in_space else 'mm^2'}:"
    for name, row in fewer_plates(report.volumes, "error").items():
        sizes = f"{row['volume']:.6g} of {row['target']:.6g} (error {row['error']:.1e})"
        yield f"  {name + ':':22} {sizes}"
    yield "greatest distance of the nodes to their CAD face, mm:"
    distances = {name: {"mm": value} for name, value in report.surface_distance_mm.items()}
    for name, row in fewer_plates(distances, "mm").items():
        yield f"  {name + ':':22} {row['mm']:.1e}"
    yield from report.remarks
    yield from _worst(report)


def _measures(report: QualityReport, volume: str) -> Iterator[tuple[str, str]]:
    """Labels and words of the mesh as a whole."""
    attempts = ""
    if report.attempts is not None:
        attempts = f", {report.attempts} attempt{'s' * (report.attempts != 1)}"
    yield "mesher", f"{report.mesher} ({report.dimension}-D, quadratic{attempts})"
    if report.failed_attempts:
        yield "attempts that failed", report.failed_attempts
    yield "modelled", MODELLED[report.modelled]
    yield "elements, nodes, dofs", f"{report.elements}, {report.nodes}, {report.dofs}"
    angles = _percentiles(report.dihedral_percentiles_deg)
    angle = "least dihedral angle" if report.dimension == 3 else "least angle"
    yield angle, f"{report.min_dihedral_deg:.2f} deg (percentiles {angles})"
    aspects = _percentiles(report.aspect_percentiles)
    yield "greatest aspect", f"{report.max_aspect:.1f} (1 = regular; percentiles {aspects})"
    yield "inverted elements", f"{report.inverted_elements}"
    yield "least Jacobian ratio", f"{report.least_jacobian_ratio:.3f} (curved over straight cell)"
    yield (
        f"body {volume} error",
        f"{report.body_volume_error:.1e} by curved cells, "
        f"{report.body_volume_error_straight:.1e} by straight ones",
    )
    plate = f"{report.worst_plate_volume_error:.1e} by curved cells"
    yield f"worst plate {volume} error", plate
    if report.dimension == 3:
        yield "worst face area error", f"{report.worst_face_area_error:.1e}"
    yield "contact residual", f"{report.contact_residual_mm:.1e} mm"
    edge = report.contact_edge_mm
    yield "edges at the contact", f"mean {edge['mean']:.3f}, greatest {edge['max']:.3f} mm"


def _percentiles(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} % {value:.1f}" for name, value in values.items())


def _sizes(report: QualityReport) -> Iterator[str]:
    """Edges over the target sizes, by zone."""
    if report.size_ratio:
        yield "edges over the target size (5 %, mean, 95 % of the elements):"
    for name, zone in report.size_ratio.items():
        ratios = f"{zone['p5']:.2f}, {zone['mean']:.2f}, {zone['p95']:.2f}"
        label = f"{ZONES.get(name, f'in {name}')}:"
        yield f"  {label:22} {ratios}; target {zone['target_mm']:.3f} mm on the mean"


def _worst(report: QualityReport) -> Iterator[str]:
    """The elements of least angle."""
    if report.worst:
        yield "elements of least angle:"
    for row in report.worst[:WORST_SHOWN]:
        place = ", ".join(f"{x:.3f}" for x in row["place_mm"])
        yield f"  {row['min_dihedral_deg']:5.1f} deg at ({place}) mm in {row['region']}"


def fewer_plates(rows: Rows, key: str) -> dict[str, Mapping[str, float]]:
    """All rows but the plates', and of these the worst."""
    plates = {name: row for name, row in rows.items() if name.startswith("plate_")}
    found = {name: row for name, row in rows.items() if name not in plates}
    if plates:
        worst = max(plates, key=lambda name: plates[name][key])
        label = worst if len(plates) == 1 else f"{worst} (worst of {len(plates)})"
        found[label] = plates[worst]
    return found
