"""Result of an analysis: the content of ``result.json`` and the arrays that its report needs.

Units stand in the names: mm, N, MPa, s; strains are microstrain (1e-6), tension positive. Forces
are those on the finger: normal > 0 in compression, tangential > 0 toward +x."""

import dataclasses
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Literal, Self

from fingerdesign.design.grip import GRAVITY, weight_per_finger
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import json_text, strict
from fingerdesign.runtime.finite import finite_json

SCHEMA_VERSION = 1
STAGES = ("geometry", "mesh", "assemble", "condense", "increments", "grips", "report")
# A grip whose normal force reaches this multiple of the least one that holds crushes the object.
MOST_FORCE = 3.0
_NESTED = ("gages", "points")  # what of an increment is no number
GripEnding = Literal["lifted", "caught", "complete slip", "stage travel", "steps", "failed"]
SlipWarning = Literal["standing", "withdrawn", "none"]


@strict
@dataclass(frozen=True)
class ModelSummary:
    """The mechanical model: how large it is and why it is the one that was used.

    symmetry: True for the half z >= 0 of a finger that mirrors in z = 0.
    reasons: sentences, one for each choice that the program made by itself.
    """

    dimension: Literal[2, 3]
    element: str
    dofs: int
    contact_nodes: int
    symmetry: bool
    reasons: tuple[str, ...] = ()


@strict
@dataclass(frozen=True)
class MeshSummary:
    """The mesh and how far it is from the CAD solid; volume errors are relative, unsigned.

    min_dihedral_deg: least dihedral angle of the tetrahedra; in plane strain the least angle of the
    triangles. worst_plate_volume_error: None without plates.
    """

    mesher: str
    elements: int
    min_dihedral_deg: float
    body_volume_error: float
    worst_plate_volume_error: float | None


@strict
@dataclass(frozen=True)
class GageResult:
    """One plate's gage, microstrain, tension positive; of tees and pairs what their bridge reads.

    membrane = (upper + lower) / 2, bending = (upper - lower) / 2; reading: that of ``gages.face``.
    """

    plate: int
    upper: float
    lower: float
    membrane: float
    bending: float
    reading: float


@strict
@dataclass(frozen=True)
class PointStrain:
    """Strain at one readout point, microstrain; xy, xz and yz are engineering shear."""

    xx: float
    yy: float
    zz: float
    xy: float
    xz: float
    yz: float


@strict
@dataclass(frozen=True)
class IncrementResult:
    """One row of the path, solved and checked. Forces are those on the finger, whole.

    normal_force_N: along -y, > 0 in compression; tangential_force_N: along +x, which is what a
    shear of the object toward +x causes; also where the object slopes.
    stick_ratio: stick area / contact area by quadrature, None without contact. In 3-D the contact
    width is taken at z = 0. residual: the contact solver's own, as it defines it. force_z_N: on the
    finger, > 0 toward +z; twist_moment_Nmm: on the finger about +y through x = z = 0.
    """

    approach_mm: float
    shear_mm: float
    normal_force_N: float
    tangential_force_N: float
    contact_width_mm: float
    stick_ratio: float | None
    open_nodes: int
    stick_nodes: int
    slip_nodes: int
    peak_pressure_MPa: float
    iterations: int
    residual: float
    gages: tuple[GageResult, ...] = ()
    points: tuple[PointStrain, ...] = ()
    shear_z_mm: float = 0.0
    twist_deg: float = 0.0
    force_z_N: float = 0.0
    twist_moment_Nmm: float = 0.0


