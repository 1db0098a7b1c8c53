"""The report as a file: complete, honest, safe, and small enough."""

from __future__ import annotations

import base64
import html
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from types import SimpleNamespace

import numpy as np
import pytest
from analysis.flights import at_rest, case1
from analysis.report_pages import NASTY, SCENARIO, bag, flight, page
from flown_bags import fly, sections

from spacecraft_gnc.analysis.report import read_run, report_html
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.drawing.chart import Chart
from spacecraft_gnc.drawing.page import paired
from spacecraft_gnc.drawing.sources import stretches
from spacecraft_gnc.drawing.table import difference, rounded
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.rigid_body import series

MEGABYTE = 1_000_000


class Page(HTMLParser):
    """A page as a browser's parser sees it."""

    def __init__(self, text):
        super().__init__()
        self.addresses, self.scripts, self.texts, self.tags = [], [], [], []
        self._inside = ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self._inside = tag
        self.tags.append(tag)
        self.addresses += [v for k, v in attributes if k in ("src", "href", "srcset", "action")]

    def handle_endtag(self, tag):
        self._inside = ""

    def handle_data(self, data):
        (self.scripts if self._inside == "script" else self.texts).append(data)

    @property
    def data(self):
        return json.loads(self.scripts[0])

    @property
    def text(self):
        return "".join(self.texts)

    def chart(self, name):
        return next(chart for chart in self.data["charts"] if chart["name"] == name)


def numbers(array):
    return np.frombuffer(base64.b64decode(array["bdata"]), dtype=array["dtype"])


