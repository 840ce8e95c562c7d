"""The exported regulator on a Cortex-M4F and M7: memory by the linker, a step's count in qemu.

GCC's cross compiler and qemu-system-arm are needed (Debian: gcc-arm-none-eabi,
libnewlib-arm-none-eabi, qemu-system-arm). qemu reports each instruction; it has no pipeline.
Cycles are an upper estimate: each instruction's most in Arm's table for the Cortex-M4 (TRM r0p1,
3.3 and 7.2), pipeline refills of three cycles, loads without overlap, one more where the next
instruction reads a floating-point result. Flash has no wait states.
"""

import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.checks.load import load_design
from fingerdesign.control.c_code import array_text, c_files
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.design.grip import Grip
from fingerdesign.errors import FingerDesignError
from fingerdesign.runtime.progress import Report
from fingerdesign.sensing.train.ready import shipped_estimator
from fingerdesign_bench.check import Check, Shown
from fingerdesign_bench.machine import machine

DESIGN = "film_tees"
TOOLS = ("arm-none-eabi-gcc", "arm-none-eabi-size", "arm-none-eabi-objdump", "qemu-system-arm")
FLASH_kB, RAM_kB, STEP_ms, CLOCK_MHz = 64.0, 16.0, 1.0, 168.0
FLAGS = ("-std=c99", "-O2", "-mthumb", "-mfloat-abi=hard", "-ffp-contract=off")
SAMPLES = 60  # The history of the features is full after 40.
_OWN = Path(__file__).parent
_TAKEN = 4  # Cycles of a branch with the pipeline's refill; 1 where it is not taken.
_BRANCH = re.compile(r"b$|b[a-z]{2}$|b[a-z]*\.|bl|bx|cb|tb")
# Most cycles of an instruction by the begin of its name; lists of registers: one more for each.
_CYCLES = (
    (r"vdiv|vsqrt", 14),
    (r"vfn?m|vn?ml", 3),
    (r"vldm|vstm|vpush|vpop|ldm|stm|push|pop", 1),
    (r"ldrd|strd", 3),
    (r"v?ldr|v?str|vcmp", 2),
    (r"v", 1),
    (r"[su]div", 12),
)


@dataclass(frozen=True)
class Core:
    """A processor and the board of qemu that has it."""

    name: str
    board: str
    flags: tuple[str, ...]


