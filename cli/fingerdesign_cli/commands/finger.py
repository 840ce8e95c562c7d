"""Commands about one finger: a design, its check, mesh, analysis, assumptions and mold; and about
many: variants, studies, searches, comparisons."""

import click

from fingerdesign_cli import options

ANY = options.ShippedOrFile("design", "scene", "study")
_KEYS = (  # validate.assumptions.ASSUMPTIONS, which would load numpy
    *("plane_strain", "gage_depth_average", "plate_span", "small_strain", "poissons_ratio"),
    *("youngs_modulus", "relaxation", "temperature", "sheets", "gage_point"),
    *("leads", "plates_left_out", "discretisation"),
)


@options.command("new", "Write a commented starter design.")
@click.argument("file", type=options.Place(dir_okay=False))
@click.option(
    "--from", "source", metavar="NAME", help="Start from this shipped design, scene or study."
)
@click.option("--scene", is_flag=True, help="Write a scene instead of a design.")
@click.option("--study", is_flag=True, help="Write a study instead of a design.")
@click.option("--all", "whole", is_flag=True, help="Write every key of a design, with its default.")
@click.option("--short", is_flag=True, help="Write only fifteen keys, of a finger that fails two.")
@click.option(
    "--lift",
    metavar="G",
    help="Start from a verified finger that lifts such objects: 500g, 50..500g.",
)
@click.option("--gages", metavar="SOURCE", help="The same with gages that are: film | bought.")
@click.option("--process", metavar="NAME", help="The same with a mold by: sla | fdm | machined.")
@click.option("--force", is_flag=True, help="Overwrite FILE.")
@options.output_options
def new() -> None:
    """Write a commented starter design to FILE.toml, its name taken from FILE; a scene; a study.

    Without an option it is a copy of the shipped finger film_tees, which passes all verdicts.
    --lift, --gages and --process take the nearest finger of an atlas, whose verdicts were found in
    3-D (`fingerdesign list atlas`). What it does not meet is printed; the exit code is then 1.
    Next to it goes design.schema.json (scene.schema.json), with which editors complete and explain
    keys. Nothing is overwritten without --force. `fingerdesign list designs` names what is shipped.
    """


@options.command("check", "Is a design, a scene or a study sound? Every fault.")
@click.argument("designs", metavar="FILE...", nargs=-1, required=True, type=ANY)
@options.scene_option("A scene's file or a shipped one's name; without it, fundamental.")
@options.details_option
@options.output_options
def check() -> None:
    """Name every fault of every FILE at once, each as key, value, bound and remedy.

    FILE is a design, a scene or a study, its file or the name of a shipped one; check sees which it
    is. What rests on a faulty key is judged once that is mended.

    For sound designs: the plates' clearances, the volume, and forecasts of the contact's
    half-width and of what `analyse` will take: equations, memory and time on this machine. Not
    where SCENE is faulty. Exit code 2 where any file has a fault.
    """


@options.command("mesh", "Mesh a design and report the mesh's quality.")
@click.argument("design_file", metavar="DESIGN", type=options.DESIGN)
@options.folder_option()
@options.fidelity_option("3d")
@options.scene_option(
    "A scene's file or a shipped one's name: fine where its contact will be; without it, "
    "the fundamental case's."
)
@click.option(
    "--format",
    "formats",
    metavar="ENDING",
    multiple=True,
    default=("vtu",),
    show_default=True,
    help="vtu and vtk (ParaView), msh (Gmsh), inp (CalculiX, Abaqus), mdpa (Kratos); may be "
    "repeated.",
)
@click.option(
    "--picture/--no-picture", default=True, help="Draw mesh.png and quality.png.", show_default=True
)
@options.output_options
def mesh() -> None:
    """Mesh DESIGN as an analysis would, and say how good the mesh is.

    DESIGN is a file or a shipped design's name; with mesh.mesher = "file" its mesh is read, checked
    and fitted. Writes mesh.ENDING for each --format, quality.txt and quality.json (angles, aspects,
    sizes against the targets, volumes and distances to the CAD faces), mesh.png and quality.png.
    Quadratic elements; cells carry their region (elastomer, plate_0, ..., core), facets the name of
    their face (base, contact, side, end, symmetry).
    """


