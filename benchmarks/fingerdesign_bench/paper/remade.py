"""Every figure of the paper, remade for one design: the numbers, and what they say of its words.

    found = remake(load_design("designs/maeno2000.toml"))
    found.claims[0].verdict

Figures 1, 4, 5, 9 and 11 of the paper are drawings of what was built and planned; the others are
made here, in plane strain as there.
"""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from fingerdesign.analysis.case import fundamental_scene, result_digest
from fingerdesign.analysis.path import contact_history, increment_result
from fingerdesign.analysis.slip_study import slip_studies
from fingerdesign.analysis.stages import in_wide_zone, zone_of
from fingerdesign.checks.load import with_values
from fingerdesign.design.schema import Design
from fingerdesign.layout.zone import Zone
from fingerdesign.records.base import ResultError, json_text
from fingerdesign.report.page import render_page
from fingerdesign.report.style import house_style
from fingerdesign.runtime.files import move_into, whole_folder
from fingerdesign.runtime.threads import one_thread
from fingerdesign.version import versions
from fingerdesign_bench.paper import lifts as lifting
from fingerdesign_bench.paper.case import FRICTIONS, PaperCase, build_case, check_case
from fingerdesign_bench.paper.claims import TEMPLATES, Remade, claims_of
from fingerdesign_bench.paper.figures import PaperFigure
from fingerdesign_bench.paper.figures_contact import (
    rectangles_figure,
    responses_figure,
    steps_figure,
    stick_map_figure,
)
from fingerdesign_bench.paper.figures_grips import lifts_figure, measured_figure, route_figure
from fingerdesign_bench.paper.measurement import SAMPLES, SEEDS, Rig, rig_of
from fingerdesign_bench.paper.rectangles import rectangles

Report = Callable[[str, float], None]

PAGE_FILE, RECORD_FILE = "paper.html", "paper.json"
SOFT_MATERIAL = "polyimide"  # Gages on it respond 50 times as much as on bronze.
_FACES = {"both": "both faces read", "upper": "upper face read", "lower": "lower face read"}
ORDER = ("fig02", "fig03", "fig06", "fig07", "fig08", "fig10", "fig12")


def paper_figures(found: Remade) -> list[PaperFigure]:
    """All figures, in :data:`ORDER`."""
    route = next(lift for lift in found.lifts if lift.friction == lifting.ROUTE_FRICTION)
    with house_style():
        made = [
            route_figure(route, found.route),
            rectangles_figure(found.rectangles),
            steps_figure(found.increments),
            stick_map_figure(found.contact, found.increments),
            responses_figure(found.studies, found.friction, found.contact),
            lifts_figure(found.lifts),
            measured_figure(found.rigs, _shown(found.rigs)),
        ]
    assert tuple(figure.key for figure in made) == ORDER
    return made


def paper_html(found: Remade, figures: list[PaperFigure], versions: dict[str, str]) -> str:
    """The page: verdicts first, then each figure with the paper's words about it."""
    claims = {claim.figure: claim for claim in found.claims}
    return render_page(
        TEMPLATES / "paper.html.j2",
        found=found,
        figures=[(figure, claims.get(figure.key)) for figure in figures],
        assumed=found.design.assumed,
        versions=versions,
    )


def _shown(rigs: tuple[Rig, ...]) -> int | None:
    """The fewest samples a step at which a finger lifts with noise; else the most tried."""
    working = [rig.least_samples[-1] for rig in rigs if rig.least_samples]
    noisy = [samples for samples in working if samples is not None]
    levels = rigs[0].levels
    return min(noisy) if noisy else levels[min(1, len(levels) - 1)]


def write_paper(found: Remade, folder: Path) -> list[Path]:
    """All figures, the page and the record in ``folder``; returns the files, the page last.

    They are made aside and moved in one by one, the page at the end: what is there before stays as
    it is until all are made, other files in the folder always. Raises ResultError where they cannot
    be written.
    """
    figures = paper_figures(found)
    folder = folder.absolute()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with whole_folder(folder) as aside:
            made = [path for figure in figures for path in figure.write(aside)]
            made += [aside / RECORD_FILE, aside / PAGE_FILE]
            made[-2].write_text(json_text(record_of(found, figures)), encoding="utf-8")
            made[-1].write_text(paper_html(found, figures, versions()), encoding="utf-8")
            move_into(folder, made)
    except OSError as error:
        raise ResultError(f"cannot write into {folder}: {error}") from error
    return [folder / path.name for path in made]


