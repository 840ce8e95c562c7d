"""Laws between answers hold on random fingers: a few fast, more slow."""

import pytest

from tests.support.laws import LAWS, known

# Both bodies, planes, a slope and a cylinder; plates turned, bent and as sheets.
FAST = {"plane-strain": (2, 4, 9), "3d": ()}
SLOW = {"plane-strain": (0, 1, 3, 5, 13), "3d": (4, 8)}
CASES = [
    pytest.param(name, fidelity, seed, marks=marks, id=f"{name}, {fidelity}, {seed}")
    for seeds, marks in ((FAST, ()), (SLOW, pytest.mark.slow))
    for name, law in LAWS.items()
    for fidelity in law.fidelities
    for seed in seeds[fidelity]
]


@pytest.mark.parametrize(("name", "fidelity", "seed"), CASES)
def test_law(name, fidelity, seed):
    law = LAWS[name]
    wrong = law.wrong(known(seed, fidelity).finger)
    assert wrong is None or wrong <= law.bound, f"{law.wrong.__doc__} To {law.bound}: {law.why}."
