"""``fingerdesign mesh``: the mesh that an analysis would use, its quality, and a picture of it."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import click

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.stages import make_mesh, zone_of
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.rows import mirrors_in_z
from fingerdesign.mesh.files.io import write_mesh
from fingerdesign.mesh.pictures import draw_mesh, draw_quality
from fingerdesign.mesh.quality import assess
from fingerdesign.mesh.quality_text import quality_text
from fingerdesign.mesh.requested import requested_sizes
from fingerdesign.records.base import json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.runtime.files import write_whole
from fingerdesign_cli.inputs import read_case, refuse_foreign, refuse_in_the_way
from fingerdesign_cli.options import OUT
from fingerdesign_cli.terminal import progress, say_done

# Those that keep quadratic cells of both dimensions.
ENDINGS = ("vtu", "vtk", "msh", "inp", "mdpa")


def mesh(
    design_file: Path,
    folder: Path | None,
    fidelity: str,
    scene_file: Path | None,
    formats: tuple[str, ...],
    picture: bool,
) -> None:
    """Mesh DESIGN as an analysis would, and say how good the mesh is."""
    endings = _endings(formats)
    finger, scene = read_case(design_file, scene_file)
    run_scene = scene or fundamental_scene(finger)
    out = folder or OUT / "mesh" / finger.design.name
    if folder is None:  # A folder of its own, next to no other record.
        refuse_foreign(RecordFolder("mesh", "quality.json", ("mesh.*", "quality.*")), out)
    _refuse_files(finger, out, endings)
    refuse(Case(finger, scene, fidelity), run_scene)
    with progress(finger.design.name) as report:
        report(f"meshing ({fidelity})")
        symmetric = mirrors_in_z(finger) and (scene is None or scene.mirrors_in_z)
        zone = zone_of(Case(finger, scene), run_scene)  # the analysis's, to share a cached mesh
        mesh = make_mesh(finger, fidelity, zone, symmetric)
        requested = requested_sizes(finger, mesh, zone)
        quality = assess(mesh, finger, requested)
        report("writing")
        out.mkdir(parents=True, exist_ok=True)
        files = [write_mesh(mesh, out / f"mesh.{ending}") for ending in endings]
        files.append(write_whole(out / "quality.txt", f"{quality_text(quality)}\n"))
        files.append(write_whole(out / "quality.json", json_text(asdict(quality))))
        if picture:
            report("drawing")
            files.append(draw_mesh(mesh, out / "mesh.png", name=finger.design.name))
            files.append(draw_quality(mesh, finger, quality, out / "quality.png", requested))
    names = list(map(str, files))
    words = f"{quality_text(quality)}\nwritten: {', '.join(names)}"
    say_done({**asdict(quality), "files": names}, words)


def _refuse_files(finger: Design, out: Path, endings: Sequence[str]) -> None:
    """DesignError where a file to write is the user's own: the design's mesh, or of no command."""
    names = [*(f"mesh.{ending}" for ending in endings), "quality.txt", "mesh.png", "quality.png"]
    files = [out / name for name in names]
    refuse_in_the_way(files, out / "quality.json")
    own = finger.mesh.file
    if own is not None and Path(own).resolve() in [each.resolve() for each in files]:
        bound = f"a folder without the design's own mesh.file, {own}"
        raise DesignError([Fault("--out", str(out), bound, "choose another --out")])


def _endings(formats: tuple[str, ...]) -> tuple[str, ...]:
    """Return each requested ending once. UsageError for one that is not known."""
    endings = tuple(dict.fromkeys(ending.lstrip(".").lower() for ending in formats))
    for ending in endings:
        if ending not in ENDINGS:
            raise click.UsageError(f"--format = {ending}: must be one of {', '.join(ENDINGS)}")
    return endings
