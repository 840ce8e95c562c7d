"""Commands about the hand: grips, gages and controllers."""

from pathlib import Path

import click

from fingerdesign_cli import options

TARGETS = {
    "c": "C99 without dependencies",
    "fmu": "a co-simulation unit of FMI 2.0",
    "fmu-plant": "the finger as such a unit",
    "mjcf": "a MuJoCo model",
    "urdf": "a robot description",
}


def _new_folder(
    context: click.Context, parameter: click.Parameter, value: tuple[str, Path] | None
) -> tuple[str, Path] | None:
    """Refuse the folder of a data set before any work."""
    options.output_folder(context, parameter, value[1] if value else None)
    return value


@options.command("analyse", "Lift an object whose weight and friction are unknown.")
@options.design_and_out()
@options.controller_option
@options.numbers_option(
    "--friction",
    "frictions",
    "MU",
    "Friction coefficient of the object; repeat it for one lift each. "
    "Instead of grip.friction_coefficients.",
)
@click.option(
    "--mass-g",
    metavar="G",
    type=options.MASSES,
    help="The object's mass, or a range, whose ends are lifted: 500, 50..500. Instead of "
    "grip.object_mass_g.",
)
@options.scene_option(
    "A scene whose object's friction, by whatever law, the grips meet, one lift each mass. "
    "Instead of grip.friction_coefficients."
)
@options.model_option
@options.estimator_option(
    "What the regulator grips by, from `fingerdesign train`; or a shipped design's name, for the "
    "estimator of a finger near to it. Without it that of the shipped finger, or one is trained."
)
@options.go_on_option
@options.result_options
@options.details_option
@options.page_options
def grip() -> None:
    """Lift an object with DESIGN by the design's [grip] table, once per friction coefficient.

    DESIGN is a file or a shipped design's name. Unlike analyse, whose default is 3d, grip takes the
    section: seconds, not minutes, but where a regulator without --estimator or a shipped one is
    trained first: up to half an hour.

    The controller feels gages and forces only. Exit code 0 also where an object slips or is not
    lifted: that is a finding, and stands in the table and in result.json.
    """


@options.command("sensing", "Train the estimator that the regulator grips by.")
@options.design_and_out("train")
@click.option(
    "--noise",
    type=options.FiniteRange(0.0, 1e3),
    default=0.5,
    show_default=True,
    help="Of a sample of your gages, microstrain: written into the file.",
)
@options.workers_option
@options.model_option
@options.output_options
def train() -> None:
    """Train the estimator that the regulator grips by, on DESIGN's own model.

    OUT/NAME/estimator.json runs on a rig with numpy alone (fingerdesign.control.estimator);
    training.json reports its errors on held-out grips: of judged_fingers other fingers or, with
    grip.regulator.training_fingers = 1, of the same one. How long it takes is printed before it
    begins. The result is cached: changes of the controllers in the [grip] table need no other.
    """