@strict
@dataclass(frozen=True)
class GripResult:
    """One grip: two like fingers, each with F_t = m g / 2 once the object is lifted.

    safety_margin: F_n over the least that holds, at the first lifted increment; None if it was not
    lifted. slip_ratio: F_t / F_n at which the contact would slip, at the lift or else at the end:
    mu, unless the object leans. None without contact, under another law, and in records of earlier
    versions.
    minimum_stick_ratio: over the increments with F_t > 0, None if there is none.
    slip_distance_mm: least accumulated slip over the points in contact.
    steps: control steps after the preload; steps_to_lift: those up to the lift, or all of them.
    holds: how often the rule set dx to zero. slips_without_rule: whether the same path without the
    rule slips completely; None if that was not tried. ending: a sentence, why the grip ended;
    outcome: the same as one word, None in records of earlier versions.
    slip_warning: state of the controller's warning as the whole contact slipped (standing: given,
    and not withdrawn); None where it did not slip, or where the controller never warns.
    lead_s, lead_force_share: of a standing one, time from the warning to complete slip, F_t at the
    warning over F_t at complete slip. alarms: warnings that were given, false_alarms: those given
    while clearly more stuck; None where it never warns. stick_error: root mean square of the
    reported less the true stick ratio over stick_error_samples, the samples with F_t > 0; None
    where none is reported. samples: that the controller answered. (control/foresight.py)
    unsure: whether the controller reported to be so as it dropped or crushed the object, or lifted
    it; None where it never reports. reaction_steps: from a study's tug to the first answer to it.
    Of an object with inertia: slid_mm through the fingers while it hung; caught: the last slide
    ended by sticking, None where nothing slid; catch_s: the longest that a catch took; swing_Hz:
    of the object on the fingers, as it was lifted. gross_slip is true of what was caught too.
    rotation_deg: by which an object off the middle has turned between the fingers, at the end.
    most_pull_N: the most that pulls at the object while it hangs, where tugs and other masses make
    it more than its first weight; None elsewhere.
    friction_law: empty for Coulomb's; under another one, friction_coefficient is half the weight
    over the least normal force that holds it.
    """

    controller: str
    friction_coefficient: float
    object_mass_g: float
    lifted: bool
    gross_slip: bool
    final_normal_force_N: float
    final_tangential_force_N: float
    safety_margin: float | None
    minimum_stick_ratio: float | None
    peak_normal_force_N: float
    slip_distance_mm: float
    steps: int
    holds: int = 0
    slips_without_rule: bool | None = None
    ending: str = ""
    slip_warning: SlipWarning | None = None
    lead_s: float | None = None
    lead_force_share: float | None = None
    alarms: int | None = None
    false_alarms: int | None = None
    stick_error: float | None = None
    stick_error_samples: int = 0
    samples: int = 0
    slid_mm: float = 0.0
    caught: bool | None = None
    catch_s: float | None = None
    swing_Hz: float | None = None
    outcome: GripEnding | None = None
    steps_to_lift: int | None = None
    unsure: bool | None = None
    reaction_steps: int | None = None
    friction_law: str = ""
    slip_ratio: float | None = None
    rotation_deg: float = 0.0
    most_pull_N: float | None = None

    @property
    def least_force_N(self) -> float:
        """Least normal force that holds the object: m g / 2 over the slip ratio, or over mu."""
        ratio = self.friction_coefficient if self.slip_ratio is None else self.slip_ratio
        return weight_per_finger(self.object_mass_g) / ratio

    @property
    def holding_force_N(self) -> float:
        """Least normal force that holds it to the end, through tugs and other masses."""
        weight = weight_per_finger(self.object_mass_g)
        return self.least_force_N * max(0.5 * (self.most_pull_N or 0.0) / weight, 1.0)

    @property
    def peak_ratio(self) -> float:
        """Peak normal force over the least one that holds to the end."""
        return self.peak_normal_force_N / self.holding_force_N

    @property
    def crushing_force_N(self) -> float:
        """The normal force from which on the object is crushed."""
        return MOST_FORCE * self.holding_force_N

    @property
    def holds_object(self) -> bool:
        """Lifted, and never wholly slipping."""
        return self.lifted and not self.gross_slip and self.outcome != "failed"

    @property
    def crushed(self) -> bool:
        """The peak force is :data:`MOST_FORCE` times the least one, or more."""
        return self.peak_ratio >= MOST_FORCE

    @property
    def success(self) -> bool:
        """The object is lifted, never slips wholly, and is not crushed."""
        return self.holds_object and not self.crushed


@strict
@dataclass(frozen=True)
class SlipStudySummary:
    """Agreement of gage area and stick area at one friction coefficient (Fig. 8).

    Rank correlations (Spearman) of the gage area with the true stick length, with and without the
    normal force's part taken out; None where not defined. The area is held where F_t changes by
    less than force_floor_N. step_correlation: of the step's number alone, its size; what an area
    says beyond it is worth something. gage_area_mm: least and greatest with a response;
    stick_length_mm: with contact; points: increments. rank_by_share: rank_correlation at other
    values of gages.area_share: (share, correlation).
    """

    friction_coefficient: float
    rank_correlation: float | None
    rank_correlation_raw: float | None
    threshold_microstrain_per_N: float
    force_floor_N: float
    step_correlation: float | None = None
    gage_area_mm: tuple[float, float] = (0.0, 0.0)
    stick_length_mm: tuple[float, float] = (0.0, 0.0)
    points: int = 0
    rank_by_share: tuple[tuple[float, float | None], ...] = ()