@options.command("analyse", "Analyse designs: contact, gages, grips, report.")
@click.argument("designs", metavar="DESIGN...", nargs=-1, required=True, type=options.DESIGN)
@options.out_option()
@options.scene_option(
    "Run this scene's path alone (a file, or a shipped scene's name); without it, the "
    "fundamental case and the design's grips."
)
@options.fidelity_option("3d", auto=True, finite=True)
@click.option(
    "--accuracy",
    "--tolerance",
    "accuracy",
    type=float,
    default=None,
    help="Error allowed in forces, stick ratio and gage readings, a part of one: takes --fidelity "
    "auto.  [default: 0.02]",
)
@click.option(
    "--mesher",
    type=click.Choice(["auto", "sweep", "tetwild"]),
    default=None,
    help="In place of the design's mesh.mesher; sweep: prisms, of straight fingers.",
)
@options.go_on_option
@options.result_options
@options.details_option
@options.page_options
def analyse() -> None:
    """Analyse each DESIGN: contact, gages, grips, and a result in OUT/NAME.

    A DESIGN is a file, or the name of a shipped finger. A result is written whole or not at all;
    one failing design does not stop the others. What was analysed before, by the same program, is
    not computed again: its result is in the cache.

    3d meshes half of the finger where design and scene mirror in z = 0, else all of it; with
    pytetwild unless the design or --mesher names another.
    """


@options.command("studio", "See a finger follow its sliders, in the browser.")
@click.argument("design_file", metavar="[DESIGN]", required=False, type=options.DESIGN)
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Of the page; without it a free one."
)
@click.option("--no-open", is_flag=True, help="Leave the browser closed; else it is opened.")
@options.quiet_option
def studio() -> None:
    """Serve a page on this machine alone, on which DESIGN's numbers follow its sliders.

    DESIGN is a file or a shipped design's name; without it, maeno2000. The page shows the section
    with its dimensions, the finger in space, contact, tractions, gages and a verdict: at once in
    plane strain, by a section coarser than an analysis's, and in 3-D on request. It
    follows the file; Save leaves its comments unchanged. The address holds a token, without
    which nothing is answered. Needs: pip install 'fingerdesign[studio]'. Ctrl-C ends it.
    """


@options.command("validate", "What each modelling assumption costs, and saves.")
@options.design_and_out("validate")
@options.scene_option()
@click.option(
    "--deep", is_flag=True, help="Finite strain in three dimensions too: minutes, not seconds."
)
@click.option(
    "--only",
    "keys",
    multiple=True,
    metavar="ASSUMPTION",
    help=f"This assumption alone; may be given again. One of: {', '.join(_KEYS)}.",
)
@click.option("--gages", is_flag=True, help="Validate the gages instead: minutes.")
@click.option(
    "--noise",
    type=float,
    help="With --gages: standard deviation of a sample, microstrain.  [default: 0.5]",
)
@click.option("--grips", type=int, help="With --gages: grips to learn from.  [default: 600]")
@options.workers_option
@options.fidelity_option("plane-strain")
@options.page_options
def validate() -> None:
    """Tell what each modelling assumption costs for DESIGN in a scene, and what it saves.

    Each is held against the next better model, at equal motion and at equal force. OUT/NAME then
    holds validate.html (table, chart, advice), validate.json, validate.csv and validate.png.

    --gages reports instead how well the gages determine the stick ratio, how few suffice and where:
    observability.json and .png, counts.csv (error by number of gages), gages.csv (each gage: rank,
    and the cost of its failure). Errors are of learners on other grips of the same finger.

    Exit code 0 also where DESIGN and scene can tell nothing: each row says why. 1, status "failed"
    and a sentence as failure, where models failed and no assumption was reported.
    """


@options.command("mold", "Spread of fingers as cast; what to tighten first.")
@options.design_and_out("tolerance")
@options.scene_option()
@options.fidelity_option("plane-strain")
@click.option(
    "--yield-within",
    "within",
    type=options.FiniteRange(1.0, 50.0),
    metavar="POINTS",
    help="Also mesh and lift fingers as cast, until the yield is known to within so many points.",
)
@options.workers_option
@options.page_options
def tolerance() -> None:
    """Report the spread of fingers that are cast as DESIGN, by one analysis and its derivatives.

    Plates are off by what holds them in the mold, the rubber by its batch, gages by their factors.
    Yield is the share of fingers that grip with 1.1 to 1.5 times the least force, if a stage closes
    all of them alike. --yield-within also lifts with the design's own controller; each finger takes
    seconds. OUT/NAME then holds report.html (what to tighten first, the spread) and tolerance.json.
    """


