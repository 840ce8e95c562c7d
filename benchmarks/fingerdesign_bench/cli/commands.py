"""The subcommands of ``fingerdesign bench``: options and words; no work."""

import click
from fingerdesign_cli.options import Place, fidelity_option, workers_option

from fingerdesign_bench.cli.frame import subcommand

HALF_A_MINUTE = "Coarser and fewer: about half a minute or less."


@subcommand(
    "known.run:suite",
    "Cases with known answers (4 min; --quick seconds).",
    click.option(
        "--problems", is_flag=True, help="Also write the contact problems, for other solvers."
    ),
    quick="The few that cost seconds.",
)
def suite() -> None:
    """Analytic solutions, other codes' answers and our own, each with its source and tolerances.

    Hertz, Cattaneo-Mindlin, Spence, Lubkin, Carter, layers, patch tests, published cases, and rates
    in the size and in the increment: a page. Exit code 1 where one is missed, or is
    no longer what it was; misses that are known and explained are none.
    """


@subcommand(
    "fidelity.fidelity:measure_fidelity",
    "Is --fidelity auto within its tolerance? (20 min).",
    workers_option,
    click.option(
        "--references",
        "again",
        is_flag=True,
        help="Compute the references, into DIR, instead of taking shipped ones (hours).",
    ),
)
def fidelity() -> None:
    """Thirty seeded fingers and scenes with tolerances of 1 to 10 %: true errors and costs.

    Every rung of each is solved once; the ladder climbs on these, and each rung is also taken as
    the one model for all. True errors are against much finer models in space. Rungs are stored in
    DIR when they are solved; an interrupted run goes on. Exit code 1 where a number misses its
    target.
    """


@subcommand(
    "any_finger.forecast:measure_forecasts",
    "Predicted and real dofs, memory, time (15 min).",
    quick="Three small ones: half a minute.",
)
def forecast() -> None:
    """Forecasts of `check` (dofs, memory, time) against whole analyses.

    An interrupted run goes on where it stopped: run it again with the same --out.

    Each analysis runs in a process of its own, with an empty mesh cache. Its forecast is for the
    machine's speed as measured right before and after it, so that other work counts on both sides.
    Exit code 1 where a forecast is off by more than a factor of 2.
    """


@subcommand(
    "any_finger.molds:measure_molds",
    "Molds of shipped and of 100 random designs (20 min).",
    click.option(
        "--seeds",
        default=100,
        show_default=True,
        type=click.IntRange(0, 10_000),
        help="How many random designs, besides the shipped ones.",
    ),
    workers_option,
)
def molds() -> None:
    """Make molds of every shipped design and of random ones of every kind.

    Each in a process of its own; the mold is deleted, its checks are stored. An interrupted run
    goes on where it stopped: the same DIR again. Exit code 1 where a number misses its target.
    """


@subcommand("atlas.make:measure_atlas", "The atlas that `new --lift` starts from (5 min).")
def atlas() -> None:
    """Judge the candidates of the atlas in 3-D, and make their molds by every process.

    Those that pass all verdicts are written to fingerdesign/data/atlas.json, each with its
    verdicts, molds, digest and commit. Exit code 1 where a candidate does not pass.
    """


@subcommand(
    "plane_strain.judge:measure_plane_strain",
    "Where is plane strain right? The map (20 min).",
    click.option(
        "--study",
        type=Place(dir_okay=False),
        help="A study file of your own instead of the shipped designs/studies/plane_strain.toml.",
    ),
    quick="The first two values of each parameter (1 min).",
)
def plane_strain() -> None:
    """Plane strain against 3-D over depth, contact width, Poisson's ratio and the plates' span.

    Errors of forces at equal motion, and of contact width, stick ratio and gage strains at equal
    motion and at equal force; the map with its contours; rules fitted to it. An interrupted run
    goes on where it stopped: the same DIR again. Exit code 1 where a number misses its target.
    """


@subcommand(
    "speed.precision:precision",
    "Errors against seconds, a line a method (15 min; --quick 3 min).",
    quick=HALF_A_MINUTE,
)
def precision() -> None:
    """Errors against seconds, a line a method.

    Forces, stick ratio and gage strain. Four shipped fingers: tetrahedra by fTetWild, swept
    tetrahedra, prisms, plane strain. One small finger: P1, P2 and mixed elements; solid plates,
    sheets and none.
    """


@subcommand(
    "speed.speed:measure_speed",
    "Seconds, memory, growth, against targets (4 min; --quick 20 s).",
    quick=HALF_A_MINUTE,
)
def speed() -> None:
    """Seconds, memory and their growth, against targets; the cost of condensation."""


@subcommand(
    "microcontroller.run:measure_microcontroller",
    "The exported regulator on a Cortex-M4F and M7 (2 min).",
)
def microcontroller() -> None:
    """Flash and RAM by the linker, instructions of a step in qemu, cycles as an upper estimate.

    Needs gcc-arm-none-eabi, libnewlib-arm-none-eabi and qemu-system-arm. Exit code 1 where 64 kB of
    flash, 16 kB of RAM or 1 ms at 168 MHz is passed.
    """


@subcommand(
    "speed.whole:measure_whole",
    "A whole `analyse` from cold caches (1.5 min).",
    fidelity_option(None, unset="both"),
)
def whole() -> None:
    """Seconds, memory and dofs of `analyse`, from cold caches."""


@subcommand(
    "stability.stability:measure_stability",
    "Hard cases through every method (3.5 min; --quick 5 s).",
    quick=HALF_A_MINUTE,
)
def stability() -> None:
    """Hard cases through every method, judged and mapped."""


@subcommand(
    "speed.peers:peers",
    "Siconos and GetFEM in the same run (20 min; --quick 1.5).",
    quick="Plane strain alone, fewer repeats.",
)
def peers() -> None:
    """Siconos on our condensed problems, GetFEM on our meshes: times, ratios, differences.

    They must be installed for /usr/bin/python3 (Debian: python3-siconos, python3-getfem); what is
    missing is named and left out. Exit code 1 where neither is there.
    """
