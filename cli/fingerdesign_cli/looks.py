"""The contents of folders that are no result of an analysis, as ``fingerdesign view`` shows them.

A kind is known by the file that it always holds. Each function reads that record and returns what
is in the folder, what is good in it, what is bad, and one table at most.
"""

import json
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from fingerdesign.analysis.verdicts import FIDELITY_WORDS, two_digits
from fingerdesign.errors import shown
from fingerdesign.records.statistics import Share
from fingerdesign.records.verdict import SIGNS
from fingerdesign.runtime.files import whole_text
from fingerdesign_cli.terminal import number

# Of lifts, or of what a study tried. The regulator reaches nine of ten on its own model, a force
# that is the same for all objects not one of two (docs/how_to/control.md).
GOOD_SHARE, POOR_SHARE = 0.9, 0.5
GOOD_STICK_ERROR = 0.1  # RMS: a tenth of the contact; at a warning ratio of 0.3 it is seen in time
LEAST_ANGLE_DEG = 5.0  # dihedral, below which the mesher does not accept a mesh
_SHOWN = 8  # sentences of a sort; the record has all
_Data = Mapping[str, Any]
_Reader = Callable[[_Data, Path], "Look"]
KINDS: list["Kind"] = []  # In the order in which they are looked for.
_EXPORTED = {  # by `fingerdesign export`: the file that each target always writes
    "finger.xml": "MuJoCo model",
    "finger.urdf": "robot description",
    "regulator.c": "regulator in C",
    "regulator.fmu": "regulator as a mock-up unit",
    "plant.fmu": "finger as a mock-up unit",
}


@dataclass(frozen=True)
class Look:
    """A folder's content. what: its kind; facts: neither good nor bad."""

    what: str
    good: Sequence[str] = ()
    bad: Sequence[str] = ()
    facts: Sequence[str] = ()
    headings: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()

    def data(self) -> dict[str, Any]:
        """For scripts."""
        return {"what": self.what, **{k: list(getattr(self, k)) for k in ("good", "bad", "facts")}}


@dataclass(frozen=True)
class Kind:
    """A kind of folder: the file that it always holds, how it is read, the page or picture that
    shows it."""

    record: str
    look: Callable[[Any, Path], Look]
    page: str = ""


def _look(record: str, page: str = "") -> Callable[[_Reader], _Reader]:
    """Register how the folders are read that hold a record."""

    def register(read: _Reader) -> _Reader:
        KINDS.append(Kind(record, read, page))
        return read

    return register


def _percent(share: _Data) -> str:
    return number(share["rate"], 0, 100.0)


def _median(spread: _Data | None) -> str:
    return "-" if spread is None else number(spread["median"])


def _judged(rates: Mapping[str, float | None], of: str) -> tuple[list[str], list[str]]:
    """Who reaches a good share, and who not even a poor one."""
    known = {name: rate for name, rate in rates.items() if rate is not None}
    words = {name: f"{name}: {100 * rate:.0f} % {of}" for name, rate in known.items()}
    good = [words[name] for name, rate in known.items() if rate >= GOOD_SHARE]
    return good, [words[name] for name, rate in known.items() if rate < POOR_SHARE]


@_look("mold_report.json", "report.html")
def _mold(data: _Data, _: Path) -> Look:
    failing = [check for check in data["checks"] if not check["ok"]]
    bad = [*([data["failure"]] if data["failure"] else []), *(c["sentence"] for c in failing)]
    good = [] if bad else [f"all {len(data['checks'])} checks passed"]
    bad += (data.get("sensor") or {"reasons": []})["reasons"]
    facts = [f"warning: {warning}" for warning in data["warnings"]]
    if data["placement"] is not None:
        facts += data["placement"]["sentences"][:1]
    rows = [
        [part["name"], part["made"], " x ".join(f"{value:.1f}" for value in part["size_mm"])]
        for part in data["parts"]
    ]
    process = data["process"]["name"]
    what = f"mold of {data['design']} ({process})"
    return Look(what, good, bad, facts, ("part", "made", "size, mm"), rows)


