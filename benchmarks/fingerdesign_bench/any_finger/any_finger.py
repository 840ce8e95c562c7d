"""``fingerdesign bench any-finger``: random designs of every kind meshed, random faults refused.

Each design's record is one line of any_finger.jsonl, written when it is done: an interrupted run
goes on where it stopped. Records of another version of the code are left as they are and redone.
"""

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fingerdesign.errors import DesignError
from fingerdesign.layout.frames import mirrors_in_z
from fingerdesign.layout.gaps import layered
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cache import FORMAT
from fingerdesign.runtime.isolate import ProcessError, call
from fingerdesign.runtime.progress import Report
from fingerdesign.version import versions
from fingerdesign_bench.check import Check
from fingerdesign_bench.lines import Record, resumed
from fingerdesign_bench.machine import machine

# Random fingers drawn: seconds against tetrahedra, and the least angle of each mesh.

MARKS = "osD^v<>PX*hd"


def draw_any_finger(records: Sequence[dict[str, Any]], path: Path) -> None:
    """Two panels: each mesh's time over its size, by body; a histogram of least dihedral angles."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    meshed = [each for each in records if each["status"] == "meshed"]
    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    bodies = list(dict.fromkeys(each["kinds"][0] for each in meshed))
    for number, body in enumerate(bodies):
        mine = [each for each in meshed if each["kinds"][0] == body]
        left.scatter(
            [each["elements"] for each in mine],
            [each["seconds"] for each in mine],
            marker=MARKS[number % len(MARKS)],
            s=26,
            alpha=0.8,
            label=f"{body} ({len(mine)})",
        )
    left.set(xscale="log", yscale="log", xlabel="tetrahedra", ylabel="seconds, CAD to mesh, s")
    left.xaxis.set_minor_formatter(NullFormatter())
    left.axhline(120.0, color="#c8321e", linewidth=1.0)
    left.text(0.02, 122.0, "asked: 120 s a try", transform=left.get_yaxis_transform(), fontsize=8)
    left.legend(fontsize=8, title="body (designs)")
    left.set_title(
        f"{len(meshed)} of {len(records)} random designs meshed", loc="left", fontsize=10
    )
    right.hist([each["min_dihedral_deg"] for each in meshed], bins=24, color="#4c78a8")
    right.axvline(5.0, color="#c8321e", linewidth=1.0)
    right.set(xlabel="least dihedral angle of a mesh, degrees", ylabel="meshes")
    right.set_title("asked: over 5 degrees", loc="left", fontsize=10)
    for axes in (left, right):
        axes.grid(alpha=0.25)
    figure.savefig(path, dpi=130)


DESIGNS, QUICK_DESIGNS = 200, 8
WORKERS = 2
# Three tries of 120 s each, and what comes before and after them; then the process is ended.
TIME_LIMIT_S = 600.0
LINES = "any_finger.jsonl"
# What issue 4 asks of every accepted mesh, and how it is named here.
ASKED = {
    "body_volume_error": 1e-3,
    "worst_plate_volume_error": 1e-2,
    "contact_residual_mm": 1e-6,
}
LEAST_DIHEDRAL_DEG, LEAST_EXTRUDED_DEG = 5.0, 1.0


@dataclass
class AnyFinger:
    """Records of the designs meshed, of those extruded too, and of the faults refused."""

    records: list[Record]
    refusals: list[Record]
    extruded: list[Record] = field(default_factory=list)
    machine: dict[str, Any] = field(default_factory=dict)

    def checks(self) -> list[Check]:
        """What issue 4 asks, against what was measured."""
        meshed = [each for each in self.records if each["status"] == "meshed"]
        lost = len(self.records) - len(meshed)
        wrong = [each for each in self.refusals if not each["named"]]
        found = [
            Check("designs not meshed", 0.02, lost / max(1, len(self.records))),
            Check(
                "kinds in less than a tenth of the designs",
                0,
                sum(n < 0.1 * len(self.records) for n in self.kinds().values()),
            ),
        ]
        for name, most in ASKED.items():
            worst = max((float(each[name]) for each in meshed), default=0.0)
            unit = "mm" if name.endswith("_mm") else ""
            found.append(Check(f"{name.replace('_', ' ').removesuffix(' mm')}", most, worst, unit))
        least = min((float(each["min_dihedral_deg"]) for each in meshed), default=90.0)
        found.append(
            Check("5 degrees less the least dihedral angle", 0.0, LEAST_DIHEDRAL_DEG - least)
        )
        layers = min((float(each["min_dihedral_deg"]) for each in self.extruded), default=90.0)
        found.append(
            Check(
                "1 degree less the least dihedral angle, extruded", 0.0, LEAST_EXTRUDED_DEG - layers
            )
        )
        crashed = sum(each["status"] == "crashed" for each in self.records)
        found.append(Check("crashes and hangs", 0, crashed))
        found.append(Check("faults not refused by their key", 0, len(wrong)))
        return found

    def kinds(self) -> dict[str, int]:
        """How many designs are of each kind."""
        return dict(Counter(kind for each in self.records for kind in each["kinds"]))


def measure_any_finger(
    folder: Path,
    report: Report = lambda message: None,
    quick: bool = False,
    count: int | None = None,
) -> AnyFinger:
    """Mesh the designs that ``folder`` has no record of yet, and try the faults."""
    number = count if count is not None else (QUICK_DESIGNS if quick else DESIGNS)
    version = f"{versions()['fingerdesign']}, meshes {FORMAT}"
    records = resumed(folder / LINES, "seed", range(number), _run, version, WORKERS, report, _words)
    report("the extruded ones, and the faults")
    return AnyFinger(records, refuse_faults(number), extrude_straight(number), machine())


def extrude_straight(number: int) -> list[Record]:
    """The random designs that can be swept through layers, meshed so too: least angles, degrees.

    A design whose section cannot be meshed is an error here: none of them is refused.
    """
    import tomlkit

    from fingerdesign.checks.load import parse_design
    from fingerdesign.mesh.quality import assess
    from fingerdesign.mesh.section.extrude import extrude
    from fingerdesign_bench.any_finger.designs import kinds, random_design

    found = []
    for seed in range(number):
        if kinds(seed)[0] not in ("arc", "block"):  # reading the rest takes seconds each
            continue
        design = parse_design(tomlkit.dumps(random_design(seed)))
        if layered(design):
            mesh = extrude(design, Zone(0.25 * design.body.width_mm), mirrors_in_z(design))
            report = assess(mesh, design)
            least, body = report.min_dihedral_deg, report.body_volume_error
            found.append({"seed": seed, "min_dihedral_deg": least, "body_volume_error": body})
    return found


def refuse_faults(number: int) -> list[Record]:
    """What is said of designs with one fault each: whether the key to blame is named."""
    import tomlkit

    from fingerdesign.checks.load import parse_design
    from fingerdesign_bench.any_finger.designs import invalid_design

    found = []
    for seed in range(number):
        data, key = invalid_design(seed)
        try:
            parse_design(tomlkit.dumps(data))
            said: list[str] = []
        except DesignError as error:
            said = [str(fault) for fault in error.faults]
            keys = [fault.key for fault in error.faults]
        named = bool(said) and any(_same(key, each) for each in keys)
        found.append({"seed": seed, "key": key, "said": said, "named": named})
    return found


def _same(key: str, said: str) -> bool:
    """Whether a fault's key is the one to blame, indices aside."""
    return said == key or said.startswith(f"{key}[")


