"""What may import what: floors, no circles, light front doors, heavy kernels behind theirs."""

import ast
import re
import subprocess
import sys
from collections import Counter

import pytest

from tests.support.house import (
    PLACES,
    ROOT,
    against_the_order,
    circles,
    imports_in,
    inside_functions,
    long_functions,
    modules,
    room,
    tree,
)
from tests.support.mutants import mutants

KERNELS = {
    "cadquery": {"cad", "mold"},
    "OCP": {"cad", "mold"},
    "pytetwild": {"mesh"},
    "netgen": {"mesh"},
    "skfem": {"fem"},
    "pypardiso": {"fem"},
    "pymetis": {"fem"},
    "manifold3d": {"layout", "mold"},
    "lib3mf": {"mold"},
    "ezdxf": {"mold"},
    "distributed": {"search"},
    "gymnasium": {"trials"},
    "trame": {"studio"},
    "mujoco": {"robots"},
    "pyarrow": {"trials"},
    "h5py": {"trials"},
}
NAMES_INSIDE_FUNCTIONS = 80  # each for a heavy library or a light start
MOST_LINES, MOST_FILES = 600, 20


def sentences(found):
    return "\n".join(f"{e.source}:{e.line} takes {e.name} from {e.target}" for e in found)


def test_every_folder_has_a_floor():
    assert {room(module) for module in modules()} - {""} == set(PLACES)


def test_imports_go_down():
    found = against_the_order()
    assert not found, sentences(found)


def test_no_files_import_each_other_in_a_loop():
    assert circles() == []


def test_few_names_are_imported_inside_functions():
    found = inside_functions()
    assert len(found) <= NAMES_INSIDE_FUNCTIONS, sentences(found)


def outside(path):
    """Packages that a file imports, wherever the import stands."""
    found = set()
    for node, _ in imports_in(tree(path)):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        found |= {name.partition(".")[0] for name in names or [node.module or ""]}
    return found - {""}


def test_heavy_kernels_stay_in_their_place():
    for module, path in modules().items():
        if module.startswith("fingerdesign."):
            for kernel in outside(path) & set(KERNELS):
                assert room(module) in KERNELS[kernel], f"{module} imports {kernel}"


def test_contact_and_control_need_numpy_alone():
    allowed = set(sys.stdlib_module_names) | {"numpy", "scipy", "fingerdesign"}
    for module, path in modules().items():
        if room(module) in {"contact", "control"}:
            assert outside(path) <= allowed, module


def test_processes_locks_and_renames_are_the_runtimes():
    """One mechanism each: isolate and pool, cache and journal, files."""
    packages = {"subprocess", "multiprocessing", "fcntl", "sqlite3", "secrets"}
    calls = re.compile(r"os\.(replace|rename|fork|exec)|ProcessPool|mkdtemp|mkstemp|\.rename\(")
    for module, path in modules().items():
        if room(module) == "runtime" or module == "fingerdesign.search.run.cluster":
            continue  # Dask is the cluster's own
        if module.startswith(("fingerdesign.", "fingerdesign_cli.")):
            assert not outside(path) & packages, module
            assert not calls.findall(path.read_text("utf-8")), module


@pytest.mark.slow
def test_files_with_registries_may_be_imported_first():
    """A registry loads the files of its kinds by name, which the imports read above do not show."""
    rooms = {"control", "design", "layout", "shapes"}
    names = [name for name in modules() if room(name) in rooms]
    code = """
import gc, importlib, sys
gc.disable()  # a fifth of the time: what is imported again and again is never free
for name in sys.argv[1:]:
    for known in [each for each in sys.modules if each.startswith("fingerdesign")]:
        del sys.modules[known]
    importlib.import_module(name)
"""
    done = subprocess.run(
        [sys.executable, "-c", code, *names], check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


def test_a_function_reads_in_one_sitting():
    assert long_functions() == []


def test_a_file_is_one_idea_and_a_folder_can_be_looked_through():
    files = [*(ROOT / "fingerdesign").rglob("*.py"), *(ROOT / "cli").rglob("*.py")]
    for path in files:
        assert len(path.read_text("utf-8").splitlines()) <= MOST_LINES, path
    for folder, count in Counter(path.parent for path in files).items():
        assert count <= MOST_FILES, folder


FILE_NAMED = re.compile(
    r"(?<![\w/.])((?:fingerdesign|cli|benchmarks|tests|designs)/[\w/]+\.(?:py|toml|j2))"
)


def test_files_that_texts_name_are_there():
    texts = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("designs/**/*.toml")]
    for part in ("fingerdesign", "cli", "benchmarks", "tests"):
        texts += (ROOT / part).rglob("*.py")
    named = {(path.name, name) for path in texts for name in FILE_NAMED.findall(path.read_text())}
    assert [each for each in named if not (ROOT / each[1]).is_file()] == []


