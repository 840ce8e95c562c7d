"""How far the numbers of an outcome may be believed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.errors import DesignError
from fingerdesign.results import Analysis
from fingerdesign.sweep.outcome import Validity

if TYPE_CHECKING:
    from fingerdesign.case import Case


def validity_of(case: Case, analysis: Analysis) -> Validity:
    """The forecast of plane strain's error, and what the ladder estimated of the mesh's.

    A sentence says why there is none, of either.
    """
    sentences, plane, mesh = [], None, None
    if analysis.result.model is not None and analysis.result.model.dimension == 2:
        from fingerdesign.study.plane_strain_estimate import plane_strain_error

        try:
            estimate = plane_strain_error(case.design, case.path_scene)
        except DesignError as error:
            sentences.append(f"no forecast of plane strain's error: {error}")
        else:
            plane = estimate.errors["normal_force"]
            sentences.append(estimate.words)
    ladder = analysis.result.ladder
    if ladder is not None:
        mesh = max(ladder.error_estimates.values(), default=None)
        sentences += [ladder.why_ended] if ladder.why_ended else []
    else:
        remedy = "fidelity 'auto' estimates it"
        sentences.append(f"no estimate of the mesh's own error: {remedy}")
    return Validity(plane, mesh, tuple(sentences))
