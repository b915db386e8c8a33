# SPDX-License-Identifier: Apache-2.0
"""Every command that a page shows is one that the command line takes; each is run once, to its exit code.

A page has a folder of its own, in which its commands run in their order; a command of several pages runs on the first
one. What a page leaves to its reader (a record, a survey) is `GIVEN`. A command prints what the page shows under it,
and the files are there that `--out` and the page's sentences with "writes" name.
Commands that go on until they are stopped get SIGINT once they have said something. What is not run is in `ELSEWHERE`,
what only each night is run in `OF_THE_NIGHT`, with the reason; the others are long.
"""

import os
import re
import resource
import shlex
import shutil
import signal
import subprocess
import time
from contextlib import redirect_stdout
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from test_tutorials import DOCS, ROOT, environment
from typer.main import get_command

import drill_twin as dt
from drill_twin.cli.app import app
from drill_twin.core.errors import DrillTwinError
from drill_twin.ros.deployment import DomainClaim

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
FENCE = re.compile(r"^ *```([^\n]*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"(?:drill-twin|ros2 run drill_twin|ros2 launch drill_twin|python -m drill_twin\w*\.)[ \w]")
PATTERN = re.compile(r"(?<![\w\"'])(?:BAG|NAME|NODE|FILE|CASE|COMMAND)(?![\w\"'])")
"""Words in place of something of the reader's."""

COMMANDS = get_command(app)

ELSEWHERE = {
    r"ros2 launch ": "the launch file: test/ros/test_launch.py; `ros2` is no part of the wheels of the tests",
    r"--enclave": "needs keys that `ros2 security` makes: test/ros/test_security.py",
    r"rig_url:=opc.tcp": "needs the OPC UA server of a rig: companions/drill_twin_rig/test",
    r"--dask": "needs a scheduler and its workers: test/runs/ensemble",
    r"^drill-twin study (verify|hard|validate|paper|analyzer-score|whirl-compare)( --page \S+)?$":
        "minutes to hours of processor time; `make evidence` runs them, the tests of evidence/ their cases",
    r"study verify --only (?!buckling)": "minutes each; evidence/test runs every case",
    r"study analyzer-score --downhole|study estimator-score|foreign_rigs|two_depths|drill_twin_evidence\.pictures":
        "minutes to hours of processor time; docs and evidence/docs are printed by them",
    r"^drill-twin effects ": "a kernel for each set of effects, minutes: test/studies/accuracy/test_effects_study.py",
    r"^drill-twin cost ": "minutes: test/studies/accuracy/test_cost_study.py",
    r"^drill-twin map wells/": "two minutes: test/cli/test_matrix.py makes a small map of the well",
    r"^drill-twin study clearance|lateral_spring": "of a package that the page makes: test/api",
    r"^drill-twin replay theirs": "a bag with topic names of others: test/ros/test_record_and_replay.py",
    r"175_completo_1": "a record that is not part of the package: evidence/docs/validation.md says where it is from",
}  # fmt: skip
"""Commands that are not run here, and why."""
OF_THE_NIGHT = {
    r"wells/s_shaped --duration|bha_full_size --accuracy": "test/dynamics/twin/test_joint.py, test/studies/accuracy",
    r"analyze out/whirl/bag_0 --why": "test/api/test_cause.py",
    r"--over rpm=": "test/dynamics/rotordynamics/test_branches.py",
    r"^drill-twin run bha_stress ": "test/physics/effects/test_fatigue.py",
    r"^drill-twin fit out/hidden ": "companions/drill_twin_studies/test/fitting",
    r"^drill-twin map pa6_bench|map_pa6_bench/map.json": "companions/drill_twin_studies/test/maps and test/ros",
    r"stamp_score|switched_off|^drill-twin estimate out/hidden ":
        "companions/drill_twin_studies/test/estimation, evidence/test/estimation",
}  # fmt: skip
"""Commands of more than ten seconds of processor time: run each night, and what guards a change."""
UNTIL_STOPPED = re.compile(r"ros2 run drill_twin|drill-twin (watch|ros node|ros load)|pace:=lockstep")


class Shown(NamedTuple):
    """A command on a page."""

    page: str
    line: str
    named: bool = False
    """In a sentence, where it may be the name of a command."""
    followed: bool = False
    """In a block `sh`, which `test_tutorials.py` follows."""
    prints: str = ""
    """What the page shows as its output, or a part of it."""


def plain(command):
    """A command without comment, with the quotes of `shlex`, so that it is known again on another page."""
    return shlex.join(shlex.split(command, comments=True)).removesuffix(" '&'")


def shown_commands(page):
    """Commands of blocks in their order, each with its output, and then those in sentences.

    A block without commands shows output: of the command that the paragraph before it begins with; behind a block of
    Python of its script, unless that paragraph is on "the command"; else of the last command.
    """
    text, name = page.read_text("utf-8"), str(page.relative_to(ROOT))
    found, output, end, script = [], {}, 0, False
    for block in FENCE.finditer(text):
        kind, between, end = block[1].strip(), text[end : block.start()], block.end()
        if kind in {"yaml", "mermaid", "python"}:
            script = kind == "python"
            continue
        lines = [re.sub(r"^ *(?:\$ )?", "", line) for line in re.sub(r"\\\n *", " ", block[2]).splitlines()]
        commands = [line for line in lines if COMMAND.match(line)] if kind != "text" else []
        if commands:
            found += [Shown(name, plain(line), followed=kind == "sh") for line in commands]
        elif kind in {"", "text"} and not page.match("reference/*"):
            paragraph = between.strip().rpartition("\n\n")[2]
            if begin := re.match(r"`([^`\n]+)`", paragraph):
                output[plain(begin[1])] = block[2]
            elif found and (not script or "command" in paragraph):
                found[-1] = found[-1]._replace(prints=block[2])
        script = False
    quoted = re.findall(r"`([^`\n]+)`", FENCE.sub("", text))
    named = [plain(command) for command in quoted if COMMAND.match(command)]
    return [*found, *(Shown(name, line, named=True, prints=output.get(line, "")) for line in named)]


ALL = [one for page in PAGES for one in shown_commands(page)]


def problem_of(line):
    """What the command line refuses of a line, without running it; None where it takes it."""
    words = shlex.split(line)
    if words[0] != "drill-twin":
        return None
    command, context, rest = COMMANDS, None, words[1:]
    try:
        while True:
            for option in command.params:
                if getattr(option, "prompt", None):  # a question is no mistake of the page
                    option.prompt, option.required = None, False
            with redirect_stdout(None):
                context = command.make_context(command.name or "drill-twin", list(rest), parent=context)
            rest = [*context._protected_args, *context.args]
            if not hasattr(command, "commands") or not rest:
                return None
            _, command, rest = command.resolve_command(context, rest)
    except DrillTwinError as error:
        return error
    except Exception as error:
        if hasattr(error, "exit_code") and not getattr(error, "format_message", None):  # a help, the version
            return None
        if not hasattr(error, "format_message"):
            raise
        return error


@pytest.mark.parametrize("shown", ALL, ids=lambda one: f"{one.page}: {one.line}"[:100])
def test_a_command_on_a_page_is_one_that_the_command_line_takes(shown):
    if PATTERN.search(shown.line.split(" --")[0]) or "clearance" in shown.line:
        return  # of the reader's own making
    problem = problem_of(shown.line)
    if shown.named:  # a name may lack what its command needs
        problem = None if type(problem).__name__ in {"MissingParameter", "BadOptionUsage"} else problem
    assert problem is None, repr(problem)


def is_name(shown):
    """Whether a sentence names a command, and shows none to be typed; those of the gallery are."""
    bare = not re.search(r" --| [\w/.]*[/.][\w/.]+| pa6_bench| BAG", shown.line)
    return shown.named and (problem_of(shown.line) is not None or (bare and shown.page != "docs/gallery.md"))


@cache
def to_be_run():
    """Commands that are run, by page, each on the first page that has it."""
    first, pages = {}, {}
    for one in ALL:
        elsewhere = one.followed or any(re.search(of, one.line) for of in ELSEWHERE)
        if not (elsewhere or PATTERN.search(one.line) or is_name(one)) and first.setdefault(one.line, one) is one:
            pages.setdefault(one.page, []).append(one)
    return pages


def of_a_change(page):
    """Those of a page that are run with each change."""
    return [one for one in to_be_run()[page] if not any(re.search(of, one.line) for of in OF_THE_NIGHT)]


def pages():
    """Pages with what is run of them: with each change, and each night all of those of which some is left to it."""
    for page, every in to_be_run().items():
        some = of_a_change(page)
        if some:
            yield pytest.param(some, marks=pytest.mark.long, id=page)
        if some != every:
            yield pytest.param(every, marks=pytest.mark.nightly, id=f"{page}, all")


def test_output_on_a_page_is_compared():
    run = {one for commands in to_be_run().values() for one in commands}
    shown = {one for one in ALL if one.prints and not one.followed}
    assert {one.page for one in shown} >= {"docs/accuracy.md", "docs/analyzer.md", "docs/drill_twin_studies/fit.md"}
    assert {one for one in shown - run if not any(re.search(of, one.line) for of in ELSEWHERE)} == set()


def written(page):
    """Names of the files that a page says its commands write."""
    for sentence in re.split(r"(?<=[.:]) |\n\s*\n", FENCE.sub("", (ROOT / page).read_text("utf-8"))):
        if re.search(r"\bwrites\b", sentence):
            yield from re.findall(r"`([\w-]+\.(?:csv|html|json|las|npz|png|rrd|yaml))`", sentence)


def test_each_page_with_a_shell_is_followed():
    text = (ROOT / "test/documentation/test_tutorials.py").read_text("utf-8")
    for page in {one.page for one in ALL if one.followed}:
        assert f'follow_shell("{page.removeprefix("docs/")}"' in text, page


@pytest.mark.parametrize("of", [*ELSEWHERE, *OF_THE_NIGHT])
def test_what_is_not_run_is_on_a_page(of):
    assert any(re.search(of, one.line) for one in ALL)


def write(name, text):
    """Something that writes a text file."""
    return lambda folder, _: (folder / name).write_text(text)


def base_run(folder, run):
    """The first run of the reference, as the bag that pages have from before; it is made once for all of them."""
    kept = folder.parent / "first_run"
    if kept.exists():
        shutil.copytree(kept, folder / "out/run")
    else:
        run('drill-twin run pa6_bench --wob "60 N" --rpm 180 --duration 20 --out out/run')
        shutil.copytree(folder / "out/run", kept)


def copied(name):
    """Something that copies that bag."""

    def make(folder, run):
        given(folder, "out/run", run)
        shutil.copytree(folder / "out/run/bag_0", folder / name)

    return make


def rig_record(folder, _):
    """Torque of a twin of `two_mass`, as a rig records it."""
    result = dt.Simulation("two_mass", {"wob": "55 kN"}).run(duration=12.0)
    rows = np.column_stack((result.time, 1e-3 * result.to_pandas()["torque [N m]"].to_numpy()))[::5]
    np.savetxt(folder / "rig.csv", rows, delimiter=",", header="time [s],Torque", comments="")


def well_record(kind):
    """Weight, speed and torque at the surface over half a minute."""

    def make(folder, run):
        rows = [(k, 40 + k % 3, 120 + k % 2, 9 + 0.1 * (k % 5)) for k in range(30)]
        if kind == "csv":
            text = "time [s],WOB [kN],RPM [rpm],TQA [kN m]\n" + "".join(",".join(map(str, row)) + "\n" for row in rows)
        elif kind == "las":
            text = ("~Version\nVERS. 2.0:\nWRAP. NO:\n~Well\nSTRT.s 0:\nSTOP.s 29:\nSTEP.s 1:\nNULL. -999.25:\n"
                    "~Curve\nTIME.s :\nSWOB.kN :\nRPMA.rpm :\nTQA.kN.m :\n~Ascii\n")  # fmt: skip
            text += "".join(" ".join(map(str, row)) + "\n" for row in rows)
        else:
            curves = (("TIME", "s"), ("SWOB", "kN"), ("RPMA", "rpm"), ("TQA", "kN.m"))
            text = '<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1">'
            text += "<log><indexType>elapsed time</indexType>"
            text += "".join(f"<logCurveInfo><mnemonic>{of}</mnemonic><unit>{unit}</unit></logCurveInfo>"
                            for of, unit in curves)  # fmt: skip
            names, units = (",".join(part) for part in zip(*curves, strict=True))
            text += f"<logData><mnemonicList>{names}</mnemonicList><unitList>{units}</unitList>"
            text += "".join(f"<data>{','.join(map(str, row))}</data>" for row in rows) + "</logData></log></logs>"
        (folder / f"well_7.{kind}").write_text(text)

    return make


WELL = "base: wells/vertical_3000\n"
GIVEN = {
    "out/run": base_run, "out/bag_0": copied("out/bag_0"),
    "rig.csv": rig_record, "well_7.csv": well_record("csv"), "well_7.las": well_record("las"),
    "well_7.xml": well_record("xml"), "well_7.yaml": write("well_7.yaml", f"name: well_7\n{WELL}"),
    "my_well.yaml": write("my_well.yaml", f"name: my_well\n{WELL}"),
    "my_scene.yaml": write("my_scene.yaml", "name: my_scene\nbase: pa6_bench\n"),
    "survey.csv": lambda folder, _: shutil.copy(ROOT / "config/wells/s_shaped_survey.csv", folder / "survey.csv"),
    "tally.csv": lambda folder, _: shutil.copy(ROOT / "config/wells/s_shaped_tally.csv", folder / "tally.csv"),
    "tripping.csv": write(
        "tripping.csv", "bit depth [m],pick-up [kN],slack-off [kN]\n1000,500,400\n2000,800,650\n2800,1000,850\n"
    ),
    "config/wells": lambda folder, _: shutil.copytree(
        ROOT / "config", folder / "config", dirs_exist_ok=True
    ),
}  # fmt: skip
"""What a page takes from its reader, by the words of a command that name it."""
OF_THE_MACHINE = re.compile(
    r"[\d.]+(?= s of processor time)|(?<=the motion: )[\d.]+|(?<=expected )[\d.]+(?= s)|(?<=the check: )[\d.]+"
)
"""Numbers in an output that are processor times."""
ANSWERS = {"ros keys": "a password of a driller\n"}


def given(folder, line, run):
    """Make what a command needs and its page has not made."""
    for name, make in GIVEN.items():
        made = folder / name
        if made.is_dir() and line.startswith(f"drill-twin replay {name} "):
            shutil.rmtree(made)  # the recorder of the page had nothing to record
        if not made.exists() and re.search(rf"(?<!new )(?<!--out )(?<!bag:=)(?<![\w/]){name}(?!\w)", line):
            made.parent.mkdir(parents=True, exist_ok=True)
            make(folder, run)


def ended(line, folder, domain):
    """Run a command to its end, or until it is stopped; returns its exit code and what it said."""
    words = line.replace("ros2 run drill_twin", "drill-twin ros node")  # what it does without `ros2`
    endless = UNTIL_STOPPED.search(line)
    more = {"ROS_DOMAIN_ID": str(domain), "ROS_LOG_DIR": str(folder), "BROWSER": "true", "PYTHONUNBUFFERED": "1"}
    if "ros demo" in line:
        del more["ROS_DOMAIN_ID"]  # it claims a free one
    answer = next((text for name, text in ANSWERS.items() if name in line), "")
    with (folder / "said.txt").open("w+", encoding="utf-8") as said:
        child = subprocess.Popen(
            ["bash", "-c", f"exec {words}"], cwd=folder, env=environment(**more), stdin=subprocess.PIPE, stdout=said,
            stderr=said, text=True, start_new_session=True,
        )  # fmt: skip
        try:
            child.stdin.write(answer)
            child.stdin.close()
            begun = time.monotonic()
            while child.poll() is None and time.monotonic() < begun + 1200.0:
                # a node that waits for messages may have nothing to say; a start under load takes half a minute
                if endless and ((folder / "said.txt").stat().st_size or time.monotonic() > begun + 60.0):
                    time.sleep(1.0)  # it goes on
                    os.killpg(child.pid, signal.SIGINT)
                    child.wait(60.0)
                time.sleep(0.05)
        finally:
            if child.poll() is None:
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()
        said.seek(0)
        return child.returncode, said.read()


@pytest.mark.parametrize("commands", list(pages()))
def test_the_commands_of_a_page_end_as_they_should(commands, tmp_path):
    claim, page = DomainClaim(), commands[0].page

    def run(line, prints=""):
        code, said = ended(line, tmp_path, claim.domain)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        print(f"{used.ru_utime + used.ru_stime:6.1f} s of processor time up to {line}: {code}")
        assert "Traceback" not in said, f"{line}\n{said}"
        assert code == 0, f"{line}\n{said}"
        words = OF_THE_MACHINE.sub("#", " ".join(said.split()))
        missing = [row for row in prints.splitlines() if OF_THE_MACHINE.sub("#", " ".join(row.split())) not in words]
        assert missing == [], f"{line}\n{said}"
        if out := re.search(r" --out '?([\w./-]+)", line):
            assert any((tmp_path / out[1]).iterdir()), line

    def pictures():
        return {path for kind in ("html", "png") for path in tmp_path.rglob(f"*.{kind}")}

    try:
        for one in commands:
            given(tmp_path, one.line, run)
            before = pictures()
            run(one.line, one.prints)
            if page == "docs/gallery.md" and not UNTIL_STOPPED.search(one.line):
                assert pictures() > before, one.line
        if commands == to_be_run()[page]:
            assert [name for name in written(page) if not any(tmp_path.rglob(name))] == []
    finally:
        claim.release()
