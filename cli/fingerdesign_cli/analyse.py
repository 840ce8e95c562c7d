"""``fingerdesign analyse`` and ``grip``: from design files to results and reports."""

import shlex
from collections import Counter
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import click
from click.core import ParameterSource

from fingerdesign.analysis.answers import DESIGN, PAGE, cached_answer, is_cached, missing
from fingerdesign.analysis.case import TOLERANCE, Case
from fingerdesign.analysis.page.tables import detail_tables
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.faults import undexed
from fingerdesign.design.scene import Scene, SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import load_scene
from fingerdesign.errors import DesignError, Fault
from fingerdesign.mesh.section.netgen import start_mesher
from fingerdesign.records.result import GripResult, Result
from fingerdesign.records.result_files import RESULTS
from fingerdesign.runtime.progress import Progress
from fingerdesign_cli import inputs, terminal
from fingerdesign_cli.options import Options

# The columns of the table of grips; those without any value are left out.
_HEADINGS = ("g", "μ", "ends", "F_n N", "margin", "stick", "pauses", "stick error", "slip warning")
_LEGEND = (
    "pauses: the hand waited, pressing; slip warning: time before complete slip; false: at a "
    "stick ratio well above the threshold; withdrawn: the warning ended before the slip"
)
_ENDED = {"stage travel": "travel ends", "steps": "steps end"}


@dataclass(frozen=True)
class Products(Options):
    """Optional parts of a result, None: all but in plane strain. fresh: analysed again, also where
    the answer is cached."""

    page: bool | None
    cad: bool | None
    fresh: bool


@dataclass(frozen=True)
class Run(Options):
    """The model of an analysis, and its scene."""

    scene_file: Path | None
    fidelity: str
    accuracy: float | None
    mesher: str | None
    go_on: bool

    def model(self) -> str:
        """The fidelity; an accuracy takes "auto". UsageError where another was given with one."""
        if self.accuracy is None or self.fidelity == "auto":
            return self.fidelity
        if click.get_current_context().get_parameter_source("fidelity") is ParameterSource.DEFAULT:
            return "auto"
        raise click.UsageError("--accuracy belongs to --fidelity auto; add that or leave it")

    def case(self, design: Design, scene: Scene | None) -> Case:
        """The analysis of a design in the scene of the file."""
        if self.mesher is not None:
            design = with_values(design, {"mesh.mesher": self.mesher})
        name, model = "" if self.scene_file is None else self.scene_file.stem, self.model()
        tolerance = TOLERANCE if self.accuracy is None else self.accuracy
        return Case(
            design, scene, model, name, go_on=self.go_on, tolerance=tolerance, mesh_error=True
        )


@dataclass(frozen=True)
class Lift(Options):
    """Values that replace those of the design's [grip] table."""

    controller: str | None
    frictions: tuple[float, ...]
    mass_g: float | list[float] | None
    scene_file: Path | None

    def surface(self) -> SceneObject | None:
        """The object of the scene's file, whose friction the grips meet. UsageError with --friction
        too, DesignError for an object that is no level plane."""
        if self.scene_file is None:
            return None
        if self.frictions:
            raise click.UsageError("--friction and --scene both give the friction; leave one")
        found = load_scene(self.scene_file).object
        if found.shape != "plane" or found.tilt_deg:
            bound, remedy = "a level plane, as grips lift it", "leave out shape, tilt and turn"
            raise DesignError([Fault("object.shape", found.shape, bound, remedy)])
        return found

    def given(self) -> dict[str, tuple[str, object]]:
        """Options that were given, with their values, by the key that each sets."""
        options = {
            "grip.controller": ("--controller", self.controller),
            "grip.friction_coefficients": ("--friction", list(self.frictions) or None),
            "grip.object_mass_g": ("--mass-g", self.mass_g),
        }
        return {key: option for key, option in options.items() if option[1] is not None}


def analyse(designs: tuple[Path, ...], out: Path, run: Run, products: Products) -> int:
    """Analyse each DESIGN: contact, gages, grips, and a result in OUT/NAME."""
    run.model()  # refuses what does not go together
    cases = _read(designs, run, out, products.fresh)
    results: list[Result] = []
    for done, case in enumerate(cases):
        name = case.design.design.name
        stored = f"{done} of {len(cases)} results are stored" if done else ""
        with inputs.interrupted(stored), terminal.progress(name) as show:
            part = terminal.part_of(show, done, len(cases))
            results.append(answer_of(case, out, part, products))
    _report(results, out, [str(path) for path in designs])
    for result in results:
        terminal.open_page(out / result.design / PAGE)
    return 0 if all(result.status == "ok" for result in results) else 1


