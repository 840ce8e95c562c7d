"""Controllers of somebody else's: what is no command is refused with a sentence."""

import math
import pickle
import sys
from fractions import Fraction

import numpy as np
import pytest

from fingerdesign.control.guarded import MOST_MOVE, ControllerError, Guarded
from fingerdesign.control.roster import Command, make_controller
from fingerdesign.control.signals import Sample
from fingerdesign.design.grip import Grip
from fingerdesign.errors import DesignError
from fingerdesign.runtime.registry import allow_code

FELT = Sample(np.zeros(3), 1.0, 0.0)


class Hand:
    """Return what it was given."""

    name = "hand"

    def __init__(self, given=None, own=None, held=None):
        self.given = given

    def start(self, calibration, sample):
        sample.readings[0] = 9.0

    def command(self, sample):
        return self.given() if callable(self.given) else self.given


class Abstractless(Hand):
    name = 3


def _raise(error):
    raise error


def _guarded(given):
    return Guarded("mine:Hand", lambda: Hand(given))


def test_each_part_of_a_sound_command_is_handed_on_as_it_is():
    given = Command(0.01, -0.02, True, 3.0, unsure=False, stick_ratio=0.4, warns=True)
    assert _guarded(given).command(FELT) == given
    other = Command(-0.01, 0.02, False, unsure=True, warns=False)
    assert _guarded(other).command(FELT) == other


@pytest.mark.parametrize(
    ("given", "named"),
    [
        (None, "NoneType"),
        ((0.0, 0.1), "tuple"),
        (lambda: Command, "type type"),
        (Command(math.nan, 0.1, False), "dx = nan"),
        (Command(0.0, -math.inf, False), "dy = -inf"),
        (Command(0.0, 2 * MOST_MOVE, False), "dy = 2000"),
        (Command(-2 * MOST_MOVE, 0.0, False), "dx = -2000"),
        (Command("1", 0.1, False), "dx = '1'"),
        (Command(1j, 0.1, False), "dx = 1j"),
        (Command(np.zeros(2), 0.1, False), "dx = "),
        (Command(10**400, 0.1, False), "OverflowError"),
        (Command(0.0, 0.1, "no"), "hold = 'no'"),
        (Command(0.0, 0.1, False, area=math.nan), "area = nan"),
        (Command(0.0, 0.1, False, stick_ratio=7.0), "stick_ratio = 7"),
        (Command(0.0, 0.1, False, warns=2), "warns = 2"),
        (lambda: _raise(ZeroDivisionError("x\ny")), "ZeroDivisionError: x y"),
        (lambda: sys.exit(0), "SystemExit"),
        (lambda: _raise(MemoryError()), "MemoryError"),
    ],
)
def test_what_is_no_command_is_named_and_goes_no_further(given, named):
    with pytest.raises(ControllerError, match="the controller mine:Hand: ") as caught:
        _guarded(given).command(FELT)
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_numbers_of_any_kind_become_plain_ones():
    given = Command(np.float32(0.5), Fraction(1, 4), np.bool_(True), stick_ratio=1 + 1e-9)
    command = _guarded(given).command(FELT)
    assert command == Command(0.5, 0.25, True, stick_ratio=1.0)
    assert [type(command.dx), type(command.dy), type(command.hold)] == [float, float, bool]
    assert _guarded(Command(np.array(0.1), 0, np.array(0))).command(FELT) == Command(0.1, 0, False)


def test_what_it_is_handed_stays_and_what_it_prints_is_no_output(capsys):
    def meddle():
        print("looking")
        np.seterr(all="raise")
        return Command(0.0, 0.1, False)

    before = np.geterr()
    hand = _guarded(meddle)
    assert hand.command(FELT) == Command(0.0, 0.1, False)
    assert np.geterr() == before
    assert capsys.readouterr().out == ""
    with pytest.raises(ControllerError, match="read-only"):
        hand.start(None, FELT)
    assert FELT.readings[0] == 0.0
    assert hand.given is meddle  # its own attributes are seen


def test_one_that_is_named_is_watched_and_a_shipped_one_is_as_it_was():
    allow_code(f"{__name__}:Hand", f"{__name__}:Abstractless")
    hand = make_controller(f"{__name__}:Hand", Grip())
    with pytest.raises(ControllerError, match="type Grip"):
        hand.command(FELT)
    assert not isinstance(make_controller("paper", Grip()), Guarded)
    with pytest.raises(DesignError, match="a class with a name"):
        make_controller(f"{__name__}:Abstractless", Grip())
