"""The whole story: Design + Scene -> solid -> mesh -> reduced model -> increments -> grips.

    analysis = run(Case(design))                 # the fundamental case and the grips, in 3-D
    result = analyse(design, scene, "plane-strain")
    result = analyse_into(Case(design), out)     # and the folder that a user opens

Refuse what cannot be; make the model (analysis/stages.py); follow the path (path.py); lift; write
down what was found (analysis.py).
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from fingerdesign.analysis.analysed import Analysed
from fingerdesign.analysis.analysis import Analysis, analysis_of, failed_analysis, strained
from fingerdesign.analysis.answers import extras, keep_answer, kept_answer
from fingerdesign.analysis.case import Case, Clock
from fingerdesign.analysis.enough import finer
from fingerdesign.analysis.fidelity.ladder import Choice, choose
from fingerdesign.analysis.finite_path import finite_faults, finite_steps
from fingerdesign.analysis.folder import cad_beside, complete_answer, write_analysis
from fingerdesign.analysis.forecast.forecast import forecast_case
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.measurable import Sections, measurability, sections_beside, states_seen
from fingerdesign.analysis.path import follow_path, problem_at_touch
from fingerdesign.analysis.stages import (
    bare_opposite,
    condense,
    in_wide_zone,
    make_mesh,
    one_thread,
    slip_studies,
    zone_of,
)
from fingerdesign.checks.load import load_design
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.episode import run_episodes
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import load_scene
from fingerdesign.errors import DesignError, FingerDesignError
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.make import mesher_of
from fingerdesign.mesh.section.netgen import start_mesher
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.folder import RESULTS
from fingerdesign.records.result import GripResult, Result
from fingerdesign.report.style import load_ahead
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.train.result import with_estimator


def analyse(
    design: Design | str | Path, scene: Scene | str | Path | None = None, fidelity: str = "3d"
) -> Analysed:
    """The record of one analysis; design and scene may be files, or names of shipped ones.

        result = analyse("maeno2000", "pull", "plane-strain")
        result.to_dataframe()["normal_force_N"]
        result.plot_finger().show()

    Without a scene: the fundamental case and the design's grips. Raises DesignError for wrong
    input, another FingerDesignError where the work fails.
    """
    design = design if isinstance(design, Design) else load_design(design)
    scene = scene if isinstance(scene, Scene | None) else load_scene(scene)
    return Analysed.of(run(Case(design, scene, fidelity, grips=scene is None, fields=False)))


def run(case: Case, report: Report = lambda message: None, clock: Clock | None = None) -> Analysis:
    """Everything between a design and its report, timed by ``clock``.

    Raises DesignError for a wrong input, another FingerDesignError where a stage fails.
    """
    scene = case.path_scene
    refuse(case, scene)
    case = with_estimator(case, report)
    if case.fidelity in ("plane-strain", "auto") or mesher_of(case.design).sections:
        start_mesher()  # loads netgen while this process loads the rest
    sections = sections_beside(case)  # for remedies of gages, on the core that meshing leaves
    clock = Clock() if clock is None else clock
    zone = zone_of(case, scene)
    notes: list[str] = []

    def note(message: str) -> None:
        notes.append(message)
        report(message)

    given = (sections, clock, notes, report)
    return in_wide_zone(case.design, zone, lambda z: _run_in_zone(case, scene, z, *given), note)


def _run_in_zone(
    requested: Case,
    scene: Scene,
    zone: Zone,
    sections: Sections | None,
    clock: Clock,
    notes: list[str],
    report: Report,
) -> Analysis:
    chosen, problem, steps = _followed(requested, scene, zone, clock, notes, report)
    case, zone = chosen.case, chosen.zone
    array = replace(problem, model=problem.model.with_gages(case.gage_array))
    grips: list[tuple[GripResult, GripTrace]] = []
    with clock.stage("grips"), one_thread(), ThreadPoolExecutor(1) as beside:
        studied = beside.submit(slip_studies, case, scene, array)
        states = beside.submit(states_seen, case, scene, array, steps)
        if case.runs_grips:
            report("gripping")
            bare = bare_opposite(case, zone, scene)
            grip, plates = case.design.grip, case.gage_array
            given = (grip.friction_coefficients, grip.object_mass_g, plates, bare, case.estimator)
            episodes = run_episodes(array, case.design, *given)
            grips = [(episode.result, episode.trace) for episode in episodes]
        measurable = measurability(case.design, states.result(), sections)
    worked = (problem, array, steps, studied.result(), grips, measurable)
    return analysis_of(requested, scene, chosen, *worked, clock)


def _followed(
    case: Case,
    scene: Scene,
    zone: Zone,
    clock: Clock,
    notes: list[str],
    report: Report,
    attempt: int = 1,
) -> tuple[Choice, ContactProblem, list[Step]]:
    """The model in a zone, and its path; meshed finer where the contact holds too few nodes."""
    design = case.design
    if case.fidelity == "auto":
        chosen = choose(case, scene, zone, clock, report)
        chosen.notes[:0] = notes
    else:
        report("meshing")
        with clock.stage("mesh"):
            mesh = make_mesh(design, case.fidelity, zone, case.symmetric)
        report(f"condensing {len(mesh.cells)} elements")
        model = condense(design, mesh, zone, scene)
        clock.add(model.timings)
        chosen = Choice(case, model, zone, notes)
    problem = problem_at_touch(chosen.model.reduced, scene.object, design.body)
    report("loading")
    with clock.stage("increments"):
        chosen, steps = _path(case, chosen, scene, problem, report)
    if (anew := finer(chosen, scene, problem, steps, attempt)) is None:
        return chosen, problem, steps

    def note(message: str) -> None:
        notes.append(message)
        report(message)

    finer_case, narrow = anew
    note(f"the contact held too few nodes: it is meshed finer over {narrow}")
    given = (clock, notes, report, attempt + 1)
    return in_wide_zone(
        design, narrow, lambda wide: _followed(finer_case, scene, wide, *given), note
    )


def _path(
    case: Case, chosen: Choice, scene: Scene, problem: ContactProblem, report: Report
) -> tuple[Choice, list[Step]]:
    """The steps of a scene's path, and the model as it was chosen for them: "auto" goes on to
    finite strain where the finger is pressed too deep for small ones."""
    own = chosen.case
    if own.fidelity != "finite":
        chosen.model.condensed.prepare_fields(needed=case.fields)
        with one_thread():
            steps = follow_path(problem, scene, own.design)
        deep = case.fidelity == "auto" and own.fidelity == "3d" and strained(own.design, steps)
        if not deep or finite_faults(own.design, scene):
            return chosen, steps
        why = "strains are not small: the path is followed at finite strain, on the same mesh"
        report(why)
        notes = [*chosen.notes, why]
        chosen = replace(chosen, case=replace(own, fidelity="finite"), notes=notes)
    return chosen, [*finite_steps(own.design, chosen.model.condensed, scene)]


def analyse_into(
    case: Case,
    out: Path,
    report: Report = lambda message: None,
    page: bool | None = None,
    cad: bool | None = None,
    fresh: bool = False,
) -> Result:
    """Run a case and write OUT/NAME; a failure of the work is written as a failed result.

    page, cad: with report.html, with STEP and STL files; None: except in plane strain. An answer
    that is kept from an earlier run is taken, unless ``fresh``. Raises DesignError for wrong input
    (nothing is written), ResultError where the folder cannot be.
    """
    if not fresh and (found := kept_answer(case, out, page, cad)) is not None:
        complete_answer(case, out, page, cad)
        return found
    refuse(case, case.path_scene)
    page, cad = extras(case, page, cad)
    with RESULTS.written(out / case.design.design.name) as folder:
        result = _worked(case, folder, report, page, cad)
        if result.status == "ok":
            keep_answer(case, folder)
    return result


def _worked(case: Case, folder: Path, report: Report, page: bool, cad: bool) -> Result:
    """Run a case and write what was found, or why nothing was, into ``folder``."""
    if case.fidelity != "auto":  # which models that will take is not known yet
        report(f"forecast: {forecast_case(case)}")
    if page:
        load_ahead()
    clock = Clock()
    try:
        with cad_beside(case.design, folder, clock, wanted=cad):
            analysis = run(case, report, clock)
    except DesignError:
        raise
    except (FingerDesignError, MemoryError) as error:
        analysis = failed_analysis(case, error, clock)
    report("writing the report")
    return write_analysis(analysis, case.design, folder, clock, page)
