"""``fingerdesign check``: is a design sound, and what is known of it before any model is built."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign_cli.common import output_options, print_json, print_table

if TYPE_CHECKING:
    from fingerdesign.design.forecast import Summary
    from fingerdesign.design.scene import Scene

_FILE = click.Path(path_type=Path)


@click.command("check")
@click.argument("designs", metavar="DESIGN...", nargs=-1, required=True, type=_FILE)
@click.option(
    "--scene",
    "scene_file",
    metavar="SCENE",
    type=_FILE,
    help="A scene's file or a shipped one's name.",
)
@output_options
def command(designs: tuple[Path, ...], scene_file: Path | None, quiet: bool, as_json: bool) -> int:
    """Name every fault of every DESIGN at once, each as key, value, bound and remedy.

    For sound designs: the plates' clearances, the volume and a forecast of the contact's
    half-width. Exit code 2 where any file has a fault.
    """
    from fingerdesign.design.starter import find_scene
    from fingerdesign.errors import DesignError

    reports: list[dict[str, object]] = []
    summaries: list[Summary] = []
    scene: Scene | None = None
    if scene_file is not None:
        try:
            scene = find_scene(scene_file)
        except DesignError as error:
            reports.append(_faulty(scene_file, error))
    for path in designs:
        try:
            summary = _summary(path, scene)
        except DesignError as error:
            reports.append(_faulty(path, error))
        else:
            summaries.append(summary)
            reports.append({"file": str(path), "sound": True, "faults": [], **summary.as_dict()})
    sound = all(report["sound"] for report in reports)
    if as_json:
        print_json(reports)
    elif summaries and not quiet:
        _show(summaries)
    return 0 if sound else 2


def _summary(path: Path, scene: Scene | None) -> Summary:
    from fingerdesign.design.forecast import summarise
    from fingerdesign.design.io import load_design
    from fingerdesign.design.scene_checks import scene_faults
    from fingerdesign.errors import DesignError

    design = load_design(path)
    faults = scene_faults(scene, design) if scene is not None else []
    if faults:
        raise DesignError(faults, f"{path} (scene)")
    return summarise(design, scene)


def _faulty(path: Path, error: Exception) -> dict[str, object]:
    from fingerdesign.errors import DesignError

    assert isinstance(error, DesignError)
    click.echo(str(error), err=True)
    faults = [
        {"key": fault.key, "value": str(fault.value), "bound": fault.bound, "remedy": fault.remedy}
        for fault in error.faults
    ]
    return {"file": str(path), "sound": False, "faults": faults}


def _show(summaries: list[Summary]) -> None:
    def number(value: float | None, digits: int = 2) -> str:
        return "-" if value is None else f"{value:.{digits}f}"

    rows = [
        [
            item.name,
            str(item.plates),
            number(item.least_cover_mm),
            number(item.least_gap_mm),
            number(item.least_side_mm),
            number(item.least_base_mm),
            f"{number(item.approach_mm)} -> {number(item.contact_half_width_mm, 1)}",
            number(item.volume_mm3, 0),
        ]
        for item in summaries
    ]
    headings = ["sound design", "plates", "cover mm", "gap mm", "side mm", "base mm"]
    headings += ["approach -> half-width mm (forecast)", "volume mm3"]
    print_table("Least clearances of the plates", headings, rows)
