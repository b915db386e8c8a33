# SPDX-License-Identifier: Apache-2.0
"""The page is self-contained, and the figures show the motion in the bag."""

import base64
import gzip
import json
import re
from html.parser import HTMLParser

import matplotlib.image
import numpy as np
import pytest
from matplotlib.patches import Circle
from PIL import Image
from summaries import summarise

from drill_twin.core.errors import BagError
from drill_twin.report import build_report, draw
from drill_twin.report.charts import CHARTS
from drill_twin.report.figures import FIGURES, OVER_TIME
from drill_twin.report.figures.style import STATE_COLOURS
from drill_twin.report.page import ON_THE_JOINT, build_page
from drill_twin.report.recording import read_recording
from drill_twin.report.text import NOT_VALIDATED
from drill_twin.scene import load_scene
from drill_twin.whirl import MotionState


class Page(HTMLParser):
    """What a browser would fetch, and what it holds."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.scripts: dict[str, str] = {}
        self.words = ""
        self._inside: str | None = None
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.fetched += [values[key] or "" for key in ("src", "href", "data", "action") if key in values]
        self._inside = values.get("id") or "code" if tag == "script" else tag if tag == "style" else None

    def handle_endtag(self, tag: str) -> None:  # noqa: ARG002  what is inside a script or style is plain text
        self._inside = None

    def handle_data(self, data: str) -> None:
        if self._inside is None:
            self.words += " ".join(data.split()) + " "
        else:
            self.scripts[self._inside] = self.scripts.get(self._inside, "") + data


@pytest.fixture
def files(known_report):
    return known_report


@pytest.fixture(scope="module")
def page(known_report):
    return Page(known_report.page.read_text("utf-8"))


@pytest.fixture(scope="module")
def recording(known_bag):
    return read_recording(known_bag)


def page_of(recording, files):
    """The page of another recording, with the figures of `files`."""
    return Page(build_page(recording, summarise(recording), files.figures, {}))


def test_a_page_has_the_note_on_the_joint_outside_of_its_warnings(recording, files):
    """Where lateral motion begins warns of nothing; it stood among what limits the findings."""
    summary, note = summarise(recording), f"{ON_THE_JOINT[0]}2773 m down"
    text = build_page(recording, summary | {"notes": [note, "a trouble"]}, files.figures, {})
    box = text[text.index('<section class="warning">') :].partition("</section>")[0]
    assert "a trouble" in box
    assert note not in box
    assert f'<p class="lead">Note: {note}</p>' in text


def test_all_files_are_there(files, known_bag):
    assert set(files.figures) == set(FIGURES)
    assert json.loads(files.summary.read_text("utf-8")) == summarise(known_bag)
    assert files.page.stat().st_size < 6e6


def test_page_fetches_nothing(page, files):
    assert page.fetched
    assert all(address.startswith("data:") for address in page.fetched)
    assert "@import" not in page.scripts["style"]
    assert "url(" not in page.scripts["style"]
    assert not re.search(r"\b(fetch|XMLHttpRequest|importScripts)\s*\(", page.scripts["code"])


def test_page_shows_every_figure_as_it_is_on_disk(page, files):
    shown = [base64.b64decode(text.partition(",")[2]) for text in page.fetched if text.startswith("data:image/png")]
    assert sorted(shown) == sorted(path.read_bytes() for path in files.figures.values())


def test_page_says_what_was_found_and_what_is_not_validated(page):
    for words in ("pa6_bench", "-0.60 Hz", "(backward)", "-0.30", "backward whirl", "12.5", "9.9.9", "gravity, wall"):
        assert words in page.words, words
    assert all(text in page.words for text in NOT_VALIDATED)
    assert "estimated" in page.words  # the scene's provenance


def test_plotly_is_packed_whole(page):
    script = gzip.decompress(base64.b64decode(page.scripts["plotly-packed"])).decode()
    assert "plotly.js v" in script[:200]
    assert "scatter3d" in script


def test_interactive_view_holds_the_motion(page, recording):
    data = json.loads(page.scripts["view-data"])
    assert data["marks"] == ["mark_1", "mark_2", "mark_3", "mark_4"]
    paths = np.frombuffer(base64.b64decode(data["paths"]["values"]), "<i2").reshape(-1, 4, 3) / data["full"]
    centre = recording.centre_lines()
    assert paths.shape[0] == len(data["paths"]["time"]) == centre.shape[0]
    assert np.abs((paths[..., 0] + 1j * paths[..., 1]) * data["radius"] - centre).max() < 1e-5
    shapes = np.frombuffer(base64.b64decode(data["shapes"]["values"]), "<i2")
    shapes = shapes.reshape(len(data["shapes"]["time"]), data["shapes"]["points"], 3) / data["full"]
    assert shapes[:, 0, 2] * data["length"] == pytest.approx(-5.0, abs=1e-3)
    assert np.abs(shapes[:, -1]).max() < 1e-3
    assert 3.0 < data["onset"] < 3.4


def test_text_of_a_scene_cannot_break_the_page(known_bag, files):
    nasty = "</script><script>alert(1)</script><b>&"
    scene = read_recording(known_bag).scene.model_copy(update={"description": nasty, "provenance": nasty})
    page = page_of(read_recording(known_bag, scene), files)
    assert nasty in page.words
    assert "alert(1)" not in "".join(page.scripts.values())


def test_interactive_view_has_the_well_as_it_is_drilled(page, files, known_bag):
    """North and depth of a well that turns from vertical to horizontal, to the east, on a quarter of a circle."""
    vertical = json.loads(page.scripts["view-data"])["well"]
    assert "as it is drilled" not in page.words
    assert vertical["names"] == ["x [mm]", "y [mm]", "z [m]"]
    assert (vertical["centre"][-1], vertical["factor"]) == ([0.0, 0.0, -5.0], 1e3)
    curved = {
        "hole.survey": "[{depth: 0 m, inclination: 0 deg}, {depth: 5 m, inclination: 90 deg, azimuth: 90 deg}]",
        "hole.intervals": "[{top: 1 m, bottom: 2 m, radius: 120 mm}]",
    }
    made = page_of(read_recording(known_bag, load_scene("pa6_bench", overrides=curved)), files)
    assert "as it is drilled" in made.words
    data = json.loads(made.scripts["view-data"])
    well, radius = data["well"], 10.0 / np.pi
    assert well["names"] == ["north [m]", "east [m]", "vertical depth [m]"]
    assert well["centre"][-1] == pytest.approx([0.0, radius, radius], abs=1e-3)
    assert np.cross(well["x"], well["y"])[-1] == pytest.approx([0.0, -1.0, 0.0], abs=1e-5)  # upwards along the hole
    assert {at for at, r in zip(well["depth"], well["hole"], strict=True) if r == 0.12} == {
        at for at in well["depth"] if 1.0 <= at < 2.0
    }  # fmt: skip
    assert {1.0, 2.0} <= set(well["rings"])
    assert data["pipe"] == pytest.approx([0.00825] * data["shapes"]["points"])
    assert data["walls"] == [0.09] * 4


@pytest.mark.parametrize("name", FIGURES)
def test_figures_are_legible_on_a_screen(files, name):
    with Image.open(files.figures[name]) as picture:
        assert picture.format == "PNG"
        assert picture.width == 1300
        assert 400 <= picture.height <= 1400
    pixels = matplotlib.image.imread(files.figures[name])
    assert pixels[..., :3].std() > 0.03  # something is drawn


def test_figures_over_time_share_their_axis_and_draw_the_onset(recording):
    onset = recording.summary.onset.time_s
    edges = set()
    for name in OVER_TIME:
        figure = draw(name, recording)
        for panel in figure.axes:
            place = panel.get_position()
            edges.add((round(place.x0, 6), round(place.x1, 6), *panel.get_xlim()))
            lines = [line.get_xdata() for line in panel.get_lines()]
            assert any(len(x) == 2 and x[0] == x[1] == onset for x in lines), name
        assert figure.axes[-1].get_xlabel() == "time [s]"
    assert len(edges) == 1
    assert next(iter(edges))[2:] == (0.0, 12.0)


@pytest.mark.parametrize("name", FIGURES)
def test_figures_have_titles_and_units(recording, name):
    figure = draw(name, recording)
    assert figure.get_suptitle()
    labels = [text for panel in figure.axes for text in (panel.get_xlabel(), panel.get_ylabel()) if text]
    assert any("[" in label for label in labels)


def test_displacement_is_that_of_the_centre_line(recording):
    """The spin of a wall mark, 8.25 mm, would show where the bow of 1 mm is."""
    figure = draw("displacement", recording)
    assert len(figure.axes) == 3  # marks 3 and 4 are at one place
    for panel in figure.axes:
        x = next(line.get_ydata() for line in panel.get_lines() if line.get_label() == "x")
        assert np.abs(x[:250]).max() == pytest.approx(1.0, rel=0.01)
        assert np.abs(x).max() == pytest.approx(31.0, rel=0.02)


def test_spectrum_marks_rotation_and_whirl_and_has_its_peak_there(recording):
    panel = draw("spectrum", recording).axes[0]
    upright = [line.get_xdata()[0] for line in panel.get_lines() if len(line.get_xdata()) == 2]
    assert sorted(upright) == pytest.approx([-0.6, 2.0], abs=0.02)
    curve = max(panel.get_lines(), key=lambda line: len(line.get_xdata()))
    assert curve.get_xdata()[np.argmax(curve.get_ydata())] == pytest.approx(-0.6, abs=0.05)
    assert max(curve.get_ydata()) == pytest.approx(30.0, rel=0.1)


def circles(panel):
    return sorted({round(patch.get_radius(), 6) for patch in panel.patches if isinstance(patch, Circle)})


def test_orbits_draw_wall_reach_and_pipe_at_their_size_one_panel_a_depth(recording):
    """Marks 3 and 4 are at one depth."""
    panels = [panel for panel in draw("orbits", recording).axes if panel.get_title()]
    assert [panel.get_title().partition(" m from")[0] for panel in panels] == [
        "mark_1, 4.4", "mark_2, 2.5", "mark_3, mark_4, 0.5",
    ]  # fmt: skip
    last = recording.centre_lines()[-1, 0] * 1e3
    for panel in panels:
        assert circles(panel) == pytest.approx([8.25, 81.75, 90.0])
        pipe = next(patch for patch in panel.patches if patch.get_radius() == pytest.approx(8.25))
        assert complex(*pipe.center) == pytest.approx(last)
        assert panel.get_aspect() == 1.0
        assert panel.get_xlim() == pytest.approx((-96.3, 96.3))


def test_small_orbits_are_enlarged_with_the_whole_hole_beside_them(messages, write):
    small = read_recording(write([row for row in messages if row[1] <= 2_500_000_000]))
    for panel in (panel for panel in draw("orbits", small).axes if panel.get_title()):
        assert panel.get_xlim() == pytest.approx((-1.6, 1.6), rel=0.01)  # the bow is 1 mm
        assert "enlarged 60 times" in panel.get_title()
        (beside,) = panel.child_axes
        assert circles(beside) == pytest.approx([8.25, 81.75, 90.0])
        assert beside.get_xlim() == pytest.approx((-96.3, 96.3))


def test_orbits_of_an_inclined_hole_name_the_low_side(recording, known_bag):
    inclined = read_recording(known_bag, load_scene("pa6_bench", overrides={"hole.inclination": "60 deg"}))
    for recorded, arrows in ((recording, 0), (inclined, 3)):
        texts = [text for panel in draw("orbits", recorded).axes for text in panel.texts]
        found = [text for text in texts if text.get_text() == "low side"]
        assert len(found) == arrows
        assert all(text.xy == pytest.approx((0.99, 0.5)) for text in found)


def test_spectrum_over_time_reaches_the_end_of_the_run(recording):
    (mesh,) = draw("spectrum_over_time", recording).axes[0].collections
    edges = mesh.get_coordinates()[..., 0]
    assert edges.min() <= recording.marks.time[0]
    assert edges.max() >= 12.0


def test_every_motion_state_has_a_colour_of_its_own():
    assert set(STATE_COLOURS) == set(MotionState)
    assert len({str(colour) for colour in STATE_COLOURS.values()}) == len(MotionState)


def test_rotation_to_the_left_turns_the_spectrum_round(recording, messages, write, known_scene):
    """Positive is the sense of rotation, so a mirrored run has the same spectrum."""
    from drill_twin.io.messages.cdr import JointStateTemplate
    from drill_twin.io.messages.decode import read_joint_state
    from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE

    rows = []
    for topic, stamp, raw in messages:
        if topic in {MARKS_STATE, RIG_STATE}:
            state = read_joint_state(raw)
            sign = np.ones(len(state.names))
            turned = [name.endswith(("/y", "/spin")) or name in {"top_drive", "bit"} for name in state.names]
            sign[turned] = -1.0
            template = JointStateTemplate(state.names)
            rows.append(
                (topic, stamp, template.fill(stamp, sign * state.position, sign * state.velocity, state.effort))
            )
        else:
            rows.append((topic, stamp, raw))
    mirrored = read_recording(write(rows))
    assert mirrored.summary.whirl_frequency_hz == pytest.approx(recording.summary.whirl_frequency_hz)
    assert mirrored.summary.rotation_rev_s == pytest.approx(-2.0, rel=1e-3)
    panel = draw("spectrum", mirrored).axes[0]
    curve = max(panel.get_lines(), key=lambda line: len(line.get_xdata()))
    assert curve.get_xdata()[np.argmax(curve.get_ydata())] == pytest.approx(-0.6, abs=0.05)


@pytest.mark.parametrize("last", [10_000_000, 20_000_000, 100_000_000, 2_500_000_000])
@pytest.mark.filterwarnings("error")
def test_short_bags_without_whirl_are_drawn_too(messages, write, last):
    short = read_recording(write([row for row in messages if row[1] <= last]))
    for name in FIGURES:
        assert draw(name, short).get_suptitle()


def test_bag_without_poses_is_drawn_without_the_view(messages, write, tmp_path):
    from drill_twin.io.messages.topics import STRING_POSES

    files = build_report(write([row for row in messages if row[0] != STRING_POSES]), tmp_path / "report")
    page = Page(files.page.read_text("utf-8"))
    assert "view-data" not in page.scripts
    assert json.loads(page.scripts["chart-data"]).keys() == set(CHARTS) - {"well"}  # its string would be missing
    assert "The string in motion" not in page.words


def test_truncated_bag_says_so_on_the_page(bench_run, files, tmp_path):
    whole = next(bench_run.bag.glob("*.mcap")).read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: int(0.6 * len(whole))])
    assert "the bag is not whole" in page_of(read_recording(tmp_path / "cut.mcap"), files).words


def test_folder_that_cannot_be_written(known_bag, tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(BagError, match="expected a place to write the report"):
        build_report(known_bag, tmp_path / "file" / "report")
