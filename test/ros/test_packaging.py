# SPDX-License-Identifier: Apache-2.0
"""Metadata of the package agree: setup.py, package.xml, parameter files, launch files, pinned versions."""

import ast
import importlib
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from process_bench import config_file

import drill_twin
from drill_twin.core.companions import COMPANIONS
from drill_twin.io.messages.topics import TOPICS
from drill_twin.ros import composed_twin, entry_points
from drill_twin.ros.core.parameters import file_text
from drill_twin.scene import presets

ROOT = Path(__file__).resolve().parents[2]
NODES = {name: entry_points.load(name) for name in entry_points.node_names()}
EXECUTABLES = {*NODES, "twin", "watch"}
# Import name -> distribution, where they differ.
DISTRIBUTIONS = {"yaml": "pyyaml", "llvmlite": "numba", "pydantic_core": "pydantic"}
FROM_ROS = {"rclpy", "rcl_interfaces", "lifecycle_msgs", "std_srvs", "ament_index_python"}


FOLDERS = {"drill_twin": ROOT} | {package.name: package for package in sorted(ROOT.glob("companions/*"))}
"""Folder of each package: the core, and its companions."""
of_each_package = pytest.mark.parametrize("package", FOLDERS)


def _setup_arguments(folder):
    """The keyword arguments that a setup.py gives to setup()."""
    import setuptools

    seen = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(setuptools, "setup", lambda **given: seen.update(given))
        patch.chdir(folder)
        runpy.run_path(str(folder / "setup.py"))
    return seen


@pytest.fixture(scope="module")
def setup_arguments():
    return _setup_arguments(ROOT)


@of_each_package
def test_versions_and_licences_agree(package):
    folder = FOLDERS[package]
    given, manifest = _setup_arguments(folder), (folder / "package.xml").read_text("utf-8")
    assert (given["name"], given["version"]) == (package, drill_twin.__version__)
    assert f"<version>{drill_twin.__version__}</version>" in manifest
    assert f"<name>{package}</name>" in manifest
    assert given["license"] == "Apache-2.0"
    assert ">Apache-2.0</license>" in manifest
    if package != "drill_twin":
        assert f"drill_twin=={drill_twin.__version__}" in given["install_requires"]
        assert "<exec_depend>drill_twin</exec_depend>" in manifest
    assert "Apache License" in (ROOT / "LICENSE").read_text("utf-8")


def test_the_table_of_companions_has_what_they_bring(setup_arguments):
    assert {companion.name for companion in COMPANIONS} == FOLDERS.keys() - {"drill_twin"}
    assert {line.partition("=")[0] for line in setup_arguments["extras_require"]["all"]} == FOLDERS.keys() - {
        "drill_twin"
    }
    for companion in COMPANIONS:
        points = _setup_arguments(FOLDERS[companion.name])["entry_points"]
        brought = {group: {line.partition(" = ")[0] for line in lines} for group, lines in points.items()}
        assert brought["drill_twin.commands"] == set(companion.commands)
        assert brought["drill_twin.nodes"] == set(companion.nodes)


def test_commands_carry_the_name_of_the_package_and_ros2_run_finds_every_node(setup_arguments):
    """What is on PATH after `pip install` is `drill-twin`; `ros2 run` looks into lib/drill_twin."""
    scripts = dict(line.split(" = ") for line in setup_arguments["entry_points"]["console_scripts"])
    assert set(scripts) == {"drill-twin"}
    module, _, function = scripts["drill-twin"].partition(":")
    assert callable(getattr(importlib.import_module(module), function))
    executables = [ROOT / file for file in dict(setup_arguments["data_files"])["lib/drill_twin"]]
    assert {file.name for file in executables} == EXECUTABLES <= set(entry_points.executables())
    assert len({file.read_bytes() for file in executables}) == 1
    assert all(os.access(file, os.X_OK) for file in executables)
    assert all(name == entry_points.load(name).NAME for name in NODES)


