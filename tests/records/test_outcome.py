"""An outcome's own text is read back; what only looks like one is refused."""

import json

import pytest

from fingerdesign.records.outcome import Outcome, OutcomeError
from tests.support.any_outcomes import any_outcomes

GOOD = next(each for each in any_outcomes(6, failed=0.0) if each.status == "ok")


def changed(**changes):
    return json.dumps(json.loads(GOOD.to_json()) | changes)


def test_its_own_text():
    for each in any_outcomes(20):
        assert Outcome.from_json(each.to_json()) == each


def nested(depth):
    return changed(values={"k": "DEEP"}).replace('"DEEP"', "[" * depth + "]" * depth)


@pytest.mark.parametrize(
    "text",
    [
        changed(status="failed"),
        changed(failure={"kind": "crashed", "sentence": "it did"}),
        changed(metrics={"cost": 1e31}),
        changed(metrics={"cost": 10**400}),
        changed(values={"plates.count": 10**400}),
        changed(values={"plates.count": [[-(10**40)]]}),
        changed(design={"body": {"width_mm": 1e300}}),
        changed(traces={"gages": [[1.0, 1e200]]}),
        changed(seconds=1e31),
        changed(values={"k": 1}).replace('"k": 1', '"k": ' + "9" * 5000),
        nested(40),
        nested(150),
        nested(100_000),
        "[" * 100_000,
    ],
    ids=range(14),
)
def test_what_no_page_could_bear_is_refused(text):
    with pytest.raises(OutcomeError):
        Outcome.from_json(text)
