"""A kind of each sort from outside the package; no file of it knows them."""

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.control.roster import Command, Range, controller
from fingerdesign.design.body import body
from fingerdesign.design.plates import PlateLayout, plate_layout
from fingerdesign.layout.bodies import Block, surface_height
from fingerdesign.mesh.make import Mesher, mesher
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.runtime.registry import key
from fingerdesign.shapes.objects import Cylinder, SceneShape, scene_object


@dataclass(frozen=True)
class Steady:
    """``[grip.steady]``: both axes move by constant steps."""

    pull_mm: float = key(0.002, "dx of every step", gt=0, le=1)


class SteadyHand:
    name = "steady"

    def __init__(self, close, pull):
        self.close, self.pull = close, pull

    def start(self, calibration, sample):
        pass

    def command(self, sample):
        return Command(0.0 if sample.lifted else self.pull, self.close, False)


@controller("steady", table=Steady, tuned=(Range("grip.steady.pull_mm", 0.001, 0.01),))
def steady(grip, own, held):
    return SteadyHand(grip.approach_step_mm, own.pull_mm)


@dataclass(frozen=True)
class Bar:
    bar_mm: float = key(8.0, "the bar's diameter", gt=0, le=1e4)


@scene_object("bar", table=Bar)
class SceneBar(SceneShape):
    """A cylinder along z, by its diameter."""

    def make(self, table):
        return Cylinder(0.0, 0.5 * self._diameter(table))

    def curvature(self, table):
        return np.diag([2.0 / self._diameter(table), 0.0])

    def idle(self, table):
        return iter([("axis", "z"), ("tilt_deg", 0.0), ("turn_deg", 0.0)])

    def plane_in_z(self, table):
        return True

    def mirrors_in_z(self, table):
        return True

    @staticmethod
    def _diameter(table):
        return Bar().bar_mm if table.bar_mm is None else table.bar_mm


@dataclass(frozen=True)
class Slices:
    """``[mesh.slices]``."""

    number: int = key(3, "layers in half the depth", ge=1, le=50)


@mesher("slices", table=Slices)
class Slicer(Mesher):
    """The extruder with layers of its own number."""

    sections = True

    def make(self, design, own, zone, symmetric):
        options = design.mesh.model_copy(update={"layers": own.number})
        found = extrude(design.model_copy(update={"mesh": options}), zone, symmetric)
        return replace(found, mesher="slices")

    def why_not(self, design):
        return None if design.body.straight else "sliced: its body is not straight"


@dataclass(frozen=True)
class Rise:
    rise_mm: float = key(0.0, "of the flat top above the sides' height", ge=0, le=10)


@body("slab", table=Rise)
class Slab(Block):
    """A block under another name, with a key of its own."""

    words = "a slab"


@plate_layout("fanned")
class Fanned(PlateLayout):
    """Level, and turned by two degrees a millimetre along the row."""

    def placed(self, body, row, pace, middle):
        height = float(surface_height(body, pace, middle))
        return pace, height - row.cover_mm, -2.0 * pace, None