def _run(seed: int) -> Record:
    from fingerdesign_bench.any_finger.designs import kinds

    try:
        record: Record = call(
            "fingerdesign_bench.any_finger.worker:mesh_one", seed, time_s=TIME_LIMIT_S
        )
    except ProcessError as error:
        record = {"seed": seed, "kinds": list(kinds(seed)), "status": "crashed"}
        record["reason"] = str(error)
    return record


def _words(record: Record) -> str:
    kinds = ", ".join(record["kinds"])
    if record["status"] != "meshed":
        return f"{kinds}: {record['status']}: {record['reason']}"
    return f"{kinds}: {record['elements']} tetrahedra in {record['seconds']:.0f} s"


def write_any_finger(found: AnyFinger, folder: Path) -> list[Path]:
    """Write any_finger.json (everything), any_finger.csv (a row a design) and the chart."""
    import csv

    paths = [folder / f"any_finger.{ending}" for ending in ("json", "csv", "png")]
    record = {
        "machine": found.machine,
        "kinds": found.kinds(),
        "checks": [check.as_dict() for check in found.checks()],
        "designs": found.records,
        "extruded": found.extruded,
        "faults": found.refusals,
    }
    paths[0].write_text(json.dumps(record, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    columns = list(dict.fromkeys(key for each in found.records for key in each))
    with paths[1].open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows({**each, "kinds": " ".join(each["kinds"])} for each in found.records)
    draw_any_finger(found.records, paths[2])
    return paths


def by_kind(records: Sequence[Record]) -> list[tuple[str, int, int, float, float]]:
    """Of each kind: designs, meshed, median seconds, least dihedral angle (degrees)."""
    import statistics

    rows = []
    for kind in sorted({kind for each in records for kind in each["kinds"]}):
        mine = [each for each in records if kind in each["kinds"]]
        meshed = [each for each in mine if each["status"] == "meshed"]
        seconds = statistics.median(each["seconds"] for each in meshed) if meshed else 0.0
        least = min((each["min_dihedral_deg"] for each in meshed), default=0.0)
        rows.append((kind, len(mine), len(meshed), seconds, least))
    return rows
