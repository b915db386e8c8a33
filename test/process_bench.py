# SPDX-License-Identifier: Apache-2.0
"""Real nodes as real processes, each test in a DDS domain of its own, and a node of the test to talk to them."""

from __future__ import annotations

import itertools
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest

rclpy = pytest.importorskip("rclpy", reason="needs rclpy: run `make test`, or source a ROS 2 Jazzy")

from rcl_interfaces.msg import SetParametersResult  # noqa: E402
from rcl_interfaces.srv import SetParameters  # noqa: E402
from rclpy.context import Context  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.node import Node  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy  # noqa: E402
from rclpy.signals import SignalHandlerOptions  # noqa: E402
from rclpy.subscription import Subscription  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402
from warm_start import Warmed, WarmPopen  # noqa: E402

from drill_twin.dynamics.twin.twin import Twin  # noqa: E402
from drill_twin.io.bag.reader import Bag  # noqa: E402
from drill_twin.io.messages.decode import JointStateReader  # noqa: E402
from drill_twin.io.messages.diagnostics import Status, decode_diagnostics  # noqa: E402
from drill_twin.io.messages.topics import DIAGNOSTICS, TOPICS, TWIN_SUMMARY  # noqa: E402
from drill_twin.ros import deployment as discovery  # noqa: E402
from drill_twin.ros.core.startup_barrier import missing_readers  # noqa: E402
from drill_twin.ros.core.topics import message_class  # noqa: E402
from drill_twin.scene import load_scene  # noqa: E402
from drill_twin.scene.set_points import Command  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]


def config_file(name: str) -> Path:
    """File below `config/`, of the core or of a companion, such as `nodes/gateway.yaml`."""
    (found,) = [
        folder / name for folder in (ROOT / "config", *ROOT.glob("companions/*/config")) if (folder / name).exists()
    ]
    return found


WORKER = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0")[2:])
WORKERS = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
# Each bench another domain, and each worker its share: nodes of a bench that has ended stay in the graph for a while.
_SHARE = discovery.HIGHEST_DOMAIN // WORKERS
_DOMAINS = (os.getppid() + _SHARE * WORKER + number % _SHARE for number in itertools.count())
LONG = 180.0  # s; longest wait for anything: a kernel may have to be compiled, a busy machine may stall a process


_NODE, _COMMAND = ([sys.executable, "-m", module] for module in ("drill_twin.ros", "drill_twin.cli"))
WARMED = Warmed()


class Process:
    """A node, or another command, as a process with a log; both may be forked with their imports done."""

    def __init__(self, command: list[str], environment: dict[str, str], log: Path, *, warm: bool) -> None:
        self.log = log
        self._popen: subprocess.Popen[bytes] | WarmPopen
        with log.open("wb") as stream:
            if warm and command[:3] in (_NODE, _COMMAND) and WARMED.fits(environment):
                self._popen = WARMED.start(command[2:], environment, log)
            else:
                self._popen = subprocess.Popen(
                    command, env=environment, cwd=log.parent, stdin=subprocess.DEVNULL, stdout=stream, stderr=stream
                )
        self.pid = self._popen.pid

    @property
    def code(self) -> int | None:
        return self._popen.poll()

    @property
    def text(self) -> str:
        return self.log.read_text("utf-8", "replace")

    def send(self, number: int) -> None:
        self._popen.send_signal(number)

    def wait(self, seconds: float = LONG) -> int:
        try:
            return self._popen.wait(seconds)
        except subprocess.TimeoutExpired:
            pytest.fail(f"{self.log.stem} still runs after {seconds} s:\n{self.text}")

    def end(self, number: int = signal.SIGINT) -> int:
        if self.code is None:
            self.send(number)
        return self.wait()

    @property
    def memory(self) -> int:
        """Resident memory [bytes]."""
        return int(Path(f"/proc/{self.pid}/statm").read_text("utf-8").split()[1]) * resource.getpagesize()

    @property
    def loop_time(self) -> float:
        """Processor time of the main thread, which runs the loop of a node [s]."""
        fields = Path(f"/proc/{self.pid}/task/{self.pid}/stat").read_text("utf-8").rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    @property
    def files(self) -> int:
        """Open file handles."""
        return sum(1 for _ in Path(f"/proc/{self.pid}/fd").iterdir())

    def kill(self) -> None:
        if self.code is None:
            self._popen.kill()
        self._popen.wait()


@cache
def compile_scene(name: str) -> None:
    """Compile the kernel of a scene, so that no test waits for a node while it does: minutes on a busy machine."""
    scene = load_scene(name)
    Twin(scene).advance(Command(scene.rig.weight_on_bit.initial, 0.0), 0.01)