@options.command("sensing", "Hidden values of one finger, from a trace or a bench.")
@click.argument("design_file", metavar="DESIGN", type=options.DESIGN)
@click.argument("source", metavar="[SOURCE]", type=options.FILE, required=False)
@options.out_option("identify")
@click.option("--measured", type=options.FILE, hidden=True)  # The former name of SOURCE.
@click.option("--simulate", is_flag=True, help="Simulate a trace of a perturbed finger instead.")
@click.option("--bench", is_flag=True, help="SOURCE is a bench; with --simulate: simulate a bench.")
@options.estimator_option(
    "For a bench: what `fingerdesign train` wrote for DESIGN; it is given this finger's curves."
)
@click.option(
    "--fault",
    "faults",
    multiple=True,
    metavar="NAME",
    help="Of a simulated bench's finger, as docs/how_to/control.md names them; may be given again. "
    "[default: plates, modulus, gains]",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 1),
    default=0,
    show_default=True,
    help="Of the simulated finger.",
)
@click.option(
    "--terms",
    type=click.IntRange(0, 2),
    help="For a trace: terms of the relaxation (Prony series).  [default: by Schwarz's criterion]",
)
@options.model_option
@options.page_options
def identify() -> None:
    """Find hidden values of the one finger that was cast by DESIGN, by least squares.

    SOURCE is a trace: a CSV of a press, a shear and a hold (docs/how_to/identify.md). OUT/NAME then
    holds identification.json, modulus, relaxation, friction and gages with their 95 % intervals,
    and the next motion that would narrow them most; identified.toml, the design with them;
    identify.html.

    Or SOURCE is a bench: the folder with phases.csv and the traces that it names, or that table
    (docs/how_to/identify.md). OUT/NAME then holds calibration.json, the plates' places, moduli and
    gains with their deviations before and after; fitted.toml, the finger as fitted; estimator.json
    with the finger's own curves. The first finger of a design takes longest.

    --simulate writes OUT/NAME/trace.csv of a finger drawn from --seed, and truth.json; with --bench
    the folder of a bench.
    """


@options.command("sensing", "Write the regulator, or the finger, for another system.")
@click.argument("files", metavar="[ESTIMATOR] DESIGN", type=options.DESIGN, nargs=-1, required=True)
@options.out_option("export")
@click.option(
    "--to",
    type=click.Choice(list(TARGETS)),
    required=True,
    help=f"{'; '.join(f'{each}: {about}' for each, about in TARGETS.items())}.",
)
@click.option(
    "--noise",
    type=options.FiniteRange(0.0, 1e3),
    help="Of a sample of your gages, microstrain.  [default: the estimator's]",
)
@click.option(
    "--density",
    "densities",
    type=(str, options.FiniteRange(0.0, 30.0, min_open=True)),
    metavar="MATERIAL G_CM3",
    multiple=True,
    help="For mjcf and urdf: instead of the material's usual one; may be given again.",
)
@options.fidelity_option(None, unset="plane-strain", purpose="For fmu-plant: which")
@click.option(
    "--flex",
    "flex_mm",
    type=options.FiniteRange(0.2, 20.0),
    metavar="MM",
    help="For mjcf: the rubber as a flex of tetrahedra of this size, which has no plates in it.",
)
@options.output_options
def export() -> None:
    """Write DESIGN for another system: its regulator, which grips by ESTIMATOR, or the finger.

    c: OUT/NAME then holds regulator.c and regulator.h. ESTIMATOR is what `fingerdesign train` wrote
    for DESIGN; without it that of the shipped finger, of 3-D before plane strain; else one is
    trained first, or taken from the cache. The file computes in single precision and holds the one
    network for the noise, with 16-bit weights: at most 64 kB for 15 gages. How to compile and call
    it: docs/how_to/control.md.

    fmu: OUT/NAME then holds regulator.fmu, the same as a unit, its sources inside. fmu-plant: its
    plant.fmu, the finger's contact with a plane, of at most 1 MB; in 3-D that needs a coarse mesh.

    mjcf, urdf: OUT/NAME then holds finger.xml or finger.urdf and the STL files that it names: body,
    plates and core to be seen, the convex hull to collide; mass and inertia; a site or frame at
    each gage. A flex shows a soft finger; for forces and gages see docs/how_to/control.md.
    """


