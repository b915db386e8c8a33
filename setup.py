# SPDX-License-Identifier: Apache-2.0
"""The drill_twin package: an ament_python package for colcon, and an ordinary one for pip."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "drill_twin"
VERSION = "0.1.0"
COMPANIONS = ("drill_twin_rig", "drill_twin_dashboard", "drill_twin_studies")
SHARE = f"share/{PACKAGE}"


def config_files() -> list[tuple[str, list[str]]]:
    """Every folder of config/, installed under share/drill_twin with its own name."""
    folders = sorted(path for path in Path("config").iterdir() if path.is_dir())
    return [(f"{SHARE}/{folder.name}", sorted(str(file) for file in folder.glob("*.*"))) for folder in folders]


setup(
    name=PACKAGE,
    version=VERSION,
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "api/__init__.pyi", "report/assets/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (SHARE, ["package.xml"]),
        # Found by `ros2 run` and `ros2 launch`; on no PATH, since their names are those of other programs too.
        (f"lib/{PACKAGE}", sorted(map(str, Path("resource/executables").iterdir()))),
        (f"{SHARE}/bin", ["resource/bin/drill-twin"]),
        (f"{SHARE}/hook", ["resource/hook/drill_twin_path.dsv"]),  # named in colcon.pkg
        *config_files(),
    ],
    python_requires=">=3.11",
    # Tested at both ends by `make bounds`: the lowest versions named here, and the newest that pip finds.
    install_requires=[
        "lz4>=4.0.2",
        "matplotlib>=3.10.8",  # 3.6 lacks legends outside and titles that are read; up to 3.10.0, pyparsing 3.3 warns
        "mcap>=1.6,<1.7",  # io/bag/file_writer.py uses private names of its Writer
        "numba>=0.63.1,<0.69",  # core/compile uses private names of it: evidence/docs/private_compiler.md
        "numpy>=1.26.4,<2.6",  # 1.26: what Ubuntu 24.04 gives ROS Jazzy; 2.6: what numba does not take yet
        "pint>=0.24.4",
        "plotly>=5.20",
        "pydantic>=2.12",  # 2.7 to 2.11 take a scene without a name
        "pyyaml>=6.0.1",
        "rich>=14.3",  # older ones end progress that is not shown with an empty line
        "rosbags>=0.11.6",  # 0.11.0 to 0.11.5 refuse messages that Fast DDS pads at the end
        "scipy>=1.11.4",  # what Ubuntu 24.04 has
        "typer>=0.29",  # has a click of its own; older ones word errors otherwise (`make bounds`)
        "zstandard>=0.22",
    ],
    extras_require={
        "all": [f"{name}=={VERSION}" for name in COMPANIONS],
        "docs": ["furo", "myst-parser", "sphinx", "typos"],
        "test": [
            "arviz-base>=0.6",
            "asyncua>=1.1.8",
            "colcon-common-extensions",
            "distributed>=2024.5",
            "filterpy>=2",
            "hypothesis",
            "import-linter",
            "jsonschema",
            "lasio>=0.31",
            "mcap-ros2-support",
            "mypy",
            "pytest",
            "pytest-rerunfailures",
            "pytest-timeout",
            "pytest-xdist",
            "ruff",
            "types-PyYAML",
            "xarray",
        ],
        "arviz": [f"drill_twin_studies=={VERSION}", "arviz-base>=0.6"],  # up to Python 3.11 the last is 0.8
        "dask": ["distributed>=2024.5"],
        "foxglove": [f"drill_twin_dashboard=={VERSION}"],
        "las": ["lasio>=0.31"],
        # rclpy, Fast DDS and the messages of Jazzy as wheels (glibc 2.28 or newer), for a machine without it.
        "ros": [
            f"{name} ; sys_platform == 'linux' and platform_machine == 'x86_64'"
            for name in (
                "ros-jazzy-rclpy==7.1.6",
                "ros-jazzy-rmw-fastrtps-cpp==8.4.3",
                "ros-jazzy-common-interfaces==5.3.6",
            )
        ],
        "opcua": [f"drill_twin_rig=={VERSION}"],
        # A wheel of 170 MB, 0.5 GB on the disk, which needs numpy 2; so it is not among the packages of the tests.
        "rerun": [f"drill_twin_dashboard=={VERSION}", "rerun-sdk>=0.28"],  # older ones cannot say where the eye is
        "xarray": ["pandas>=2.2", "xarray"],
    },
    zip_safe=False,
    author="The drill_twin contributors",
    maintainer="The drill_twin contributors",
    description="A digital twin of a flexible drillstring as a ROS 2 node set",
    long_description=Path("README.md").read_text(encoding="utf-8") if Path("README.md").exists() else "",
    long_description_content_type="text/markdown",
    license="Apache-2.0",
    keywords=["drilling", "drillstring", "whirl", "stick-slip", "digital twin", "ROS 2"],
    classifiers=[
        "Development Status :: 4 - Beta",
        "Environment :: Console",
        "Intended Audience :: Science/Research",
        "Operating System :: POSIX :: Linux",
        "Programming Language :: Python :: 3.11",
        "Programming Language :: Python :: 3.12",
        "Topic :: Scientific/Engineering :: Physics",
        "Typing :: Typed",
    ],
    entry_points={
        "console_scripts": [f"drill-twin = {PACKAGE}.cli:main"],
    },
)
