"""The table of docs/reference/suite.md, from the files of ``cases``: ``make records`` writes it.

Values are those of the last run that was accepted, ``regression``; a run of the suite checks them.
"""

from pathlib import Path

from fingerdesign.records.base import csv_text
from fingerdesign.runtime.files import write_whole
from fingerdesign_bench.known.case import Outcome, load_cases
from fingerdesign_bench.known.run import HEADINGS, row

FILE = Path(__file__).parents[3] / "docs" / "reference" / "suite.csv"


def table() -> str:
    """The rows as CSV under HEADINGS."""
    return csv_text(HEADINGS, [row(Outcome(case, case.regression)) for case in load_cases()])


if __name__ == "__main__":
    print(write_whole(FILE, table()))
