"""What a report says in sentences (templates/words.txt.j2): the finger, the object, the verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fingerdesign.analysis.verdicts import (
    CLEARLY,
    GOOD_CORRELATION,
    HUMAN_MARGIN,
    follows,
    force_ratio,
    lifts,
    measures,
    shortfall,
)
from fingerdesign.control.calibration import LEAST_GAGES
from fingerdesign.control.metrics import MOST_FORCE
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.result import (
    GripResult,
    IncrementResult,
    Measurability,
    Result,
)
from fingerdesign.report.page import paragraphs
from fingerdesign.report.table import NOISE, loaded_increments, value_text, without_noise
from fingerdesign.runtime.registry import BODIES, SCENE_OBJECTS, Kind

TEMPLATES = Path(__file__).parent / "templates"
SENTENCES, FIGURES = TEMPLATES / "words.txt.j2", TEMPLATES / "figures.txt.j2"
OBJECT, PATH = "scene.object.", "scene.path."  # of the keys of ``Result.parameters``
MOST_PHASES = 6  # in one sentence; a longer path is described by its ranges
_MOTIONS = (("approach", "mm"), ("shear", "mm"), ("shear along z", "mm"), ("twist", "degrees"))
_FORCES = (("normal force", "N"), ("tangential force", "N"))
_ASIDE = 0.01  # of the normal force, and of it times the contact's width: less is the mesh's
UNDEFINED = "too little force or the area never changes"
NOT_JUDGED = (
    "Not judged: plates are left out (plates.model = none), so the readings that slip study and "
    "rule rest on are not a gage's."
)

Keys = Mapping[str, Any]
# "note": a fact that is neither merit nor fault.
Answer = Literal["yes", "no", "partly", "open", "note"]


def finger_words(keys: Keys) -> str:
    """Body, core and plates of a design's dotted keys (``body.width_mm``) in a few sentences.

    Empty where the keys do not hold them.
    """
    if "body.shape" not in keys or "body.width_mm" not in keys:
        return ""
    shape = str(keys["body.shape"])
    entry = BODIES.get(shape)
    top = ((entry and entry.made.words) or shape).format(
        radius=float(keys.get("body.arc_radius_mm") or 0.0),
        dome=float(keys.get("body.dome_radius_mm") or 0.0),
    )
    return paragraphs(SENTENCES, "finger", keys=keys, top=top, rows=_rows(keys))[0]


def _below(table: str, keys: Keys) -> dict[str, Any]:
    """The keys of a table, without its name."""
    return {k.removeprefix(table): value for k, value in keys.items() if k.startswith(table)}


def _rows(keys: Keys) -> list[dict[str, Any]]:
    """Every row of plates with the keys that it takes from ``[plates]``; those of no plate not."""
    plates = _below("plates.", keys)
    rows = [{}, *(plates.get("rows") or [])]
    tables = [{**plates, **{k: v for k, v in row.items() if v is not None}} for row in rows]
    return [table | {"along": table.get("along") or "x"} for table in tables if table.get("count")]


def object_text(result: Result) -> str:
    """What touches the finger and how it is moved, in a few sentences; empty if not known."""
    keys = _below(OBJECT, result.parameters)
    if keys.get("friction_coefficient") is None:
        return ""
    shape = str(keys.get("shape") or "plane")
    kind: Kind | None = SCENE_OBJECTS.get(shape)
    radius = keys.get("radius_mm")
    return paragraphs(
        SENTENCES,
        "object",
        keys=keys,
        shape=shape,
        radius="" if radius is None else value_text(radius),
        more="" if kind is None else kind.made.words(keys),
        friction=value_text(keys["friction_coefficient"]),
        path=_path(result),
        forced=force_controlled(result),
        substeps=result.parameters.get(f"{PATH}substeps") or 1,
        model=result.model,
    )[0]


def force_controlled(result: Result) -> bool:
    """Whether the path's rows are forces."""
    return bool(result.parameters.get(f"{PATH}control") == "force")


def _path(result: Result) -> list[str] | None:
    """The stretches of the path, or the ranges of one of many; None where it is not known."""
    keys = result.parameters
    rows = keys.get(f"{PATH}increments_N") or keys.get(f"{PATH}increments_mm") or []
    if not rows:
        return None
    names = _FORCES if force_controlled(result) else _MOTIONS
    table = np.array([[*row, *[0.0] * (len(names) - len(row))] for row in rows], dtype=float)
    phases = _phases(table)
    if len(phases) > MOST_PHASES:
        return [
            f"{name} from {low:g} to {high:g} {unit}"
            for (name, unit), low, high in zip(names, table.min(0), table.max(0), strict=True)
            if low or high
        ]
    return [
        " with ".join(f"{names[c][0]} to {table[last][c]:g} {names[c][1]}" for c in columns)
        for columns, last in phases
    ]


