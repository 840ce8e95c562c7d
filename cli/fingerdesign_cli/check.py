"""``fingerdesign check``: is a design sound, and what is known of it before any model is built."""

from __future__ import annotations

import random
import shutil
import sys
import textwrap
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign.cad.step_rules import check_mirror
from fingerdesign.checks.foil import gage_keys
from fingerdesign.checks.meshing import plane_strain_faults
from fingerdesign.control.roster import needs_training
from fingerdesign.design.io import Judged
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import file_text, kind_of
from fingerdesign.design.step import StepFacts, step_facts
from fingerdesign.errors import DesignError, Fault, MeshError, printable
from fingerdesign.layout.fitting import gage_fit, gage_words, sheet_words, stiffness_words
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.summary import Summary, summarise
from fingerdesign.materials import disagreement_of
from fingerdesign.records.verdict import SIGNS
from fingerdesign_cli import terminal
from fingerdesign_cli.inputs import collected, judged_design, judged_scene

if TYPE_CHECKING:
    from fingerdesign.analysis.forecast.forecast import Forecast
    from fingerdesign.analysis.forecast.lift import Lift
    from fingerdesign.search.study.file import Study

_MANY_FACES = 60  # a question of all faces to all edges: below a second
_VARIANTS_TRIED = 50  # of a study: 10 ms each
_NUMBERS_WIDE = 63  # characters of the table without its first column's words


@dataclass(frozen=True)
class _Checked:
    """A sound design: its report for scripts, and the rows of the tables."""

    report: dict[str, object]
    summary: Summary
    costs: list[Forecast]
    lifts: list[Lift]
    notes: list[str]


def check(designs: tuple[Path, ...], scene_file: Path | None) -> int:
    """Name every fault of every FILE at once, each as key, value, bound and remedy."""
    scene, wrong = judged_scene(scene_file) if scene_file is not None else (None, None)
    reports = [_faulty(scene_file, wrong)] if scene_file is not None and wrong is not None else []
    found = [_judged(path, scene, wrong is None) for path in designs]
    checked = [each for each in found if isinstance(each, _Checked)]
    reports += [each.report if isinstance(each, _Checked) else each for each in found]
    name = scene_file.stem if scene_file else ""
    terminal.say_result(lambda: reports, lambda: _show_all(checked, name, wrong is None))
    return 0 if all(report["sound"] for report in reports) else 2


def _judged(
    path: Path, scene: Judged[Scene] | None, scene_sound: bool
) -> _Checked | dict[str, object]:
    """Judge a file: a sound design with its forecasts, or the report of anything else."""
    if (kind := kind_of(path)) != "design":
        return _other(path, kind)
    found, error = judged_design(path, scene)
    if error is not None or found is None or found.value is None:
        report = _faulty(path, error or DesignError([]))
        if found is not None and found.value is None:
            click.echo(
                "mend these first, then check again: distances are judged after that", err=True
            )
        return report
    if wrong := _mesh_fault(found.value):
        return _faulty(path, DesignError([wrong], str(path)))
    return _forecast(path, found.value, scene, scene_sound)


def _mesh_fault(design: Design) -> Fault | None:
    """The fault of a mesh of another program that is none of this finger."""
    if design.mesh.file is None:
        return None
    from fingerdesign.mesh.files.imported import imported_mesh

    try:
        imported_mesh(design)
    except MeshError as error:
        return Fault("mesh.file", design.mesh.file, "a mesh of this finger", str(error))
    return None


