"""Controllers by the names that ``[grip] controller`` and ``--controller`` take.

    make_controller("oracle_1.2", design.grip, friction=0.3, mass_g=500.0)

A new one is a file in controllers/ with one registration: its own keys, ``[grip.NAME]``, the
ranges that it is tuned in, its line in the figures, what it must know of the object. ::

    @dataclass(frozen=True)
    class Press:
        force_N: float = key(10.0, "normal force", gt=0, le=1e5)

    @controller("press", table=Press, tuned=(Range("grip.press.force_N", 0.5, 40.0),))
    def press(grip, own, held):
        return PressController(own.force_N)

A class that is not registered, in any module, answers to "package.module:Class".

Who knows what: the oracles know friction and mass, the regulator has an estimator that was
trained on its design; all others have the design's ``[grip]`` table alone, one for every object.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from inspect import isabstract, signature
from typing import Any, TypeVar

import numpy as np

from fingerdesign.control.command import Command, Controller
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.guarded import Guarded
from fingerdesign.design.grip import Grip
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.registry import CONTROLLERS, LAST, Kind, own_values

__all__ = ["Command", "Controller"]  # Modules of controllers import them from here.
Look = tuple[str, Any, str]  # colour (report/style's name, or #rrggbb), dashes, marker
_Make = TypeVar("_Make", bound=Callable[..., Controller])
# The calls that a controller must accept: making it, and its two methods.
_CALLS = {"": "grip, own, held", "start": "self, calibration, sample", "command": "self, sample"}


@dataclass(frozen=True)
class Range:
    """A parameter (dotted key of the design) between two bounds; searched by its logarithm."""

    key: str
    low: float
    high: float
    logarithmic: bool = True

    def at(self, share: float) -> float:
        """The value at ``share`` (0 to 1) of the range, to four digits."""
        low, high = self._scaled(self.low), self._scaled(self.high)
        value = low + share * (high - low)
        return float(f"{np.exp(value) if self.logarithmic else value:.4g}")

    def share(self, value: float) -> float:
        """Position of ``value`` in the range, 0 to 1; beyond an end that end."""
        low, high = self._scaled(self.low), self._scaled(self.high)
        inside = min(max(value, self.low), self.high)
        return float((self._scaled(inside) - low) / (high - low))

    def _scaled(self, value: float) -> float:
        return float(np.log(value)) if self.logarithmic else value


@dataclass(frozen=True)
class Object:
    """Knowledge that a controller may be given besides the ``[grip]`` table; None: it is not known.

    friction, mass_g: the object's. estimator: the regulator's.
    """

    friction: float | None = None
    mass_g: float | None = None
    estimator: GripEstimator | None = None


@dataclass(frozen=True, kw_only=True)
class ControllerKind(Kind):
    """A registered controller.

    make: from the ``[grip]`` table, its own table (None where it has none) and the object. tuned:
    what it is tuned in. look: its line in figures. knows: what of the object it must be given, in
    words; None: nothing. trained: whether it needs an estimator.
    """

    make: Callable[[Grip, Any, Object], Controller]
    tuned: tuple[Range, ...] = ()
    look: Look | None = None
    knows: str | None = None
    trained: bool = False


def controller(
    name: str, *, place: int = LAST, table: type | None = None, table_name: str = "", **own: Any
) -> Callable[[_Make], _Make]:
    """Register what makes a controller; see :class:`ControllerKind`. table_name: absent: ``name``.

    May be given more than once, under several names.
    """

    def register(make: _Make) -> _Make:
        kind = ControllerKind(
            name=name, place=place, table=table, table_name=table_name or name, make=make, **own
        )
        CONTROLLERS.add(kind)
        return make

    return register


def _adopted(reference: str, made: Any, key: str) -> ControllerKind:
    """The kind of what "package.module:Class" names: the registered one, or the class as it is."""
    for kind in CONTROLLERS.loaded():
        if kind.make is made:
            return kind  # type: ignore[no-any-return]

    def refuse(bound: str, remedy: str) -> DesignError:
        return DesignError([Fault(key, reference, bound, remedy)])

    if not isinstance(made, type):
        raise refuse("a class, or what @controller registers", "name the controller's class")
    for method, given in _CALLS.items():
        call = f"{method or made.__name__}({given})"
        try:
            signature(getattr(made, method) if method else made).bind(*given.split(", "))
        except Exception as error:  # its metaclass may raise anything
            raise refuse(f"a controller: {call} can be called", f"correct it: {error}") from None
    if isabstract(made):
        lacks = ", ".join(sorted(getattr(made, "__abstractmethods__", ())))
        raise refuse("a class that can be made", f"it is abstract: give it {lacks}")
    name = getattr(made, "name", "")
    if not (isinstance(name, str) and re.fullmatch(r"[\w.-]{1,64}", name)):
        what = "a controller: a class with a name of letters, digits, '-', '_' or '.'"
        raise refuse(what, f'give {made.__name__} a line like name = "press"')
    return ControllerKind(name=reference, make=made)


CONTROLLERS.adopt(_adopted)


def make_controller(
    name: str,
    grip: Grip,
    *,
    estimator: GripEstimator | None = None,
    friction: float | None = None,
    mass_g: float | None = None,
) -> Controller:
    """A fresh controller with the parameters of a design's ``[grip]`` table.

    friction and mass_g are the object's; only the oracles look at them, and ValueError is raised
    where they lack. Raises DesignError for an unknown name and for a regulator without estimator,
    ControllerError where one that is not shipped cannot be made; what such a one answers is judged
    (:mod:`fingerdesign.control.guarded`).
    """
    kind: ControllerKind = CONTROLLERS.find(name, "grip.controller")
    if kind.knows is not None and (friction is None or mass_g is None):
        raise ValueError(f"{name} must be given the object's friction and mass")
    if kind.trained and estimator is None:
        bound = "a controller without training, where no estimator of this design is given"
        remedy = "train one first, or choose another controller"
        raise DesignError([Fault("grip.controller", name, bound, remedy)])
    own, known = own_values(grip, kind), Object(friction, mass_g, estimator)
    home = str(getattr(kind.make, "__module__", ""))
    if home.partition(".")[0] == "fingerdesign":
        return kind.make(grip, own, known)
    return Guarded(name, lambda: kind.make(grip, own, known))


def needs_training(name: str) -> bool:
    """True if a controller needs an estimator; DesignError for an unknown name."""
    kind: ControllerKind = CONTROLLERS.find(name, "--controller")
    return kind.trained