@pytest.fixture(scope="module")
def nasty(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    paths = [bag(folder / "one"), flight(12).save(folder / "two.npz")]
    return Page(page(folder / "r.html", paths, [NASTY, "two"]).read_text(encoding="utf-8"))


def test_nothing_is_fetched(nasty):
    assert all(address.startswith(("#", "data:")) for address in nasty.addresses)
    assert len(nasty.scripts) == 3  # data, plotly.js once, ours


def test_what_a_user_wrote_is_text_and_never_markup(nasty):
    assert nasty.tags.count("script") == 3
    assert nasty.text.count(NASTY) >= 4  # heading, table, selector, scenario
    labels = {trace["name"] for trace in nasty.chart("error")["figure"]["data"]}
    assert html.escape(NASTY, quote=False) in labels  # plotly.js reads a little HTML
    assert SCENARIO.strip() in nasty.text


def test_the_curves_are_the_recorded_numbers(nasty):
    flown = flight()
    (first, _) = nasty.chart("torque_norm")["figure"]["data"][:2]
    norm = 1e3 * series.torque_norm(flown)
    np.testing.assert_allclose(numbers(first["y"])[:-1], norm, rtol=1e-15)
    np.testing.assert_array_equal(numbers(first["x"]), series.state_times(flown))
    run = nasty.data["view"]["runs"][0]
    recorded = series.attitudes(flown).ravel()
    np.testing.assert_array_equal(numbers(run["attitude"]), recorded)


def test_every_run_is_in_every_vector(nasty):
    for name in ("momentum", "torque", "inertial_momentum"):
        figure = nasty.chart(name)["figure"]
        assert len(figure["data"]) == 6  # x, y, z of two runs
        assert "body" in SCENARIO


def test_the_representations_say_what_they_are(nasty):
    variants = {v["name"]: v for v in nasty.chart("attitude")["variants"]}
    assert list(variants) == ["quaternion", "roll_pitch_yaw", "rotation_vector"]
    assert all("body to inertial" in v["note"] for v in variants.values())
    assert "x, y, z, w" in variants["quaternion"]["note"]
    assert "Rz(yaw) Ry(pitch) Rx(roll)" in variants["roll_pitch_yaw"]["note"]
    assert "gimbal lock: none" in variants["roll_pitch_yaw"]["note"]
    units = {"quaternion": "[-]", "roll_pitch_yaw": "[deg]", "rotation_vector": "[rad]"}
    for name, unit in units.items():
        axes = variants[name]["figure"]["layout"]
        assert axes["yaxis"]["title"]["text"].endswith(unit)


def test_zones_cover_what_they_should(nasty):
    star, station = nasty.data["view"]["runs"][0]["zones"]
    for zone, axis, angle in ((star, [0, 1, 0], 5.0), (station, [0, 0, 1], 80.0)):
        points = numbers(zone["points"]).reshape(-1, 3)
        directions = points / np.linalg.norm(points, axis=1, keepdims=True)
        away = np.degrees(np.arccos(np.clip(directions @ axis, -1.0, 1.0)))
        assert away.max() == pytest.approx(angle)
        border = numbers(zone["border"]).reshape(-1, 3)
        assert len(border) == 72
        assert max(max(corner) for corner in zone["triangles"]) == len(points) - 1
    assert (star["boresight"], station["boresight"]) == (False, True)


def test_losses_are_shown(tmp_path):
    lost = [("attitude_reference", 3), ("solver_status", 4), ("attitude_state", 5)]
    path = bag(tmp_path / "bag", lost=lost)
    text = Page(report_html([read_run(path, "run")])).text
    assert "attitude_reference lacks step 3" in text
    assert "steps without a state or a torque (gaps in the curves): 1" in text
    assert "steps flown on a fallback torque: 12" in text
    assert "solver_status lacks step 4" in text


def test_missed_deadlines_are_drawn_and_counted(tmp_path):
    run = read_run(flight().save(tmp_path / "a.npz"), "run")
    assert "slack" not in {c["name"] for c in Page(report_html([run])).data["charts"]}
    slack = np.linspace(0.3, -0.1, 20)
    late = replace(run, telemetry=replace(run.telemetry, deadline_slack=slack))
    seen = Page(report_html([late]))
    assert "solves that ended after their deadline: 5" in seen.text
    drawn = numbers(seen.chart("slack")["figure"]["data"][0]["y"])
    np.testing.assert_allclose(drawn, slack, rtol=1e-12)


def test_late_torques_of_a_free_run_are_told(tmp_path):
    """A solve that ended in time may reach the plant late: only the plant knows."""
    free = sections(plant={"mode": "free_run"})
    run = read_run(fly(tmp_path, free, late=(3, 7)), "run")
    assert run.metrics["missed_deadlines"] == 2
    assert "torques that came after their deadline: 2" in run.warnings()
    assert "Deadlines missed" in Page(report_html([run])).text
    (tmp_path / "lockstep").mkdir()
    run = read_run(fly(tmp_path / "lockstep"), "run")
    assert run.metrics["missed_deadlines"] is None
    assert "Deadlines missed" not in Page(report_html([run])).text


def test_a_failed_audit_is_a_warning(tmp_path):
    run = read_run(bag(tmp_path / "bag"), "run")
    assert run.verdict.passed is False  # Case I was flown by another solver, invariants by none
    text = Page(report_html([run])).text
    assert f"the audit failed: {run.verdict.text}" in text
    assert run.verdict.checks[0][0] in text


def test_a_file_of_gnc_simulate_says_that_it_is_not_audited(nasty):
    assert "not audited: a .npz file holds no plans" in nasty.text


def test_the_difference_to_the_first_run_is_shown(tmp_path):
    flown = flight()
    paths = [
        flown.save(tmp_path / "a.npz"),
        replace(flown, iterations=flown.iterations + 2).save(tmp_path / "b.npz"),
    ]
    text = report_html([read_run(path, path.stem) for path in paths])
    row = text.split("Iterations a solve, most</th>")[1].split("</tr>")[0]
    assert row == '<td>2</td><td>4 <span class="difference">(+2, +100 %)</span></td>'


@pytest.mark.parametrize(
    ("value", "first", "text"),
    [
        (4.0, 4.0, "same"),
        (3.0, 4.0, "-1, -25 %"),
        (12.0, 4.0, "+8, +200 %"),
        (12.1, 4.0, "+8.1, 3.02 times"),
        (-5.423, -0.01, "-5.41, 542 times"),
        (5.413, -0.01, "+5.42"),  # of another sign: no factor
        (1.0, 0.0, "+1"),
        (0.0, 4.0, "-4, -100 %"),
        (1e-4, 2.0, "-2, 5e-05 times"),
    ],
)
def test_a_difference_from_a_tiny_number_is_no_share_of_it(value, first, text):
    assert difference(value, first) == text


def cells(page, label):
    row = page.split(f"<th scope=row>{label}")[1].split("</tr>")[0]
    return re.findall("<td>(.*?)</td>", row)


def test_never_unknown_none_and_not_applicable_are_told_apart(tmp_path):
    """Of a flight whose scenario is known, of one without it, and of one that lost its end."""
    known = flight(12)
    lost = replace(known, final_attitude=np.full((3, 3), np.nan), attitude=known.attitude * np.nan)
    unlimited = from_sections(
        {
            "plant": {"inertia": [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]},
            "nmpc_controller": {"max_torque": 0.0},
        }
    )
    runs = [
        read_run(known.save(tmp_path / "known.npz", unlimited.to_yaml()), "known"),
        read_run(known.save(tmp_path / "alien.npz"), "alien"),
        read_run(lost.save(tmp_path / "lost.npz"), "lost"),
    ]
    page = report_html(runs)
    assert cells(page, "Error below 0.1° for good") == ["never", "never", "unknown"]
    assert cells(page, "Torque limit") == ["none", "unknown", "unknown"]
    assert cells(page, "Least zone margin") == ["-", "unknown", "unknown"]
    assert cells(page, "Error at the end")[2].startswith("unknown")
    assert "Deadlines missed" not in page  # of none of them there is such a thing


def long_flight(n=100_000):
    """Return a flight at rest with one spike that no picture may hide."""
    rng = np.random.default_rng(3)
    torque = 1e-3 * rng.normal(size=(n, 3))
    torque[70_003] = [0.5, 0.0, 0.0]
    source = np.zeros(n, dtype=np.int64)
    source[70_005] = 4
    solve_time = rng.uniform(1e-5, 1e-3, n)
    return replace(at_rest(n), torque=torque, source=source, solve_time=solve_time)


def test_a_long_run_is_an_envelope_and_says_so(tmp_path):
    run = read_run(long_flight().save(tmp_path / "long.npz"), "long")
    text = report_html([run])
    assert len(text.encode()) < 10 * MEGABYTE
    seen = Page(text)
    assert "least and the greatest value of each interval" in seen.text
    assert "every 34th state of long" in seen.text
    norm = seen.chart("torque_norm")["figure"]["data"][0]
    assert numbers(norm["y"]).max() == 0.5  # [N m]
    zero = [
        stretch
        for stretch in stretches(run.trajectory.source, run.times, 50)
        if stretch.source == 4
    ]
    assert len(zero) == 1
    assert zero[0].begin <= 0.4 * 70_005 <= zero[0].end


def test_many_runs_stay_small_too(tmp_path):
    path = case1().save(tmp_path / "a.npz")
    text = report_html([read_run(path, f"run {i}") for i in range(12)])
    assert len(text.encode()) < 10 * MEGABYTE


@pytest.mark.parametrize("kept", [1, 2])
def test_the_shortest_flights_have_a_report(tmp_path, kept):
    path = bag(tmp_path / "bag", n=kept)
    assert Page(report_html([read_run(path, "short")])).data["view"]["runs"][0]["count"] == kept + 1


def run_command(*arguments):
    """Run ``gnc report`` and return its exit code."""
    with pytest.raises(SystemExit) as ended:
        main(["report", *map(str, arguments)])
    return ended.value.code or 0


def test_the_command_writes_a_page_and_names_it(tmp_path, capsys):
    path, out = bag(tmp_path / "bag"), tmp_path / "r.html"
    assert run_command(path, "-o", out, "--title", "<i>Mine</i>") == 0
    captured = capsys.readouterr()
    assert captured.out == f"{out}\n"
    assert "warning: " in captured.err
    assert "<title>&lt;i&gt;Mine&lt;/i&gt;</title>" in out.read_text(encoding="utf-8")


def test_json_holds_metrics_audit_and_warnings(tmp_path, capsys):
    one, two = bag(tmp_path / "bag"), flight().save(tmp_path / "two.npz")
    assert run_command(one, two, "-o", tmp_path / "r.html", "--json", "--quiet") == 0
    answer = json.loads(capsys.readouterr().out)
    assert [run["name"] for run in answer["runs"]] == ["bag", "two"]
    assert answer["runs"][0]["metrics"]["steps"] == 20
    assert answer["runs"][1]["audit"]["passed"] is None
    assert answer["bytes"] == (tmp_path / "r.html").stat().st_size


@pytest.mark.parametrize(
    ("name", "reason"), [("none.npz", "cannot be read"), ("none", "no such file")]
)
def test_bad_input_is_one_line_and_leaves_nothing(tmp_path, capsys, name, reason):
    assert run_command(tmp_path / name, "-o", tmp_path / "r.html") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")
    assert reason in line
    assert not (tmp_path / "r.html").exists()


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        (".", "no .html file"),
        ("", "no .html file"),
        ("page.pdf", "no .html file"),
        ("page.html", "a directory"),
        ("none/page.html", "in a folder that does not exist"),
    ],
)
def test_a_page_that_cannot_be_is_refused_before_anything_is_read(
    tmp_path, capsys, monkeypatch, name, reason
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "page.html").mkdir()
    assert run_command(tmp_path / "none.npz", "-o", name) == 2
    (error,) = capsys.readouterr().err.splitlines()
    assert error.startswith("error: --out: received ")
    assert f"{reason}; required a .html file in a writable folder; " in error