class Bench:
    """One domain: processes in it, and a node of the test."""

    def __init__(self, folder: Path) -> None:
        compile_scene("pa6_bench")
        self.folder = folder
        self._claim = discovery.DomainClaim(start=next(_DOMAINS))
        self.domain = self._claim.domain
        discovery.prepare()
        self.environment = dict(
            os.environ,
            ROS_DOMAIN_ID=str(self.domain),
            ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST",
            ROS_LOG_DIR=str(folder / "ros_log"),
            ROS_PYTHON_CHECK_FIELDS="1",
            PYTHONPATH=os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]),
            PYTHONUNBUFFERED="1",
        )
        WARMED.prepare(self.environment)
        self._context = Context()
        rclpy.init(
            args=[], context=self._context, domain_id=self.domain, signal_handler_options=SignalHandlerOptions.NO
        )
        self.node = Node("test", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._processes: list[Process] = []
        self.statuses: dict[str, Status] = {}
        self.history: list[Status] = []
        self._subscriptions: list[Subscription] = []
        self._taken = 0
        self.warm = True
        """Nodes and commands are forked with their imports done; False: each begins with the start of Python."""
        self.asked_ready = 0.0
        self.node.create_service(Trigger, "~/ready", self._answer_ready)
        self.subscribe(DIAGNOSTICS, self._on_diagnostics)

    def start(self, node: str, *arguments: str, **parameters: object) -> Process:
        """A node with parameters; text is quoted."""
        words = [
            f"{name}:={value!r}" if isinstance(value, str) else f"{name}:={value}" for name, value in parameters.items()
        ]
        words = [word.replace("True", "true").replace("False", "false") for word in words]
        given = [part for word in words for part in ("-p", word)]
        return self.command(node, [*_NODE, node, "--ros-args", *given, *arguments])

    def start_with(self, words: list[str], node: str) -> Process:
        """A node with arguments that are not of ROS."""
        return self.command(node, [*_NODE, node, *words])

    def command(self, name: str, command: list[str], **environment: str) -> Process:
        log = self.folder / f"{name}_{len(self._processes)}.log"
        process = Process(command, {**self.environment, **environment}, log, warm=self.warm)
        self._processes.append(process)
        return process

    def subscribe(self, topic: str, received: Callable[[bytes], None], *, latched: bool = False) -> None:
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        quality = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE, durability=durability)

        def callback(raw: bytes) -> None:
            self._taken += 1
            received(raw)

        kind = message_class(TOPICS[topic])
        self._subscriptions.append(self.node.create_subscription(kind, topic, callback, quality, raw=True))

    def collect(self, topic: str, *, latched: bool = False) -> list[bytes]:
        """All messages of a topic from now on."""
        raws: list[bytes] = []
        self.subscribe(topic, raws.append, latched=latched)
        return raws

    def publisher(self, topic: str):
        """A publisher that is matched with at least one reader before it is returned."""
        publisher = self.node.create_publisher(message_class(TOPICS[topic]), topic, 10)
        self.until(lambda: publisher.get_subscription_count() > 0, what=f"a reader of {topic}")
        return publisher

    def drain(self) -> None:
        """Take all that has arrived; who published it has waited until it had, and publishes no more."""
        quiet, end = 0, time.monotonic() + LONG
        while quiet < 3:
            assert time.monotonic() < end, "expected the topics to fall silent"
            before = self._taken
            self._executor.spin_once(timeout_sec=0.05)
            quiet = 0 if self._taken > before else quiet + 1

    def _take_waiting(self) -> None:
        """Take what came while the test did not listen, which is of before."""
        quiet, end = 0, time.monotonic() + 1.0
        while quiet < 5 and time.monotonic() < end:
            taken = self._taken
            self._executor.spin_once(timeout_sec=0.0)
            quiet = 0 if self._taken > taken else quiet + 1

    def spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)

    def until(self, happened: Callable[[], bool], seconds: float = LONG, what: str = "") -> None:
        end = time.monotonic() + seconds
        while not happened():
            assert time.monotonic() < end, f"waited {seconds} s for {what or happened}:\n{self.logs()}"
            self._executor.spin_once(timeout_sec=0.02)

    def until_ready(self, *nodes: str) -> None:
        """Until each node answers that it is ready; it is then connected to all that the test listens to."""
        for node in nodes:
            client = self.node.create_client(Trigger, f"/{node}/ready")
            self.until(lambda client=client: self._ready(client), what=f"{node} to be ready")
            self.node.destroy_client(client)

    def _ready(self, client) -> bool:
        if not client.service_is_ready():
            return False
        answer = client.call_async(Trigger.Request())
        end = time.monotonic() + 2.0
        while not answer.done() and time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)
        if not answer.done():
            client.remove_pending_request(answer)
            return False
        return answer.result().success and not missing_readers(self.node, answer.result().message)

    def call(self, service: str, request=None, kind=Trigger):
        """The answer of a service."""
        client = self.node.create_client(kind, service)
        self.until(client.service_is_ready, what=service)
        answer = client.call_async(kind.Request() if request is None else request)
        self.until(answer.done, what=f"the answer of {service}")
        self.node.destroy_client(client)
        return answer.result()

    def set_parameter(self, node: str, name: str, value: object) -> SetParametersResult:
        """Set a live parameter, as `ros2 param set` does."""
        request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        return self.call(f"/{node}/set_parameters", request, SetParameters).results[0]

    def until_status(self, node: str, wanted: Callable[[Status], bool], seconds: float = LONG) -> Status:
        """Wait until the diagnostics of a node fulfil a condition, from now on."""
        self._take_waiting()
        self.statuses.pop(node, None)
        try:
            self.until(lambda: node in self.statuses and wanted(self.statuses[node]), seconds, f"a status of {node}")
        except AssertionError as error:
            raise AssertionError(f"{error}\nthe last one was {self.statuses.get(node)}") from error
        return self.statuses[node]

    def simulated_time(self) -> float:
        """Simulated time in the simulator's next diagnostics [s]."""
        return float(self.until_status("simulator", bool).values["simulated_time"])

    def keeps_real_time(self, simulator: Process, seconds: float) -> None:
        """Check over some simulated seconds that a simulator holds real time, if it has a processor.

        A busy machine may give the loop less than it needs; it is at fault only where it had most of a processor.
        """
        first, spent, begun = self.simulated_time(), simulator.loop_time, time.monotonic()
        end = first + seconds
        last = self.until_status("simulator", lambda status: float(status.values["simulated_time"]) >= end, LONG)
        gone = float(last.values["simulated_time"]) - first
        taken = time.monotonic() - begun
        assert taken < 1.05 * gone or simulator.loop_time - spent < 0.9 * taken, last

    def _answer_ready(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """As a node of ours answers: `wait_for="simulator test"` holds a driver until the test misses nothing."""
        del request
        self.asked_ready = time.monotonic()
        late = [topic.topic_name for topic in self._subscriptions if not self._connected(topic)]
        response.success, response.message = not late, f"not yet connected to {', '.join(late)}" if late else ""
        return response

    def _connected(self, topic: Subscription) -> bool:
        return 0 < topic.get_publisher_count() >= self.node.count_publishers(topic.topic_name)

    def _on_diagnostics(self, raw: bytes) -> None:
        for status in decode_diagnostics(raw)[1]:
            self.statuses[status.name] = status
            self.history.append(status)

    def logs(self) -> str:
        return "\n".join(
            f"--- {process.log.name} (exit code {process.code})\n{process.text}" for process in self._processes
        )

    def close(self) -> None:
        for process in self._processes:
            process.kill()
        self.node.destroy_node()
        self._context.try_shutdown()
        self._claim.release()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path)
    yield bench
    bench.close()