def _phases(table: np.ndarray) -> list[tuple[tuple[int, ...], int]]:
    """Stretches in which the same columns move the same way: the columns, the last row."""
    steps = np.diff(table, axis=0, prepend=np.zeros((1, table.shape[1])))
    phases: list[tuple[tuple[int, ...], int]] = []
    before: Any = None
    for number, step in enumerate(steps):
        way = tuple(np.sign(step).tolist())
        columns = tuple(np.flatnonzero(step).tolist())
        if not columns:
            continue
        if way == before:
            phases[-1] = (columns, number)
        else:
            phases.append((columns, number))
        before = way
    return phases


def leaves_section(found: Sequence[IncrementResult]) -> bool:
    """Whether anything is moved, or pushed, out of the plane of the section."""
    if any(row.shear_z_mm or row.twist_deg for row in found):
        return True
    most = max((abs(row.normal_force_N) for row in found), default=0.0)
    width = max((row.contact_width_mm for row in found), default=0.0)
    force = max((abs(row.force_z_N) for row in found), default=0.0)
    moment = max((abs(row.twist_moment_Nmm) for row in found), default=0.0)
    return force > _ASIDE * max(most, NOISE) or moment > _ASIDE * max(most * width, NOISE)


def slip_grows_with_shear(found: Sequence[IncrementResult]) -> bool:
    """Whether the stick ratio falls from its largest to its last as the tangential force grows."""
    loaded = loaded_increments(found)
    if len(loaded) < 2 or loaded != list(range(loaded[0], len(found))) or leaves_section(found):
        return False
    rows = [found[place] for place in loaded]
    ratio = np.array([row.stick_ratio or 0.0 for row in rows])
    force = np.abs(without_noise(row.tangential_force_N for row in rows))
    start = len(ratio) - 1 - int(ratio[::-1].argmax())  # the last of the largest
    falls = bool((np.diff(ratio[start:]) <= 0).all()) and ratio[-1] < ratio[start]
    return falls and bool((np.diff(force[start:]) >= -1e-6 * force.max()).all())


@dataclass(frozen=True)
class Question:
    """One question of a verdict and the numbers behind its answer, the class of its look: an
    :data:`Answer`, or "best" of several."""

    answer: str
    question: str
    detail: str


def _question(name: str, answer: Answer, **values: Any) -> Question:
    question, detail = paragraphs(SENTENCES, name, answer=answer, **values)
    return Question(answer, question, detail)


def verdict(result: Result, traces: Sequence[GripTrace] = ()) -> list[Question]:
    """The report's verdict. What was not computed is answered "open", not left out.

    ``traces``: of the grips, where they are at hand: they tell what was lifted without the rule.
    """
    if result.status == "failed":
        return [_question("failed", "no", failure=result.failure)]
    if result.increments and not result.slip_studies and not result.grips:
        return [_touches(result.increments), *_measurable(result.measurability)]
    found = [
        _follows(result),
        _lifts(result.grips),
        *_needed(result.grips, traces),
        *_measurable(result.measurability),
    ]
    if result.parameters.get("plates.model") == "none":
        return [Question("open", each.question, NOT_JUDGED) for each in found]
    return found


def in_short(result: Result) -> list[Question]:
    """The first lines: is it good, for which objects, what limits it, what to change by how much.

    All from the numbers of the record: margins of the grips, the model's own force over approach,
    the remedies that were worked for the gages. Empty where no grip was run or nothing is judged.
    """
    grips = result.grips
    if result.status == "failed" or not grips or result.parameters.get("plates.model") == "none":
        return []
    judged = [study for study in result.slip_studies if study.rank_correlation is not None]
    found = result.measurability
    states = found.states if found else ()
    lifted = [grip for grip in grips if lifts(grip)]
    failing = [shortfall(grip, result) for grip in grips if grip not in lifted]
    seen = [each for each in states if found and measures(each, found)]
    counts = {
        "lifted": (len(lifted), len(grips)),
        "followed": (sum(map(follows, judged)), len(judged)),
        "seen": (len(seen), len(states)),
    }
    nearest = min(lifted, key=lambda grip: grip.safety_margin or np.inf, default=None)
    margin = nearest.safety_margin if nearest else None
    thin = margin is not None and margin < HUMAN_MARGIN[0]
    hardest = max(lifted, key=force_ratio, default=None)
    crushed = hardest is not None and force_ratio(hardest) >= MOST_FORCE
    whole = not crushed and all(good == every for good, every in counts.values())
    of = {
        "counts": counts,
        "lifted": lifted,
        "failing": sorted(failing, key=lambda each: -each.needed_N),
        "nearest": nearest,
        "thin": thin,
        "hardest": hardest if crushed else None,
        "squeeze": force_ratio(hardest) if hardest else 0.0,
        "sound": whole and not thin,
        "unlike": [study for study in judged if not follows(study)],
        "found": found,
        "worst": max(states, key=lambda each: each.smallest_stick_change, default=None),
        "human": HUMAN_MARGIN,
        "parameters": result.parameters,
    }
    answer: Answer = "no" if not lifted else "yes" if whole and not thin else "partly"
    names: tuple[tuple[str, Answer], ...] = (
        ("good", answer),
        ("objects", "note"),
        ("limits", "note"),
        ("change", "note"),
    )
    return [_question(name, each, of=of) for name, each in names]


