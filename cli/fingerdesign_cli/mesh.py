"""``fingerdesign mesh``: the mesh that an analysis would use, its quality, and a picture of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fingerdesign.analysis.stages import make_mesh, zone_of
from fingerdesign.layout.frames import mirrors_in_z
from fingerdesign.mesh.files.io import write_mesh
from fingerdesign.mesh.picture import draw_mesh
from fingerdesign.mesh.pictures import draw_quality
from fingerdesign.mesh.quality import asked_sizes, assess
from fingerdesign_cli.common import output_folder, output_options, print_json, progress, read_case

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.layout.zone import Zone
    from fingerdesign.mesh.types import Mesh

_FILE = click.Path(path_type=Path)
# Those that keep quadratic cells of both dimensions.
ENDINGS = ("vtu", "vtk", "msh", "inp", "mdpa")


def _endings(_context: click.Context, _parameter: click.Parameter, value: tuple[str, ...]) -> Any:
    endings = tuple(dict.fromkeys(ending.lstrip(".").lower() for ending in value))
    for ending in endings:
        if ending not in ENDINGS:
            raise click.UsageError(f"--format = {ending}: must be one of {', '.join(ENDINGS)}")
    return endings


@click.command("mesh")
@click.argument("design", metavar="DESIGN", type=_FILE)
@click.option(
    "--out",
    metavar="DIR",
    required=True,
    type=_FILE,
    callback=output_folder,
    help="The folder to write into.",
)
@click.option(
    "--fidelity", type=click.Choice(["plane-strain", "3d"]), default="3d", show_default=True
)
@click.option(
    "--scene",
    "scene_file",
    metavar="SCENE",
    type=_FILE,
    help="A scene's file or a shipped one's name: fine where its contact will be; without it, "
    "the fundamental case's.",
)
@click.option(
    "--format",
    "formats",
    metavar="ENDING",
    multiple=True,
    default=("vtu",),
    show_default=True,
    callback=_endings,
    help="vtu and vtk (ParaView), msh (Gmsh), inp (CalculiX, Abaqus), mdpa (Kratos); may be "
    "repeated.",
)
@click.option(
    "--picture/--no-picture",
    default=True,
    help="Draw mesh.png and quality.png.",
    show_default=True,
)
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

    DESIGN is a file or a shipped design's name; with mesh.mesher = "file" its mesh is read, checked
    and fitted. Writes mesh.ENDING for each --format, quality.txt and quality.json (angles, aspects,
    sizes against those asked, volumes and distances to the CAD faces), mesh.png and quality.png.
    Quadratic elements; cells carry their region (elastomer, plate_0, ..., core), facets the name of
    their face (base, contact, side, end, symmetry).
    """
    from fingerdesign.analysis.case import Case, fundamental_scene
    from fingerdesign.analysis.forecast.limits import refuse

    finger, scene = read_case(design, scene_file)
    refuse(Case(finger, scene, fidelity), scene or fundamental_scene())
    with progress(finger.design.name, quiet) as tell:
        tell(f"meshing ({fidelity})")
        symmetric = mirrors_in_z(finger) and (scene is None or scene.mirrors_in_z)
        zone = _zone(finger, scene)
        mesh = make_mesh(finger, fidelity, zone, symmetric)
        asked = asked_sizes(finger, mesh, zone.half_width, zone.half_depth)
        report = assess(mesh, finger, asked)
        tell("writing")
        files = _write(mesh, out, formats, report.text(), report.to_dict())
        if picture:
            tell("drawing")
            files.append(draw_mesh(mesh, out / "mesh.png", name=finger.design.name))
            files.append(draw_quality(mesh, finger, report, out / "quality.png", asked))
    if as_json:
        print_json({**report.to_dict(), "files": [str(path) for path in files]})
    elif not quiet:
        click.echo(report.text())
        click.echo("written: " + ", ".join(str(path) for path in files))


def _zone(design: Design, scene: Scene | None) -> Zone:
    """The fine zone: the analysis's first, so that both share a kept mesh."""
    from fingerdesign.analysis.case import Case, fundamental_scene

    return zone_of(Case(design, scene), scene or fundamental_scene())


def _write(
    mesh: Mesh, out: Path, formats: tuple[str, ...], text: str, report: dict[str, object]
) -> list[Path]:
    import json

    out.mkdir(parents=True, exist_ok=True)
    files = [write_mesh(mesh, out / f"mesh.{ending}") for ending in formats]
    contents = {
        "quality.txt": text + "\n",
        "quality.json": json.dumps(report, indent=2, allow_nan=False) + "\n",
    }
    for name, content in contents.items():
        (out / name).write_text(content, encoding="utf-8")
        files.append(out / name)
    return files
