# SPDX-License-Identifier: Apache-2.0
"""Buttons of the live page send what they are, not what is written on them: a browser may translate it."""

import json
import shutil
import subprocess
from importlib.resources import files

import pytest

STUBS = {
    "state.js": """
const made = {};
const make = () => ({ heard: {}, addEventListener(kind, f) { this.heard[kind] = f; }, querySelector: make });
export const $ = (name) => (made[name] ??= make()), state = {};
""",
    "connection.js": "export const said = []; export const say = (what) => said.push(what);",
    "units.js": "export const onUnits = () => {}, size = () => 1, unit = () => '';",
}
MAIN = """
globalThis.document = { activeElement: null };
const { $ } = await import("./state.js"), { said } = await import("./connection.js");
const { offerControls, showControls } = await import("./controls.js");
offerControls();
for (const [state, playing] of [["running", true], ["paused", false]]) {
  said.length = 0;
  showControls({ state, rig: {}, player: { playing, begin: 0, at: 0, length: 1 } });
  for (const name of ["pause", "play"]) { $(name).textContent = "anhalten"; $(name).heard.click(); }
  console.log(JSON.stringify(said.filter((what) => !("seek" in what))));
}
"""


def test_a_translated_label_is_no_command(tmp_path):
    if (node := shutil.which("node")) is None:
        pytest.skip("needs node")
    page = files("drill_twin_dashboard.live") / "page" / "controls.js"
    for name, text in {**STUBS, "controls.js": page.read_text("utf-8"), "main.mjs": MAIN}.items():
        (tmp_path / name).write_text(text, "utf-8")
    (tmp_path / "package.json").write_text('{"type": "module"}', "utf-8")
    done = subprocess.run([node, str(tmp_path / "main.mjs")], capture_output=True, text=True, check=True, timeout=20)
    running, paused = map(json.loads, done.stdout.splitlines())
    assert running == [{"pause": True}, {"play": False}]
    assert paused == [{"resume": True}, {"play": True}]