def _graded(good: int, every: int) -> Answer:
    return "yes" if good == every else "partly" if good else "no"


def _touches(found: Sequence[IncrementResult]) -> Question:
    """What the contact did, where neither slip study nor grips tell more."""
    loaded = loaded_increments(found)
    row = found[loaded[-1]] if loaded else None
    answer: Answer = "open"
    if row is not None:
        answer = "no" if not row.stick_nodes else "partly" if row.slip_nodes else "yes"
    return _question(
        "touches",
        answer,
        row=row,
        number=loaded[-1] + 1 if loaded else 0,
        count=len(found),
        aside=leaves_section(found),
        bare=not found[0].gages,
        single=0 < len(found[0].gages) < LEAST_GAGES,
    )


def _follows(result: Result) -> Question:
    studies, keys = result.slip_studies, result.parameters
    defined = [s for s in studies if s.rank_correlation is not None]
    good = sum(follows(study) for study in defined)
    return _question(
        "follows",
        _graded(good, len(defined)) if defined else "open",
        studies=studies,
        bare=bool(result.increments) and not result.increments[0].gages,
        defined=len(defined),
        good=good,
        enough=GOOD_CORRELATION,
        clearly=CLEARLY,
        undefined=UNDEFINED,
        part=keys.get("gages.area_share", 0.5),
        rows=_rows(keys),
        placed=keys.get("plates.placement") is not None,
    )


def _lifts(grips: Sequence[GripResult]) -> Question:
    good = [grip for grip in grips if lifts(grip)]
    margins = [grip.safety_margin for grip in good if grip.safety_margin is not None]
    answer = _graded(len(good), len(grips)) if grips else "open"
    return _question("lifts", answer, grips=grips, good=good, margins=margins, human=HUMAN_MARGIN)


def _measurable(found: Measurability | None) -> list[Question]:
    """Whether what the gages answer to slip stands above the amplifier's noise."""
    if found is None:
        return []
    wanted, states = found.wanted_stick_change, found.states
    good = sum(measures(state, found) for state in states)
    worst = max(states, key=lambda state: state.smallest_stick_change)
    responses = [state.response_microstrain_per_N for state in states]
    changes = [state.smallest_stick_change for state in states]
    forces = [state.smallest_force_change_N for state in states]
    return [
        _question(
            "measurable",
            _graded(good, len(states)),
            found=found,
            good=good,
            worst=worst,
            response=(min(responses), max(responses)),
            change=(min(changes), max(changes)),
            force=(min(forces), max(forces)),
            gain=worst.smallest_stick_change / wanted,
        )
    ]


def _needed(grips: Sequence[GripResult], traces: Sequence[GripTrace]) -> list[Question]:
    """What the rule did: the same grip without it.

    Neither a merit nor a fault of the finger: a grip that fails counts where lifts are judged.
    """
    tried = [grip for grip in grips if grip.slips_without_rule is not None]
    if not tried:
        return []
    lifting = {
        (trace.friction_coefficient, trace.object_mass_g)
        for trace in traces
        if trace.without_rule is not None and trace.without_rule.lift_step is not None
    }
    slipping = [grip for grip in tried if grip.slips_without_rule]
    unlifted = [grip for grip in tried if not grip.lifted and not grip.slips_without_rule]
    doubts = {
        "vain": [grip for grip in slipping if grip.gross_slip],
        "harmed": [grip for grip in tried if grip.gross_slip and not grip.slips_without_rule],
        "stopped": [g for g in unlifted if (g.friction_coefficient, g.object_mass_g) in lifting],
        "unsure": [] if traces else [grip for grip in unlifted if not grip.gross_slip],
    }
    held = [grip for grip in tried if grip.holds > 0]
    frictions = {
        name: [grip.friction_coefficient for grip in each]
        for name, each in {**doubts, "slipping": slipping, "held": held}.items()
    }
    return [_question("needed", "note", tried=len(tried), **frictions)]