def _forecast(
    path: Path, design: Design, judged: Judged[Scene] | None, scene_sound: bool
) -> _Checked:
    """Summarise a sound design and forecast its analysis; not where the scene is faulty."""
    from fingerdesign.analysis.case import fundamental_scene
    from fingerdesign.analysis.finite_path import pressure_note
    from fingerdesign.analysis.forecast.forecast import forecasts
    from fingerdesign.analysis.forecast.lift import lifts
    from fingerdesign.analysis.forecast.limits import too_large

    scene = judged.value if judged is not None and scene_sound else None
    summary = summarise(design, scene)
    costs = forecasts(design, scene) if scene_sound else []
    found = lifts(design) if judged is None and scene_sound else []
    remedies = dict.fromkeys(words for each in found for words in each.remedies)
    notes = [*_notes(design), *remedies, *filter(None, map(too_large, costs))]
    if scene_sound:
        notes += filter(None, [pressure_note(design, scene or fundamental_scene(design))])
    report: dict[str, object] = {"file": str(path), "sound": True, "faults": [], "notes": notes}
    if scene_sound:
        report |= asdict(summary)
        report["forecast"] = [each.as_dict() for each in costs]
        report["lifts"] = [asdict(each) for each in found]
    return _Checked(report, summary, costs, found, [f"{path}: {note}" for note in notes])


def _show_all(checked: list[_Checked], scene: str, scene_sound: bool) -> None:
    """Print the tables of all sound designs, then the notes."""
    if checked and scene_sound:
        for each in checked:
            terminal.say(f"{SIGNS['pass']} {each.summary.name}: no fault")
        _show([each.summary for each in checked], scene)
        _show_costs([(each.summary.name, cost) for each in checked for cost in each.costs], scene)
        _show_lifts([(each.summary.name, lift) for each in checked for lift in each.lifts])
    for each in checked:
        for note in each.notes:
            terminal.say_marked(SIGNS["note"], f"note: {note}")


def _other(path: Path, kind: str) -> dict[str, object]:
    """Summarise a scene or a study; find every fault of it, of its base and of its scenes."""
    facts, error = _scene_facts(path) if kind == "scene" else _study_facts(path)
    if error is not None:
        return _faulty(path, error)
    if not (terminal.quiet() or terminal.as_json()):
        terminal.say(f"{SIGNS['pass']} {path}: no fault ({kind})")
        for name, value in facts.items():
            terminal.say_marked("", f"{name}: {value}")
    return {"file": str(path), "kind": kind, "sound": True, "faults": [], **facts}


def _scene_facts(path: Path) -> tuple[dict[str, object], DesignError | None]:
    found, error = judged_scene(path)
    if error is not None or found is None or found.value is None:
        return {}, error
    scene = found.value
    shape, friction = scene.object.shape, scene.object.law.shown
    return {"object": shape, "friction": friction, "rows": len(scene.path.rows)}, None


def _study_facts(path: Path) -> tuple[dict[str, object], DesignError | None]:
    from fingerdesign.search.run.run import study_scenes
    from fingerdesign.search.study.file import parse_study
    from fingerdesign.search.study.variants import base_design, number_of_points

    try:
        study = parse_study(file_text(path, "study"), str(path))
    except DesignError as error:
        return {}, error
    errors: list[DesignError] = []
    notes: dict[str, object] = {}
    with collected(errors):
        base = base_design(study, path)
        notes["each variant"] = "; ".join(_training_words(base))
        notes["cannot exist"] = _impossible(study, base)
    with collected(errors):
        study_scenes(study, path.parent)
    if errors:
        return {}, DesignError.together(errors)
    facts: dict[str, object] = {
        "base": study.study.base,
        "variants": number_of_points(study),
        "parameters": len(study.parameters),
        "scenes": ", ".join(study.study.scenes) or "the fundamental case and the grips",
        "fidelity": study.study.fidelity,
        "objectives": ", ".join(f"{each.direction} {each.metric}" for each in study.objectives),
    }
    return facts | {name: words for name, words in notes.items() if words}, None


