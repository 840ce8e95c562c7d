"""Ready as a sensor: the one place that decides it, and the lines that make it so.

A cast finger is a sensor where it has plates; where a gage that is sold or quoted lies on each of
them (the one that notes and bill are about); where plates off their places change no reading by
more than MOST_ERROR; and where its leads change none by more than leads.MOST. What is not known is
not ready.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fingerdesign.checks.load import with_values
from fingerdesign.design.keys import leaves
from fingerdesign.design.schema import Design
from fingerdesign.design.stock import GageType
from fingerdesign.errors import DesignError
from fingerdesign.layout.fitting import GageFit, gage_fit, gage_words
from fingerdesign.layout.leads import thin_bundle, traces_possible
from fingerdesign.mold.leads import MOST
from fingerdesign.mold.placement import placement_effect
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.products.notes import percent, placement_worst

# Of the largest reading: beyond it a gage's reading says less than a fifth more about the object
# than about where its plate came to stand, and no calibration of one gage mends its neighbours.
MOST_ERROR = 0.2
Values = Mapping[str, float | str]
_LEG: Values = {"mold.leads": "leg"}
# Changes of the mold that place plates closer, the least effort first.
_MACHINED, _FINE = {"mold.process": "machined"}, {"mold.comb.tolerance_mm": 0.005}
_FINER: tuple[Values, ...] = (_FINE, _MACHINED, {**_MACHINED, **_FINE})
_NO_FINER = (
    ": no finer process or comb does; plates that leave through a flat face, wider legs "
    "(mold.leg_mm) or longer plates are placed closer"
)

_SMALLER = (0.8, 0.6, 0.4)  # grids of film, over the design's

Reason = tuple[str, Sequence[str]]  # why it is not ready; lines for the design that mend it


def sensor_of(
    design: Design,
    fit: GageFit | None,
    placement: Mapping[str, Any] | None,
    leads: Mapping[str, Any] | None,
) -> dict[str, Any]:
    """Judge if a finger's gages can be had and read what the model computes, as cast.

    "fix": lines for the design that end every reason; none where one of them has no such lines.
    """
    found, type_ = list(_gage(design, fit)), None
    if fit is not None:
        type_ = fit.found
        found = [*_placed(placement), *found, *_led(design, type_, leads)]
    fix = list(dict.fromkeys(line for _, lines in found for line in lines))
    return {
        "ready": not found,
        "reading_error": placement_worst(placement) if fit and _is_known(placement) else None,
        "lead_error": leads["reading_error"] if fit and leads and _is_known(leads) else None,
        "gage": None if type_ is None else type_.name,
        "to_measure": type_ is not None and type_.to_measure,
        "reasons": [reason for reason, _ in found],
        "fix": fix if all(lines for _, lines in found) else [],
    }


def _is_known(effect: Mapping[str, Any] | None) -> bool:
    """True where an effect on the readings was computed."""
    return effect is not None and effect.get("reason") is None


def _gage(design: Design, fit: GageFit | None, search: bool = True) -> Iterator[Reason]:
    """No plates, no gage on them, or one that nobody sells or quotes; with lines that mend it where
    these are to be searched."""
    if fit is None:
        yield "the finger has no plates, so it is no sensor", ["plates.count = 9"]
        return
    if fit.found is None:
        yield gage_words(design, fit) or "", _gage_lines(design, fit) if search else []
        return
    wrong = not_offered(fit.found)
    if wrong:
        yield f"{fit.found.name} is neither sold nor quoted: {wrong}", ["mold.gage = 'auto'"]
    elif design.gages.kind not in (None, fit.found.name):
        words = f"gages.kind = {design.gages.kind!r} is read, but mold.gage = {fit.found.name!r} is"
        yield f"{words} cast", [f'gages.kind = "{fit.found.name}"']
    elif fit.differs_from(design):
        grid = {"length": fit.found.grid_length_mm, "width": fit.found.grid_width_mm}
        lines = [f"gages.{side}_mm = {size:g}" for side, size in grid.items()]
        yield gage_words(design, fit) or "", lines


def not_offered(type_: GageType) -> str:
    """Name what a type's entry lacks to be ordered; "": nothing."""
    lacking = {"source": type_.source, "price": type_.price, "lead_weeks": type_.lead_weeks}
    return ", ".join(f"no {key}" for key, value in lacking.items() if not value)


