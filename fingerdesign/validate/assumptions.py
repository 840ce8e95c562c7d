"""Assumptions, and the two models that show the cost of each.

Each assumption is a function of the shared solves that returns its comparisons, or raises
NotTestable with the reason why this design and scene cannot tell.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.fidelity.models import Plates, Solved
from fingerdesign.analysis.fidelity.rungs import can_be_sheets, can_extrude
from fingerdesign.analysis.path import steps_sideways
from fingerdesign.analysis.stages import slip_studies
from fingerdesign.checks.meshing import plane_strain_faults
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design, Part
from fingerdesign.errors import FingerDesignError
from fingerdesign.layout.fitting import gage_fit
from fingerdesign.layout.leads import leads_as_cast
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mesh.section.section import sheet_room_faults
from fingerdesign.runtime.threads import one_thread
from fingerdesign.validate.comparison import Answer, answer_of, compare, compare_gages
from fingerdesign.validate.record import ComparisonData, Kind
from fingerdesign.validate.solves import FINER_SECTION, FINER_SPACE, Reader, Solves

Pairs = list[ComparisonData]
PairsOf = Callable[[Solves, bool], Pairs]
ASSUMPTIONS: list["Assumption"] = []  # in the order in which they are reported

NU_LIKELY, NU_BAND = (0.45, 0.4999), 0.05  # rubber's; another material's nu: so much either way
RUBBER_FROM = 0.4
E_BAND = 0.2
KELVIN = 10.0  # warmer than when gages were zeroed
LEFT = 0.75  # of the modulus, of rubber that has relaxed as casting silicones may
POINT = 0.05  # of the gage's length and width: short enough to be a point, long enough to round


class NotTestable(FingerDesignError):
    """This design or scene cannot tell what the assumption costs; the message says why."""


@dataclass(frozen=True)
class Assumption:
    """One assumption: its key in validate.json, by which templates/assumptions.toml names it.

    kind: "model", a cheaper model; "value", one that the source did not give; "reading", how a gage
    is read off one model. pairs: the comparisons.
    """

    key: str
    kind: Kind
    pairs: PairsOf


def _assumption(kind: Kind) -> Callable[[PairsOf], PairsOf]:
    """Register a function as what compares for the assumption of its name."""

    def registered(pairs: PairsOf) -> PairsOf:
        ASSUMPTIONS.append(Assumption(pairs.__name__, kind, pairs))
        return pairs

    return registered


def section_why_not(design: Design, scene: Scene) -> str | None:
    """Reason why plane strain cannot show this design in this scene; None where it can."""
    if design.body.kind.turned:
        return "a turned body has no section that is like the whole"
    if steps_sideways(scene):
        return "the scene is not the same in every section: it needs three dimensions"
    faults = plane_strain_faults(design) or sheet_room_faults(design)
    return f"{faults[0].key} = {faults[0].value} cannot be shown by a section" if faults else None


@_assumption("model")
def plane_strain(solves: Solves, deep: bool) -> Pairs:
    why = section_why_not(solves.design, solves.scene)
    if why is not None:
        raise NotTestable(why)
    # The finger in space first: whatever is solved first pays for loading the libraries.
    truth = answer_of(solves.space(), "3-D")
    flat = answer_of(solves.section(solves.scale), "plane strain")
    return [compare("plane strain", flat, truth, solves.scene)]


@_assumption("reading")
def gage_depth_average(solves: Solves, deep: bool) -> Pairs:
    """The mean over the plate's whole span against the gage's own width."""
    _needs_plates(solves.design, ", so no gages")
    reader, gages, span = solves.reader(), solves.design.gages, _span(solves.design)
    truth = _read(reader, f"{gages.width_mm:g} mm wide at z = {gages.z_mm:g} mm")
    wide = reader.read(gages.model_copy(update={"width_mm": span, "z_mm": 0.0}))
    found = replace(truth, name=f"{span:g} mm wide", readings=wide)
    return [compare_gages(f"{span:g} mm wide for {gages.width_mm:g} mm", found, truth)]


def _read(reader: Reader, name: str) -> Answer:
    return replace(answer_of(reader.solved, name), readings=reader.own)


@_assumption("model")
def plate_span(solves: Solves, deep: bool) -> Pairs:
    design = solves.design
    _needs_plates(design)
    if design.plates.model == "none":
        raise NotTestable("plates.model = none: the plates are left out of the model")
    if not design.body.straight:
        raise NotTestable("plates of full span are compared for straight bodies alone")
    if design.plates.placement is not None or design.plates.rows:
        raise NotTestable("plates placed one by one, or in rows, have no one span")
    if design.plates.along == "z":
        raise NotTestable("plates along z do not span the depth")
    depth = design.body.depth_mm
    full = {"plates.span_mm": None, "plates.span_offset_mm": 0.0, "plates.stagger_mm": 0.0}
    if design.extruded:
        half = {"plates.span_mm": 0.5 * depth}
        found, truth = solves.space(), solves.space(values=half)
        label = f"span {depth:g} mm (the design's, full) against {0.5 * depth:g} mm"
    else:
        found, truth = solves.space(values=full), solves.space()
        label = f"span {depth:g} mm (full) against the design's {_span(design):g} mm"
    return [_solved_pair(label, found, truth, solves)]


@_assumption("model")
def small_strain(solves: Solves, deep: bool) -> Pairs:
    # Sheets are not known at finite strain: solid plates stand for them.
    plates: Plates | None = "solid" if solves.design.plates.model == "sheet" else None
    why = section_why_not(solves.design, solves.scene)
    if why is not None and not deep:
        raise NotTestable(f"{why}; --deep tests it in three dimensions")
    models: dict[str, Callable[..., Solved]] = {"3-D": solves.space} if deep else {}
    if why is None:
        models = {"plane strain": solves.section, **models}
    found = []
    for name, solved in models.items():
        small = solves.in_single_increments(solved(plates=plates))
        found.append(compare(name, answer_of(small), solves.finite(small), small.scene))
    return found


def _of_body(design: Design, constant: str) -> tuple[str, float]:
    """The dotted key of a constant of the body's material, and its value."""
    value: float = getattr(design.material_of("body"), constant)
    return f"materials.{design.body.material}.{constant}", value


