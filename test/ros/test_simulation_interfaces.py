# SPDX-License-Identifier: Apache-2.0
"""The common services of simulators: what they answer (the package itself is not in the wheels)."""

from types import SimpleNamespace

import pytest

from drill_twin.core.errors import DrillTwinError
from drill_twin.ros.simulator import run_control as common
from drill_twin.ros.simulator.run_control import Answers


class Run:
    """A run as the services hold it in hand."""

    def __init__(self):
        self.paused, self.frames, self.over, self.refuses = False, 0, False, ""
        self.told = None

    @property
    def state(self):
        if not self.paused:
            return common.PLAYING
        return common.PAUSED if self.frames else common.STOPPED

    def pause(self):
        self.paused = True

    def resume(self):
        self.paused = False

    def reset(self):
        self.frames = 0

    def take_frames(self, count, told):
        if self.refuses:
            raise DrillTwinError(self.refuses)
        self.frames += count
        self.told = told

    def quit(self):
        self.over = True


@pytest.fixture
def run():
    return Run()


@pytest.fixture
def ask(run):
    def asked(service, **given):
        response = SimpleNamespace(
            result=SimpleNamespace(), state=SimpleNamespace(), features=SimpleNamespace(features=[], custom_info="")
        )
        return getattr(Answers(run), service)(SimpleNamespace(**given), response)

    return asked


def _state(number):
    return SimpleNamespace(state=number)


def test_a_run_is_paused_stepped_played_and_stopped(ask, run):
    assert ask("get_simulation_state").state.state == common.PLAYING
    assert ask("step_simulation", steps=3).result.result == common.INCORRECT_STATE
    assert ask("set_simulation_state", state=_state(common.PAUSED)).result.result == common.OK
    later, sent = ask("step_simulation", steps=3), []
    later.send = sent.append
    run.told(True, "3 frames on")
    assert [response.result.result for response in sent] == [common.OK]
    ask("step_simulation", steps=0).send = sent.append
    run.told(False, "expected 3 frames, took 1")
    assert (sent[1].result.result, sent[1].result.error_message) == (common.FAILED, "expected 3 frames, took 1")
    assert (run.frames, ask("get_simulation_state").state.state) == (3, common.PAUSED)
    assert ask("set_simulation_state", state=_state(common.PAUSED)).result.result == common.ALREADY
    assert ask("set_simulation_state", state=_state(common.STOPPED)).result.result == common.OK
    assert (run.frames, ask("get_simulation_state").state.state) == (0, common.STOPPED)
    assert ask("set_simulation_state", state=_state(common.PLAYING)).result.result == common.OK
    assert not run.paused


def test_what_cannot_be_done_is_said(ask, run):
    run.paused, run.refuses = True, "expected the pace realtime"
    answer = ask("step_simulation", steps=1).result
    assert (answer.result, answer.error_message) == (common.FAILED, "expected the pace realtime")
    assert ask("set_simulation_state", state=_state(9)).result.result == common.UNSUPPORTED
    assert ask("reset_simulation", scope=1).result.result == common.UNSUPPORTED  # time alone


def test_reset_and_quit(ask, run):
    run.frames = 5
    assert ask("reset_simulation", scope=255).result.result == common.OK
    assert run.frames == 0
    assert ask("reset_simulation").result.result == common.OK  # a version without scopes
    ask("set_simulation_state", state=_state(common.QUITTING))
    assert run.over
    assert len(ask("get_simulator_features").features.features) == 4