@options.command("mold", "Make the mold that a finger is cast in.")
@options.design_and_out("mold")
@click.option(
    "--process",
    type=click.Choice(["sla", "fdm", "machined"]),
    help="Instead of mold.process: how the parts are made.",
)
@click.option(
    "--fixture",
    "plate_fixture",
    type=click.Choice(["comb", "slots"]),
    help="Instead of mold.plate_fixture: what holds the plates.",
)
@click.option(
    "--profile",
    type=options.Place(dir_okay=False),
    help="Instead of mold.process, [mold.limits] and [mold.comb]: what your machine and cutter "
    "hold, as measured on the profile.toml of a first mold.",
)
@options.open_option
@options.details_option
@options.output_options
def mold() -> None:
    """Make the mold that DESIGN is cast in: parts, plate fixture, checks, casting notes.

    OUT/NAME then holds each part as STL and STEP, mold.3mf (printed parts on the bed, in mm), DXF
    drawings of plates and combs, bill_of_materials.csv, profile.toml, exploded.png,
    mold_report.json and report.html with the casting notes. The design's [mold] table says how it
    is made; docs/how_to/molds.md tells its keys.

    Exit code 1 where a check fails: record and report say which, and why.
    """


@options.command("shelf", "What there is: designs, materials, metrics ...")
@click.argument("what", metavar="WHAT...", nargs=-1, type=click.Choice(options.SHELVES))
@options.json_option
def list_() -> None:
    """List the entries of WHAT: designs, scenes, studies, materials, metrics, controllers (those of
    plug-ins too), gages. Without WHAT, these topics; with --json, every entry."""


@options.command("view", "Draw a design, or show a result.")
@click.argument("target", metavar="DESIGN|DIR", type=options.DESIGN)
@options.out_option()
@options.details_option
@options.open_option
@click.option("--cad", is_flag=True, help="Of a result: write STEP and STL files if missing.")
@options.output_options
def view() -> None:
    """Draw DESIGN with its dimensions, or show what a command wrote to DIR.

    DESIGN is a file or a shipped design's name. OUT/NAME.svg and OUT/NAME.png show its section, its
    side and one plate enlarged, in a second: nothing is meshed or solved.

    DIR is a folder that a command wrote, or a folder of such folders. The
    terminal shows what is in it, what is good and bad in it, and where its report is. A result's
    report that is missing is drawn, but not with --quiet or --json.

    Exit code 2 where there is nothing that a command wrote. A failed analysis is shown like any
    other.
    """


study_fidelity_option = options.fidelity_option(
    None, auto=True, unset="study.fidelity; of a study alone"
)


@options.command("studies.generate", "Write a study's variants as files.")
@click.argument("study_file", metavar="STUDY", type=options.STUDY)
@options.out_option()
@click.option(
    "--only",
    metavar="N",
    type=click.IntRange(min=1),
    multiple=True,
    help="Only the variant of this number; may be given again.",
)
@click.option("--cad/--no-cad", default=True, show_default=True, help="Write STEP and STL too.")
@options.workers_option
@options.output_options
def generate() -> None:
    """Write the variants of STUDY, a TOML file or a shipped study: a folder each in OUT/NAME.

    It holds the variant's design as TOML, finger.step, and finger.stl (the outside), body.stl and
    plates.stl. variants.csv lists values and digests of designs; invalid.csv those that cannot
    exist, with the faults found (one that hides others is reported first). Run again, it makes what
    is missing.

    With --json a line of JSON a variant as it is done (number: the variant's; done: how many are),
    and a last one for the folder.

    Exit code 1 where the CAD of a variant fails, or no variant can exist.
    """


