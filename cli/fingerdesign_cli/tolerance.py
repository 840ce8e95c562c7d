"""``fingerdesign tolerance``: the spread of fingers as they are cast, and what to tighten first."""

from pathlib import Path

from fingerdesign_cli.inputs import read_case, recorded
from fingerdesign_cli.terminal import open_page, say_block, say_result


def tolerance(design_file: Path, out: Path, scene_file: Path | None, fidelity: str) -> int:
    """Report the spread of fingers that are cast as DESIGN."""
    design, scene = read_case(design_file, scene_file)
    from fingerdesign.tolerance.page import view_of
    from fingerdesign.tolerance.spread import FOLDER, tolerance, write_tolerance

    name = design.design.name
    stem = scene_file.stem if scene_file is not None else ""
    with recorded(FOLDER, out / name) as (folder, show):
        found = tolerance(design, scene, fidelity, lambda message: show(message), stem)
        write_tolerance(found, folder)
    say_result(found.data, lambda: say_block(view_of(found), out / name))
    open_page(out / name / "report.html")
    return 0
