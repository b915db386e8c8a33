# SPDX-License-Identifier: Apache-2.0
"""The package drill_twin_dashboard: the live page of a running twin or of a bag, in a browser."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "drill_twin_dashboard"
VERSION = "0.1.0"
SHARE = f"share/{PACKAGE}"

setup(
    name=PACKAGE,
    version=VERSION,
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "live/page/*", "front/page/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (SHARE, ["package.xml"]),
        *(
            (f"{SHARE}/{folder.name}", sorted(map(str, folder.glob("*.*"))))
            for folder in sorted(Path("config").glob("*"))
        ),
    ],
    python_requires=">=3.11",
    install_requires=[f"drill_twin=={VERSION}", "websockets>=14"],
    zip_safe=False,
    author="The drill_twin contributors",
    maintainer="The drill_twin contributors",
    description="the live page of a running twin or of a bag, in a browser",
    license="Apache-2.0",
    entry_points={
        "drill_twin.commands": ["watch = drill_twin_dashboard.cli.watch:watch"],
        "drill_twin.exports": ["rerun = drill_twin_dashboard.cli.rerun_file:recording"],
        "drill_twin.nodes": ["watch = drill_twin_dashboard.ros.live_page:run"],
    },
)