@options.command("studies.search", "Analyse every variant of a study.")
@click.argument("study_file", metavar="STUDY", type=options.STUDY)
@options.out_option()
@options.scheduler_options
@click.option("--retry", is_flag=True, help="Run again what failed: for time, memory, a crash.")
@click.option(
    "--shard",
    metavar="I/N",
    help="Every N-th variant from the I-th, into OUT/NAME.I-of-N; compare OUT joins them.",
)
@study_fidelity_option
@options.page_options
def sweep() -> None:
    """Analyse every variant of STUDY, a TOML file or a shipped study, and compare them.

    Each variant is analysed in a process of its own under the study's [limits]: one that crashes,
    hangs or takes too much memory is a failure with its cause, and the rest goes on. What is done
    is stored at once, by content: interrupted or run again, a study computes only what is missing,
    and two studies share what they have in common. OUT/NAME holds report.html, outcomes, tables; of
    more than 5,000 outcomes outcomes.sqlite, and a page of the best.

    With --json a line of JSON an outcome as it comes (number: the variant's; done: how many are),
    and a last one for the folder. With --quiet one line where variants failed. Exit code 1 where no
    variant at all could be analysed.
    """


@options.command("studies.search", "Find a finger that passes, from a design; or search a study.")
@click.argument("study_file", metavar="DESIGN|STUDY", type=options.ShippedOrFile("design", "study"))
@options.out_option()
@click.option(
    "--trials",
    type=click.IntRange(1, 100_000),
    help="Most trials. Without it 48 from a design, 16 where it cannot be swept; of a study "
    "what its [optimise] says.",
)
@click.option(
    "--keep",
    multiple=True,
    metavar="KEY",
    help="From a design: a key or table that stays, as body or plates.material; repeatable.",
)
@click.option(
    "--free",
    multiple=True,
    metavar="KEY",
    help="From a design: a further key that may vary, as body.width_mm; repeatable.",
)
@options.scheduler_options
@click.option("--retry", is_flag=True, help="Run again what failed for time, memory or a crash.")
@study_fidelity_option
@options.page_options
def optimise() -> None:
    """Search from DESIGN for a finger that passes all verdicts of `analyse`.

    Body, plates, gages and the rule of the hand vary; --keep and --free change that. A round shape,
    your own CAD or a core is given up where no finger passes with it, and the command says so.
    Trials run in 3-D on swept cells. The best are analysed as `analyse` does it, and the search
    ends with the first that passes. OUT/NAME-optimised.toml is the finger, OUT/NAME-optimised its
    analysis, OUT/NAME-optimised.html compares it with DESIGN. Exit code 1 where none passes: the
    page then shows which verdicts exclude each other.

    With a STUDY: search for fingers that are better in its [[objectives]], within its
    [constraints]. After trials in plane strain the best of the front, and the study's base as the
    reference, are analysed in 3-D. OUT/NAME holds report.html, study.json, outcomes.jsonl, tables.
    Exit code 1 where no trial could be analysed.

    All trials are stored: an interrupted search, run again, goes on where it stopped.
    """


@options.command("studies.compare", "Which finger is better at what, on one page.")
@click.argument("results", metavar="RESULT...", nargs=-1, required=True, type=options.FILE)
@click.option(
    "--out",
    metavar="FILE",
    type=options.FILE,
    default=options.OUT / "compare.html",
    show_default=True,
    help="Where to write: the page, FILE.html.",
)
@click.option(
    "--csv", "csv_file", metavar="FILE", type=options.FILE, help="Also a row a design as CSV."
)
@click.option(
    "--objective",
    "requested",
    metavar="METRIC[:min|max]",
    multiple=True,
    help="The aim of a finger, instead of the study's own; may be given again.",
)
@click.option(
    "--complete",
    is_flag=True,
    help="Work out what results of analyse lack: stick_error, cost and what others have.",
)
@options.page_options
def compare() -> None:
    """Compare the designs of every RESULT on one page that opens offline.

    A RESULT is what sweep or optimise wrote (OUT/NAME), a result of analyse, a folder of such
    folders, or a file of outcomes (outcomes.jsonl). The page recommends a finger and says why;
    its table sorts and filters, its chart shows the Pareto front, two designs stand side by side,
    failures are listed, and every number can be saved.

    With --json what is recommended, and why not the others, on stdout.

    Exit code 2 where a RESULT is none. Failed designs are shown with their causes: exit code 0.
    """