def test_mutants_are_of_lines_that_are_there():
    assert [m.what for m in mutants() if m.right not in (ROOT / m.file).read_text("utf-8")] == []


POSIX_MODULES = re.compile(
    "crypt|fcntl|grp|nis|posix|pty|pwd|readline|resource|spwd|syslog|termios|tty"
)
POSIX_NAMES = {
    "os": "chown fchmod fchown fork forkpty getegid geteuid getgid getgroups getloadavg getpgid "
    "getpriority getsid getuid killpg lchown mkfifo mknod nice openpty pipe2 posix_fallocate "
    "posix_spawn pread pwrite sched_getaffinity sched_setaffinity setegid seteuid setgid setpgid "
    "setpriority setsid setuid statvfs sync uname wait wait3 wait4 waitid WIFEXITED WNOHANG",
    "signal": "SIGALRM SIGCHLD SIGCONT SIGHUP SIGKILL SIGPIPE SIGQUIT SIGSTOP SIGTSTP SIGUSR1 "
    "SIGUSR2 SIGXCPU alarm pause pthread_kill pthread_sigmask setitimer sigwait",
}


def only_posix(node, guarded=False):
    """What only POSIX has below a node, where no condition asks for the system or for the name."""
    if isinstance(node, ast.If | ast.IfExp | ast.BoolOp):
        condition = node.values[0] if isinstance(node, ast.BoolOp) else node.test
        guarded = guarded or re.search(r"hasattr|sys.platform|os.name", ast.unparse(condition))
    if not guarded:
        names = [each.name for each in node.names] if isinstance(node, ast.Import) else []
        names += [node.module] if isinstance(node, ast.ImportFrom) else []
        yield from filter(POSIX_MODULES.fullmatch, filter(None, names))
        of = getattr(getattr(node, "value", None), "id", None)
        if isinstance(node, ast.Attribute) and node.attr in POSIX_NAMES.get(of, "").split():
            yield f"{of}.{node.attr}"
        if isinstance(node, ast.Constant) and str(node.value).startswith(("/tmp", "/var", "/dev/")):
            yield str(node.value)
    for each in ast.iter_child_nodes(node):
        yield from only_posix(each, guarded)


def test_nothing_is_called_that_windows_lacks():
    for module, path in modules().items():
        if module.startswith(("fingerdesign.", "fingerdesign_cli.")):
            assert list(only_posix(tree(path))) == [], module
    for line in ("import fcntl", "os.killpg(0, 9)", "x = signal.SIGKILL", "open('/tmp/a')"):
        assert list(only_posix(ast.parse(line))), line
    assert not list(only_posix(ast.parse("if hasattr(os, 'fork'):\n    os.fork()")))


def test_hashes_are_of_the_versions_that_are_pinned():
    def pinned(name):
        lines = (ROOT / name).read_text("utf-8").splitlines()
        rows = [re.match(r"([\w.-]+)==([^\s;]+)", line) for line in lines]
        return {re.sub(r"[-_.]+", "-", row[1]).lower(): row[2] for row in rows if row}

    hashed, every = pinned("hashes.txt"), pinned("constraints.txt")
    assert len(hashed) > 100
    assert {name: every.get(name) for name in hashed} == hashed
    lines = (ROOT / "hashes.txt").read_text("utf-8").splitlines()
    assert all(re.search(r" --hash=sha256:[0-9a-f]{64}$", each) for each in lines if each[0] != "#")


def test_the_table_of_sizes_says_which_python_has_its_packages():
    given = [sys.executable, "-S", "-E", ROOT / "tests" / "support" / "size.py"]  # no packages
    found = subprocess.run(given, capture_output=True, text=True, timeout=60, check=False)
    assert found.returncode == 1
    assert re.fullmatch(r"No module named '.*': run it by .venv/bin/python.*\n", found.stderr)