@options.command("trials", "Compare controllers over friction, weight and noise.")
@click.argument("design_file", metavar="DESIGN", type=options.DESIGN, required=False)
@options.out_option("study")
@options.controllers_option
@options.numbers_option(
    "--friction",
    "frictions",
    "MU",
    "Friction coefficient; may be given again. Without it ten from 0.2 to 0.8.",
)
@options.numbers_option(
    "--mass-g",
    "masses",
    "G",
    "The object's mass; may be given again. Without it ten from 100 to 1000 g.",
)
@options.numbers_option(
    "--noise",
    "noises",
    "E",
    "Standard deviation of a gage's sample, microstrain; may be given again. Without it 0, "
    "0.5, 1, 2, 5 and 10; with --perturbed, and for tuning, 0.5.",
)
@click.option("--quick", is_flag=True, help="4 frictions, 4 masses, 3 noises: seconds.")
@click.option("--no-tug", is_flag=True, help="Leave out the grips whose lifted object is tugged.")
@click.option(
    "--tune",
    is_flag=True,
    help="Tune the controllers first, each on 1808 grips: 1 to 5 minutes each on a free core, more "
    "on a busy one; all of them and the study took 40 minutes on two.",
)
@click.option("--perturbed", is_flag=True, help="On fingers drawn with faults.")
@click.option(
    "--fault",
    "faults",
    multiple=True,
    metavar="NAME",
    help="With --perturbed: none (the model itself), all (every fault at once), or one of the "
    "faults in docs/how_to/control.md; joined by + several at once; may be given again. Without "
    "it none, each fault and all.",
)
@click.option(
    "--plants",
    type=click.IntRange(1, 1000),
    help="With --perturbed: fingers of each fault.  [default: 25]",
)
@click.option(
    "--lifts", type=click.IntRange(1, 100), help="With --perturbed: objects a finger.  [default: 4]"
)
@click.option(
    "--program",
    metavar="COMMAND",
    help="Judge a program of any language that answers lines of JSON "
    "(docs/reference/gripbench.md).",
)
@click.option(
    "--held-out",
    metavar="PHRASE",
    help="With gripbench: the phrase of the release's notes. Without it the public set.",
)
@click.option(
    "--to",
    type=(click.Choice(["lerobot"]), options.FILE),
    callback=_new_folder,
    metavar="lerobot DIR",
    help="Write the lifts, sample by sample, as a LeRobot data set into a new DIR; judge nothing.",
)
@click.option(
    "--recorded",
    metavar="DIR",
    type=options.FILE,
    help="Judge our detectors of slip on recordings of others in DIR, instead of a DESIGN.",
)
@options.open_option
@click.option(
    "--seed", type=int, default=0, show_default=True, help="Of all noise, fingers and trials."
)
@click.option(
    "--sealed",
    is_flag=True,
    help="Take the seed of published tables, on which nothing is developed: once for each table.",
)
@options.estimator_option(
    "For the regulator: what `fingerdesign train` wrote for DESIGN; or a shipped design's name, "
    "for the estimator of a finger near to it. Without it that of the shipped finger in this "
    "fidelity; else one is trained first (up to half an hour), or taken from the cache."
)
@options.workers_option
@options.model_option
@options.output_options
def study() -> None:
    """Judge controllers on DESIGN over friction, weight and gage noise.

    Each lifts every object at every noise and, once, holds it against a tug. With --perturbed each
    finger is drawn from the seed (rubber, plates' places, cover, gages, mesh, the object's tilt and
    radius), measures itself on its bench, and lifts objects between the least and greatest friction
    and mass. OUT/NAME then holds control.html (chart, findings, tables), control.json, grips.csv
    (every grip), control.png and path_*.csv (the grips that are drawn).

    `fingerdesign study gripbench` judges them on a fixed set: 99 perturbed fingers, four objects
    each. OUT/gripbench then holds gripbench.json (the scorecard), gripbench.csv, gripbench.png.

    `fingerdesign study --recorded DIR` reads recordings in the plain format or of public sets
    (docs/how_to/recorded.md). OUT/recorded then holds recorded.html and recorded.json.

    --tune tunes the controllers first, each by the same procedure and the same number of grips, on
    other objects and noise than the study's; tuned.toml is DESIGN with the best values.

    Finished grips are in OUT/NAME.unfinished.sqlite until the folder is there: an interrupted study
    continues where it stopped. Exit code 0 also where objects are dropped or crushed: that is a
    finding.
    """
