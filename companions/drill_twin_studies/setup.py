# SPDX-License-Identifier: Apache-2.0
"""The package drill_twin_studies: operating maps with their advice, fits of numbers, and the estimator."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "drill_twin_studies"
VERSION = "0.1.0"
SHARE = f"share/{PACKAGE}"

setup(
    name=PACKAGE,
    version=VERSION,
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "maps/page.*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (SHARE, ["package.xml"]),
        *(
            (f"{SHARE}/{folder.name}", sorted(map(str, folder.glob("*.*"))))
            for folder in sorted(Path("config").glob("*"))
        ),
    ],
    python_requires=">=3.11",
    install_requires=[f"drill_twin=={VERSION}", "contourpy>=1.0.7"],
    extras_require={"dask": ["distributed>=2024.5"]},
    zip_safe=False,
    author="The drill_twin contributors",
    maintainer="The drill_twin contributors",
    description="operating maps with their advice, fits of numbers, and the estimator",
    license="Apache-2.0",
    entry_points={
        "drill_twin.commands": [
            "estimate = drill_twin_studies.cli.estimate:estimate",
            "fit = drill_twin_studies.cli.fit:fit",
            "map = drill_twin_studies.cli.operating_map:operating_map",
        ],
        "drill_twin.nodes": [
            "advisor = drill_twin_studies.ros.advisor.node:Advisor",
            "estimator = drill_twin_studies.ros.estimator.node:Estimator",
        ],
    },
)