@_look("tolerance.json", "report.html")
def _tolerance(data: _Data, _: Path) -> Look:
    made, calibrated = (f"{100.0 * share:.0f} %" for share in data["yield_by_motion"])
    facts = [f"yield by motion: margin 1.1 to 1.5 in {made} as made, {calibrated} calibrated"]
    if (response := data.get("gage_response")) is not None:
        designed, reached = (f"{value:.3g}" for value in response)
        facts.append(f"response: {designed} microstrain/N; nine of ten as made reach {reached}")
    rows = []
    for each in data["sources"]:
        tolerance = f"{two_digits(each['tolerance'])} {each['unit']}"
        rows.append([each["words"], tolerance, number(each["share"], 0, 100.0)])
    what = f"tolerances of {data['design']} ({FIDELITY_WORDS[data['fidelity']]})"
    headings = ("cause of scatter", "tolerance ±", "share of variance, %")
    return Look(what, (), (), facts, headings, rows)


@_look("control.json", "control.html")
def _control(data: _Data, _: Path) -> Look:
    noise = data["criteria"]["good_amplifier_microstrain"]
    rows, rates, used = [], {}, noise
    for each in data["controllers"]:
        levels = each["by_noise"]
        level = min(levels, key=lambda row: abs(row["noise_microstrain"] - noise))
        used, name = level["noise_microstrain"], each["controller"]
        rates[name] = level["success"]["rate"]
        counts = (str(level[key]) for key in ("dropped", "crushed", "not_lifted"))
        rows.append([name, _percent(level["success"]), *counts, _median(level["margin_at_lift"])])
    good, bad = _judged(rates, f"success at {used:g} microstrain")
    model = data["model"]["fidelity"]
    what = f"controllers on {data['design']} ({model}), {data['grips']} grips"
    if (data.get("conditions") or {}).get("perturbed"):
        what += ", on perturbed fingers"
    headings = ("controller", "success %", "dropped", "crushed", "not lifted", "margin")
    return Look(what, good, [*bad, *data["warnings"]], (), headings, rows)


@_look("unlike.json")
def _unlike(data: _Data, _: Path) -> Look:
    names = list(next(iter(data["summaries"].values())))
    rows = [
        [label, *(_percent(by[name]["success"]) for name in names)]
        for label, by in data["summaries"].items()
    ]
    rates = {
        f"{name}, {label}": by[name]["success"]["rate"]
        for label, by in data["summaries"].items()
        for name in names
    }
    good, bad = _judged(rates, "success")
    what = f"{data['plants']} perturbed fingers of {data['design']} ({data['fidelity']})"
    return Look(what, good, bad, ("the table: success in %",), ("fault", *names), rows)


@_look("tuning.json")
def _tuning(data: _Data, _: Path) -> Look:
    rows, good, bad = list[list[str]](), list[str](), list[str]()
    for name, found in data["controllers"].items():
        before, after = (found[key]["success_rate"] for key in ("default", "best"))
        rows.append([name, f"{100 * before:.1f}", f"{100 * after:.1f}"])
        words = f"{name}: success {100 * before:.0f} -> {100 * after:.0f} %"
        (good if after > before else bad).append(words + ("" if after > before else ": no gain"))
    what = f"controllers of {data['design']} tuned; tuned.toml is the design with their values"
    return Look(what, good, bad, (), ("controller", "before %", "tuned %"), rows)


@_look("lesson.json")  # of former versions
@_look("training.json")
def _training(data: _Data, folder: Path) -> Look:
    former = data.get("used_errors", ())  # the key of former versions
    frictions = data.get("friction_utilisation_errors", former)
    levels = zip(data["noises_microstrain"], data["stick_errors"], frictions, strict=True)
    rows = [[f"{noise:g}", f"{stick:.3f}", f"{used:.3f}"] for noise, stick, used in levels]
    least = data["stick_errors"][0]
    words = f"stick ratio with an error of {least:.3f} (RMS) at {rows[0][0]} microstrain"
    good, bad = ([words], []) if least <= GOOD_STICK_ERROR else ([], [words])
    if not data.get("judged_fingers"):
        bad.append("tested on no other finger than the training one: perturbed ones may do worse")
    what = f"estimator trained on {folder.name}: {data['samples']} samples; estimator.json"
    return Look(what, good, bad, (), ("noise, microstrain", "stick ratio", "friction used"), rows)


