# SPDX-License-Identifier: Apache-2.0
"""Start of a simulator: its scene with compiled kernels, no second simulator, and the places of its checkpoints."""

import time
from pathlib import Path
from types import SimpleNamespace

from drill_twin.core.errors import CheckpointError, DrillTwinError, RunError
from drill_twin.core.files.output import writing
from drill_twin.io.messages.topics import STRING_POSES
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.pacing import Tick
from drill_twin.ros.core.scene_parameters import resolved, scene_of
from drill_twin.ros.core.topics import relative
from drill_twin.scene import Scene
from drill_twin.scene.blocks.numerics import frame_period

_LEASE = 6.0  # s; a killed node has left the graph by then
_DISCOVERY = 1.0  # s; a living node has been found by then
_LOG_PERIOD = 5.0  # s between two lines about a compilation


class CheckpointPlaces:
    """Folders that the operator named when the node started: checkpoints are written in no other.

    Anyone in the graph can set the parameters that name a file.
    """

    def __init__(self, settings: SimpleNamespace) -> None:
        """Take the folders of `checkpoint` and `saved_checkpoint`, and make a folder that is missing.

        Raises:
            CheckpointError: A parameter is no path of a file, or the folder of the file cannot be made.
        """
        given = [path for path in (settings.checkpoint, settings.saved_checkpoint) if path]
        self._folders = {Path(path).resolve().parent for path in given}
        for path in given:
            self.file(path)
            with writing(path, "the checkpoint", "choose another place", CheckpointError):
                Path(path).resolve().parent.mkdir(parents=True, exist_ok=True)

    def file(self, path: str) -> Path:
        """File of a path, where links lead to.

        Raises:
            CheckpointError: The path is in none of the folders, or is no path of a file.
        """
        target = Path(path).resolve()
        if not path.isprintable() or target.is_dir():
            found = "a folder" if path.isprintable() else "a name with control characters"
            raise CheckpointError(f"{path}: expected the path of a file for a checkpoint, found {found}")
        if target.parent not in self._folders:
            named = ", ".join(sorted(map(str, self._folders))) or "none; start the node with -p saved_checkpoint:=FILE"
            raise CheckpointError(
                f"{path}: expected a file in a folder that was named when the node started ({named}), found {target}"
            )
        return target


class StartUp:
    """Preparation of the first frame of a simulator.

    With autostart, services and diagnostics are served while kernels are compiled. Within a requested transition rclpy
    answers no other request; a signal ends the compilation in both cases.
    """

    def __init__(self, node: TwinNode) -> None:
        self._node = node
        self._created = time.monotonic()
        self._log_due, self._diagnostics_due = Tick(_LOG_PERIOD), Tick(1.0)
        self.progress = ""
        """Progress of the compilation, while it goes on."""

    def compiled_scene(self) -> Scene:
        """Scene of the parameters; its kernels are in the cache afterwards.

        Raises:
            SceneError: The scene cannot be loaded.
            RunError: The stop was requested meanwhile.
        """
        from drill_twin.runs import compile_kernel  # it takes long, and a bad parameter should be refused before

        settings = self._node.settings
        scene = resolved(scene_of(settings), settings.duration, self._node.get_logger().info)
        rate = settings.frame_rate or scene.numerics.frame_rate
        try:
            compile_kernel(scene, frame_period(rate), self._report)
        finally:
            self.progress = ""
            self._node.withdraw_ready()  # created again last, as the start-up barrier requires
        return scene

    def _report(self, progress: str) -> None:
        self.progress = progress
        if self._log_due.due():
            self._node.get_logger().info(progress)
        if self._node.settings.autostart:
            self._node.offer_ready()
            self._node.spin_all()
        elif self._node.stop:
            raise RunError(f"stopped while {progress}")
        elif self._diagnostics_due.due():
            self._node.publish_diagnostics()

    def refuse_second_simulator(self, *, own: int) -> None:
        """Refuse to start beside a simulator that publishes the same topics.

        Args:
            own: Publishers that are this node's.

        Raises:
            DrillTwinError: There is one.
        """
        node = self._node
        time.sleep(max(self._created + _DISCOVERY - time.monotonic(), 0.0))
        deadline = time.monotonic() + _LEASE
        while len(found := node.topics.publisher_nodes(STRING_POSES)) > own:
            if time.monotonic() > deadline:
                topic, domain = node.resolve_topic_name(relative(STRING_POSES)), node.context.get_domain_id()
                raise DrillTwinError(
                    f"expected to be the only simulator here, found publishers of {topic}: {', '.join(found)}, "
                    f"in ROS_DOMAIN_ID={domain}; stop it, or choose another domain or namespace"
                )
            time.sleep(0.1)
