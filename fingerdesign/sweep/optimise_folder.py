"""OUT/NAME of an optimisation: a study's files, with what was searched, confirmed and decides.

study.json  has "optimise" besides: the front, the confirmation, sensitivities
front.png   trials, reference and confirmed fingers in the first two objectives
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from fingerdesign.record_folder import RecordFolder
from fingerdesign.sweep.compare import STUDY_FILE
from fingerdesign.sweep.confirm import Confirmation, Judged
from fingerdesign.sweep.optimise import Search, Tried
from fingerdesign.sweep.outcome import Outcome
from fingerdesign.sweep.sensitivity import Sensitivity, sensitivities
from fingerdesign.sweep.study_folder import FILES, REPORT_FILE, write_study

CHART_FILE = "front.png"
FOLDER = RecordFolder("optimisation", STUDY_FILE, (*FILES, CHART_FILE))


@dataclass(frozen=True)
class Optimised:
    """A search that is done."""

    search: Search
    tried: tuple[Tried, ...]
    confirmation: Confirmation

    @property
    def outcomes(self) -> tuple[Outcome, ...]:
        """All: the reference and confirmations first, then trials; of one digest the first."""
        trials = (outcome for each in self.tried for outcome in each.outcomes)
        every = (*self.confirmation.outcomes, *trials)
        kept: dict[str, Outcome] = {}
        for outcome in every:
            kept.setdefault(outcome.digest, outcome)
        return tuple(kept.values())

    @cached_property
    def sensitivities(self) -> tuple[Sensitivity, ...]:
        """Of each objective to each parameter, over the trials of the first scene."""
        return sensitivities(self.search.study, [each.outcomes[0] for each in self.tried])

    def counts(self) -> dict[str, int]:
        """Trials, and of them those that are no finger, that failed, and that are feasible."""
        failures = [
            next((o.failure.kind for o in each.outcomes if o.failure is not None), None)
            for each in self.tried
        ]
        invalid = sum(kind == "invalid" for kind in failures)
        return {
            "trials": len(self.tried),
            "invalid": invalid,
            "failed": sum(kind is not None for kind in failures) - invalid,
            "front": len(self.confirmation.front),
            "dominate_reference": len(self.confirmation.dominating),
            "confirmed": len(self.confirmation.standing),
        }

    def sentences(self) -> tuple[str, ...]:
        """What came out, in words."""
        found, counts = self.confirmation, self.counts()
        objectives = " and ".join(
            f"{'lowest' if each.direction == 'min' else 'highest'} {each.metric}"
            for each in self.search.study.objectives
        )
        said = [
            f"{_many(counts['trials'], 'trial', 'trials')} ({counts['invalid']} no finger, "
            f"{counts['failed']} failed) for {objectives}: {counts['front']} on the front, "
            f"{_many(counts['dominate_reference'], 'dominates', 'dominate')} "
            f"{found.reference.name}."
        ]
        if found.reference.failure:
            said.append(f"The reference could not be analysed: {found.reference.failure}")
        elif not found.reference.feasible:
            said.append("The reference itself misses a constraint.")
        if found.thorough_reference is None:
            return (*said, "Nothing was confirmed by a more thorough model.")
        dominate = "dominates" if len(found.standing) == 1 else "dominate"
        better = sum(_all_better(each.thorough, found) for each in found.standing)
        said.append(
            f"Analysed again by {found.fidelity}, as the reference was, {len(found.standing)} of "
            f"{len(found.confirmed)} {dominate} it there too, {better} in every objective."
        )
        return tuple(said)

    def data(self) -> dict[str, Any]:
        """For study.json and scripts."""
        found = self.confirmation
        names = {each.number: each.outcomes[0].name for each in self.tried}
        deep = found.thorough_reference
        return {
            **self.counts(),
            "reference": _judged(found.reference),
            "front_names": [names[number] for number in found.front],
            "dominating_names": [names[number] for number in found.dominating],
            "confirm_fidelity": found.fidelity,
            "thorough_reference": None if deep is None else _judged(deep),
            "confirmations": [
                {
                    "trial": each.number,
                    "quick": _judged(each.quick),
                    "thorough": _judged(each.thorough),
                    "dominates": deep is not None and each.thorough.dominates(deep),
                    "better_in_all": deep is not None and each.thorough.better_in_all(deep),
                }
                for each in found.confirmed
            ],
            "volumes": [round(each, 6) for each in found.volumes],
            "sensitivities": [asdict(each) | {"words": each.words} for each in self.sensitivities],
            "sentences": list(self.sentences()),
        }


def journal_beside(target: Path) -> Path:
    """The file that keeps an optimisation's trials, beside its folder."""
    return target.with_name(f"{target.name}.trials.jsonl")


def write_optimised(folder: Path, found: Optimised, source: str) -> None:
    """Write all files into ``folder``; ``source``: the text of the study's file."""
    from dataclasses import replace

    from fingerdesign.report.compare_html import compare_html
    from fingerdesign.report.figures_optimise import draw_front
    from fingerdesign.report.optimise_tables import confirmed_table, sensitivity_tables
    from fingerdesign.report.optimise_words import verdict

    study, told = found.search.study, found.confirmation
    compared = write_study(folder, study, found.outcomes, source, {"optimise": found.data()})
    tables = [confirmed_table(found), *sensitivity_tables(found)]
    record = {key: text for key, text in compared.facts.record.items() if key != "optimise"}
    facts = replace(compared.facts, sources=(), record=record)
    page = compare_html(
        compared.outcomes,
        facts,
        answer=verdict(found),
        notes=found.sentences(),
        tables=[table for table in tables if table is not None],
        references=[each.name for each in (told.reference, told.thorough_reference) if each],
    )
    (folder / REPORT_FILE).write_text(page, encoding="utf-8", newline="\n")
    if len(study.objectives) > 1:
        draw_front(found, folder / CHART_FILE)


def _many(count: int, one: str, more: str) -> str:
    return f"{count} {one if count == 1 else more}"


def _all_better(own: Judged, found: Confirmation) -> bool:
    return found.thorough_reference is not None and own.better_in_all(found.thorough_reference)


def _judged(own: Judged) -> dict[str, Any]:
    return {
        "name": own.name,
        "metrics": own.metrics,
        "feasible": own.feasible,
        "failure": own.failure or None,
    }