def answer_of(case: Case, out: Path, show: Progress, products: Products) -> Result:
    """Write OUT/NAME from the cached answer, or by an analysis, which alone loads the solvers."""
    page, cad = (True if terminal.opens() else products.page), products.cad
    found = None if products.fresh else cached_answer(case, out, page, cad)
    if found is not None:
        show("analysed before: its answer is taken (analyse --fresh analyses it again)")
        if any(missing(case, out, page, cad)):
            from fingerdesign.analysis.folder import complete_answer

            complete_answer(case, out, page, cad)
        return found
    from fingerdesign.pipeline import analyse_into

    with inputs.folders_above(out / case.design.design.name):
        return analyse_into(case, out, show, page, cad, fresh=True)


def _read(designs: tuple[Path, ...], run: Run, out: Path, fresh: bool) -> list[Case]:
    """Every fault of every file, of each design in its scene, and of --out, before any work."""
    wrong: list[DesignError] = []
    cases: list[Case] = []
    scene = None
    with inputs.collected(wrong):
        scene = None if run.scene_file is None else load_scene(run.scene_file)
    for path in designs:
        with inputs.collected(wrong):
            cases.append(run.case(load_design(path), scene))
            if cases[-1].runs_grips:
                hand, fidelity = cases[-1].design.grip.controller, cases[-1].fidelity
                inputs.estimator_for(cases[-1].design, None, fidelity, [hand])
    for case in cases:
        with inputs.collected(wrong):
            if fresh or not is_cached(case):
                _refuse_impossible(case)
        with inputs.collected(wrong):
            inputs.refuse_foreign(RESULTS, out / case.design.design.name)
    counts = Counter(case.design.design.name for case in cases)
    remedy = "rename: it names the folder"
    faults = [
        Fault("design.name", name, "different in each file", remedy)
        for name in sorted(name for name, count in counts.items() if count > 1)
    ]
    if wrong or faults:
        raise DesignError.together([*wrong, DesignError(faults)])
    for path, case in zip(designs, cases, strict=True):
        _say_replaced(path, case.design.design.name, out)
    return cases


def _say_replaced(path: Path, name: str, out: Path) -> None:
    """Warn where a file of another name than its design's replaces a result of that name."""
    if path.stem != name and (out / name).exists() and not terminal.quiet():
        remedy = "set design.name to keep both"
        click.echo(f"{path} has design.name {name!r}: it replaces {out / name}; {remedy}", err=True)


def _refuse_impossible(case: Case) -> None:
    """DesignError for what this machine cannot analyse; the mesher loads meanwhile."""
    if case.fidelity == "plane-strain":
        start_mesher()
    from fingerdesign.analysis.forecast.limits import refuse

    refuse(case, case.path_scene)


def _report(results: list[Result], out: Path, files: list[str]) -> None:
    def show() -> None:
        for result, file in zip(results, files, strict=True):
            _show(result, out / result.design, file)

    if terminal.quiet() and not terminal.as_json():
        for each in results:
            _say_failure(each)
    terminal.say_result(lambda: [_facts(each, out) for each in results], show)


def _facts(result: Result, out: Path) -> dict[str, object]:
    """The outcome of an analysis, for scripts."""
    facts = {key: getattr(result, key) for key in ("design", "status", "failure")}
    reached = {"reached": result.ladder.reached} if result.ladder else {}
    return {**facts, "folder": str(out / result.design), **reached}


def _say_failure(result: Result) -> None:
    if result.failure:
        click.echo(f"{result.design} failed: {result.failure}", err=True)


def _show(result: Result, folder: Path, file: str) -> None:
    """The result as a block; file: of its design, as the user named it. With --details all that
    the block leaves out: the model, each warning, tables of numbers."""
    terminal.say_block(verdict_view(result, shlex.quote(file)), folder)
    if not terminal.details():
        return
    if result.ladder:
        click.echo(f"{result.ladder.chosen}; {result.ladder.models[-1].why}")
    terminal.say_details(result.warnings, detail_tables(result))


