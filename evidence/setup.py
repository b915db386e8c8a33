# SPDX-License-Identifier: Apache-2.0
"""The drill_twin_evidence package: what shows that drill_twin is right, and its commands."""

from setuptools import find_packages, setup

PACKAGE = "drill_twin_evidence"
COMMANDS = {
    "analyzer-score": "analyzer_score:analyzer_score",
    "estimator-score": "estimator_score:estimator_score",
    "hard": "hard:hard",
    "paper": "paper:paper",
    "validate": "validate:validate",
    "verify": "verify:verify",
    "whirl-compare": "whirl_compare:whirl_compare",
}

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["config/*/*", "benchmarks/scenes/*"]},
    python_requires=">=3.11",
    install_requires=["drill_twin"],  # with what it needs itself; the evidence needs nothing beside
    extras_require={
        "bench": [
            "exudyn>=1.13.6",
            "mujoco>=4.0",
            "pylife>=2.2",
            "pyelastica>=1.0",
            "pytest",
            "pytest-benchmark>=5",
            "ross-rotordynamics>=2.3",  # imports with plotly<7
            "torque_drag>=0.1.1",
            "welleng>=0.30",
        ],
    },
    zip_safe=False,
    author="The drill_twin contributors",
    maintainer="The drill_twin contributors",
    description="Evidence that drill_twin is right: exact checks, records of rigs, stress, scores, benchmarks",
    license="Apache-2.0",
    entry_points={
        "drill_twin.commands": [
            *(f"{name} = {PACKAGE}.cli.{function}" for name, function in COMMANDS.items()),
            f"ros load = {PACKAGE}.benchmarks.cpu_load:load",
        ],
        "drill_twin.scenes": [f"hard = {PACKAGE}:HARD"],
    },
)
