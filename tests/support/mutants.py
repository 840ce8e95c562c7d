"""Mutants: faults put into a copy of the code; the tests named with each must catch it.

    python tests/support/mutants.py [WORD ...]

Without a word all of them, else those of which the title holds one. A line a mutant: what was made
wrong, and the first test that fails. Exits with 1 where a mutant lives, or where the text to be
made wrong is no longer there.
"""

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("fingerdesign", "cli", "benchmarks", "tests", "designs", "docs")
_TIME_S = 1200.0  # of the tests of one
FILES = ("pyproject.toml", "README.md", "CHANGELOG.md", "LICENSE")


class Mutant(NamedTuple):
    """``right`` in the file becomes ``wrong``; tests: what must catch it."""

    what: str
    file: str
    tests: str
    right: str
    wrong: str


MUTANTS = """
contact law: the friction disc is twice as wide
fingerdesign/contact/laws.py | tests/contact
- bound = friction.bound(projected[:, 0])
+ bound = 2.0 * friction.bound(projected[:, 0])

hands: a calibration of other steps is taken
fingerdesign/control/plants/rig.py | tests/search/test_evaluate.py
- known = (friction, bounds, grip.hardware, grip.seed)
+ known = (friction, grip.hardware, grip.seed)

hands: another travel is taken for the same finger
fingerdesign/search/run/hand.py | tests/search/test_evaluate.py
- STEPS = ("grip.approach_step_mm", "grip.shear_step_mm")
+ STEPS = ("grip.approach_step_mm", "grip.shear_step_mm", "grip.max_approach_mm")

optimise: a dome keeps the share of its arc
fingerdesign/search/passing/passing.py | tests/search/test_passing.py
- found = self._with_best_share(jobs)
+ found = self.evaluated(jobs)

optimise: fingers with good gages are taken as they come
fingerdesign/search/passing/found.py | tests/search/test_passing.py
- return shortfall_of(outcome), -(outcome.metrics.get("area_correlation") or 0.0)
+ return shortfall_of(outcome), 0.0

optimise: fingers that cannot be cast come first
fingerdesign/search/passing/passing.py | tests/search/test_passing.py
- return sorted(outcomes, key=lambda each: not self.castable[each.digest])
+ return list(outcomes)

optimise: the arc of a pin is as deep as the pin
fingerdesign/search/passing/space.py | tests/search/test_passing.py
- tries.insert(0, arc | {"body.depth_mm": span})
+ tries.insert(0, arc)

optimise: many bodies are tried though an arc may replace them
fingerdesign/search/passing/passing.py | tests/search/test_passing.py
- if not self.last and short >= _MOST_SHORT:
+ if not self.last and short >= 8 * _MOST_SHORT:

optimise: the arc that replaces a body begins anywhere
fingerdesign/search/passing/space.py | tests/search/test_passing.py
- starts = _sound_starts(space, [*again[:_AGAIN], *starts_of(base, space.parameters)])
+ starts = _sound_starts(space, starts_of(base, space.parameters))

optimise: a core is given up though gages are good with it
fingerdesign/search/passing/space.py | tests/search/test_passing.py
- if base.body.core is not None and freedom.allows("body.core") and hinders:
+ if base.body.core is not None and freedom.allows("body.core"):

optimise: the radius of a similar finger goes with its width
fingerdesign/search/passing/ranges.py | tests/search/test_passing_space.py
- powers = dict.fromkeys(_LENGTHS, 1) | {"body.arc_radius_mm": 2}
+ powers = dict.fromkeys(_LENGTHS, 1) | {"body.arc_radius_mm": 1}

optimise: a core stays as deep as it was in a shallower body
fingerdesign/search/passing/ranges.py | tests/search/test_passing_space.py
- ("body.core.depth_mm", "body.depth_mm"),
+ ("body.core.depth_mm", "body.width_mm"),

gage area: gages of a row along z get their own x
fingerdesign/fem/model.py | tests/fem/test_gages.py
- return np.where(in_row, positions[:, 0], np.nan)
+ return positions[:, 0].copy()

friction law: the cap is left out
fingerdesign/shapes/friction.py | tests/contact/test_friction_laws.py
- return np.asarray(np.minimum(np.minimum(STEEPEST * normal, free), self.cap * areas))
+ return np.asarray(np.minimum(STEEPEST * normal, free))

contact law: the residual takes penetration for a gap
fingerdesign/contact/laws.py | tests/contact
- step = multiplier - motion / self_compliance[:, None]
+ step = multiplier + motion / self_compliance[:, None]

certificate: forces outside the friction disc pass
fingerdesign/contact/laws.py | tests/contact
- coulomb = max(0.0, float((lengths(tangential) - bound).max())) / force
+ coulomb = 0.0

recorded: a taxel that stays behind still counts
fingerdesign/trials/recorded/detect.py | tests/trials/test_recorded.py
- area = int((d > THRESHOLD * scale).sum())
+ area = int((d >= 0.0).sum())

recorded: an alarm after the slip is early
fingerdesign/trials/recorded/detect.py | tests/trials/test_recorded.py
- share(slip, lambda w: w.lead > 0.0) if timed else None,
+ share(slip, lambda w: w.alarm) if timed else None,

recorded: a marker that is lost has moved
fingerdesign/trials/recorded/uskin.py | tests/trials/test_recorded.py
- lost = np.abs(marker[begin:end]).max(axis=1) > _LOST
+ lost = np.abs(marker[begin:end]).max(axis=1) > 99.0

recorded: the exponent has the other sign
fingerdesign/trials/recorded/friction.py | tests/trials/test_recorded.py
- return Exponent(-slope, -slope - reach, -slope + reach, len(x), count)
+ return Exponent(slope, slope - reach, slope + reach, len(x), count)

unit: the peak pressure is a force
fingerdesign/contact/measures.py | tests/contact benchmarks/tests/test_known.py
- pressure = increment.multiplier[:, 0] / model.areas
+ pressure = increment.multiplier[:, 0]

unit: strains read as parts, not as microstrain
fingerdesign/control/signals.py | tests/control
- return np.asarray(1e6 * gages
+ return np.asarray(gages

measure: the largest slip for the least
fingerdesign/contact/measures.py | tests/contact tests/control
- slip_distance=float(travelled.min())
+ slip_distance=float(travelled.max())

frame: plates along z lie along x
fingerdesign/layout/frames.py | tests/layout tests/fem
- order = parts if self.along == "x" else (zero, vector[..., 1], vector[..., 0])
+ order = parts

frame: a bent plate's place along its arc is one along its chord
fingerdesign/layout/frames.py | tests/layout tests/fem
- s = self.bend_radius * np.arctan2(s, rise)
+ s = s + 0.0 * rise

shrinkage: taken off the cavity instead of added
fingerdesign/mold/plan/slots.py | tests/mold/test_planning.py tests/mold/test_legs.py tests/mold
- return 1.0 / (1.0 - design.mold.shrinkage_used)
+ return 1.0 - design.mold.shrinkage_used

readout: a half model's mirror image is not turned
fingerdesign/fem/readout.py | tests/fem
- return sp.csr_matrix(sp.diags_array(turn.ravel()) @ rows)
+ return rows

readout: a gage's strain is not divided by its length
fingerdesign/fem/readout.py | tests/fem
- np.outer([1.0 / length, -1.0 / length], frame.axis)
+ np.outer([1.0, -1.0], frame.axis)

readout: a gage's width counts twice
fingerdesign/fem/readout.py | tests/fem
- return gages.z_mm + 0.5 * gages.width_mm * nodes, 0.5 * weights
+ return gages.z_mm + 0.5 * gages.width_mm * nodes, weights

certificate: slip not opposed to its force passes
fingerdesign/contact/laws.py | tests/contact
- return max(self.complementarity, self.coulomb, self.dissipation)
+ return max(self.complementarity, self.coulomb)

gages: handed to the controller in the opposite order
fingerdesign/control/plants/plant.py | tests/control
- readings = gage_readings(found.gages, face)
+ readings = gage_readings(found.gages, face)[::-1]

object: the tilt of a cylinder along x is ignored
fingerdesign/shapes/objects.py | tests/contact/test_objects.py
- along_x = np.array([math.cos(tilt), math.sin(tilt), 0.0])
+ along_x = np.array([1.0, 0.0 * tilt, 0.0])

digest: a scene's friction is no part of it
fingerdesign/design/digest.py | tests/design tests/records
- UNSEEN: Any = {"mold": True, "grip": {"defaults"}}
+ UNSEEN: Any = {"mold": True, "grip": {"defaults"}, "object": {"friction_coefficient"}}

path: friction moves once a row, whatever its substeps
fingerdesign/contact/path.py | tests/contact
-             state = increment.state
+         state = increment.state

cached meshes: one for every contact zone
fingerdesign/mesh/cache.py | tests/mesh
-         "zone_mm": asdict(zone),
+         "zone_mm": asdict(zone)["inner"],

cached meshes: one for the half and the whole
fingerdesign/mesh/cache.py | tests/mesh/test_io.py
-         "symmetric": symmetric,
+         "symmetric": True,

cached meshes: sizes without their stretch
fingerdesign/mesh/cache.py | tests/mesh/test_io.py
-         "sizes": asdict(sizes),
+         "sizes": asdict(sizes) | {"stretch": 1.0},

training key: without the friction of the bench
fingerdesign/sensing/train/result.py | tests/sensing/test_cache_keys.py
-         grip.bench_friction_coefficient,
+         None,

studio: one character of the token is enough
fingerdesign/studio/door.py | tests/studio/test_serve.py
-     if not hmac.compare_digest(given.encode(errors="replace"), token.encode()):
+     if not (given and token.startswith(given)):

studio: an origin that ends with the host passes
fingerdesign/studio/door.py | tests/studio/test_serve.py
-     if origin is not None and origin != f"{request.url.scheme}://{request.host}":
+     if origin is not None and not origin.endswith(request.host):

regulator: the smaller share of friction in use for the larger
fingerdesign/control/controllers/regulator.py | tests/control/test_c_code.py tests/control
- max(self._utilisation, believed)
+ min(self._utilisation, believed)

C regulator: a friction that is hardly known has no floor
fingerdesign/control/templates/regulator.c | tests/control/test_c_code.py
- return friction_at(r, force) * larger(1.0f - CAUTION / sqrtf(r->weight), 0.5f);
+ return friction_at(r, force) * (1.0f - CAUTION / sqrtf(r->weight));

friction: the first probe says nothing of the exponent
fingerdesign/control/controllers/friction_belief.py | tests/control/test_estimator.py
- found = (_PRIOR * _EXPONENT + 0.5 * rise * fall) / (_PRIOR + 0.5 * rise * rise)
+ found = _EXPONENT

bench: without what a coarse mesh misses
fingerdesign/sensing/identify/bench.py | tests/sensing/test_identify_bench.py -k coarse_mesh
- more = [moduli[0] / moduli[1] * each for each in missed]
+ more = [0.0 * each for each in missed]

identify: slopes do not pass through the gages' gains
fingerdesign/sensing/identify/bench_fit.py | tests/sensing/test_identify_bench.py -k by_moduli
- own = through[:, None] * (self.columns + self._exact_columns(x))
+ own = self.columns + self._exact_columns(x)

identify: gains are not fitted again at each finger
fingerdesign/sensing/identify/bench_fit.py | tests/sensing/test_identify_bench.py -k gains_and_touch
- x[own] += lsq_linear(jacobian, -self.residual(x), room).x
+ x[own] += 0.0 * lsq_linear(jacobian, -self.residual(x), room).x

an order of elimination is lost to the next pattern
fingerdesign/fem/factor.py | tests/fem/test_condensation.py -k order_of_a_model
- if held + coming <= _held.get():
+ if held <= 0:

sensitivities: values lie farther apart than they do
fingerdesign/sensing/identify/sensitivities.py | tests/sensing/test_identify_bench.py -k own_curves
- return Difference(low, high, 2.0 * step)
+ return Difference(low, high, 3.0 * step)

sensitivities: two leans lie farther apart than they do
fingerdesign/sensing/identify/sensitivities.py | tests/sensing/test_identify_bench.py -k own_curves
- return Difference(leaning_by(lean_deg - step), leaning_by(lean_deg + step), 2.0 * step)
+ return Difference(leaning_by(lean_deg - step), leaning_by(lean_deg + step), 3.0 * step)

sensitivities: a part of the rates is left out
fingerdesign/sensitivity/forms.py | tests/sensitivity
- found[numbers] += own
+ found[numbers] = own

threads: answers come as they are ready
fingerdesign/runtime/threads.py | tests/runtime/test_threads.py
- yield waiting.popleft().result()
+ yield waiting.pop().result()

keys of cached work: of a mesh's file the path alone
fingerdesign/design/digest.py | tests/sensing/test_cache_keys.py
-     if isinstance(model, MeshOptions):
+     if False:

sampling: a whole number by rounding, the ends half as often
fingerdesign/search/study/values.py | tests/search/test_study_file.py
- value = self.low + step * min(int(share * levels), levels - 1)
+ value = self.low + step * round(share * (levels - 1))

status: on the limit within a thousandth
fingerdesign/contact/outcome.py | tests/contact/test_history.py
- _ON_LIMIT = 1e-9
+ _ON_LIMIT = 1e-3

history: the kinetic share is taken of what slid before as well
fingerdesign/contact/history.py | tests/contact/test_history.py
- at_rest = replace(self.problem, friction_share=self._own_shares)
+ at_rest = self.problem

statistics: clusters count for more than they are worth
fingerdesign/records/statistics.py | tests/trials/test_control_page.py
- spread = clusters / (clusters - 1) * float(
+ spread = float(

contact: a twist moves points the wrong way along z
fingerdesign/contact/problem.py | tests/contact tests/fem
- modes[3, :, 2] = np.deg2rad(points[:, 0])
+ modes[3, :, 2] = -np.deg2rad(points[:, 0])

contact: patches of friction forget those that were there
fingerdesign/contact/problem.py | tests/contact tests/trials
- return replace(self, friction_share=np.asarray(share * own, dtype=np.float64))
+ return replace(self, friction_share=np.asarray(share, dtype=np.float64))

measure: the border of stick with the compliance of the border of contact
fingerdesign/contact/measures.py | tests/contact benchmarks/tests/test_known.py
- return 4.0 * local, 5.0 * local
+ return 4.0 * local, 4.0 * local

measure: the peak pressure at the free ends counts
fingerdesign/contact/measures.py | tests/contact benchmarks/tests/test_known.py
- peak_pressure=float(pressure[inner].max(initial=0.0)),
+ peak_pressure=float(pressure.max(initial=0.0)),

friction by pressure: nothing is carried before the first touch
fingerdesign/contact/friction.py | tests/contact
- return np.where(pressed > 0.0, whole / safe, self.shares * self.law.steepest)
+ return np.where(pressed > 0.0, whole / safe, 0.0)

history: nodes that begin to slide leave the contact settled
fingerdesign/contact/history.py | tests/contact tests/control
- self.settled = not (slid & ~self._slid).any()
+ self.settled = True

balance: a shear is found to a ten thousandth of the force
fingerdesign/contact/balance.py | tests/contact tests/control
- _TOLERANCE = 1e-9  # of the largest force in the balance
+ _TOLERANCE = 1e-4  # of the largest force in the balance

certificate: tension between finger and object passes
fingerdesign/contact/laws.py | tests/contact
- complementarity = float(np.abs(np.minimum(normal / force, gap / length)).max())
+ complementarity = float(np.minimum(normal / force, gap / length).max(initial=0.0))

regulator: a step of the climb fades the past as one of a pull does
fingerdesign/control/controllers/regulator.py | tests/control
- sure, memory = _CLIMBING * sure, 1.0 - _CLIMBING * (1.0 - memory)
+ sure, memory = _CLIMBING * sure, memory

slip ratio: the object's lean is left out
fingerdesign/contact/problem.py | tests/contact
- pressing, pulling = self.resultant(self.to_global(limit)).tolist()
+ pressing, pulling = self.model.total_force(limit)[:2].tolist()

training: smooth objects weigh less
fingerdesign/sensing/train/samples.py | tests/sensing/test_train.py -k smooth
- weights = np.full(len(inputs), 1.0 / grip.friction_coefficient)
+ weights = np.full(len(inputs), grip.friction_coefficient)

training: the network does not see the weights
fingerdesign/sensing/train/network.py | tests/sensing/test_train.py -k smooth
- network.fit(rows, truths.astype(np.float32), sample_weight=own)
+ network.fit(rows, truths.astype(np.float32))

training: the friction utilisation is of the coefficient, whatever leans
fingerdesign/sensing/train/paths.py | tests/control/test_grip_episode.py
- t.tangential_force / (t.slip_ratio * t.normal_force) if t.slip_ratio else 0.0
+ t.tangential_force / (self.friction_coefficient * t.normal_force) if t.slip_ratio else 0.0

derivatives: cells count as alike however they move
fingerdesign/sensitivity/forms.py | tests/sensitivity
- for field in (mesh.points, moving):
+ for field in (mesh.points, 0.0 * moving):

derivatives: a cell that grows holds no more pressure
fingerdesign/sensitivity/forms.py | tests/sensitivity
- self._add_pressures(found, self.weights * growth, self.first)
+ self._add_pressures(found, 0.0 * self.weights * growth, self.first)

derivatives: a velocity does not grow the volume
fingerdesign/sensitivity/forms.py | tests/sensitivity
- self._add(found, turned + 0.5 * grown, np.where(self.mixed, 0.0, self.first), self.shear)
+ self._add(found, turned + 0.0 * grown, np.where(self.mixed, 0.0, self.first), self.shear)

derivatives: where rubber grows stiffer the plates do too
fingerdesign/sensitivity/parts.py | tests/sensitivity
- grown = -stiffer * (1.0 - mine)
+ grown = -0.0 * stiffer * (1.0 - mine)

derivatives: where rubber grows stiffer attached sheets do too
fingerdesign/sensitivity/parts.py | tests/sensitivity
- attached = None if body.attached is None else -stiffer * _full(body.attached)
+ attached = None if body.attached is None else -0.0 * stiffer * _full(body.attached)

scatter: a row does not move as a whole
fingerdesign/mold/placement.py | tests/mold/test_placement.py
- .sum(axis=(0, -1)) + (rows**2).sum(axis=0)
+ .sum(axis=(0, -1)) + 0.0 * (rows**2).sum(axis=0)

scatter: the gage area takes the threshold of a row that presses
fingerdesign/tolerance/area.py | tests/tolerance
- [int(np.argmax(shears))]
+ [int(np.argmin(shears))]

scatter: no gage's factor moves the gage area
fingerdesign/tolerance/area.py | tests/tolerance
- variance(gain * readings, none) for gain
+ variance(0.0 * gain * readings, none) for gain

metric: a study does not see the mold of fingers as made
fingerdesign/search/run/evaluate.py | tests/search/test_evaluate.py
- if self.on_request else ""
+ if self.on_request and self.scene else ""

derivatives: the field of a force on the rows has the other sign
fingerdesign/fem/factor.py | tests/fem/test_condensation.py
- loads[:, self._size :] = -border
+ loads[:, self._size :] = border

regulator: a small tug at a hanging object is not answered
fingerdesign/control/controllers/regulator.py | tests/control/test_estimator.py
- return in_use > self._own.most_held or ratio > _TUGGED * self._carried
+ return in_use > self._own.most_held

C regulator: the error that the estimator reports is always its least
fingerdesign/control/templates/regulator.c | tests/control/test_c_code.py
- found.spread = SPREAD[k][1];
+ found.spread = SPREAD[0][1];

bench: cross-talk by the difference of the two slides
fingerdesign/control/calibration.py | tests/control
- return 0.0 if right is None or left is None else 0.5 * (right + left)
+ return 0.0 if right is None or left is None else 0.5 * (right - left)

bench: the press begins at the first force, not at first contact
fingerdesign/control/calibration.py | tests/control
- begin = max(int(np.argmax(forces > 0.0)) - 1, 0)
+ begin = int(np.argmax(forces > 0.0))

signals: past its last force a calibration stays level
fingerdesign/control/signals.py | tests/control
- share = (normal_force - force[k]) / (force[k + 1] - force[k])
+ share = min((normal_force - force[k]) / (force[k + 1] - force[k]), 1.0)

signals: a falling pull is below any floor
fingerdesign/control/signals.py | tests/control
- if abs(force_change) < floor or not np.isfinite(responses).all():
+ if force_change < floor or not np.isfinite(responses).all():

hardware: play is lost at every move back, not at a turn alone
fingerdesign/control/plants/hardware.py | tests/control
- lost = min(self._backlash - self._play, -turned)
+ lost = min(self._backlash, -turned)

hardware: cross-talk from one neighbour alone
fingerdesign/control/plants/hardware.py | tests/control
- strain = strain + hardware.gage_cross_talk * (padded[:-2] + padded[2:])
+ strain = strain + hardware.gage_cross_talk * padded[:-2]

lift: an object slides on past its support
fingerdesign/control/plants/lift.py | tests/control
- way = max(min(slid.way, move.hand - at), 0.0)  # the support ends it
+ way = max(slid.way, 0.0)  # the support ends it

lift: of several slides the last alone is reported
fingerdesign/control/plants/lift.py | tests/control
- self._slid_before, self._slide_time = self._truth.slid, 0.0
+ self._slid_before, self._slide_time = 0.0, 0.0

cached meshes: one for solid plates and for sheets
fingerdesign/mesh/cache.py | tests/mesh
- "model": design.plates.model,
+ "model": "solid",

training key: the preload for the stage's travel
fingerdesign/sensing/train/result.py | tests/sensing
- Bounds.of(grip).max_approach,
+ Bounds.of(grip).preload,

digest: a controller's class by its name alone
fingerdesign/design/digest.py | tests/design tests/trials tests/records
- out["controller"] = [hand, CONTROLLERS.content_of(hand)]
+ out["controller"] = [hand]

key of a stored grip: without the arm's tug
fingerdesign/trials/stored.py | tests/trials
- parts = (cell.controller, cell.friction, cell.mass_g, cell.noise, cell.tug)
+ parts = (cell.controller, cell.friction, cell.mass_g, cell.noise)

statistics: an error's interval is that of its square
fingerdesign/records/statistics.py | tests/records tests/trials
- reach = 0.5 * float(stdtrit(clusters - 1, 1.0 - _TAIL)) * math.sqrt(variance) / mean
+ reach = float(stdtrit(clusters - 1, 1.0 - _TAIL)) * math.sqrt(variance) / mean

journal: one of another format is read
fingerdesign/runtime/journal.py | tests/runtime
- if any(about.get(key) != self._about[key] for key in ("format", "kind")):
+ if any(about.get(key) != self._about[key] for key in ("kind",)):

cache: it holds one entry more than it may
fingerdesign/runtime/cache.py | tests/runtime
- if number >= most or (number and total > self._most_MB):
+ if number > most or (number and total > self._most_MB):

studio: a machine of the same network comes in
fingerdesign/studio/door.py | tests/studio
- if not ip_address(request.remote or "0.0.0.0").is_loopback:
+ if not ip_address(request.remote or "0.0.0.0").is_private:

studio: one key that a page may set lets all others in
fingerdesign/studio/door.py | tests/studio
- if not all(isinstance(row, dict) and row.get("key") in changed for row in rows):
+ if not any(isinstance(row, dict) and row.get("key") in changed for row in rows):

mold: a lock takes three times its rubber
fingerdesign/mold/products/casting.py | tests/mold
- cone = math.pi * plan.base * (d**2 + d * outer + outer**2) / 12.0
+ cone = math.pi * plan.base * (d**2 + d * outer + outer**2) / 4.0

mold: a threaded rod gets one nut
fingerdesign/mold/products/bill.py | tests/mold
- yield _item("nut", count + rods[size], *_STEEL, size)
+ yield _item("nut", count, *_STEEL, size)

unit: a warm body's load lacks two thirds of its bulk
fingerdesign/fem/thermal.py | tests/fem
- stress = body.thickness * (3.0 * first + 2.0 * shear) * expansion
+ stress = body.thickness * (first + 2.0 * shear) * expansion

turning: the centre is on the other side
fingerdesign/contact/turning.py | tests/contact/test_turning.py
- modes[3] -= np.deg2rad(centre_mm) * modes[1]
+ modes[3] += np.deg2rad(centre_mm) * modes[1]

turning: the springs never rest
fingerdesign/contact/increment.py | tests/contact/test_turning.py
- reached = problem.found_motion(motion, found.multiplier)
+ reached = motion

turning: the normal forces' part of the limit is left out
fingerdesign/contact/turning.py | tests/contact/test_turning.py
- carried = bounds @ size - forces @ pull[:, 0] - lifts @ found
+ carried = bounds @ size

turning: no turn is too far
fingerdesign/control/plants/lift.py | tests/control/test_turning_lift.py
- if abs(found.held.increment.state.motion.twist_deg) > MOST_TURN_DEG:
+ if False:

turning: the square of the arm over the turn radius is forgotten
fingerdesign/control/features.py | tests/control/test_estimator.py
- return np.where(known, 1.0 / (1.0 + (arm / np.where(known, radius, 1.0)) ** 2), 1.0)
+ return np.where(known, 1.0 / (1.0 + np.abs(arm) / np.where(known, radius, 1.0)), 1.0)

turning: the bench's curves lose the model's turn radius
fingerdesign/control/estimator.py | tests/control/test_c_code.py
- return replace(self, curves=FingerCurves.of(calibration).turning_as(self.curves))
+ return replace(self, curves=FingerCurves.of(calibration))

turning: training labels a moment by the ratio of the lift
fingerdesign/control/plants/lift.py | tests/control/test_turning_lift.py
- if changes and not ratio_of_now:
+ if changes:

friction: a coefficient holds at one pressure, whatever the force
fingerdesign/contact/gross_slip.py | tests/contact/test_friction_laws.py
- FrictionLaw(friction, exponent=exponent, reference=float(falls ** (-1.0 / exponent)))
+ FrictionLaw(friction, exponent=exponent, reference=0.1)

gross slip: a leaning surface is dragged as a level one
fingerdesign/contact/gross_slip.py | tests/contact/test_friction_laws.py
- if problem.softness is not None or not problem.is_level:
+ if problem.softness is not None:

friction: rubber that relaxes has less of it
fingerdesign/control/plants/fingers.py | tests/control/test_lift.py
- left**-exponent
+ left**exponent

estimator: a dead gage is forgotten where a press would not strain it
fingerdesign/control/features.py | tests/control/test_estimator.py
- dead[k, gage] = np.abs(alone).max() > _HEARD * nothing
+ dead[k, gage] = np.abs(alone[-1]) > _HEARD * nothing

estimator: a dead gage is completed without the roots of the relations
fingerdesign/control/completion.py | tests/control/test_estimator.py
- -np.linalg.solve(both, self.matrix[dead] * self.root)
+ -np.linalg.solve(both, self.matrix[dead])

estimator: rows with dead gages count in the relations
fingerdesign/control/completion.py | tests/control/test_estimator.py
- whole = rows[np.isfinite(rows).all(axis=1)]
+ whole = np.nan_to_num(rows)

estimator: the last value of a dead gage helps to complete it, in C
fingerdesign/control/templates/regulator.c | tests/control/test_c_code.py
- values[places[count++]] = 0.0f;
+ count++;

turning: half a finger does
fingerdesign/analysis/case.py | tests/control/test_turning_lift.py
- return centred and mirrors_in_z(self.design) and self.path_scene.mirrors_in_z
+ return mirrors_in_z(self.design) and self.path_scene.mirrors_in_z

identify: the modulus of Coulomb's fit stays
fingerdesign/sensing/identify/trace_fit.py | tests/sensing/test_identify_trace.py
- own, fit = _with_law(own, law, trace, fidelity)
+ fit = law

training: networks predict their errors on grips that they know
fingerdesign/sensing/train/network.py | tests/sensing/test_train.py
- others[tested] = False
+ others[tested] = True

identify: what a model does not explain widens nothing
fingerdesign/sensing/identify/trace_fit.py | tests/sensing/test_identify_trace.py
- total = information / max(self.misfit, 1.0)
+ total = information / min(self.misfit, 1.0)

trials: a tug ends in stairs
fingerdesign/trials/grid.py | tests/trials/test_control_study.py
- Disturbance(begin + k, part, end - begin - k)
+ Disturbance(begin + k, part, end - begin)

search: parts of an outcome share a digest
fingerdesign/search/run/evaluate.py | tests/search/test_evaluate.py
- parts = (decided, gripped, self.part, f"metrics {METRICS_VERSION}", mold, *self.on_request)
+ parts = (decided, gripped, f"metrics {METRICS_VERSION}", mold, *self.on_request)

compare: more grips tell less
fingerdesign/search/compare/recommend.py | tests/search/test_compare_page.py
- share = metric.noisy * math.sqrt(GRIPS_MEASURED / grips) or share
+ share = metric.noisy * math.sqrt(grips / GRIPS_MEASURED) or share

venting: openings are twice as wide
fingerdesign/mold/checks/venting.py | tests/mold/test_planning.py
- - 0.5 * hole.diameter
+ - hole.diameter

tolerance: rows without a pull have a response
fingerdesign/tolerance/area.py | tests/tolerance
- return np.asarray(alone & (pull > _PULL * np.abs(readings.normal_force)))
+ return np.asarray(alone & (pull > 0.0))

identify: another finger's bench is fitted
fingerdesign/sensing/identify/bench_fit.py | tests/sensing/test_identify_bench.py
- if fit.misfit > _ANOTHER**2 and (moduli & stopped).any():
+ if fit.misfit > _ANOTHER**2 and (moduli & stopped).all():
"""