@strict
@dataclass(frozen=True)
class MeasuredState:
    """Slip that gages measure while an object is held at one friction with a margin of 1.5.

    response_microstrain_per_N: the strongest gage's to F_t while all sticks.
    stick_change_microstrain: of the readings together (length of the vector) per unit of stick
    ratio at the same forces. smallest_...: what one sample shows, three standard deviations of the
    amplifier: of the stick ratio from all gages, forces known; of F_t from the strongest gage.
    """

    friction_coefficient: float
    normal_force_N: float
    tangential_force_N: float
    response_microstrain_per_N: float
    stick_change_microstrain: float
    smallest_stick_change: float
    smallest_force_change_N: float

    @property
    def object_mass_g(self) -> float:
        """Mass of the object of which a finger carries half the weight."""
        return 2e3 * self.tangential_force_N / GRAVITY


@strict
@dataclass(frozen=True)
class GageRemedy:
    """One key changed until the gages answer enough, or as far as it goes: worked with the model.

    gain: of the gages' answer to F_t where all sticks, under the worst state's F_n. Their change
    with the stick ratio grows about as much (maeno2000: by 3.7 where this is 4.3), on soft plates
    made softer still by less; enough: were it as much, the smallest change of the stick ratio would
    be within the target. known: materials of such plates.
    """

    key: str
    value: float
    changed: float
    gain: float
    enough: bool
    known: tuple[str, ...] = ()


@strict
@dataclass(frozen=True)
class Measurability:
    """The gages' response to slip against an amplifier's noise (analysis/detection.py).

    noise_microstrain: of one sample; noise_stated: by the design's [grip.hardware], else the
    reference amplifier's. wanted_stick_change: what a hand that steers by the stick ratio must see.
    remedies: worked in plane strain where the gages see too little and a section tells; a quieter
    amplifier helps in proportion.
    """

    noise_microstrain: float
    noise_stated: bool
    wanted_stick_change: float
    states: tuple[MeasuredState, ...]
    remedies: tuple[GageRemedy, ...] = ()

    @property
    def smallest_stick_change(self) -> float:
        """The smallest change that is seen, at the worst of the states."""
        return max(state.smallest_stick_change for state in self.states)


@strict
@dataclass(frozen=True)
class ErrorEstimate:
    """Estimated errors from one source, mesh or path: the largest of all rows.

    Of forces, parts of the row's own; of gages, parts of the row's largest reading; of the stick
    ratio, absolute.
    """

    normal_force: float
    tangential_force: float
    stick_ratio: float
    gages: float


@strict
@dataclass(frozen=True)
class TriedModel:
    """A rung of the fidelity ladder. error_estimates: by quantity, parts of one; None where nothing
    stood to judge it by (normal_force, tangential_force, stick_ratio, gage)."""

    name: str
    dimension: Literal[2, 3]
    dofs: int
    contact_nodes: int
    seconds: float
    error_estimates: dict[str, float] | None
    why: str


@strict
@dataclass(frozen=True)
class LadderSummary:
    """Path of --fidelity auto to its model: the one in ``chosen``, tried last.

    reached: the greatest of error_estimates is at most the tolerance; why_ended: a sentence where
    it is not.
    """

    tolerance: float
    reached: bool
    chosen: str
    error_estimates: dict[str, float]
    why_ended: str
    models: tuple[TriedModel, ...]


