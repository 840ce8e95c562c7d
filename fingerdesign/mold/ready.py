"""Ready as a sensor: the one place that decides it, and the lines that make it so.

A cast finger is a sensor where it has plates; where a gage that is sold or quoted lies on each of
them (the one that notes and bill are about); where plates off their places change no reading by
more than MOST_ERROR; and where its leads change none by more than leads.MOST. What is not known is
not ready.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fingerdesign.design.schema import Design
from fingerdesign.design.stock import GageType
from fingerdesign.layout.fitting import GageFit, gage_words
from fingerdesign.layout.leads import thin_bundle, traces_possible
from fingerdesign.mold.leads import MOST
from fingerdesign.mold.products.notes import placement_worst

# Of the largest reading: beyond it a gage's reading says less than a fifth more about the object
# than about where its plate came to stand, and no calibration of one gage mends its neighbours.
MOST_ERROR = 0.2
_LEG = ('mold.leads = "leg"',)

Reason = tuple[str, Sequence[str]]  # why it is not ready; lines for the design that mend it


def sensor_of(
    design: Design,
    fit: GageFit | None,
    placement: Mapping[str, Any] | None,
    leads: Mapping[str, Any] | None,
) -> dict[str, Any]:
    """Judge if a finger's gages can be had and read what the model computes, as cast."""
    found = [
        *(() if fit is None else _placed(design, placement)),
        *_gage(design, fit),
        *(() if fit is None else _led(design, fit.found, leads)),
    ]
    known = placement is not None and placement.get("reason") is None and fit is not None
    wired = leads is not None and leads.get("reason") is None and fit is not None
    return {
        "ready": not found,
        "reading_error": placement_worst(placement) if known else None,
        "lead_error": leads["reading_error"] if wired and leads is not None else None,
        "gage": None if fit is None or fit.found is None else fit.found.name,
        "reasons": [reason for reason, _ in found],
        "fix": list(dict.fromkeys(line for _, lines in found for line in lines)),
    }


def _gage(design: Design, fit: GageFit | None) -> Iterator[Reason]:
    """No plates, no gage on them, or one that nobody sells or quotes."""
    if fit is None:
        yield "the finger has no plates, so it is no sensor", ["plates.count = 9"]
        return
    if fit.found is None:
        yield gage_words(design, fit) or "", _gage_lines(design, fit)
        return
    wrong = not_offered(fit.found)
    if wrong:
        yield f"{fit.found.name} is neither sold nor quoted: {wrong}", ["mold.gage = 'auto'"]
    elif fit.differs_from(design):
        grid = {"length": fit.found.grid_length_mm, "width": fit.found.grid_width_mm}
        lines = [f"gages.{side}_mm = {size:g}" for side, size in grid.items()]
        yield gage_words(design, fit) or "", lines


def not_offered(type_: GageType) -> str:
    """What a type's entry lacks to be ordered; "": nothing."""
    lacking = {"source": type_.source, "price": type_.price, "lead_weeks": type_.lead_weeks}
    return ", ".join(f"no {key}" for key, value in lacking.items() if not value)


def _gage_lines(design: Design, fit: GageFit) -> list[str]:
    """The gage that fits the plates as they are; else plates for the nearest one."""
    films = [each for each in design.gage_types if each.name in fit.films]
    film = next((each for each in reversed(films) if not not_offered(each)), None)
    if film is not None:
        return [f'mold.gage = "{film.name}"', *_LEG]
    if fit.others:
        return [f'gages.kind = "{fit.others[0]}"']
    if fit.nearest is None:
        return []
    span = fit.width + 2.0 * abs(design.gages.z_mm)
    lines = [f"plates.length_mm = {fit.length:g}"] if fit.length > fit.room[0] else []
    return lines + ([f"plates.span_mm = {span:g}"] if fit.width > fit.room[1] else [])


def _placed(design: Design, placement: Mapping[str, Any] | None) -> Iterator[Reason]:
    if placement is None or placement.get("reason") is not None:
        words = "what placement does to the gages is not known"
        yield (placement["sentences"][0] if placement else words), []
        return
    error = placement_worst(placement)
    if error > MOST_ERROR:
        machined = design.mold.process == "machined"
        finer = "mold.comb.tolerance_mm = 0.005"
        yield (
            f"plates off their places change a reading by up to {100.0 * error:.0f} % of the "
            f"largest; {100.0 * MOST_ERROR:.0f} % are allowed: a finer process or comb, wider "
            "legs or longer plates place them closer",
            [finer if machined else 'mold.process = "machined"'],
        )


def _led(
    design: Design, type_: GageType | None, leads: Mapping[str, Any] | None
) -> Iterator[Reason]:
    """Leads whose price is not known, is too high, or that cannot run where they are to."""
    if type_ is None:
        return
    course = design.mold.leads
    if course == "leg" and not traces_possible(design, type_):
        words = 'mold.leads = "leg" needs traces: plates of polyimide, or a film gage'
        yield words, [f"mold.wire_mm = {thin_bundle(design):g}", 'mold.leads = "wires"']
    elif type_.to_measure and course != "leg" and design.gages.leads is None:
        yield (
            f"{type_.name} is made on the sheet with its traces, and wires cannot be soldered to "
            "it: lead it out on its legs",
            _LEG,
        )
    elif leads is None or leads["reason"] is not None:
        unknown = "what the leads do to the readings is not known"
        yield (leads["sentences"][0].rstrip(".") if leads and leads["sentences"] else unknown), []
    elif leads["reading_error"] > MOST:
        fixes = leads.get("fixes") or [{"lines": []}]
        yield (
            f"{leads['words']} change a reading by up to {100.0 * leads['reading_error']:.0f} % of "
            f"the largest; {100.0 * MOST:.0f} % are allowed",
            fixes[0]["lines"],
        )
