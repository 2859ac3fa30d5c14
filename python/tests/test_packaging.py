"""Files that build packages elsewhere: they are read, name what is here, and agree with the package."""

import subprocess
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

from supercoil import _supercoil

ROOT = Path(__file__).parents[2]


def read(path: str) -> dict[Any, Any]:
    """A file of YAML."""
    yaml = pytest.importorskip("yaml")
    found = yaml.safe_load((ROOT / path).read_text())
    assert isinstance(found, dict)
    return found


@pytest.mark.parametrize("name", ["tests", "wheels", "docs"])
def test_workflows_are_valid(name: str) -> None:
    flow = read(f".github/workflows/{name}.yml")
    # YAML 1.1 takes "on" for true
    assert {"name", "jobs"} <= set(flow) and (True in flow or "on" in flow)
    for job in flow["jobs"].values():
        assert "runs-on" in job and set(job.get("needs", []) if isinstance(job.get("needs"), list) else []) <= set(flow["jobs"])
        for step in job["steps"]:
            assert ("uses" in step) != ("run" in step), step
            assert "@" in step.get("uses", "@"), step
            folder = step.get("working-directory") or step.get("with", {}).get("working-directory")
            assert folder is None or (ROOT / folder).is_dir()


@pytest.mark.parametrize("name", ["tests", "wheels", "docs"])
def test_workflows_follow_the_schema(name: str) -> None:
    """The schema of GitHub's workflows, as check-jsonschema brings it along."""
    pytest.importorskip("check_jsonschema")
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", "vendor.github-workflows"]
    done = subprocess.run([*command, ROOT / f".github/workflows/{name}.yml"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_rattler_build_reads_the_recipe() -> None:
    """The program with which conda-forge builds; it resolves what depends on platform and Python."""
    rattler = pytest.importorskip("rattler_build")
    recipe = rattler.Stage0Recipe.from_file(str(ROOT / "python/conda/recipe.yaml"))
    # what conda-forge's own configuration says
    pinned = {"is_abi3": ["true"], "python": ["3.10.*"], "c_stdlib": ["sysroot"], "c_stdlib_version": ["2.28"]}
    (rendered,) = recipe.render(rattler.VariantConfig(pinned))
    assert rendered.recipe.package.name == "supercoil"


def test_the_recipe_agrees_with_the_package() -> None:
    project = (ROOT / "python" / "pyproject.toml").read_text()
    recipe = read("python/conda/recipe.yaml")
    assert f'version = "{recipe["context"]["version"]}"' in project
    for requirement in recipe["requirements"]["run"][1:]:
        assert f'"{requirement.replace(" ", "")}"' in project
    assert all((ROOT / name).exists() for name in recipe["about"]["license_file"][:2])
    assert f'supercoil = "{recipe["build"]["python"]["entry_points"][0].split(" = ")[1]}"' in project


def test_one_wheel_serves_all_versions_of_python() -> None:
    found = metadata.distribution("supercoil")
    assert "Tag: cp310-abi3-" in (found.read_text("WHEEL") or "")
    assert found.metadata["Requires-Python"] == ">=3.10"
    names = {Path(str(file)).name for file in found.files or []}
    assert {"LICENSE-MIT", "LICENSE-APACHE", "LICENSE-DejaVuSans"} <= names


def test_the_wheel_keeps_to_the_stable_interface() -> None:
    """abi3audit looks up every symbol that the library takes from Python, and since which version it is stable."""
    pytest.importorskip("abi3audit")
    command = [sys.executable, "-m", "abi3audit", "--strict", "--assume-minimum-abi3", "3.10", _supercoil.__file__]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