@pytest.mark.parametrize(
    ("value", "digits", "sign", "text"),
    [
        (100_000, 5, "", "100000"),
        (123_456, 5, "", "123456"),
        (45070.4, 4, "", "45070"),
        (99999.6, 5, "", "100000"),
        (44624.9, 3, "+", "+44625"),
        (0.0123456, 3, "", "0.0123"),
        (-1234.56, 3, "+", "-1235"),
        (1e15, 5, "", "1e+15"),
    ],
)
def test_counts_and_long_times_are_written_out(value, digits, sign, text):
    assert rounded(value, digits, sign) == text


@pytest.mark.parametrize(
    ("shapes", "expected"),
    [
        ("ss", "ss"),
        ("sss", "ssw"),
        ("sssw", "ssww"),
        ("stsw", "stsw"),
        ("sttw", "wttw"),
        ("sst", "ssw"),
        ("swsssws", "wwsswww"),
        ("", ""),
    ],
)
def test_columns_end_alike(shapes: str, expected: str) -> None:
    """s: a single chart, t: a tall one, w: a wide one."""
    charts = [Chart(f"{i}", "", wide=s == "w", tall=s == "t") for i, s in enumerate(shapes)]
    done = paired(charts)
    assert "".join("w" if c.wide else "t" if c.tall else "s" for c in done) == expected
    assert [chart.tall for chart in done] == [chart.tall for chart in charts]
    assert [chart.name for chart in done] == [chart.name for chart in charts]


def test_runs_of_different_vehicles_are_refused(tmp_path):
    """They have no diagram in common."""
    one = read_run(bag(tmp_path / "one"), "one")
    wheels = SimpleNamespace(vehicle=SimpleNamespace(name="two_wheel"))
    with pytest.raises(ParameterError, match=r"vehicles rigid_body, two_wheel; required flights"):
        report_html([one, replace(one, name="other", scenario=wheels)])
