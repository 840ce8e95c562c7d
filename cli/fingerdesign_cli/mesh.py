"""``fingerdesign mesh``: the mesh that an analysis would use, its quality, and a picture of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign_cli.common import output_options, print_json, progress

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.mesh.types import Mesh

_FILE = click.Path(path_type=Path)


@click.command("mesh")
@click.argument("design", metavar="DESIGN", type=_FILE)
@click.option("--out", metavar="DIR", required=True, type=_FILE, help="The folder to write into.")
@click.option(
    "--fidelity", type=click.Choice(["plane-strain", "3d"]), default="3d", show_default=True
)
@click.option(
    "--scene",
    "scene_file",
    metavar="FILE",
    type=_FILE,
    help="Fine where this scene's contact will be; without it, the fundamental case's.",
)
@click.option(
    "--format",
    "formats",
    metavar="ENDING",
    multiple=True,
    default=("vtu",),
    show_default=True,
    help="vtu, msh (Gmsh), vtk, inp ... as meshio knows them; may be repeated.",
)
@click.option("--picture/--no-picture", default=True, help="Draw mesh.png.", show_default=True)
@output_options
def command(
    design: Path,
    out: Path,
    fidelity: str,
    scene_file: Path | None,
    formats: tuple[str, ...],
    picture: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Mesh DESIGN as an analysis would, and say how good the mesh is.

    Writes mesh.ENDING for each --format, quality.txt, quality.json and mesh.png. Quadratic
    elements; cells carry their region (0 elastomer, k + 1 plate k), facets the name of their face.
    """
    from fingerdesign.design.io import load_design, load_scene
    from fingerdesign.design.scene_checks import scene_faults
    from fingerdesign.errors import DesignError
    from fingerdesign.mesh.quality import assess
    from fingerdesign.pipeline import make_mesh

    finger = load_design(design)
    scene = load_scene(scene_file) if scene_file is not None else None
    faults = scene_faults(scene, finger) if scene is not None else []
    if faults:
        raise DesignError(faults, f"{design} ({scene_file})")
    with progress(finger.design.name, quiet) as tell:
        tell(f"meshing ({fidelity})")
        mesh = make_mesh(finger, fidelity, _zone(finger, scene))
        report = assess(mesh, finger)
        tell("writing")
        files = _write(mesh, out, formats, report.text(), report.to_dict())
        if picture:
            from fingerdesign.mesh.picture import draw_mesh

            tell("drawing")
            files.append(draw_mesh(mesh, out / "mesh.png"))
    if as_json:
        print_json({**report.to_dict(), "files": [str(path) for path in files]})
    elif not quiet:
        click.echo(report.text())
        click.echo("written: " + ", ".join(str(path) for path in files))


def _zone(design: Design, scene: Scene | None) -> float:
    """Half-width of the fine zone, mm: the analysis's first, so that both share a kept mesh."""
    from fingerdesign.design.forecast import contact_half_width
    from fingerdesign.pipeline import (
        _ZONE_FACTOR,
        _ZONE_MARGIN,
        Case,
        fundamental_scene,
        greatest_approach,
    )

    reach = greatest_approach(Case(design, scene), scene or fundamental_scene())
    zone = _ZONE_FACTOR * contact_half_width(design, reach) + _ZONE_MARGIN
    return min(zone, 0.5 * design.body.width_mm)


def _write(
    mesh: Mesh, out: Path, formats: tuple[str, ...], text: str, report: dict[str, object]
) -> list[Path]:
    import json

    from fingerdesign.mesh.io import write_mesh

    out.mkdir(parents=True, exist_ok=True)
    files = [write_mesh(mesh, out / f"mesh.{ending.lstrip('.')}") for ending in formats]
    contents = {
        "quality.txt": text + "\n",
        "quality.json": json.dumps(report, indent=2, allow_nan=False) + "\n",
    }
    for name, content in contents.items():
        (out / name).write_text(content, encoding="utf-8")
        files.append(out / name)
    return files