def mutants():
    """Those of the text: what, where and which tests, the line as it is and as it becomes."""
    for block in MUTANTS.strip().split("\n\n"):
        what, place, right, wrong = block.splitlines()
        yield Mutant(what, *place.split(" | "), right.removeprefix("- "), wrong.removeprefix("+ "))


def caught_by(mutant, tree):
    """The first test that fails on the mutant; None where all pass."""
    path = tree / mutant.file
    text = path.read_text("utf-8")
    if mutant.right not in text:
        raise SystemExit(f"{mutant.file} no longer holds {mutant.right!r}")
    path.write_text(text.replace(mutant.right, mutant.wrong), "utf-8")
    try:
        paths = [str(tree / each) for each in (".", "cli", "benchmarks")]
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-x", *shlex.split(mutant.tests)],
            cwd=tree,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
            capture_output=True,
            text=True,
            check=False,
            timeout=_TIME_S,
        )
    except subprocess.TimeoutExpired:
        return "it never ends"
    finally:
        path.write_text(text, "utf-8")
    if done.returncode == 2:  # interrupted: a file of tests cannot even be imported
        return "its import"
    if done.returncode not in (0, 1):  # no test ran: that would catch anything
        raise SystemExit(done.stdout[-2000:])
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].split(" - ")[0].split(" ", 1)[1] if failed else None


def copied(tree):
    """A copy of the code in a folder, to be made wrong."""
    for part in PARTS:
        shutil.copytree(ROOT / part, tree / part)
    for name in FILES:
        shutil.copy(ROOT / name, tree)
    return tree


def main(words):
    """Try the mutants, all or those named, in one copy of the tree."""
    lives = 0
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        tree = copied(Path(folder))
        for mutant in mutants():
            if words and not any(word in mutant.what for word in words):
                continue
            found = caught_by(mutant, tree)
            lives += found is None
            print(f"{mutant.what}: {found or 'LIVES'}", flush=True)
    return int(lives > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
