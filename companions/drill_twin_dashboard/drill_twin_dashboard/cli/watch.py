# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin watch`: page on a folder, live page of a running twin, or of a bag."""

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from drill_twin.cli.interrupt import stop_request
from drill_twin.cli.options import NamespaceOption, UnitsOption
from drill_twin.cli.show import remark, shown_progress
from drill_twin.core.errors import DrillTwinError


def watch(
    bag: Annotated[
        str | None,
        typer.Argument(
            metavar="[BAG]",
            help="Bag to play, or live: the running twin (needs ROS 2: rclpy). Without one, this folder; with "
            "--namespace, --limit, --units or --foxglove, the running twin.",
        ),
    ] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, metavar="PORT", help="Port of the page; 0: any free one.")
    ] = 8000,
    host: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS", help="Address on which the page is served. Commands need the link that is printed."
        ),
    ] = ("127.0.0.1"),
    allow_host: Annotated[
        list[str],
        typer.Option("--allow-host", metavar="NAME", help="Further name of this server for browsers; repeatable."),
    ] = [],  # noqa: B006  typer does not change the default
    limit: Annotated[
        list[str],
        typer.Option(
            "--limit",
            metavar="NAME=VALUE",
            help='Limit that raises an alarm, as "torque_high=12 kN m": _low or _high of wob, rps, bit_rps, torque, '
            "hookload or rop; repeatable. The page changes limits too.",
        ),
    ] = [],  # noqa: B006
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
    namespace: NamespaceOption = "",
    units: UnitsOption = "",
    foxglove: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=65535,
            metavar="PORT",
            help="Port at which Foxglove gets all topics of a running twin.",
        ),
    ] = None,
) -> None:
    """Open a page in the browser: on scenes and runs of this folder, on a running twin, or on a bag.

    The page on this folder makes scenes from survey and tally, and runs the other commands. A running twin is found by
    ROS_DOMAIN_ID; set-points go through the rig driver where there is one.
    """
    live = bag == "live" or (bag is None and bool(namespace or limit or units or foxglove is not None))
    if bag is not None and not live and foxglove is not None:
        raise DrillTwinError("expected --foxglove without a bag, found both; Foxglove opens the bag itself")
    if live:
        from drill_twin.ros.entry_points import start

        arguments = [f"--host={host}", f"--port={port}", *(f"--allow-host={name}" for name in allow_host)]
        arguments += [*(f"--limit={text}" for text in limit), *([f"--units={units}"] if units else [])]
        arguments += [] if browser else ["--no-browser"]
        if foxglove is not None:
            arguments.append(f"--foxglove={foxglove}")
        if namespace:
            arguments += ["--ros-args", "-r", f"__ns:=/{namespace.strip('/')}"]
        raise typer.Exit(start("watch", arguments))
    if bag is None:
        from drill_twin_dashboard.front.server import FrontServer

        _serve(FrontServer(Path.cwd(), host=host, port=port, names=allow_host), "this folder", browser)
        return
    from drill_twin.io.bag.reading.files import bag_path
    from drill_twin_dashboard.live.alarms import parse_limit
    from drill_twin_dashboard.live.player import Player
    from drill_twin_dashboard.live.server import PageServer

    parsed = [parse_limit(text) for text in limit]
    with shown_progress("reading the bag"):
        player = Player(bag_path(Path(bag)), namespace or None)
    player.state.units = units
    for one in parsed:
        player.state.take(one)
    for text in player.damage:
        remark(text)
    server = PageServer(
        player.snapshot, player.on_request, history=player.state.history, host=host, port=port, allowed_hosts=allow_host
    )
    _serve(server, bag, browser)
    player.close()
    for text in player.state.skipped.sentences():
        remark(text)


def _serve(server: Any, what: str, browser: bool) -> None:
    """Serve a page until asked to stop, by a server whose import takes time that --help has not."""
    with stop_request() as asked:
        server.links.show(what)
        if browser:
            server.links.open_browser()
        while not asked:
            time.sleep(0.1)
    server.close()
