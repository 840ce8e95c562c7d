"""A result with its arrays, for scripts and notebooks."""

from collections.abc import Sequence
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any, Self

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.folder import read_analysis
from fingerdesign.analysis.page.contact import contact_chart, path_chart
from fingerdesign.analysis.page.finger import finger_figure
from fingerdesign.analysis.page.gage import gages_chart
from fingerdesign.analysis.page.page import report_html
from fingerdesign.records.base import ResultError
from fingerdesign.records.result import Result
from fingerdesign.report.figure import in_notebook
from fingerdesign.runtime.files import write_whole

_NOT_HELD = (
    "the record of {design} holds no {name}: it was read from a result.json alone, or failed; "
    "analyse it, or take load_result of a folder with its arrays.npz"
)


class Analysed(Result):
    """A :class:`Result` that draws itself: what ``analyse`` and ``load_result`` return.

        result = fingerdesign.analyse("maeno2000", "pull", "plane-strain")
        result.plot_finger().show()
        result.report("pull.html")

    The figures are those of the report, as plotly.graph_objects.Figure.
    """

    _analysis: Analysis | None = None

    @classmethod
    def of(cls, analysis: Analysis) -> Self:
        """The record of an analysis, with its arrays; the condensed finger is let go."""
        result = analysis.result
        found = cls(**{each.name: getattr(result, each.name) for each in fields(Result)})
        object.__setattr__(found, "_analysis", replace(analysis, problem=None))
        return found

    def __eq__(self, other: object) -> bool:
        """True if the records are the same; the arrays do not count."""
        return isinstance(other, Result) and asdict(self) == asdict(other)

    def plot_path(self) -> Any:
        """Forces and stick ratio, increment by increment.

        result.plot_path().show()
        """
        self._increment(-1)
        return in_notebook(path_chart(self))

    def plot_gages(self, increments: Sequence[int] | None = None) -> Any:
        """Membrane and bending strain of every gage, over the places of the plates, microstrain.

        increments: from 0, -1 the last; by default a few under load. ResultError without gages.

        result.plot_gages([0, -1]).show()
        """
        chosen = None if increments is None else [self._increment(k) for k in increments]
        if not self.increments or not self.increments[0].gages:
            raise ResultError(f"{self.design} has no gages to draw: it has no plates, or failed")
        return in_notebook(gages_chart(self, self._arrays().plates, chosen))

    def plot_contact(self, increment: int = -1) -> Any:
        """Pressure and shear traction along x, in 3-D on the mid-plane, at an increment, MPa.

        result.plot_contact(3).show()
        """
        chosen = [self._increment(increment)]
        return in_notebook(contact_chart(self._held("contact"), chosen))

    def plot_finger(self, increment: int = -1) -> Any:
        """The finger in space, to be turned, with a slider over the increments and menus of what
        colours the contact, how the body is drawn and from where it is seen.

        result.plot_finger().write_html("finger.html")
        """
        self._held("mesh")
        return in_notebook(finger_figure(self._arrays(), self._increment(increment)))

    def report(self, path: str | Path) -> Path:
        """Write the report, one page that opens offline; returns its path.

        result.report("maeno2000.html")
        """
        return write_whole(Path(path), report_html(self._arrays()))

    def arrays(self) -> dict[str, Any]:
        """:meth:`Result.arrays`, and the stick maps: of k increments and m contact points.

            maps = result.arrays()
            x, stuck = maps["contact_points_mm"][:, 0], maps["status"] == 1

        contact_points_mm (m, 2 | 3), on the undeformed surface, of a half model those at z >= 0;
        status (k, m): 0 open, 1 stick, 2 slip; pressure_MPa (k, m); shear_traction_MPa and slip_mm
        (k, m, 1 | 2): along x (and z). Where they are not held, asking for one raises ResultError.
        """
        found, contact = _Arrays(super().arrays()), self._arrays().contact
        if contact is None:
            return found
        return found | {
            "contact_points_mm": contact.points,
            "status": contact.status,
            "pressure_MPa": contact.normal_traction,
            "shear_traction_MPa": contact.tangential_traction,
            "slip_mm": contact.slip,
        }

    def _arrays(self) -> Analysis:
        return replace(self._analysis or Analysis(self), result=self)

    def _held(self, name: str) -> Any:
        """An array of the analysis. ResultError where it is not there."""
        found = getattr(self._arrays(), name)
        if found is None:
            raise ResultError(_NOT_HELD.format(name=name, design=self.design))
        return found

    def _increment(self, number: int) -> int:
        if not -(count := len(self.increments)) <= number < count:
            bound = f"{-count} to {count - 1}, an index (pages count from 1)"
            bound = bound if count else "nothing: there are no increments"
            raise ResultError(f"increment = {number} must be {bound}")
        return number % count


class _Arrays(dict[str, Any]):
    def __missing__(self, name: str) -> Any:
        raise ResultError(_NOT_HELD.format(name=name, design="this analysis"))


def load_result(folder: str | Path) -> Analysed:
    """The result in a folder that ``analyse`` wrote, with its arrays.

        load_result("out/maeno2000").plot_contact().show()

    Raises ResultError and DesignError where the files are not there, or not what was written.
    """
    return Analysed.of(read_analysis(Path(folder)))