def _impossible(study: Study, base: Design) -> str:
    """Count, of a few variants at random, those that cannot exist, with the chief reason; or "".
    Raises DesignError where all were tried and none of them can."""
    from fingerdesign.search.study.generate import reasons
    from fingerdesign.search.study.variants import number_of_points, points, variant_of

    every = range(1, number_of_points(study) + 1)
    chosen = {*random.Random(0).sample(every, min(len(every), _VARIANTS_TRIED))}
    numbered = enumerate(points(study), start=1)
    tried = [variant_of(study, base, k, values) for k, values in numbered if k in chosen]
    refused = [each for each in tried if each.design is None]
    if not refused:
        return ""
    _, _, fault, name = reasons(refused)[0]
    if len(refused) == len(every):
        shown = f"variants: {len(every)}"
        raise DesignError([Fault("parameters", shown, "such that a variant can exist", str(fault))])
    return f"{len(refused)} of {len(tried)} variants tried ({name}: {fault})"


def _notes(design: Design) -> list[str]:
    """Describe a sound design's solid, and what to know before analysing it, a sentence each."""
    found = [_step_words(design)] if design.body.shape == "step" else []
    if design.body.shape in ("revolved", "dome"):
        found.append(
            "--fidelity plane-strain draws the section z = 0 straight along z: of a "
            f"{design.body.shape} body it overstates forces several times"
        )
    rubber = design.body.material
    disagreement = disagreement_of(rubber, design.material_of("body").youngs_modulus_MPa)
    found += [disagreement] if disagreement else []
    fit = gage_fit(design)
    keys = gage_keys(design, fit) if fit is not None and fit.found is None else {}
    mends = ", ".join(f"{key} = {value:g}" for key, value in keys.items())
    about_gages = (gage_words(design, fit, mends), stiffness_words(design, fit))
    found += [*filter(None, about_gages), *sheet_words(design)]
    found += [*_training_words(design)]
    return found + [
        f"sound in three dimensions only: {fault.key} = {fault.value} must be {fault.bound}"
        for fault in plane_strain_faults(design)
    ]


def _training_words(design: Design) -> Iterator[str]:
    """The training that a design's controller begins with, and what makes it needless."""
    if not needs_training(design.grip.controller):
        return
    from fingerdesign.sensing.train.ready import shipped_estimator

    if shipped_estimator(design, "plane-strain") is None:
        ships = shipped_estimator(design) is not None
        where = "; in 3-D it takes an estimator that ships" if ships else ""
        plane = " in plane strain" if ships else ""
        yield (
            f"grip.controller = '{design.grip.controller}' is trained before its first grip"
            f"{plane}, in up to half an hour{where}"
        )


def _step_words(design: Design) -> str:
    """Describe a STEP file: its solid's sizes, its base and its contact surface."""
    assert design.body.step is not None
    facts = step_facts(design.body.step)
    sizes = " x ".join(f"{high - low:.4g}" for low, high in zip(facts.low, facts.high, strict=True))
    words = (
        f"step: {sizes} mm (x, y, z as turned), base {facts.area['base']:.4g} mm2, contact "
        f"{len(facts.contact)} of {len(facts.faces)} faces, {facts.area['contact']:.4g} mm2"
    )
    if not design.body.step.mirrors_in_z and _could_mirror(design, facts):
        words += "; it mirrors in z: body.step.mirrors_in_z = true halves the work"
    return words


def _could_mirror(design: Design, facts: StepFacts) -> bool:
    """Tell whether half of a finger could be modelled; only solids of few faces are examined."""
    few = len(facts.faces) <= _MANY_FACES
    if not few or not all(frame.mirrors_in_z for frame in plate_frames(design)):
        return False
    refused: list[DesignError] = []
    with collected(refused):
        check_mirror(facts.faces, "")
    return not refused


def _faulty(path: Path, error: DesignError) -> dict[str, object]:
    click.echo(printable(str(error)), err=True)
    keys = ("key", "value", "bound", "remedy")
    faults = [{key: str(getattr(fault, key)) for key in keys} for fault in error.faults]
    return {"file": str(path), "sound": False, "faults": faults}


