"""control.html: success of every controller, and the forces it takes, on one page for offline use.

The success chart and the verdicts come first; tables fold out.
"""

from collections.abc import Iterator

from fingerdesign.records.verdict import VerdictView
from fingerdesign.report.page import Bullets, Fold, Item, Page, Section, Text, page_html, texts_of
from fingerdesign.trials import figures, tables
from fingerdesign.trials.findings import findings
from fingerdesign.trials.record import ControlData, ControlStudy


def control_html(study: ControlStudy) -> str:
    """The page of a study; figures are of its ``trace_noise``."""
    data, found = study.data, findings(study.data)
    words = texts_of(figures.WORDS)["page"]
    title = f"{data['design']}: controllers compared"
    details = [f"{each.verdict.sign} {each.question} {each.detail}" for each in found]
    success = Text(words["success"].format(most=data["criteria"]["most_force_ratio"]), "quiet")
    warnings = [Bullets(data["warnings"], "warnings")] if data["warnings"] else []
    view = VerdictView(
        data["design"], "", data["seconds"]["whole"], tuple(each.verdict for each in found)
    )
    page = Page(
        title=title,
        heading=title,
        lead=f"{data['grips']:,} simulated grips · {data['seconds']['whole']:.0f} s",
        sections=[
            Section("findings", "Findings", [success, Bullets(details, "findings"), *warnings]),
            Section("forces", "Forces", list(_figures(study))),
            Section("tables", "Tables", list(_tables(study))),
        ],
        record=list(_record(data)),
        first=figures.success_figure(data),
        view=view,
    )
    return page_html(page)


def _figures(study: ControlStudy) -> Iterator[Item]:
    data, noise = study.data, study.trace_noise
    yield figures.force_figure(data, study.trials, noise)
    if data["conditions"]["perturbed"] is None:
        yield figures.map_figure(data, study.trials, noise)
        yield figures.paths_figure(study.traces, noise)


def _tables(study: ControlStudy) -> Iterator[Item]:
    data, noise = study.data, study.trace_noise
    criteria, words = data["criteria"], texts_of(figures.WORDS)["page"]
    warned = words["warnings"].format(
        warning=criteria["warning_stick_ratio"], alarm=criteria["false_alarm_stick_ratio"]
    )
    folded = {
        "Who lifts, and how": (tables.main_tables(data, noise), words["lifts"]),
        "Tuning": (tables.tuning_tables(data["tuning"]), ""),
        "By noise": (tables.noise_tables(data), ""),
        "Tugged": (tables.tug_tables(data), words["tugs"]),
        "Warnings before slip": (tables.warning_tables(data, noise), warned),
        "Conditions": (tables.condition_tables(data), ""),
    }
    for title, (found, how) in folded.items():
        if found:
            yield Fold(title, [*found, *([Text(how, "quiet")] if how else [])])


def _record(data: ControlData) -> Iterator[Item]:
    seconds, workers = data["seconds"], data["workers"]
    yield Text(
        f"{seconds['whole']:.0f} s in all, of which {seconds['grips']:.0f} s for the grips, on "
        f"{workers} process{'' if workers == 1 else 'es'}; {data['peak_memory_MB']:.0f} MB. "
        f"Digest {data['digest']}."
    )
    versions = ", ".join(f"{name} {each}" for name, each in data["versions"].items())
    yield Text(f"Versions: {versions or 'not recorded'}.")
    yield Text(texts_of(figures.WORDS)["page"]["files"], "quiet")