def nu_values(design: Design) -> tuple[float, float]:
    """Poisson's ratios that the assumed one is held against."""
    given = design.material_of("body").poissons_ratio
    if given >= RUBBER_FROM:
        return NU_LIKELY
    return max(0.0, round(given - NU_BAND, 6)), round(given + NU_BAND, 6)


@_assumption("value")
def poissons_ratio(solves: Solves, deep: bool) -> Pairs:
    key, given = _of_body(solves.design, "poissons_ratio")
    values = [value for value in nu_values(solves.design) if abs(value - given) > 1e-9]
    return [_varied(f"nu {value:g} for {given:g}", {key: value}, solves) for value in values]


@_assumption("value")
def youngs_modulus(solves: Solves, deep: bool) -> Pairs:
    key, given = _of_body(solves.design, "youngs_modulus_MPa")
    values = [round(given * factor, 9) for factor in (1.0 - E_BAND, 1.0 + E_BAND)]
    return [_varied(f"E {value:g} for {given:g} MPa", {key: value}, solves) for value in values]


@_assumption("model")
def relaxation(solves: Solves, deep: bool) -> Pairs:
    """Fresh rubber's answers times what relaxing has left, against rubber of the modulus left.

    Plates do not relax: that is what the shortcut leaves out (contact/memory.py).
    """
    key, given = _of_body(solves.design, "youngs_modulus_MPa")
    truth = answer_of(solves.space(values={key: LEFT * given}), f"rubber of {LEFT * given:g} MPa")
    fresh = answer_of(solves.space(), f"{LEFT:g} times fresh rubber's")
    found = replace(fresh, readings=fresh.readings.times(LEFT), along=None)
    return [compare(f"{LEFT:g} of the modulus left", found, truth, solves.scene)]


@_assumption("value")
def temperature(solves: Solves, deep: bool) -> Pairs:
    """A finger warmer by KELVIN than when its gages were zeroed, all along, against one as warm.

    Rubber and plates expand. Gages are matched to the plates: on a free one they read nothing.
    """
    design = solves.design
    _needs_plates(design, ", so no gages")
    if design.plates.model != "solid":
        raise NotTestable(f"plates.model = {design.plates.model}: solid plates are needed")
    parts: list[Part] = ["body", "plates", "core"] if design.body.core else ["body", "plates"]
    for part in parts:
        if design.expansion_of(part) is None:
            raise NotTestable(f"expansion_per_K of the material of the {part} is not given")
    truth = answer_of(solves.space())
    return [compare(f"{KELVIN:g} K warmer", solves.warmer(KELVIN), truth, solves.scene)]


