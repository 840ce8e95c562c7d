"""Commands about one finger: a design, its check, mesh, analysis, assumptions and mold."""

from __future__ import annotations

from pathlib import Path

import click

from fingerdesign_cli.options import (
    FILE,
    command,
    design_and_out,
    go_on_option,
    out_option,
    output_options,
    result_options,
    scene_option,
)

_KEYS = (  # validate.assumptions.ASSUMPTIONS, which would load numpy
    *("plane_strain", "gage_depth_average", "plate_span", "small_strain", "poissons_ratio"),
    *("youngs_modulus", "sheets", "gage_point", "plates_left_out", "discretisation"),
)


@command("folders", "Write a commented starter design.")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--from", "source", metavar="NAME", help="Start from this shipped design (or scene).")
@click.option("--scene", is_flag=True, help="Write a scene instead of a design.")
@click.option("--force", is_flag=True, help="Overwrite FILE.")
@click.option("--quiet", "-q", is_flag=True, help="Print only failures.")
def new() -> None:
    """Write a commented starter design to FILE.toml, its name taken from FILE; or a scene.

    Beside it goes design.schema.json (scene.schema.json), with which editors complete and explain
    keys. Nothing is overwritten without --force. Shipped designs: maeno2000, homogeneous, narrow,
    wide, domed, pin, block, both_ways, boned.
    """


@command("check", "Is a design sound? Every fault at once.")
@click.argument("designs", metavar="DESIGN...", nargs=-1, required=True, type=FILE)
@scene_option("A scene's file or a shipped one's name; without it, fundamental.")
@output_options
def check() -> None:
    """Name every fault of every DESIGN at once, each as key, value, bound and remedy.

    DESIGN is a file or a shipped design's name. What rests on a faulty key is judged once that is
    mended.

    For sound designs: the plates' clearances, the volume, and forecasts of the contact's
    half-width and of what `analyse` will take: equations, memory and time on this machine. Not
    where SCENE is faulty. Exit code 2 where any file has a fault.
    """


@command("mesh", "Mesh a design and report the mesh's quality.")
@design_and_out("The folder to write into.")
@click.option(
    "--fidelity", type=click.Choice(["plane-strain", "3d"]), default="3d", show_default=True
)
@scene_option(
    "A scene's file or a shipped one's name: fine where its contact will be; without it, "
    "the fundamental case's."
)
@click.option(
    "--format",
    "formats",
    metavar="ENDING",
    multiple=True,
    default=("vtu",),
    show_default=True,
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
def mesh() -> None:
    """Mesh DESIGN as an analysis would, and say how good the mesh is.

    DESIGN is a file or a shipped design's name; with mesh.mesher = "file" its mesh is read, checked
    and fitted. Writes mesh.ENDING for each --format, quality.txt and quality.json (angles, aspects,
    sizes against those asked, volumes and distances to the CAD faces), mesh.png and quality.png.
    Quadratic elements; cells carry their region (elastomer, plate_0, ..., core), facets the name of
    their face (base, contact, side, end, symmetry).
    """


@command("analyse", "Analyse designs: contact, gages, grips, report.")
@click.argument("designs", metavar="DESIGN...", nargs=-1, required=True, type=FILE)
@out_option("Results go to OUT/NAME of each design.")
@scene_option(
    "Run this scene's path alone (a file, or a shipped scene's name); without it, the "
    "fundamental case and the design's grips."
)
@click.option(
    "--fidelity",
    type=click.Choice(["plane-strain", "3d", "auto"]),
    default="3d",
    show_default=True,
    help="3d meshes half of the finger where design and scene mirror in z = 0, else all of it; "
    "with pytetwild unless the design says mesh.mesher. auto takes the cheapest model whose "
    "estimated error is under --tolerance.",
)
@click.option(
    "--tolerance",
    type=float,
    default=None,
    help="Of --fidelity auto: error allowed in forces, stick ratio and gage readings, a part of "
    "one.  [default: 0.02]",
)
@go_on_option
@click.option(
    "--no-fields",
    is_flag=True,
    help="Recover no displacements: the .vtu file and the pictures show the mesh unmoved.",
)
@result_options
@output_options
def analyse() -> None:
    """Analyse each DESIGN: contact, gages, grips, and a result in OUT/NAME.

    A DESIGN is a file, or the name of a shipped finger. A result is written whole or not at all;
    one failing design does not stop the others. What was analysed before, by the same program, is
    not worked again: its answer is kept.
    """


@command("validate", "What each modelling assumption costs, and saves.")
@design_and_out("The record goes to OUT/NAME of the design.")
@scene_option(
    "In this scene (a file, or a shipped scene's name); without it, the fundamental case."
)
@click.option(
    "--deep", is_flag=True, help="Finite strain in three dimensions too: minutes, not seconds."
)
@click.option(
    "--only",
    "keys",
    multiple=True,
    metavar="ASSUMPTION",
    help=f"This assumption alone; may be given again. One of: {', '.join(_KEYS)}.",
)
@output_options
def validate() -> None:
    """Tell what each modelling assumption costs for DESIGN in a scene, and what it saves.

    Each is held against the next better model, at equal motion and at equal force. OUT/NAME then
    holds validate.html (table, chart, advice), validate.json, validate.csv and validate.png.

    Exit code 0 also where DESIGN and scene can tell nothing: each row says why. 1, status "failed"
    and a sentence as failure, where models failed and no assumption was reported.
    """


@command("mold", "Make the mold that a finger is cast in.")
@design_and_out("The mold goes to OUT/NAME of the design.")
@click.option(
    "--process",
    type=click.Choice(["sla", "fdm", "machined"]),
    help="Instead of mold.process: how the parts are made.",
)
@click.option(
    "--fixture",
    type=click.Choice(["comb", "slots"]),
    help="Instead of mold.plate_fixture: what holds the plates.",
)
@output_options
def mold() -> None:
    """Make the mold that DESIGN is cast in: parts, plate fixture, checks, casting notes.

    OUT/NAME then holds each part as STL and STEP, mold.3mf (printed parts on the bed, in mm), DXF
    drawings of plates and combs, bill_of_materials.csv, exploded.png, mold_report.json and
    report.html with the casting notes. The design's [mold] table says how it is made; docs/molds.md
    tells its keys.

    Exit code 1 where a check fails: record and report say which, and why.
    """


@command("folders", "Look at a result.")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--open", "open_browser", is_flag=True, help="Open the report in the browser.")
@click.option("--cad", is_flag=True, help="Write STEP and STL files where they are missing.")
@output_options
def view() -> None:
    """Show the result in DIR, or each result in the folders of DIR, and where its report is.

    A report that is missing is drawn, unless --quiet or --json want no more than what is there.

    Exit code 2 where there is no result. That of a failed analysis is shown like any other.
    """
