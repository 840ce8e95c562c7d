"""The whole story: Design + Scene -> solid -> mesh -> reduced model -> increments -> grips.

    analysis = run(Case(design))                 # the fundamental case and the grips, in 3-D
    result = analyse(design, scene, "plane-strain")
    result = analyse_into(Case(design), out)     # and the folder that a user opens

Refuse what cannot be; make the model; follow the path; lift; write down what was found.
"""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from fingerdesign.analysis.analysed import Analysed
from fingerdesign.analysis.analysis import Analysis, analysis_of, failed_analysis, too_deep
from fingerdesign.analysis.answers import cache_answer, cached_answer, requested_products
from fingerdesign.analysis.case import Case, Clock
from fingerdesign.analysis.fidelity.choice import Choice, choose
from fingerdesign.analysis.finite_path import finite_steps
from fingerdesign.analysis.folder import complete_answer, products_begun, write_analysis
from fingerdesign.analysis.forecast.forecast import forecast_progress
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.measurable import Sections, measurability, start_sections, states_seen
from fingerdesign.analysis.mesh_error import Second, mesh_error, start_second
from fingerdesign.analysis.path import follow_path, problem_at_touch
from fingerdesign.analysis.path_error import path_error
from fingerdesign.analysis.stages import condense, make_mesh, rig_of, run_grips, slip_studies
from fingerdesign.analysis.work import Followed, Lifted, Work
from fingerdesign.checks.load import load_design
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import load_scene
from fingerdesign.errors import FingerDesignError
from fingerdesign.records.result import Result
from fingerdesign.records.result_files import RESULTS
from fingerdesign.runtime.progress import Progress, Report, listening, silent
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.train.ready import with_estimator


def analyse(
    design: Design | str | Path, scene: Scene | str | Path | None = None, fidelity: str = "3d"
) -> Analysed:
    """The record of one analysis; design and scene may be files, or names of shipped ones.

        result = analyse("maeno2000", "pull", "plane-strain")
        result.plot_finger().show()

    Without a scene: the fundamental case and the design's grips. Errors as of :func:`run`.
    """
    design = design if isinstance(design, Design) else load_design(design)
    name = "" if isinstance(scene, Scene | None) else Path(scene).stem
    scene = scene if isinstance(scene, Scene | None) else load_scene(scene)
    case = Case(design, scene, fidelity, name, grips=scene is None, fields=False)
    return Analysed.of(run(case))


def run(case: Case, report: Report = lambda message: None, clock: Clock | None = None) -> Analysis:
    """Everything between a design and its report, timed by ``clock``. Raises DesignError for a
    wrong input, another FingerDesignError where a stage fails."""
    refuse(case, case.path_scene)
    work = Work(with_estimator(case, report), clock or Clock(), report)
    sections = start_sections(work.case)  # on the core that meshing leaves idle
    while True:
        try:
            chosen = make_model(work)
            second = start_second(chosen, work.scene)
            followed = follow(work, chosen)
            if not work.refine_if_needed(followed):
                return analysis_of(work, followed, lift(work, followed, sections, second))
        except ZoneExhausted as exhausted:
            work.widen(exhausted)


def make_model(work: Work) -> Choice:
    """The condensed finger: the one that the fidelity names, or the ladder's choice."""
    case, zone, scene = work.case, work.zone, work.scene
    with listening(work.report):
        if case.fidelity == "auto":
            return choose(case, scene, zone, work.clock, work.report).after(work.notes)
        work.report("meshing")
        with work.clock.stage("mesh"):
            mesh = make_mesh(case.design, case.fidelity, zone, case.symmetric)
    work.report(f"condensing {len(mesh.cells)} elements")
    model = condense(case.design, mesh, zone, scene)
    work.clock.add(model.timings)
    return Choice(case, model, zone, list(work.notes))


def follow(work: Work, chosen: Choice) -> Followed:
    """The scene's path on a model; "auto" goes on to finite strain where small ones do not do."""
    scene, design, finger = work.scene, chosen.case.design, chosen.model.condensed
    problem = problem_at_touch(chosen.model.reduced, scene.object, design.body)
    work.report("loading")
    with work.clock.stage("increments"):
        if chosen.case.fidelity != "finite":
            finger.prepare_fields(needed=chosen.case.fields)
            with one_thread():
                steps = follow_path(problem, scene, design)
                error = path_error(problem, scene.path, design.gages.face, steps)
            if work.case.fidelity != "auto" or not too_deep(chosen.case, scene, steps):
                return Followed(chosen, problem, steps, error)
            work.note("strains are not small: the path is followed at finite strain, on this mesh")
            chosen = chosen.at_finite_strain(work.notes[-1])
        return Followed(chosen, problem, [*finite_steps(design, finger, scene)])


def lift(work: Work, followed: Followed, sections: Sections | None, second: Second | str) -> Lifted:
    """The grips, and concurrently the slip studies, the gages' measurability, the mesh's error."""
    case, scene, array = followed.chosen.case, work.scene, followed.array
    with work.clock.stage("grips"), one_thread(), ThreadPoolExecutor(1) as thread:
        studies = thread.submit(slip_studies, case, scene, array)
        states = thread.submit(states_seen, case, scene, array, followed.steps)
        error = thread.submit(mesh_error, second, followed, scene)
        work.report("gripping" if case.runs_grips else "reading the gages")
        grips = run_grips(case, rig_of(case, followed.chosen.zone, scene, array))
        measurable = measurability(case.design, states.result(), sections)
    return Lifted(studies.result(), grips, measurable, error.result())


def analyse_into(
    case: Case,
    out: Path,
    show: Progress = silent,
    page: bool | None = None,
    cad: bool | None = None,
    fresh: bool = False,
) -> Result:
    """Run a case and write OUT/NAME; a failure of the work is written as a failed result.

    page, cad: with report.html, with STEP and STL files; None: except in plane strain. A stored
    answer is taken, unless ``fresh``. Raises DesignError for wrong input, and writes nothing then.
    """
    if not fresh and (found := cached_answer(case, out, page, cad)) is not None:
        complete_answer(case, out, page, cad)
        return found
    refuse(case, case.path_scene)
    page, cad = requested_products(case, page, cad)
    clock = Clock()
    report = forecast_progress(case, show, clock)
    with RESULTS.written(out / case.design.design.name) as folder:
        try:
            with products_begun(case.design, folder, clock, page, cad):
                analysis = run(case, report, clock)
        except (FingerDesignError, MemoryError) as error:
            analysis = failed_analysis(case, error, clock)
        report("writing the report" if page else "writing the results")
        result = write_analysis(analysis, case.design, folder, clock, page)
        cache_answer(case, folder, result)
    return result