def _gage_lines(design: Design, fit: GageFit) -> list[str]:
    """The first lines that give plates a gage: film on them as they are, another type, film on a
    smaller grid, larger plates; none where none of these makes a sound design."""
    made = [each.name for each in design.gage_types if each.to_measure and not not_offered(each)]
    films: list[Values] = [{"mold.gage": name, **_LEG} for name in reversed(made)]
    tried = [*films, *({"gages.kind": name} for name in fit.others[:1])]
    for share in _SMALLER:
        sizes = {"length": design.gages.length_mm, "width": design.gages.width_mm}
        small = {f"gages.{side}_mm": round(share * size, 2) for side, size in sizes.items()}
        tried += [{**small, **film} for film in films]
    if fit.nearest is not None:
        sizes = {"length": fit.length, "span": fit.width + 2.0 * abs(design.gages.z_mm)}
        grows = (fit.length > fit.room[0], fit.width > fit.room[1])
        larger = zip(sizes.items(), grows, strict=True)
        tried.append({f"plates.{side}_mm": size for (side, size), more in larger if more})
    taken = next((values for values in tried if _takes_gage(design, values)), {})
    own = dict(leaves(design.model_dump(mode="json")))
    return _lines({key: value for key, value in taken.items() if own.get(key) != value})


def _takes_gage(design: Design, values: Values) -> bool:
    """True where a design with other values has a mold, and a gage on offer fits its plates."""
    try:
        changed = with_values(design, dict(values))
        if list(_gage(changed, gage_fit(changed), search=False)):
            return False
        plan_mold(changed)
    except DesignError:
        return False
    return True


def _lines(values: Values) -> list[str]:
    """Values by their keys as lines of a design file.

    >>> _lines({"mold.leads": "leg", "gages.width_mm": 0.6})
    ['mold.leads = "leg"', 'gages.width_mm = 0.6']
    """
    return [
        f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value:g}"
        for key, value in values.items()
    ]


def placement_with_fixes(design: Design, plan: MoldPlan) -> dict[str, Any]:
    """placement_effect, and where it is above MOST_ERROR "fixes": lines of the mold's own keys that
    were tried and bring it below, with what is left ("reading_error")."""
    found = placement_effect(design, plan)
    if placement_worst(found) <= MOST_ERROR:
        return found
    for values in _FINER:
        try:
            changed = with_values(design, dict(values))
            left = placement_worst(other := placement_effect(changed, plan_mold(changed)))
        except DesignError:
            continue
        if other["reason"] is None and left <= MOST_ERROR:
            return found | {"fixes": [{"lines": _lines(values), "reading_error": left}]}
    return found | {"fixes": []}


def _placed(placement: Mapping[str, Any] | None) -> Iterator[Reason]:
    if placement is None or placement.get("reason") is not None:
        words = "what placement does to the gages is not known"
        yield (placement["sentences"][0] if placement else words), []
        return
    error, lines = placement_worst(placement), _first(placement)
    if error > MOST_ERROR:
        words = f"plates off their places change a reading by up to {percent(error)} of the largest"
        yield f"{words}; {100.0 * MOST_ERROR:.0f} % are allowed{'' if lines else _NO_FINER}", lines


def _first(effect: Mapping[str, Any]) -> Sequence[str]:
    """Lines of the first of an effect's fixes; none where it has none."""
    return next((fix["lines"] for fix in effect.get("fixes", ())), [])


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
    elif type_.to_measure and course != "leg":
        words = f"{type_.name} is made on the sheet with its traces, and wires cannot be soldered"
        yield f"{words} to it: lead it out on its legs", _lines(_LEG) + _other_leads(design, "leg")
    elif other := _other_leads(design, course):
        words = "gages.leads describes other leads than the mold makes (mold.leads)"
        yield f"{words}, so their price is not known", other
    else:
        yield from _priced(leads)


def _other_leads(design: Design, course: str) -> list[str]:
    """Lines that have ``gages.leads`` describe a mold's leads of a course; none where it does."""
    leads, legs = design.gages.leads, course == "leg"
    if leads is None:
        return []
    usual: Values = {"kind": "traces" if legs else "wire", "course": "leg" if legs else "z"}
    wrong = {key: value for key, value in usual.items() if getattr(leads, key) != value}
    if leads.number == 0:
        wrong["number"] = design.gages.model_copy(update={"leads": None}).lead_count
    return _lines({f"gages.leads.{key}": value for key, value in wrong.items()})


def _priced(leads: Mapping[str, Any] | None) -> Iterator[Reason]:
    """Leads whose price is not known, or is too high."""
    if leads is None or leads["reason"] is not None:
        unknown = "what the leads do to the readings is not known"
        yield (leads["sentences"][0].rstrip(".") if leads and leads["sentences"] else unknown), []
    elif leads["reading_error"] > MOST:
        error = f"{100.0 * leads['reading_error']:.0f} % of the largest"
        words = f"{leads['words']} change a reading by up to {error}"
        yield f"{words}; {100.0 * MOST:.0f} % are allowed", _first(leads)