def record_of(found: Remade, figures: list[PaperFigure]) -> dict[str, Any]:
    """The content of paper.json."""
    return {
        "design": found.design.design.name,
        "digest": result_digest(found.design, fundamental_scene(), "paper"),
        "fidelity": "plane-strain",
        "dofs": found.dofs,
        "assumed": list(found.design.assumed),
        "claims": [asdict(claim) for claim in found.claims],
        "figures": [
            {
                "key": figure.key,
                "title": figure.shown.title,
                "words": figure.shown.alternative,
                "files": [f"{figure.key}.{kind}" for kind in ("png", "svg", "csv")],
            }
            for figure in figures
        ],
        "seeds": {"grip": found.design.grip.seed, "rig": list(range(SEEDS))},
        "seconds": round(found.seconds, 3),
        "versions": versions(),
    }


@dataclass(frozen=True)
class Effort:
    """The amount of work: frictions of Fig. 8 (the scene's among them), samples a step and
    seeds of Fig. 12. The default is what the page is made with."""

    frictions: tuple[float, ...] = FRICTIONS
    samples: tuple[int, ...] = SAMPLES
    seeds: int = SEEDS


def remake(
    design: Design,
    report: Report = lambda message, fraction: None,
    effort: Effort = Effort(),  # it is frozen
) -> Remade:
    """Make all figures' numbers. Raises DesignError for a design without an array of gages or that
    has no section, another FingerDesignError where a stage fails."""
    start = time.perf_counter()
    scene = fundamental_scene()
    case = check_case(design, scene)
    zone = zone_of(case, scene)

    def work(zone: Zone) -> Remade:
        with one_thread():
            report("condensing the finger, with plates and without", 0.02)
            return _remade(build_case(design, scene, zone), zone, report, effort)

    found = in_wide_zone(design, zone, work, lambda message: report(message, 0.0))
    found = replace(found, seconds=time.perf_counter() - start)
    return replace(found, claims=claims_of(found))


def _remade(case: PaperCase, zone: Zone, report: Report, effort: Effort) -> Remade:
    report("Figs 6 and 7: the eight steps", 0.2)
    steps = case.steps(case.finger)
    report("Fig. 3: rectangles near the surface", 0.25)
    turned = rectangles(case)
    report("Fig. 8: gage area and stick area", 0.3)
    share = case.design.gages.area_share
    studies = slip_studies(case.finger, case.rows, case.face, effort.frictions, share=share)
    report("Figs 2 and 10: lifts", 0.5)
    grips = tuple(lifting.lifts(case))
    route = lifting.squeeze(case)
    report("Fig. 12: lifts on a rig", 0.6)
    material = case.design.plates.material
    name = f"{material.replace('_', ' ')}, {_FACES[case.face]}"
    rigs = [rig_of(case, name, effort.samples, effort.seeds)]
    if (material, case.face) != (SOFT_MATERIAL, "both"):
        report("Fig. 12: the same with plates of polyimide, both faces read", 0.8)
        soft = {"plates.material": SOFT_MATERIAL, "gages.face": "both"}
        softer = build_case(with_values(case.design, soft), case.scene, zone)
        soft_name = f"{SOFT_MATERIAL}, {_FACES['both']}"
        rigs.append(rig_of(softer, soft_name, effort.samples, effort.seeds))
    return Remade(
        design=case.design,
        dofs=case.dofs,
        friction=case.friction,
        increments=tuple(increment_result(step, case.face) for step in steps),
        contact=contact_history(case.finger, steps),
        rectangles=turned,
        studies=studies,
        lifts=grips,
        route=route,
        rigs=tuple(rigs),
        seconds=0.0,
    )
