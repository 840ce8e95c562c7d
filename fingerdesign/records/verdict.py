"""Verdicts on a result, ready to be shown: the terminal's block and a page's first screen."""

from dataclasses import dataclass
from typing import Literal

# "pass": the requirement is met; "fail": it is not; "warning": it is met, but with something to
# know; "note": a fact without a requirement.
Status = Literal["pass", "fail", "warning", "note"]
SIGNS: dict[Status, str] = {"pass": "✓", "fail": "✗", "warning": "!", "note": "·"}


@dataclass(frozen=True)
class Verdict:
    """One thing that was judged.

    name      of what: "slip sensing"
    number    what was found: "rank correlation 0.71 ... 0.75"
    target    what is required: "target 0.80"; empty of a note
    count     of how many cases, or by how far it fails: "0 of 5 μ", "15 x short"
    """

    status: Status
    name: str
    number: str
    target: str = ""
    count: str = ""

    @property
    def sign(self) -> str:
        """The character of the status."""
        return SIGNS[self.status]


@dataclass(frozen=True)
class Fix:
    """One change that was worked out, and its effect.

    change    a key of the design and its value, or a command
    brings    its effect: "gage signal ✓"
    by        the model that shows it: "section model"; empty of a command
    """

    change: str
    brings: str
    by: str = ""

    @property
    def effect(self) -> str:
        """The effect with its model: "gage signal ✓ (section model)"."""
        return f"{self.brings} ({self.by})" if self.by else self.brings


@dataclass(frozen=True)
class VerdictView:
    """Everything that is shown of a result at a glance.

    name, fidelity ("plane strain", "3-D"), seconds: the result's. fixes: most useful first.
    warnings: whole sentences. failure: of a run that did not end; then there are no verdicts.
    """

    name: str
    fidelity: str
    seconds: float
    verdicts: tuple[Verdict, ...]
    fixes: tuple[Fix, ...] = ()
    warnings: tuple[str, ...] = ()
    failure: str | None = None

    @property
    def summary(self) -> str:
        """The number of verdicts that fail: "2 of 4 fail", "all 4 pass"."""
        if self.failure:
            return "failed"
        judged = [each.status for each in self.verdicts if each.status != "note"]
        fail, warn = judged.count("fail"), judged.count("warning")
        if fail:
            return f"{fail} of {len(judged)} fail"
        if warn:
            return f"{len(judged) - warn} pass, {warn} warning{'s' * (warn > 1)}"
        if len(judged) < 2:
            return "passes" if judged else "numbers only"
        return f"all {len(judged)} pass"