@_look("calibration.json")
def _calibration(data: _Data, _: Path) -> Look:
    fit, latents = data["fit"], data["latents"]
    known = sum(each["determined"] for each in latents)
    before, after = fit["before_microstrain"], fit["after_microstrain"]
    off = f"{before:.3g} microstrain from the design, {after:.3g} when fitted (RMS)"
    good = [f"readings off by {off}"]
    bad = list(data["warnings"])
    if data["dead_gages"]:
        bad.append(f"dead gages: {', '.join(map(str, data['dead_gages']))}")
    facts = [f"{known} of {len(latents)} hidden values are determined by the bench"]
    return Look(f"calibration of {data['design']} ({data['fidelity']})", good, bad, facts)


@_look("recorded.json", "recorded.html")
def _recordings(data: _Data, _: Path) -> Look:
    from pydantic import TypeAdapter

    from fingerdesign.trials.recorded.page import verdicts
    from fingerdesign.trials.recorded.sets import RecordedData

    whole = TypeAdapter(RecordedData).validate_json(json.dumps(data))
    judged: dict[str, list[str]] = {"pass": [], "fail": [], "note": []}
    for each in verdicts(whole):
        judged[each.status].append(f"{each.name}: {each.number}, {each.target}, {each.count}")
    rows = [
        [own.name, each.detector, *map(_percent_of, (each.right, each.found, each.false))]
        for own in whole.sets
        for each in own.scores
    ]
    bad = [*judged["fail"], *(f"not read: {words}" for words in whole.unread)]
    headings = ("recordings", "detector", "right %", "found %", "false %")
    what = f"detectors of slip on {whole.folder}"
    return Look(what, judged["pass"], bad, judged["note"], headings, rows)


def _percent_of(share: Share) -> str:
    return "-" if share.rate is None else number(share.rate, 0, 100.0)


@_look("validate.json", "validate.html")
def _validation(data: _Data, _: Path) -> Look:
    rows = [[each["title"], each["verdict"]] for each in data["assumptions"]]
    advice: dict[str, list[str]] = defaultdict(list)
    for each in data["assumptions"]:
        advice[each["verdict"]].append(f"{each['title']}: {each['advice']}")
    bad = [*([data["failure"]] if data["failure"] else []), *advice["drop"], *advice["measure"]]
    what = f"assumptions of models of {data['design']}, scene {data['scene']}"
    return Look(what, advice["keep"], bad, advice["limited"], ("assumption", "verdict"), rows)


@_look("observability.json", "observability.png")
def _gages(data: _Data, _: Path) -> Look:
    error, target = data["stick_error"], data["target_stick_error"]
    words = f"stick ratio with an error of {error:.3f} (RMS); target {target:g}"
    good, bad = ([words], []) if error <= target else ([], [words])
    if data["too_quiet"]:
        share = 100 * data["worth_of_gages"]
        bad.append(f"the gages take only {share:.0f} % off the error of forces and moves alone")
    enough = f"{data['gages_that_suffice']} of {len(data['gages'])} gages suffice"
    what = f"gages of {data['design']} at {data['noise_microstrain']:g} microstrain"
    return Look(what, good, bad, (enough, data["advice"]))


@_look("study.json", "report.html")
def _study(data: _Data, folder: Path) -> Look:
    from fingerdesign.search.compare.read import read_comparison
    from fingerdesign.search.compare.recommend import recommend
    from fingerdesign.search.compare.words import summary

    found = read_comparison([folder])
    best = recommend(found.outcomes, found.facts.objectives, found.facts.constraints)
    short = summary(found.outcomes, found.facts, best)
    failed = {k: v for k, v in data["outcomes"].items() if k not in ("all", "ok")}
    bad = [f"{count} {kind}: causes in failures.csv" for kind, count in failed.items()]
    good = [short.words] if short.recommended else []
    good += [f"its {key} = {value}" for key, value in short.values.items()]
    bad += [] if short.recommended else [short.why]
    facts = [short.counts, *(f"better elsewhere: {each}" for each in short.given_up)]
    facts += [f"warning: {each}" for each in short.warnings]
    table = short.table
    rows, headings = (table.rows, table.columns) if table else ((), ())
    return Look(f"study {data['name']} of {data['base']}", good, bad, facts, headings, rows)