@_assumption("model")
def sheets(solves: Solves, deep: bool) -> Pairs:
    design = solves.design
    _needs_plates(design)
    if can_extrude(design) and can_be_sheets(design):
        found, truth = solves.space(plates="sheet"), solves.space(plates=_as_solids(design))
        return [_solved_pair("3-D", found, truth, solves)]
    why = section_why_not(design, solves.scene)
    if why is not None:
        raise NotTestable(f"the plates cannot be sheets in layers here, and {why}")
    found, truth = solves.section(plates="sheet"), solves.section(plates=_as_solids(design))
    return [_solved_pair("plane strain", found, truth, solves)]


@_assumption("reading")
def gage_point(solves: Solves, deep: bool) -> Pairs:
    """The strain at the gage's middle against its mean over length and width."""
    _needs_plates(solves.design, ", so no gages")
    reader, gages = solves.reader(), solves.design.gages
    truth = _read(reader, f"mean over {gages.length_mm:g} x {gages.width_mm:g} mm")
    small = {"length_mm": POINT * gages.length_mm, "width_mm": POINT * gages.width_mm}
    found = replace(truth, name="a point", readings=reader.read(gages.model_copy(update=small)))
    return [compare_gages("a point for the gage's face", found, truth)]


@_assumption("model")
def leads(solves: Solves, deep: bool) -> Pairs:
    """The finger without leads against itself with them as it is wired when it is cast; and without
    its gages' own stiffness, where ``gages.kind`` has one."""
    design = solves.design
    _needs_plates(design, ", so no leads")
    if design.plates.model == "none":
        raise NotTestable("plates.model = none: the plates are left out of the model")
    fit = gage_fit(design)
    wired = leads_as_cast(design, fit.found if fit else None).model_dump()
    own = solves.space(values={f"gages.leads.{key}": value for key, value in wired.items()})
    without = solves.space(values={"gages.leads.kind": "none"})
    ranks = " and ".join(_rank_words(each) for each in (without, own))
    label = f"leads left out (rank correlation {ranks} with them)"
    found = [_solved_pair(label, without, own, solves)]
    if design.gage_type is not None and design.gage_type.stiffness:
        gone = solves.space(values={"gages.kind": None, "gages.gage_factor": design.gage_factor})
        found.append(_solved_pair("gages left out", gone, solves.space(), solves))
    return found


def _rank_words(solved: Solved) -> str:
    """Least rank correlation of the gage area with the stick area over the frictions studied."""
    case = Case(solved.design, grips=False, fields=False)
    with one_thread():
        studies = slip_studies(case, solved.scene, solved.problem)
    ranks = [each.rank_correlation for each in studies if each.rank_correlation is not None]
    return f"{min(ranks):.2f}" if ranks else "unknown"


@_assumption("model")
def plates_left_out(solves: Solves, deep: bool) -> Pairs:
    _needs_plates(solves.design)
    found, truth = solves.space(plates="none"), solves.space(plates=_as_solids(solves.design))
    return [_solved_pair("3-D", found, truth, solves)]


@_assumption("model")
def discretisation(solves: Solves, deep: bool) -> Pairs:
    found = []
    if section_why_not(solves.design, solves.scene) is None:
        pair = solves.section(), solves.section(FINER_SECTION)
        found.append(_solved_pair("plane strain", *pair, solves))
    if solves.design.mesh.mesher != "file" or can_extrude(solves.design):
        found.append(_solved_pair("3-D", solves.space(), solves.space(FINER_SPACE), solves))
    if not found:
        raise NotTestable("mesh.mesher = 'file': there is no finer mesh than the file's")
    return found


def _solved_pair(label: str, found: Solved, truth: Solved, solves: Solves) -> ComparisonData:
    return compare(label, answer_of(found), answer_of(truth), solves.scene)


def _varied(label: str, values: dict[str, object], solves: Solves) -> ComparisonData:
    """Change of the answers where a value is another one, relative to those with the assumed."""
    found = answer_of(solves.space(values=values), label)
    return compare(label, found, answer_of(solves.space()), solves.scene)


def _as_solids(design: Design) -> Plates | None:
    """None where the design's plates are solids anyway: that model serves other rows too."""
    return None if design.plates.model == "solid" else "solid"


def _needs_plates(design: Design, hence: str = "") -> None:
    if not design.plates.number:
        raise NotTestable(f"the design has no plates{hence}")


def _span(design: Design) -> float:
    return min(frame.span for frame in plate_frames(design))
