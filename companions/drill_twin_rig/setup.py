# SPDX-License-Identifier: Apache-2.0
"""The package drill_twin_rig: rig software by OPC UA and WITS 0, and files of the Drillbotics competition."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "drill_twin_rig"
VERSION = "0.1.0"
SHARE = f"share/{PACKAGE}"

setup(
    name=PACKAGE,
    version=VERSION,
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "gateway/dwis.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (SHARE, ["package.xml"]),
        *(
            (f"{SHARE}/{folder.name}", sorted(map(str, folder.glob("*.*"))))
            for folder in sorted(Path("config").glob("*"))
        ),
    ],
    python_requires=">=3.11",
    install_requires=[f"drill_twin=={VERSION}", "asyncua>=1.1.8", "cryptography>=42.0.1"],
    extras_require={"las": ["lasio>=0.31"]},
    zip_safe=False,
    author="The drill_twin contributors",
    maintainer="The drill_twin contributors",
    description="rig software by OPC UA and WITS 0, and files of the Drillbotics competition",
    license="Apache-2.0",
    entry_points={
        "drill_twin.commands": ["ros keys = drill_twin_rig.cli.keys:keys"],
        "drill_twin.exports": ["drillbotics = drill_twin_rig.cli.drillbotics:competition"],
        "drill_twin.nodes": ["gateway = drill_twin_rig.ros.node:Gateway"],
    },
)
