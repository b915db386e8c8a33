"""Hard scenes: steady whirls, or a sentence why there are none."""

import numpy as np
import pytest

from drill_twin.api.rotordynamics import final_command, steady_scene
from drill_twin.core.errors import SceneError
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.whirl_states import check_whirls, whirl_states
from drill_twin_evidence.stress import all_hard_cases
from drill_twin_evidence.stress.case import LATERAL

SENTENCES = {
    "level_hole": "in which no steady whirl exists",
    "start_on_the_opposite_wall": "in which no steady whirl exists",
    "near_critical": "expected a rotation other than 0",
    "start_at_rest": "expected a rotation other than 0",
    "random_force": "--without random_force leaves it out",
    "stick_slip": "nothing limits a whirl",
    "bit_bounce": "expected set-points with a final value",
    "commands_jump": "expected set-points with a final value",
    "weight_jumps": "expected set-points with a final value",
    "elements_2000": "take fewer elements",
    "steel_8000_m": "take fewer elements",
}
SEARCHED = ("load_300_n", "speed_20")
EVALUATIONS = 1000


@pytest.mark.long
def test_hard_scenes_have_whirls_or_a_sentence():
    """Searches are cut short; the other scenes are only checked for what forbids a whirl."""
    for case in all_hard_cases():
        sentence = SENTENCES.get(case.scene_name.removeprefix("hard/"))
        if sentence is not None:
            with pytest.raises(SceneError, match=sentence):
                whirls(case.scene())
            continue
        is_sought = case.form == LATERAL and case.scene_name.removeprefix("hard/") in SEARCHED
        equations, states = whirls(case.scene(), is_sought=is_sought)
        for state in states:
            assert np.isfinite(state.growth), case.name
            residual = equations.evaluate(state.whirl.command, *state.whirl.motion).residual
            force = equations.evaluate(state.whirl.command, *state.whirl.motion).stiffness
            assert np.abs(residual).max() < 1e-6 * np.abs(force).max() * equations.scene.least_clearance, case.name


def whirls(scene, *, is_sought=True):
    own = steady_scene(scene, None, ())
    equations, command = EquationsOfMotion(own), final_command(own)
    check_whirls(equations, command)
    found = whirl_states(equations, command, random_starts=0, evaluations=EVALUATIONS) if is_sought else ()
    return equations, found