@pytest.mark.parametrize("layout", ["lib/drill_twin", "bin"])
def test_an_executable_runs_its_node_wherever_the_command_is(tmp_path, layout):
    """`colcon` puts the command beside the executables, `pip` into bin; it is called from any folder, by a link too."""
    command = tmp_path / layout / "drill-twin"
    executables = tmp_path / "lib" / "drill_twin"
    for folder in (command.parent, executables):
        folder.mkdir(parents=True, exist_ok=True)
    command.write_text(f"#!{sys.executable}\nfrom drill_twin.cli import main\nmain()\n")
    command.chmod(0o755)
    (executables / "analyzer").symlink_to(ROOT / "resource" / "executables" / "analyzer")
    environment = dict(os.environ, PYTHONPATH=str(ROOT))
    said = subprocess.run(
        [executables / "analyzer", "--help"],
        cwd="/", env=environment, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert said.returncode == 0, said.stderr
    assert said.stdout.startswith("usage: analyzer ")


@of_each_package
def test_all_data_is_installed(package):
    folder = FOLDERS[package]
    given = _setup_arguments(folder)
    installed = {Path(file) for _, files in given["data_files"] for file in files}
    for file in (folder / "config").glob("*/*.*"):
        assert file.relative_to(folder) in installed
    folders = {Path(place).name for place, _ in given["data_files"]}
    assert {"scenes", "schema", "nodes", "launch", "dds", "views", "packages"} <= folders or package != "drill_twin"
    (pattern,) = given["package_data"].values()
    packed = {path for each in pattern for path in (folder / package).glob(each)}
    other = {path for path in (folder / package).rglob("*") if path.is_file() and path.suffix not in {".py", ".pyc"}}
    assert other <= packed


@of_each_package
def test_every_import_is_declared(package):
    folder = FOLDERS[package]
    given = _setup_arguments(folder)
    extras = given.get("extras_require", {})
    wanted = {name for name in extras if name in {"las", "dask", "xarray"}}
    lines = [*given["install_requires"], *(line for name in wanted for line in extras[name])]
    if package != "drill_twin":  # what the core needs is there with it
        lines += _setup_arguments(ROOT)["install_requires"]
    declared = {re.split(r"[<>=!~ ]", line)[0].lower() for line in lines}
    found = set()
    for file in (folder / package).rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                found.add(node.module.partition(".")[0])
    outside = found - set(sys.stdlib_module_names) - FROM_ROS - {"drill_twin", package}
    assert {DISTRIBUTIONS.get(name, name) for name in outside} - declared == set()
    for name in FROM_ROS & found:
        assert f"<exec_depend>{name}</exec_depend>" in (folder / "package.xml").read_text("utf-8")


@of_each_package
def test_the_manifest_names_every_package_of_messages(package):
    """Also a package that is used where it is installed, and a package of the types of the topics."""
    folder = FOLDERS[package]
    imported = re.compile(r'(?:^from |import_module\(")(\w+)\.(?:msg|srv)\b', re.MULTILINE)
    texts = [file.read_text("utf-8") for file in (folder / package).rglob("*.py")]
    used = {name for text in texts for name in imported.findall(text)}
    if package == "drill_twin":
        used |= {topic.type_name.split("/")[0] for topic in TOPICS.values()}
    assert used <= set(re.findall(r"<exec_depend>(\w+)<", (folder / "package.xml").read_text("utf-8")))


def test_versions_are_pinned(setup_arguments):
    pins = dict(line.split("==") for line in (ROOT / "constraints.txt").read_text("utf-8").splitlines() if "==" in line)
    names = {name.lower() for name in pins}
    extras = setup_arguments["extras_require"]
    for line in [*setup_arguments["install_requires"], *extras["test"], *extras["docs"]]:
        assert re.split(r"[<>=!~ ]", line)[0].lower() in names, line
    assert {line.partition(" ")[0] for line in extras["ros"]} <= {f"{name}=={pin}" for name, pin in pins.items()}


@of_each_package
def test_each_bound_names_a_version_that_can_be_tested(package):
    """`.ci/bounds lowest` installs it."""
    for line in _setup_arguments(FOLDERS[package])["install_requires"]:
        assert line.startswith("drill_twin==") or re.fullmatch(r"[a-z0-9]+>=[0-9.]+(,<[0-9.]+)?", line)


NEWER_THAN_NUMPY_1_26 = {
    "acos", "asin", "astype", "bitwise_count", "concat", "cumulative_prod", "cumulative_sum", "isdtype",
    "matrix_transpose", "matvec", "permute_dims", "trapezoid", "unique_counts", "unique_values", "unstack", "vecdot",
    "vecmat",
}  # fmt: skip
SEEDED_BY_SCIPY = {"Halton", "LatinHypercube", "Sobol", "bootstrap", "differential_evolution", "permutation_test"}


@pytest.mark.parametrize("room", ["drill_twin", "evidence", "test"])
def test_no_call_asks_for_more_than_the_lowest_numpy_and_scipy(room):
    """Where no test of `.ci/bounds` comes by; `rng` of scipy's functions is newer than 1.11, which knows `seed`."""
    for file in (ROOT / room).rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "np":
                assert node.attr not in NEWER_THAN_NUMPY_1_26, f"{file}:{node.lineno}: np.{node.attr}"
            elif isinstance(node, ast.Call):
                name = getattr(node.func, "attr", getattr(node.func, "id", ""))
                given = {keyword.arg for keyword in node.keywords}
                assert name not in SEEDED_BY_SCIPY or "rng" not in given, f"{file}:{node.lineno}: {name}(rng=...)"


def test_a_ros_workspace_gets_what_has_no_key_in_rosdep(setup_arguments):
    page, manifest = ((ROOT / name).read_text("utf-8") for name in ("docs/install.md", "package.xml"))
    (line,) = re.findall(r"^\$ \.venv/bin/pip install (.*)$", page, re.MULTILINE)
    keys = {"pyyaml": "python3-yaml"}
    of_companions = (line for folder in FOLDERS.values() for line in _setup_arguments(folder)["install_requires"])
    needed = {
        line
        for line in of_companions
        if not line.startswith("drill_twin==")
        and f">{keys.get(name := line.partition('>')[0], f'python3-{name}')}<" not in manifest
    }
    assert set(re.findall(r'"([^"]+)"', line)) == {"numpy<2", *needed}


@pytest.mark.parametrize("node", sorted(NODES))
def test_a_parameter_file_holds_every_parameter_with_its_default_and_a_comment(node):
    text = config_file(f"nodes/{node}.yaml").read_text("utf-8")
    values = yaml.safe_load(text)["/**"]["ros__parameters"]
    defaults = ((parameter.name, parameter.default) for parameter in NODES[node].PARAMETERS)
    assert values == {name: list(value) if isinstance(value, tuple) else value for name, value in defaults}
    for parameter in NODES[node].PARAMETERS:
        comment = re.search(rf"((?:^ +#.*\n)+) +{parameter.name}:", text, re.MULTILINE)
        assert comment, f"{parameter.name} has no comment"
        assert len(comment[1]) > 30
        if parameter.unit and not isinstance(parameter.default, str):
            assert f"[{parameter.unit}]" in comment[1]


@pytest.mark.parametrize("node", sorted(NODES))
def test_a_parameter_file_is_what_the_table_of_the_node_prints(node):
    """To make it anew: drill-twin ros node NODE --parameters > config/nodes/NODE.yaml."""
    make = NODES[node]
    assert config_file(f"nodes/{node}.yaml").read_text("utf-8") == file_text(node, make.PURPOSE, make.PARAMETERS)


def test_the_parameter_file_of_the_twin_holds_defaults_of_its_nodes():
    values = yaml.safe_load((ROOT / "config" / "nodes" / "twin.yaml").read_text("utf-8"))["/**"]["ros__parameters"]
    nodes = (composed_twin, *(NODES[name] for name in ("simulator", "rig_driver", "analyzer", "recorder")))
    known = {parameter.name: parameter.default for make in nodes for parameter in make.PARAMETERS}
    # A parameter given to the process reaches every node that has it, so one name must have one default.
    assert all(known[parameter.name] == parameter.default for make in nodes for parameter in make.PARAMETERS)
    assert values.items() <= known.items()
    assert {parameter.name for parameter in composed_twin.PARAMETERS} <= values.keys()
    all_known = [p for make in (*nodes, *(NODES[name] for name in ("advisor", "estimator", "gateway")))
                 for p in make.PARAMETERS]  # fmt: skip
    assert len({(p.name, p.default) for p in all_known}) == len({p.name for p in all_known})


@pytest.mark.parametrize(("name", "table"), [("twin", entry_points.TWIN), ("replay", entry_points.REPLAY)])
def test_a_launch_starts_executables_with_parameters_that_exist(name, table):
    """`launch` is not among the wheels, so the file is read here; `test_launch.py` runs it where there is one."""
    parts = list(ast.walk(ast.parse((ROOT / f"config/launch/{name}.launch.py").read_text("utf-8"))))
    calls = [part for part in parts if isinstance(part, ast.Call)]
    makers = {"argument", "DeclareLaunchArgument"}
    declared = {call.args[0].value for call in calls if getattr(call.func, "id", "") in makers}
    keys = [part.slice for part in parts if isinstance(part, ast.Subscript)]
    used = {key.value for key in keys if isinstance(key, ast.Constant)}
    assert table.keys() <= set(entry_points.executables())
    for node, row in table.items():
        parameters = {parameter.name for parameter in NODES[node].PARAMETERS} if row.has_parameters else set()
        assert {*row.takes.split(), *entry_points.waits(node, table)} <= parameters
        assert row.package == "drill_twin" or FOLDERS[row.package]
    flags = {row.flag for row in table.values() if row.flag}
    takes = {argument for row in table.values() for argument in row.takes.split()}
    assert takes <= declared <= takes | used
    assert len(flags) + len(declared) == len(flags | declared)


def test_a_launch_needs_no_package_to_read_the_table_of_nodes():
    """`ros2 launch` runs with the Python of ROS, the nodes with the Python of their environment."""
    words = "import sys; import drill_twin.ros.entry_points; print(*sys.modules)"
    found = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, timeout=60, check=True)
    plain = subprocess.run(
        [sys.executable, "-c", "import sys; print(*sys.modules)"],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    loaded = {name.partition(".")[0] for name in set(found.stdout.split()) - set(plain.stdout.split())}
    assert loaded <= {"drill_twin", *sys.stdlib_module_names}


def test_who_sends_first_waits_for_the_running_nodes_that_must_miss_no_message():
    assert entry_points.waits("rig_driver", {"recorder", "advisor", "simulator"}) == {
        "wait_for": ("simulator", "recorder")
    }
    assert entry_points.waits("replayer", {"replayer", "analyzer"}) == {"wait_for": ("analyzer",)}
    assert entry_points.waits("analyzer", {"simulator"}) == {}


def test_the_installed_scenes_are_all_there():
    assert {"pa6_bench", "bha_full_size", "ufrj_rig"} <= set(presets())


def test_the_changelog_is_one_for_ros():
    lines = (ROOT / "CHANGELOG.rst").read_text("utf-8").splitlines()
    assert lines[1] == "Changelog for package drill_twin"
    releases = [line for line in lines if re.fullmatch(r"\d+\.\d+\.\d+ \(\d{4}-\d{2}-\d{2}\)", line)]
    version, _, date = releases[0].partition(" ")
    assert version == drill_twin.__version__
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert (citation["version"], f"({citation['date-released']})") == (version, date)