@strict
@dataclass(frozen=True)
class Result:
    """The record of one analysis; ``to_json`` is the content of ``result.json``.

    design, scene: names. digest: of the design, the scene and what else decides the numbers.
    parameters: the design's keys in dotted form with their values; assumed: those of them that the
    source did not give. timings_s: seconds by stage, 0 for a stage that was not run. ladder: with
    --fidelity auto only; fidelity is then that of the model chosen. measurability: of the gages in
    the array along x; None where there is none, or no load is reached at which they answer.
    path_error, mesh_error: from the length of the increments and from the mesh; None where it was
    not estimated, as at finite strain. mesh_error_absent: why there is no mesh_error, a clause.
    """

    design: str
    scene: str
    digest: str
    versions: dict[str, str]
    fidelity: Literal["plane-strain", "3d", "finite"]
    status: Literal["ok", "failed"] = "ok"
    failure: str | None = None
    warnings: tuple[str, ...] = ()
    model: ModelSummary | None = None
    mesh: MeshSummary | None = None
    increments: tuple[IncrementResult, ...] = ()
    grips: tuple[GripResult, ...] = ()
    slip_studies: tuple[SlipStudySummary, ...] = ()
    schema_version: int = SCHEMA_VERSION
    seeds: dict[str, int] = field(default_factory=dict)
    timings_s: dict[str, float] = field(default_factory=dict)
    peak_memory_MB: float = 0.0
    parameters: dict[str, Any] = field(default_factory=dict)
    assumed: tuple[str, ...] = ()
    ladder: LadderSummary | None = None
    measurability: Measurability | None = None
    path_error: ErrorEstimate | None = None
    mesh_error: ErrorEstimate | None = None
    mesh_error_absent: str = ""

    def __post_init__(self) -> None:
        if (self.status == "failed") != bool(self.failure):
            raise ValueError("failure must hold a sentence exactly when status is 'failed'")
        if self.status == "ok" and (self.model is None or self.mesh is None):
            raise ValueError("a result that is 'ok' must hold its model and its mesh")
        every_stage = dict.fromkeys(STAGES, 0.0) | dict(self.timings_s)
        object.__setattr__(self, "timings_s", every_stage)

    def __repr__(self) -> str:
        """Describe the result in a line, for a notebook and a prompt."""
        return f"<Result of {self.design}: {'; '.join(self._phrases())}>"

    def _phrases(self) -> list[str]:
        """Identity and findings, a phrase each."""
        found = [f"scene {self.scene}, {self.fidelity}, {self.failure or self.status}"]
        if self.increments:
            last = self.increments[-1]
            forces = f"{last.normal_force_N:.4g} and {last.tangential_force_N:.4g} N"
            found.append(f"{len(self.increments)} increments to F_n and F_t of {forces}")
        if self.grips:
            held = sum(grip.lifted and not grip.gross_slip for grip in self.grips)
            found.append(f"{held} of {len(self.grips)} grips lifted without complete slip")
        if self.measurability is not None:
            change = self.measurability.smallest_stick_change
            seen = change <= self.measurability.wanted_stick_change
            words = "can be measured" if seen else "answer too little for the amplifier"
            found.append(f"gages {words} (smallest change of the stick ratio {change:.2g})")
        if self.warnings:
            found.append(f"{len(self.warnings)} warnings")
        return found

    def arrays(self) -> dict[str, Any]:
        """Each number of the increments as a numpy array (increments,), NaN where there is none;
        "gages": readings (increments, gages), microstrain."""
        import numpy as np

        names = [each.name for each in dataclasses.fields(IncrementResult)]
        rows, numbers = self.increments, [each for each in names if each not in _NESTED]
        found = {k: np.array([getattr(row, k) for row in rows], dtype=float) for k in numbers}
        readings = [[gage.reading for gage in row.gages] for row in rows]
        return found | {"gages": np.array(readings, dtype=float)}

    def to_dataframe(self) -> Any:
        """A pandas.DataFrame of :meth:`arrays`, a row an increment; gages as ``gage_0`` and so on,
        by their plates. Raises ImportError without pandas, which is no dependency."""
        try:
            pandas = import_module("pandas")
        except ModuleNotFoundError as error:
            words = "a data frame needs pandas: pip install pandas, or take arrays()"
            raise ImportError(words, name=error.name) from error
        found = Result.arrays(self)
        readings = found.pop("gages")
        plates = [gage.plate for gage in self.increments[0].gages] if self.increments else []
        return pandas.DataFrame(found | {f"gage_{p}": readings[:, k] for k, p in enumerate(plates)})

    def to_json(self) -> str:
        """JSON text, keys in the order of the class. Raises ResultError on a NaN or an infinity."""
        return json_text(dataclasses.asdict(self), indent=1, ascii_only=False)

    @classmethod
    def from_json(cls, text: str, source: str = "result.json") -> Self:
        """The result that ``to_json`` wrote. Raises DesignError with every fault found."""
        from pydantic import TypeAdapter, ValidationError

        try:
            loaded = finite_json(text)
        except (ValueError, RecursionError) as error:
            fault = Fault("JSON", str(error), "the text of a result.json", "run analyse again")
            raise DesignError([fault], source) from error
        if not isinstance(loaded, dict):
            fault = Fault(
                "JSON", f"{loaded}"[:40], "the text of a result.json", "run analyse again"
            )
            raise DesignError([fault], source)
        version = loaded.get("schema_version")
        if version != SCHEMA_VERSION:
            remedy = "read it with the fingerdesign that wrote it, or run analyse again"
            fault = Fault("schema_version", version, f"{SCHEMA_VERSION}", remedy)
            raise DesignError([fault], source)
        try:
            result: Self = TypeAdapter(cls).validate_json(text)
        except ValidationError as error:
            raise DesignError([_fault(item) for item in error.errors()], source) from error
        return result


def _fault(item: Any) -> Fault:
    bounds = {"missing": "present", "unexpected_keyword_argument": "a key of this schema version"}
    value = "{...}" if isinstance(item["input"], dict | list) else item["input"]
    value = "nothing" if item["type"] == "missing" else value
    key = ".".join(str(part) for part in item["loc"]) or "result"
    words = item["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    bound = bounds.get(item["type"], words)
    return Fault(key, value, bound, "run analyse again")
