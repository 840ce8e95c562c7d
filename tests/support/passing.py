"""Outcomes of a search for a passing finger, without an analysis."""

from fingerdesign.records.outcome import Outcome, Traces


def outcome(design, shortfall, **metrics):
    """The outcome of a job: loads as on a layer, so that a travel can be found."""
    depths = (0.05, 0.1, 0.2)
    traces = Traces(approach_mm=depths, normal_force_N=tuple(300.0 * d**1.5 for d in depths))
    digest = f"{abs(hash(repr(design.model_dump()))):064x}"[:64]
    found = {"shortfall": shortfall, "area_correlation": 0.9, "smallest_stick_change": 0.05}
    return Outcome(
        digest,
        design.design.name,
        {},
        {},
        "fundamental",
        "3d",
        "ok",
        metrics=found | metrics,
        traces=traces,
    )
