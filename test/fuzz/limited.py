# SPDX-License-Identifier: Apache-2.0
"""An attack in a child process with bounds on time and memory, so that one that succeeds does no harm."""

import json
import os
import resource
import signal
import traceback
from dataclasses import dataclass
from pathlib import Path

from drill_twin.core.errors import DrillTwinError

SECONDS, MEMORY = 10, 500  # of processor time, MB


@dataclass
class Outcome:
    """What an attack came to: refused in a sentence, or read; it took so much processor time [s] and memory [MB]."""

    refused: str
    failure: str
    seconds: float
    memory: float


def attack(function, *arguments):
    """Call a function in a fork of this process, where it may use at most a minute and 2 GB."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(reader)
            with os.fdopen(writer, "w") as stream:
                json.dump(_bounded(function, arguments), stream)
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as stream:
        said = stream.read()
    _, status = os.waitpid(child, 0)
    if not said:
        return Outcome("", f"ended by signal {os.WTERMSIG(status)}", float("inf"), float("inf"))
    return Outcome(**json.loads(said))


def harmless(function, *arguments):
    """The sentence of an attack that was refused, or an empty one; checks that it did no harm."""
    outcome = attack(function, *arguments)
    assert not outcome.failure, outcome.failure
    assert outcome.seconds < SECONDS, outcome
    assert outcome.memory < MEMORY, outcome
    assert "\n" not in outcome.refused
    assert len(outcome.refused) < 2000, outcome.refused
    assert outcome.refused.isprintable(), outcome.refused
    return outcome.refused


def _bounded(function, arguments):
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + (2 << 30), size + (2 << 30)))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.alarm(120)
    refused = failure = ""
    before, begun = resource.getrusage(resource.RUSAGE_SELF), _processor_time()
    try:
        function(*arguments)
    except DrillTwinError as error:
        refused = str(error)
    except BaseException:  # noqa: BLE001 - whatever it is, it must not reach a user
        failure = traceback.format_exc()[-3000:]
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before.ru_maxrss
    return {"refused": refused, "failure": failure, "seconds": _processor_time() - begun, "memory": grown / 1024}


def _processor_time():
    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime
