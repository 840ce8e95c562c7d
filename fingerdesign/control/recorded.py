"""A recorded grip in the place of a plant: the same controllers and estimators beside a real rig.

A record cannot answer to what is asked of it: each move returns its next sample, whatever the
controller would have done. replay.py asks a controller along it.
"""

from __future__ import annotations

from pathlib import Path

from fingerdesign.control.plant import Truth
from fingerdesign.control.signals import Sample
from fingerdesign.control.trace import Trace, read_trace
from fingerdesign.errors import SolverError


class TraceEnded(SolverError):
    """More samples were asked for than the trace has."""


class RecordedPlant:
    """Plays a trace back, sample by sample; see trace.py for the file.

    source: a CSV file or a Trace. gages: how many the finger has, where that is known. Raises
    DesignError, with row and column, for a file that is faulty.
    """

    def __init__(self, source: Path | str | Trace, gages: int | None = None) -> None:
        self.trace = source if isinstance(source, Trace) else read_trace(source, gages)
        self._next = 0
        self._truth = Truth(0.0, 0.0, 0.0, 0.0, None, 0.0, False)

    def move(self, dx: float, dy: float) -> Sample:
        """The next sample; what is asked for is not done. Raises TraceEnded after the last."""
        trace, k = self.trace, self._next
        if k >= len(trace):
            raise TraceEnded(
                f"the trace has {len(trace)} samples and ends in row {trace.rows[-1]}; "
                "record a longer one"
            )
        self._next += 1
        normal, tangential = float(trace.normal_force[k]), float(trace.tangential_force[k])
        lifted = None if trace.lifted is None else bool(trace.lifted[k])
        self._truth = Truth(
            approach=self._truth.approach + float(trace.dy[k]),
            shear=self._truth.shear + float(trace.dx[k]),
            normal_force=normal,
            tangential_force=tangential,
            stick_ratio=None,
            slip_distance=0.0,
            complete_slip=False,
            lifted=lifted,
        )
        return Sample(trace.readings[k].copy(), normal, tangential, bool(lifted))

    def truth(self) -> Truth:
        """Where the stage is and what was felt; nobody knows what stuck or slipped."""
        return self._truth

    def __len__(self) -> int:
        """Samples left."""
        return len(self.trace) - self._next
