# SPDX-License-Identifier: Apache-2.0
"""Refined whirl states beside equations that are not ours."""

import ast
import inspect

import pytest

from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.refinement import refined
from drill_twin.dynamics.rotordynamics.steady.whirl_states import whirl_states
from drill_twin_evidence.verify.contact import whirling_rod
from drill_twin_evidence.verify.contact.whirl_states import guided, reference


def test_the_growth_on_finer_meshes_is_that_of_code_that_is_not_ours():
    """The state of 20 N and 2 rev/s: on 16 elements it grows, by two contact points in an element; the rod decays."""
    scene, command = guided(16)
    (state,) = whirl_states(EquationsOfMotion(scene), command, random_starts=0)
    fine = refined(scene, state)
    for elements, points, growth in ((16, 2, state.growth), (64, 2, -1.265), (64, 8, fine.growth)):
        omega, values = reference(scene, state, elements, points)
        assert omega == pytest.approx(fine.whirl.omega, rel=3e-4)
        assert values[0].real == pytest.approx(growth, rel=0.03)


def test_the_reference_imports_nothing_of_ours():
    tree = ast.walk(ast.parse(inspect.getsource(whirling_rod)))
    named = [node.module for node in tree if isinstance(node, ast.ImportFrom)]
    assert not [name for name in named if name.startswith("drill_twin")]