CORES = (
    Core("Cortex-M4F", "mps2-an386", ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16")),
    Core("Cortex-M7", "mps2-an500", ("-mcpu=cortex-m7", "-mfpu=fpv5-sp-d16")),
)


@dataclass(frozen=True)
class Counted:
    """flash, ram: bytes, stack and curves with them. instructions, cycles: of the longest step.
    answers (n, 5): dx, dy, stick ratio, utilisation, friction of each step, single."""

    flash: int
    ram: int
    instructions: int
    cycles: int
    answers: Array


def missing_tools() -> list[str]:
    """Names of the programs that are not installed."""
    return [name for name in TOOLS if shutil.which(name) is None]


def samples(estimator: GripEstimator, count: int = SAMPLES) -> Array:
    """A press, then a pull at 3 N up to half of it: rows of F_n, F_t, readings (n, 2 + g)."""
    curves, rows = estimator.curves, []
    for k in range(count):
        normal, pull = min(0.3 + 0.1 * k, 3.0), 0.05 * max(k - 28, 0)
        pressed = _at(normal, curves.normal_force, curves.pressed)
        readings = pressed + pull * _at(normal, curves.normal_force, curves.sticking)
        rows.append([normal, pull, *readings])
    return np.array(rows, dtype=np.float32)


def _at(force: float, forces: Array, table: Array) -> Array:
    return np.array([np.interp(force, forces, column) for column in table.T])


def counted(
    core: Core, estimator: GripEstimator, grip: Grip, delay: int = 0, count: int = SAMPLES
) -> Counted:
    """Compile, link within the memory, run. Raises CalledProcessError where it does not fit."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in c_files(estimator, grip).items():
            (folder / file).write_text(text)
        (folder / "samples.h").write_text(_samples_h(estimator, grip, delay, count))
        program = folder / "firmware.elf"
        command = ["arm-none-eabi-gcc", *FLAGS, *core.flags, f"-I{folder}", "-nostartfiles"]
        command += [f"-T{_OWN / 'firmware.ld'}", str(_OWN / "firmware.c")]
        command += [str(folder / "regulator.c"), "-o", str(program), "-lm"]
        subprocess.run(command, check=True)
        flash, ram = _sizes(program)
        cycles = _cycles(program)
        run = ["qemu-system-arm", "-M", core.board, "-display", "none", "-kernel", str(program)]
        run += ["-singlestep", "-d", "exec,nochain", "-chardev", f"file,id=out,path={folder}/out"]
        run += ["-semihosting-config", "enable=on,target=native,chardev=out"]
        with subprocess.Popen(run, stderr=subprocess.PIPE, text=True) as traced:
            assert traced.stderr is not None
            steps = list(_steps(traced.stderr, cycles))
        *rows, stack = (folder / "out").read_text().split("\n")[:-1]
    bits = np.array([[int(each, 16) for each in row.split()] for row in rows], np.uint32)
    most = max(steps, key=lambda step: step[1])
    return Counted(flash, ram + int(stack, 16), *most, bits.view(np.float32))


def stiffness(estimator: GripEstimator, grip: Grip) -> float:
    """dF_t/dx at the preload, N/mm, as a single."""
    curves = estimator.curves
    return float(np.float32(np.interp(grip.preload_mm, curves.approach, curves.stiffness)))


def _samples_h(estimator: GripEstimator, grip: Grip, delay: int, count: int) -> str:
    curves, rows = estimator.curves, samples(estimator, count)
    tables = {"F": curves.normal_force, "P": curves.pressed.ravel(), "S": curves.sticking.ravel()}
    tables |= {"A": curves.approach, "K": curves.stiffness, "R": curves.turn_radius}
    lines = [array_text(f"CURVE_{name}[]", values) for name, values in tables.items()]
    *named, radius = (f"CURVE_{name}" for name in tables)
    given = ", ".join([str(len(curves.approach)), *named, "0.0f", radius])
    lines += [f"static const regulator_curves CURVES = {{{given}}};"]
    lines += [f"#define SAMPLES {len(rows)}", f"#define DELAY {delay}"]
    lines += [f"#define STIFFNESS {stiffness(estimator, grip)!r}f"]
    place = '__attribute__((section(".bench"))) '
    return "\n".join([*lines, place + array_text(f"SAMPLE[][{rows.shape[1]}]", rows)])


def _sizes(program: Path) -> tuple[int, int]:
    """Bytes in flash and of variables in RAM."""
    shown = subprocess.check_output(["arm-none-eabi-size", "-A", program], text=True)
    found = {name: int(size) for name, size in re.findall(r"^(\.\w+)\s+(\d+)", shown, re.M)}
    ram = found.get(".data", 0) + found.get(".bss", 0)
    return found[".text"] + found.get(".data", 0), ram


def _cycles(program: Path) -> dict[int, tuple[int, int]]:
    """Most cycles of each instruction by its address: in all, and where it does not jump."""
    shown = subprocess.check_output(["arm-none-eabi-objdump", "-d", program], text=True)
    lines = re.findall(r"^ +([0-9a-f]+):\t[0-9a-f ]+\t(\S+)(.*)$", shown, re.M)
    following = [given for *_, given in lines[1:]] + [""]
    found = {}
    for (at, name, given), after in zip(lines, following, strict=True):
        most = _most(name, given, after)
        found[int(at, 16)] = (_TAKEN, 1) if _BRANCH.match(name) else (most, most)
    return found


def _most(name: str, given: str, following: str) -> int:
    """Most cycles of what is no branch; given, following: operands, and those of the next."""
    into, listed = given.split(",")[0].strip(), re.search(r"\{(.*)\}", given)
    most = next((most for begin, most in _CYCLES if re.match(begin, name)), 1)
    waits = name.startswith("v") and re.search(rf"\b{re.escape(into)}\b", following) is not None
    return most + waits + (_registers(listed[1]) if listed else 0) + _TAKEN * (into == "pc")


def _registers(listed: str) -> int:
    """Number in a list such as r4-r7, pc; a jump through pc is four more."""
    count = _TAKEN * ("pc" in listed)
    for part in listed.split(","):
        ends = [int(each) for each in re.findall(r"\d+", part)]
        count += ends[-1] - ends[0] + 1 if ends else 1
    return count


def _steps(trace: Iterable[str], cycles: dict[int, tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Instructions and cycles of each call of regulator_step.

    A trace has millions of lines, "Trace 0: 0x7f [00800408/ADDRESS/00000110/ff000201] FUNCTION":
    regular expressions would take as long as the emulator.
    """
    step: list[int] = []
    for line in trace:
        head, _, function = line.rstrip().rpartition("] ")
        if head and (step or function == "regulator_step"):
            step.append(int(head.split("/", 2)[1], 16))
            if function == "main":
                ways = (np.diff(step) > 0) & (np.diff(step) <= 4)
                pairs = zip(step, ways.tolist(), strict=False)
                yield len(ways), sum([cycles[at][goes_on] for at, goes_on in pairs])
                step = []


def measure_microcontroller(_folder: Path, report: Report) -> Shown:
    """Numbers of both processors against their limits, for the regulator of DESIGN.

    Raises FingerDesignError where a tool is missing.
    """
    if missing := missing_tools():
        raise FingerDesignError(f"not installed: {', '.join(missing)}")
    begun, checks, design = machine(), list[Check](), load_design(DESIGN)
    estimator = shipped_estimator(design)
    assert estimator is not None
    for core in CORES:
        report(core.name)
        found = counted(core, estimator, design.grip)
        step = 1e-3 * found.cycles / CLOCK_MHz
        checks += [
            Check(f"{core.name}: flash", FLASH_kB, found.flash / 1024, "kB"),
            Check(f"{core.name}: RAM with stack", RAM_kB, found.ram / 1024, "kB"),
            Check(f"{core.name}: step, {found.instructions} instructions", STEP_ms, step, "ms"),
        ]
    title = f"The regulator of {DESIGN}, {estimator.gages} gages, at {CLOCK_MHz:g} MHz"
    return Shown(title, checks, begun)