def _show(summaries: list[Summary], scene: str) -> None:
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 200
    room = max(width - _NUMBERS_WIDE, 10)  # a name is never cut
    rows = [
        [
            "\n".join([*textwrap.wrap(item.name, room), item.body, "; ".join(item.rows) or "bare"]),
            *map(terminal.number, (item.least_surface_mm, item.least_gap_mm)),
            *map(terminal.number, (item.least_side_mm, item.least_base_mm)),
            terminal.number(item.volume_mm3, 0),
        ]
        for item in summaries
    ]
    headings = ["design, body, plates", "surface", "gap", "side", "base", "volume, mm³"]
    terminal.print_table("Distances of the plates, mm", headings, rows)
    terminal.say_marked(
        "", "least distance of a plate to the contact surface, to another plate, to the"
    )
    terminal.say_marked("", "finger's side and to its base")
    if terminal.details():
        path = f"the scene {scene}" if scene else "the fundamental path"
        for item in summaries:
            reach = f"half-width of contact {terminal.number(item.contact_half_width_mm, 1)} mm"
            words = (
                f"{path}, first approach {terminal.number(item.approach_mm)} mm: {reach} (forecast)"
            )
            terminal.say_marked("", f"{item.name}: {words}")


def _remarks(found: Forecast) -> str:
    facts = ["half"] * found.half + ["mesh cached"] * found.mesh_kept
    return f" ({', '.join(facts)})" if facts else ""


def _show_costs(costs: list[tuple[str, Forecast]], scene: str) -> None:
    """Forecast the cost of an analysis at each fidelity that is open to the design."""
    rows = [
        [
            name,
            found.fidelity + _remarks(found),
            *map(str, (found.elements, found.dofs, found.contact_nodes)),
            f"{found.memory_MB / 1024.0:.1f}",
            f"{found.total_s:.0f}" if found.total_s >= 9.5 else f"{found.total_s:.1f}",
        ]
        for name, found in costs
    ]
    if not rows:
        return
    headings = ["design", "fidelity", "elements", "equations", "contact", "GB", "s"]
    case = f"--scene {scene}" if scene else "the fundamental case and the grips"
    terminal.print_table("Cost of analyse (forecast)", headings, rows)
    terminal.say_marked("", "contact: nodes that may touch; GB: memory; s: time on this machine")
    if terminal.details():
        terminal.say_marked("", f"{case}, on {costs[0][1].machine_words}")


def _show_lifts(held: list[tuple[str, Lift]]) -> None:
    """Forecast the lift of the grips' object at each friction."""
    if not held:
        return
    rows = [
        [
            name,
            f"{each.object_mass_g:g}",
            f"{each.friction_coefficient:g}",
            *map(terminal.number, (each.normal_force_N, each.tangential_force_N, each.approach_mm)),
            *(_contact_cells(each) if terminal.details() else ()),
            {True: "likely pass", False: "likely fail", None: "open"}[each.measurable],
        ]
        for name, each in held
    ]
    headings = ["design", "mass, g", "friction", "F_n N", "F_t N", "approach, mm"]
    headings += [*(["half-width", "nodes 2-D / 3-D"] if terminal.details() else []), "gage signal"]
    terminal.print_table("Lift with a margin of 1.5 (forecast)", headings, rows)
    terminal.say_marked(
        "", "F_n, F_t: normal and tangential force of one finger; approach: its depth"
    )
    terminal.say_marked(
        "", "gage signal: the verdict of that name; open: the forecast does not decide it"
    )
    terminal.say_marked("", "slip sensing is not forecast: analyse judges it")


def _contact_cells(found: Lift) -> tuple[str, str]:
    """The contact's half-width, and its nodes in plane strain and in 3-D."""
    nodes = " / ".join(f"{count}" for count in found.contact_nodes.values())
    return terminal.number(found.contact_half_width_mm, 1), nodes