@pytest.fixture
def make_bench(tmp_path: Path) -> Iterator[Callable[[], Bench]]:
    """More than one domain in a test."""
    benches: list[Bench] = []

    def make() -> Bench:
        folder = tmp_path / f"bench_{len(benches)}"
        folder.mkdir()
        benches.append(Bench(folder))
        return benches[-1]

    yield make
    for bench in benches:
        bench.close()


@pytest.fixture(scope="session")
def compiled() -> Callable[[str], None]:
    """Compile the kernel of another scene than the paper's."""
    return compile_scene


@pytest.fixture(scope="session")
def payloads() -> Callable[[Path, str], list[bytes]]:
    """The messages of a topic in a bag, filled up to four bytes as they are on the wire between two processes."""

    def read(bag: Path, topic: str) -> list[bytes]:
        raws = [raw + bytes(-len(raw) % 4) for _, _, raw in Bag(bag).messages((topic,))]
        # The last number of a summary is the real-time factor, which tells wall time.
        return [raw[:-16] + raw[-8:] for raw in raws] if topic == TWIN_SUMMARY else raws

    return read


@pytest.fixture
def joints() -> Callable[[list[bytes]], list]:
    """JointStates of raw messages."""

    def read(raws: list[bytes]) -> list:
        reader = JointStateReader()
        return [reader.read(bytes(raw)) for raw in raws]

    return read


@pytest.fixture(scope="session")
def small_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag of half a second, recorded from a real run over DDS in lockstep."""
    folder = tmp_path_factory.mktemp("small_bag")
    bench = Bench(folder)
    try:
        record_run(bench, folder / "bag_0", duration=0.5)
    finally:
        bench.close()
    return folder / "bag_0"


def record_run(bench: Bench, bag: Path, **parameters: object) -> None:
    """A whole run in lockstep, recorded; every node must end well."""
    simulator = bench.start("simulator", pace="lockstep", **parameters)
    analyzer = bench.start("analyzer")
    recorder = bench.start("recorder", bag=str(bag))
    driver = bench.start("rig_driver", wait_for="simulator analyzer recorder")
    bench.until(lambda: simulator.code is not None, LONG, "the run to end")
    assert simulator.code == 0, bench.logs()
    for process in (driver, analyzer, recorder):
        assert process.end() == 0, bench.logs()


@pytest.fixture(scope="module")
def module_bench() -> Iterator[Callable[[Path], Bench]]:
    """Benches that live as long as the tests of one file."""
    benches: list[Bench] = []

    def make(folder: Path) -> Bench:
        benches.append(Bench(folder))
        return benches[-1]

    yield make
    for bench in benches:
        bench.close()
