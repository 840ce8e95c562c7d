"""Verdicts on the studio's finger: those of ``fingerdesign analyse``."""

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.design.schema import Design
from fingerdesign.records.verdict import VerdictView

PLANE, SPACE = "plane-strain", "3d"


def judged(design: Design, fidelity: str) -> VerdictView:
    """The verdicts and fixes of an analysis of the design, on its own mesh.

    Raises FingerDesignError where the design cannot be analysed so, or the work fails.
    """
    from fingerdesign.pipeline import run  # It loads the solvers.

    return verdict_view(run(Case(design, None, fidelity, fields=False)).result)
