"""Inputs of subcommands: files or shipped names, estimators, folders that are written whole."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path

import click

from fingerdesign.checks.load import judge_design
from fingerdesign.checks.scene import scene_faults
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.roster import needs_training
from fingerdesign.design.io import Judged, judge_scene
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import file_text
from fingerdesign.errors import DesignError, EstimatorError, Fault
from fingerdesign.records.base import ResultError
from fingerdesign.records.folder import RecordFolder
from fingerdesign.runtime.files import whole_text, why_unread
from fingerdesign.runtime.journal import held
from fingerdesign.runtime.progress import Progress
from fingerdesign_cli.terminal import progress, quiet

GOES_ON = "finished work is stored: run the same command to go on"


def read_case(design_name: Path, scene_name: Path | None = None) -> tuple[Design, Scene | None]:
    """Return a design and a scene, each of a file or shipped under that name. Raises
    :class:`DesignError` with every fault of both and of the one against the other."""
    scene, wrong = (None, None) if scene_name is None else judged_scene(scene_name)
    found, error = judged_design(design_name, scene)
    if wrong or error or found is None or found.value is None:
        raise DesignError.together([each for each in (wrong, error) if each])
    return found.value, scene.value if scene is not None else None


@contextmanager
def collected(wrong: list[DesignError]) -> Iterator[None]:
    """Add the block's refusal to the others; each names its own file."""
    try:
        yield
    except DesignError as error:
        wrong.append(error)


def all_sound(*steps: Callable[[], object]) -> None:
    """Take each step. Raises one DesignError with the faults of all."""
    wrong: list[DesignError] = []
    for step in steps:
        with collected(wrong):
            step()
    if wrong:
        raise DesignError.together(wrong)


def judged_scene(name: Path) -> tuple[Judged[Scene] | None, DesignError | None]:
    """Judge a scene's file, or the shipped one; with the error that holds its faults, if any."""
    try:
        found = judge_scene(file_text(name, "scene"), str(name))
    except DesignError as error:
        return None, error
    return found, DesignError(found.faults, str(name)) if found.faults else None


def judged_design(
    name: Path, scene: Judged[Scene] | None = None
) -> tuple[Judged[Design] | None, DesignError | None]:
    """Judge a design's file, or the shipped one, and against it the scene where there is one."""
    try:
        found = judge_design(file_text(name), str(name), Path(name).parent)
    except DesignError as error:
        return None, error
    both = [DesignError(found.faults, str(name))]
    if scene is not None and scene.value is not None and found.value is not None:
        both.append(DesignError(scene_faults(scene.value, found.value), f"{name} (scene)"))
    together = DesignError.together(both)
    return found, together if together.faults else None


def estimator_for(
    design: Design, path: Path | None, fidelity: str | None = None, hands: Iterable[str] = ()
) -> GripEstimator | None:
    """The estimator in a file that ``fingerdesign train`` wrote, or that of a shipped design, by
    its name; None without a file.

    hands: controllers that will grip; a line on stderr reports where one of them could have had the
    estimator that ships under the design's name, if the design were as it shipped. DesignError for
    any other file, and for one that was trained on another design or at another fidelity (None:
    any).
    """
    if path is None:
        if any(map(needs_training, hands)):
            _say_unused(design, fidelity)
        return None
    from fingerdesign.design.shipped import estimator_texts
    from fingerdesign.sensing.train.ready import adopted_estimator
    from fingerdesign.sensing.train.result import estimator_faults

    estimator = None if path.exists() else adopted_estimator(design, str(path))
    if estimator is not None and estimator.adopted_from and not quiet():
        own = "fingerdesign train makes this finger's own, which lifts more with several faults"
        click.echo(f"the estimator of {path} is of another finger; {own}", err=True)
    try:
        estimator = estimator or GripEstimator.from_json(whole_text(path))
    except (OSError, UnicodeDecodeError, EstimatorError) as error:
        bound = f"an estimator's JSON file, or a design with one: {', '.join(estimator_texts())}"
        fault = Fault("--estimator", str(path), bound, why_unread(error))
        raise DesignError([fault]) from error
    if faults := estimator_faults(design, estimator, fidelity):
        raise DesignError(faults, str(path))
    return estimator


def _say_unused(design: Design, fidelity: str | None) -> None:
    """Report that the estimator which ships under the design's name is not used, if so."""
    from fingerdesign.sensing.train.ready import grip_fidelity, unused_estimator

    note = unused_estimator(design, fidelity and grip_fidelity(fidelity))
    if note and not quiet():
        click.echo(note, err=True)


@contextmanager
def naming_out(target: Path, what: str, option: str = "--out") -> Iterator[None]:
    """DesignError that names the option for a ResultError of the block: ``target`` is in the way.
    --out is the folder above it, any other option the target itself."""
    try:
        yield
    except ResultError as error:
        remedy = f"choose another, for {str(error).removesuffix('; choose another --out')}"
        given = target.parent if option == "--out" else target
        fault = Fault(option, str(given), f"a folder for {what}", remedy)
        raise DesignError([fault]) from error


def refuse_foreign(kind: RecordFolder, target: Path, option: str = "--out") -> None:
    """DesignError, before any work, where ``target`` holds what is no older record of the kind."""
    with naming_out(target, f"a {kind.kind}", option):
        kind.refuse_foreign(target)


def refuse_in_the_way(files: Iterable[Path], own: Path) -> None:
    """DesignError, before any work, where one of ``files`` is there already and nothing shows that
    a command made it: ``own``, which is written next to them, is missing."""
    if not own.is_file() and (there := [each for each in files if each.exists()]):
        named = ", ".join(each.name for each in there)
        bound = f"a folder without {named}, which no command has written"
        raise DesignError([Fault("--out", str(own.parent), bound, "choose another --out")])


@contextmanager
def interrupted(stored: str) -> Iterator[None]:
    """Give an interruption of the block, or of the function that this decorates, the words for
    what becomes of its work; main prints them."""
    try:
        yield
    except KeyboardInterrupt as stopped:
        raise KeyboardInterrupt(stored) from stopped


@contextmanager
def recorded(
    kind: RecordFolder, target: Path, journal: Path | None = None, option: str = "--out"
) -> Iterator[tuple[Path, Progress]]:
    """A folder to write into, which takes the place of ``target``, and progress.

    journal: of work that goes on where it stopped; it is one process's, and is gone once the folder
    stands. option: see :func:`naming_out`.
    """
    refuse_foreign(kind, target, option)
    own = nullcontext() if journal is None else interrupted(GOES_ON)
    with own, folders_above(target), held(journal) if journal is not None else nullcontext():
        with kind.written(target) as folder, progress(target.name) as show:
            yield folder, show
        if journal is not None:
            journal.unlink(missing_ok=True)


@contextmanager
def folders_above(target: Path) -> Iterator[None]:
    """Remove the folders above ``target`` that the block made, where it wrote nothing there."""
    missing = [each for each in target.absolute().parents if not each.exists()]
    try:
        yield
    finally:
        for each in missing:
            with suppress(OSError):  # it holds something
                each.rmdir()
