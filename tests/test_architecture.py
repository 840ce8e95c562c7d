"""What may import what: one direction of data, light front doors, heavy kernels behind theirs."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "fingerdesign"
ORDER = ["design", "geometry", "mesh", "reduced", "fem", "contact", "finite", "control"]
ALLOWED = {
    "cadquery": {"geometry", "mold"},
    "OCP": {"geometry", "mold"},
    "pytetwild": {"mesh/tetra/worker.py"},
    "netgen": {"mesh/section/worker.py"},
    "skfem": {"fem"},
    "pypardiso": {"fem/factor.py"},
    "manifold3d": {"mold"},
    "lib3mf": {"mold"},
    "ezdxf": {"mold"},
    "optuna": {"sweep"},
    "distributed": {"sweep"},
    "matplotlib": {"report", "study", "bench", "mesh/pictures.py"},
    "pyvista": {"report", "mesh"},
}


def imports(path: Path) -> set[str]:
    """Modules that a file imports, whether at its top or inside functions; not for typing only."""
    tree = ast.parse(path.read_text("utf-8"))
    typing_only = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    found = set()
    for node in ast.walk(tree):
        if id(node) in typing_only:
            continue
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module)
    return found


FILES = sorted(PACKAGE.rglob("*.py"))


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_heavy_kernels_stay_in_their_place(path):
    relative = path.relative_to(PACKAGE).as_posix()
    folder = relative.split("/")[0]
    for module in imports(path):
        places = ALLOWED.get(module.split(".")[0])
        if places is not None:
            assert folder in places or relative in places, f"{relative} imports {module}"


@pytest.mark.parametrize("folder", ["contact", "control"])
def test_contact_and_control_need_numpy_alone(folder):
    standard = set(sys.stdlib_module_names) | {"numpy", "fingerdesign"}
    for path in (PACKAGE / folder).rglob("*.py"):
        for module in imports(path):
            assert module.split(".")[0] in standard, f"{path.name} imports {module}"
            parts = module.split(".")
            if parts[0] == "fingerdesign" and len(parts) > 1:
                assert parts[1] not in {"geometry", "mesh", "fem", "report", "pipeline"}


def test_data_flows_one_way():
    for path in FILES:
        layer = path.relative_to(PACKAGE).as_posix().split("/")[0].removesuffix(".py")
        if layer not in ORDER:
            continue
        for module in imports(path):
            parts = module.split(".")
            if parts[0] == "fingerdesign" and len(parts) > 1 and parts[1] in ORDER:
                assert ORDER.index(parts[1]) <= ORDER.index(layer), f"{path} imports {module}"


def test_report_knows_results_only():
    for path in (PACKAGE / "report").rglob("*.py"):
        for module in imports(path):
            assert not module.startswith(
                ("fingerdesign.contact", "fingerdesign.fem", "fingerdesign.control")
            )
            assert module != "fingerdesign.pipeline"


def test_importing_the_package_is_light():
    heavy = "{'numpy', 'pydantic', 'cadquery', 'pyvista', 'netgen', 'skfem', 'matplotlib'}"
    code = f"import sys, fingerdesign; sys.exit(bool({heavy} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_files_are_about_one_idea(path):
    assert len(path.read_text("utf-8").splitlines()) <= 500