def grip(
    design_file: Path,
    out: Path,
    lift: Lift,
    fidelity: str,
    estimator_file: Path | None,
    go_on: bool,
    products: Products,
) -> int:
    """Lift an object with DESIGN by the design's [grip] table, once per friction coefficient."""
    design, _ = inputs.read_case(design_file)
    inputs.all_sound(partial(_with_options, design, lift.given()), lift.surface)
    design, surface = _with_options(design, lift.given()), lift.surface()
    _refuse_relaxing(design, surface)
    if design.plates.number < 2:
        remedy = "add plates: without gages there is nothing to feel"
        raise DesignError([Fault("plates.count", design.plates.number, "at least 2", remedy)])
    inputs.refuse_foreign(RESULTS, out / design.design.name)
    estimator = inputs.estimator_for(design, estimator_file, fidelity, [design.grip.controller])
    with terminal.progress(design.design.name) as show:
        case = Case(design, None, fidelity, go_on=go_on, estimator=estimator, surface=surface)
        result = answer_of(case, out, show, products)
    if result.failure and not terminal.as_json():
        _say_failure(result)
    facts = _facts(result, out) | {"grips": [asdict(each) for each in result.grips]}
    page = out / result.design / PAGE
    # The design next to the result has the controller of the option.
    file = out / result.design / DESIGN if lift.controller else design_file
    terminal.say_result(lambda: facts, partial(_show_grips, result, out, str(file)), page)
    return 0 if result.status == "ok" else 1


def _refuse_relaxing(design: Design, surface: SceneObject | None) -> None:
    """DesignError where rubber relaxes under a law whose bounds do not scale with forces."""
    if surface is None or surface.law.is_coulomb:
        return
    bound, remedy = f"left out for friction_law '{surface.friction_law}'", "remove it"
    own = {name: getattr(design.grip, name) for name in ("relaxation_per_minute", "rubber_memory")}
    faults = [Fault(f"grip.{name}", value, bound, remedy) for name, value in own.items() if value]
    if faults:
        raise DesignError(faults)


def _with_options(design: Design, given: dict[str, tuple[str, object]]) -> Design:
    """Set the keys of options; their faults name the option."""
    if not given:
        return design
    try:
        return with_values(design, {key: value for key, (_, value) in given.items()})
    except DesignError as error:
        faults = [
            replace(f, key=f"{given[key][0]} ({f.key})") if (key := undexed(f.key)) in given else f
            for f in error.faults
        ]
        raise DesignError(faults) from None


def _show_grips(result: Result, out: Path, file: str) -> None:
    if result.failure:
        return
    first = result.grips[0]
    one = len({grip.object_mass_g for grip in result.grips}) == 1
    mass = f"{first.object_mass_g:g} g, " if one else ""
    rows = [_row(grip) for grip in result.grips]
    shown = [k for k in range(len(_HEADINGS)) if any(row[k] not in ("-", "") for row in rows)]
    shown = shown[one:]
    cells = [[row[k] for k in shown] for row in rows]
    headings = [_HEADINGS[k] for k in shown]
    terminal.print_table(
        f"{result.design}: {mass}{first.controller}", headings, cells, terminal.WIDTH
    )
    _explain(result)
    _show(result, out / result.design, file)


def _explain(result: Result) -> None:
    """Lines below the table of grips: what they are one draw of, and its columns."""
    if result.parameters.get("grip.hardware.gage_noise_microstrain"):
        terminal.say_marked("", "one draw of noise (grip.seed); `fingerdesign study` gives rates")
    if terminal.details():
        terminal.say_marked("", _LEGEND)


def _row(grip: GripResult) -> list[str]:
    ends = {"caught": grip.caught, "slips": grip.gross_slip, "lifted": grip.lifted}
    return [
        f"{grip.object_mass_g:g}",
        f"{grip.friction_coefficient:g}",
        next(
            (word for word, is_so in ends.items() if is_so),
            _ENDED.get(f"{grip.outcome}", "not lifted"),
        ),
        terminal.number(grip.final_normal_force_N),
        terminal.number(grip.safety_margin),
        terminal.number(grip.minimum_stick_ratio),
        f"{grip.holds}",
        terminal.number(grip.stick_error, 3),
        _warned(grip),
    ]


def _warned(grip: GripResult) -> str:
    """Time and part of F_t at which the controller warned of complete slip; its false alarms."""
    words = {"withdrawn": "withdrawn", "none": "none"}.get(grip.slip_warning or "", "-")
    if grip.lead_s is not None:
        words = (
            f"{grip.lead_s:.2f} s before, {terminal.number(grip.lead_force_share, 0, 100.0)} % F_t"
        )
    return f"{words}; {grip.false_alarms} of {grip.alarms} false" if grip.alarms else words