@_look("generate.json")
def _variants(data: _Data, folder: Path) -> Look:
    good = [f"{data['variants']} variants that can exist"] if data["variants"] else []
    bad = []
    if data["invalid"]:
        bad.append(f"{data['invalid']} cannot exist: faults in invalid.csv")
    if data["cad_failed"]:
        bad.append(f"{data['cad_failed']} without CAD, which failed: generate again")
    return Look(f"variants of the study {data['name']}", good, bad)


@_look("quality.json", "mesh.png")
def _mesh(data: _Data, _: Path) -> Look:
    angle, inverted = data["min_dihedral_deg"], data["inverted_elements"]
    kind = "angle" if data["dimension"] == 2 else "dihedral angle"
    words = f"least {kind} {angle:.1f} degrees, {inverted} inverted elements"
    sound = inverted == 0 and (data["dimension"] == 2 or angle >= LEAST_ANGLE_DEG)
    what = f"mesh by {data['mesher']}: {data['elements']} elements, {data['dofs']} equations"
    facts = [f"body's volume off by {data['body_volume_error']:.1e}"]
    return Look(what, [words] * sound, [*([] if sound else [words]), *data["remarks"]], facts)


@_look("paper.json", "paper.html")
def _paper(data: _Data, _: Path) -> Look:
    claims = data["claims"]
    rows = [[each["title"], each["where"], each["verdict"]] for each in claims]
    good = [each["title"] for each in claims if each["verdict"] == "yes"]
    bad = [f"{each['title']}: {each['measured']}" for each in claims if each["verdict"] == "no"]
    what = f"the paper's figures remade with {data['design']}"
    return Look(what, good, bad, (), ("claim", "paper", "holds"), rows)


@_look("identification.json", "identify.html")
def _identification(data: _Data, _: Path) -> Look:
    values = [each for each in data["values"] if not each["name"].startswith("gage_")]
    rows = [
        [each["name"].replace("_", " "), f"{each['value']:.4g} {each['unit']}".strip()]
        for each in values
    ]
    wide = [v["name"] for v in data["values"] if not v.get("determined", v.get("told"))]
    bad = [f"{name} is not determined well enough" for name in wide]
    motion = data["next_motion"]
    facts = [f"warning: {warning}" for warning in data["warnings"]]
    facts += [] if motion is None else [f"next: {motion['words']}"]
    what = f"values of {data['design']} from {data['trace']}"
    return Look(what, (), bad, facts, ("value", "found"), rows)


def _exported(words: str, _: _Data, folder: Path) -> Look:
    files = sorted(each.name for each in folder.iterdir() if each.name[0] != ".")
    return Look(
        f"{words} of {folder.resolve().name}, by export", facts=(f"files: {', '.join(files)}",)
    )


KINDS += [Kind(record, partial(_exported, words)) for record, words in _EXPORTED.items()]


def kind_of(place: Path) -> Kind | None:
    """The kind of a folder; None where it is none that is known."""
    return next((kind for kind in KINDS if (place / kind.record).is_file()), None)


def look_at(kind: Kind, place: Path) -> Look:
    """The content of a folder of that kind. ValueError and its like where it cannot be read."""
    is_json = kind.record not in _EXPORTED
    found = kind.look(json.loads(whole_text(place / kind.record)) if is_json else {}, place)
    cut = {key: [shown(each) for each in getattr(found, key)] for key in ("good", "bad", "facts")}
    rows = [[shown(str(cell)) for cell in row] for row in found.rows]
    return Look(shown(found.what), **cut, headings=found.headings, rows=rows)


def marked(look: Look, whole: bool = False) -> list[tuple[str, str]]:
    """Marks and sentences: what is bad first; not more of a sort than fit a screen."""
    found: list[tuple[str, str]] = []
    marks = (SIGNS["fail"], look.bad), (SIGNS["pass"], look.good), (SIGNS["note"], look.facts)
    for mark, sentences in marks:
        few = sentences if whole else sentences[:_SHOWN]
        found += [(mark, each) for each in few]
        if len(few) < len(sentences):
            found.append((mark, f"... and {len(sentences) - len(few)} more"))
    return found
