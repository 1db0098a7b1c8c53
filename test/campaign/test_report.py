"""The report of a campaign as a file: complete, safe, small, and its counts those of the rows."""

from __future__ import annotations

import html
import json
import re
import shlex

import numpy as np
import pyarrow as pa
import pytest
from analysis.test_report import Page, numbers
from campaign.made_campaigns import NASTY, VARIATIONS, made
from matplotlib.image import imread

from spacecraft_gnc import lie
from spacecraft_gnc.campaign.columns import numbers as column_numbers
from spacecraft_gnc.campaign.report import read_data, report_html
from spacecraft_gnc.campaign.report.charts import (
    MOST_CHARTS,
    MOST_PAIRS,
    MOST_PARAMETERS,
    value_axis,
)
from spacecraft_gnc.campaign.report.failures import clauses_of
from spacecraft_gnc.campaign.report.features import features
from spacecraft_gnc.campaign.statistics import binning, clopper_pearson
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.errors import RecordingError

MEGABYTE = 1_000_000


class Report(Page):
    """A page as a browser's parser sees it."""

    def pair(self, name):
        return next(pair for pair in self.data["pairs"] if pair["name"] == name)

    def titled(self, title):
        place = re.search(rf'id="h-([a-z0-9-]+)">{re.escape(html.escape(title))}<', self.source)
        return self.chart(place[1])["figure"]

    def __init__(self, text):
        self.source = text
        super().__init__(text)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return made(tmp_path_factory.mktemp("campaign") / "it's a <b>folder")


@pytest.fixture(scope="module")
def table(campaign):
    return campaign.table()


@pytest.fixture(scope="module")
def report(campaign):
    return Report(report_html(campaign))


def column(table, name):
    return table[name].to_numpy().astype(np.float64)


def test_nothing_is_fetched(report):
    assert all(address.startswith(("#", "data:")) for address in report.addresses)
    assert len(report.scripts) == 3  # data, plotly.js once, ours


def test_what_a_user_wrote_is_text_and_never_markup(report):
    assert report.tags.count("script") == 3
    assert "b" in report.tags  # the interval
    assert report.tags.count("b") == 1
    assert report.text.count(NASTY) > 5  # headings, tables, reason, variations
    assert VARIATIONS.strip() in report.text
    assert "it's a <b>folder" in report.text


def test_the_headline_is_the_success_rate_with_its_interval(report, table):
    passed, runs = np.count_nonzero(column(table, "passed")), table.num_rows
    low, high = clopper_pearson(passed, runs)
    assert f"{100 * passed / runs:.1f} %" in report.text
    assert f"{100 * low:.1f} % to {100 * high:.1f} %" in report.text
    statuses = table["status"].to_pylist()
    for status in ("passed", "failed", "refused", "error"):
        assert f"{statuses.count(status)} {status}" in report.text
    assert 'final_error_deg < 0.1 and "settle_time_0.1deg" < 100' in report.text


def test_it_says_what_flew(report, campaign):
    spec = campaign.spec
    for text in (spec.identity, spec.package_version, spec.libraries, spec.variations_path):
        assert text in report.text
    assert "random, 400 runs" in report.text


def test_histograms_count_every_run_that_has_a_value(report, table):
    values, passed = column(table, "final_error_deg"), column(table, "passed") == 1.0
    yes, no = report.titled("final_error_deg")["data"]
    assert (yes["name"], no["name"]) == ("passed", "not passed")
    assert sum(yes["y"]) == np.count_nonzero(passed)
    assert sum(no["y"]) == np.count_nonzero(~passed & np.isfinite(values))
    middle, width = numbers(yes["x"]), numbers(yes["width"])
    edges = np.append(middle - 0.5 * width, middle[-1] + 0.5 * width[-1])
    inner = edges[1:-1]
    for bars, chosen in ((yes, passed), (no, ~passed & np.isfinite(values))):
        counted = np.cumsum(bars["y"])[:-1]
        np.testing.assert_array_equal(counted, [(values[chosen] < edge).sum() for edge in inner])


def test_success_over_a_choice_is_the_share_of_its_runs(report, table):
    points = report.titled("nmpc_controller.horizon")["data"][0]
    horizon, passed = column(table, "nmpc_controller.horizon"), column(table, "passed")
    for i, value in enumerate((5, 8)):
        some = passed[horizon == value]
        assert numbers(points["y"])[i] == pytest.approx(100.0 * some.mean())
        low, high = clopper_pearson(int(some.sum()), len(some))
        assert numbers(points["error_y"]["array"])[i] == pytest.approx(100.0 * (high - some.mean()))
        assert numbers(points["error_y"]["arrayminus"])[i] == pytest.approx(
            100.0 * (some.mean() - low)
        )


def test_the_parameter_that_decides_stands_first(report):
    """Attitudes far off settle late."""
    angle = "plant.initial_rotation_vector: angle [deg]"
    assert report.pair("rates")["x"][0]["label"] == angle
    assert report.chart("rate-0")["figure"]["layout"]["xaxis"]["title"]["text"].startswith(
        "plant.initial_rotation_vector: angle"
    )


@pytest.mark.parametrize("name", ["rates", "density"])
def test_a_map_counts_the_runs_of_both_columns(report, table, name):
    pair = report.pair(name)
    angle = np.degrees(np.linalg.norm(np.array(
        table["plant.initial_rotation_vector"].to_pylist()), axis=1))  # fmt: skip
    other = {
        "rates": column(table, "nmpc_controller.horizon"),
        "density": column(table, "final_error_deg"),
    }[name]
    label = {"rates": "nmpc_controller.horizon", "density": "final_error_deg"}[name]
    j = next(k for k, each in enumerate(pair["y"]) if each["label"] == label)
    if name == "rates":
        other = np.where(other == 5, 0.0, 1.0)
    passed = column(table, "passed")
    edges = [pair["x"][0]["edges"], pair["y"][j]["edges"]]
    for k, counts in enumerate(pair["cells"][f"0,{j}"]):
        some = (passed == k) & np.isfinite(other)
        expected = np.histogram2d(angle[some], other[some], edges)[0]
        np.testing.assert_array_equal(np.reshape(counts, expected.T.shape), expected.T)


def test_failures_are_grouped_by_reason_with_a_command(report, campaign, table):
    rows = report.source.split('<h2 id="failures">')[1].split("<h2")[0]
    status = np.array(table["status"].to_pylist())
    assert f"<td>{np.count_nonzero(status == 'refused')}</td>" in rows  # reasons differ in numbers
    command = html.escape(
        f"gnc campaign rerun {shlex.quote(str(campaign.folder))} --run 5 --launch"
    )
    assert command in rows
    error, settled = column(table, "final_error_deg"), column(table, "settle_time_0.1deg")
    late = (status == "failed") & ~(settled < 100.0)
    for text, count in {
        'not met: "settle_time_0.1deg" < 100': late & (error < 0.1),
        "not met: final_error_deg < 0.1": ~late & (status == "failed"),
        'not met: final_error_deg < 0.1; "settle_time_0.1deg" < 100': late & ~(error < 0.1),
    }.items():
        row = next(each for each in rows.split("<tr>") if f">{html.escape(text)}</span>" in each)
        assert f"<td>{np.count_nonzero(count)}</td>" in row


def test_the_command_is_read_by_a_shell_as_it_is_meant(report, campaign):
    command = next(text for text in report.texts if text.startswith("gnc campaign rerun"))
    words = shlex.split(command)
    assert words[3] == str(campaign.folder)
    assert words[-1] == "--launch"


def test_worst_runs_are_the_largest_values(campaign, table):
    worst = {each.metric: each for each in read_data(campaign).worst}
    assert set(worst) == {"final_error_deg", "settle_time_0.1deg"}
    values = column(table, "final_error_deg")
    known = np.flatnonzero(np.isfinite(values))
    expected = known[np.argsort(-values[known], kind="stable")][:10]
    assert [each.run for each in worst["final_error_deg"].runs] == expected.tolist()
    ended = np.isfinite(values)
    missing = np.count_nonzero(ended & np.isnan(column(table, "settle_time_0.1deg")))
    assert worst["settle_time_0.1deg"].missing == missing


def test_what_has_no_diagram_is_told(campaign):
    data = read_data(campaign)
    assert data.undrawn["steps"] == "375"
    assert data.undrawn["min_zone_margin_deg"] == "no value in any run"
    assert "different texts" in data.undrawn["scenario_hash"]
    assert set(data.words["error_to"]) == {"reference", "target"}
    assert data.words["limits_exceeded"] == {"zone sun by # deg": 100}


def test_the_page_of_many_runs_and_columns_stays_small(tmp_path):
    """With every bin a histogram may have, and more metrics than are drawn."""
    campaign = made(tmp_path / "large", 30_000, metrics=70)
    text = report_html(campaign)
    assert len(text.encode()) < 10 * MEGABYTE
    report = Report(text)
    names = [chart["name"] for chart in report.data["charts"]]
    assert sum(name.startswith("metric-") for name in names) == MOST_CHARTS
    assert sum(name.startswith("rate-") for name in names) <= MOST_PARAMETERS
    assert len(report.pair("density")["cells"]) <= MOST_PAIRS
    assert f"the first {MOST_CHARTS} are drawn" in report.text


def test_a_campaign_that_is_not_complete_says_so(tmp_path):
    text = Report(report_html(made(tmp_path / "part", 400, done=40))).text
    assert "40 of 400 runs are done" in text


def test_a_design_that_is_not_random_says_so(tmp_path):
    campaign = made(tmp_path / "sobol", variations=f"sampling: sobol\n{VARIATIONS}")
    assert "a design of sampling sobol" in Report(report_html(campaign)).text


def test_a_campaign_without_results_is_refused(tmp_path):
    with pytest.raises(RecordingError, match="without results"):
        report_html(made(tmp_path / "empty", done=0))


@pytest.mark.parametrize("passes", ["final_error_deg < 1e-30", "final_error_deg < 1e30"])
def test_a_campaign_where_all_end_alike_has_a_report(tmp_path, passes):
    """One run is enough."""
    text = VARIATIONS[: VARIATIONS.index("pass:")] + f"pass: {passes}\n"
    assert "of 1 runs" in Report(report_html(made(tmp_path / "one", 1, variations=text))).text


def test_the_parts_of_a_criterion_are_as_they_are_written():
    text = '(a < 1 or b > 2) and "zone.x" > 0 and not c == 1'
    assert clauses_of(text) == ["a < 1 or b > 2", '"zone.x" > 0', "not c == 1"]
    assert clauses_of(" a < 1 or b > 2") == ["a < 1 or b > 2"]


def test_numbers_that_differ_late_have_two_ticks_with_their_digits():
    values = np.linspace(0.01000000121, 0.01000003323, 500)
    axis = value_axis("max_torque", binning(values))
    assert len(axis["tickvals"]) == 2
    np.testing.assert_allclose([float(text) for text in axis["ticktext"]], axis["tickvals"], 1e-9)
    assert len(set(axis["ticktext"])) == 2
    assert "tickvals" not in value_axis("cost", binning(values * np.arange(500)))


def named(name, values):
    return {each.name.removeprefix(f"{name}: "): each.values for each in features(name, values)}


def test_rotations_are_told_by_angle_and_vector():
    random = np.random.default_rng(1)
    vectors = random.normal(size=(50, 3))
    vectors *= (random.uniform(0.0, 3.1, 50) / np.linalg.norm(vectors, axis=1))[:, None]
    vectors[0] = 0.0
    angles = np.degrees(np.linalg.norm(vectors, axis=1))
    matrices = np.array([lie.exp(vector) for vector in vectors])
    quaternions = np.array([lie.to_quaternion_xyzw(matrix) for matrix in matrices])
    found = named("plant.attitude", matrices.reshape(-1, 9))
    for i, axis in enumerate("xyz"):
        np.testing.assert_allclose(found[f"rotation vector {axis}"], vectors[:, i], atol=1e-9)
    for values in (vectors, matrices.reshape(-1, 9), -quaternions):
        found = named("plant.initial_rotation_vector", values)
        np.testing.assert_allclose(found["angle [deg]"], angles, atol=1e-6)


def test_inertias_are_told_by_their_principal_values():
    random = np.random.default_rng(2)
    turned = np.linalg.qr(random.normal(size=(20, 3, 3)))[0]
    matrices = np.einsum("nij,j,nkj->nik", turned, [1.0, 2.0, 2.5], turned).reshape(20, 9)
    matrices[4] = np.nan
    found = named("plant.inertia", matrices)
    for which, value in zip(("least", "middle", "greatest"), (1.0, 2.0, 2.5), strict=True):
        expected = np.where(np.arange(20) == 4, np.nan, value)
        np.testing.assert_allclose(found[f"{which} principal value"], expected)


def test_vectors_are_told_by_norm_and_components():
    values = np.random.default_rng(3).normal(size=(9, 3))
    found = named("plant.initial_momentum", values)
    assert list(found) == ["norm", "x", "y", "z"]
    np.testing.assert_allclose(found["norm"], np.linalg.norm(values, axis=1))
    assert list(named("plant.torques", np.ones((4, 30)))) == ["norm"]


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([1.5, None, 2.0], [1.5, np.nan, 2.0]),
        ([1, None, 2], [1.0, np.nan, 2.0]),
        ([True, None, False], [1.0, np.nan, 0.0]),
        ([None, None], [np.nan, np.nan]),
        ([[1.0, 2.0], None, [3.0, 4.0]], [[1.0, 2.0], [np.nan, np.nan], [3.0, 4.0]]),
    ],
)
def test_columns_of_any_numbers_are_read(values, expected):
    np.testing.assert_array_equal(column_numbers(pa.chunked_array([values])), expected)


@pytest.mark.parametrize("values", [["a", None], [["a"], ["b"]], [[1.0], [1.0, 2.0]]])
def test_columns_of_words_and_of_uneven_lists_are_no_numbers(values):
    assert column_numbers(pa.chunked_array([values])) is None


def run(*words):
    """Run the command and return its exit code."""
    with pytest.raises(SystemExit) as end:
        main(["campaign", "report", *map(str, words)])
    return end.value.code


def test_the_command_writes_page_and_figures(campaign, tmp_path, capsys):
    page, figures = tmp_path / "r.html", tmp_path / "figures"
    assert run(campaign.folder, "-o", page, "--png", figures, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["bytes"] == page.stat().st_size
    assert told["success_rate"] == told["statuses"]["passed"] / 400
    assert told["interval"] == list(clopper_pearson(told["statuses"]["passed"], 400))
    names = ["distributions", "success", "success_map", "density"]
    assert sorted(figures.iterdir()) == sorted(figures / f"{name}.png" for name in names)
    for file in figures.iterdir():
        image = imread(file)
        assert image.shape[1] == 1260
        assert image[..., :3].std() > 0.05


def test_the_command_writes_into_the_folder_by_default(campaign, capsys):
    assert run(campaign.folder) == 0
    assert capsys.readouterr().out == f"{campaign.folder / 'report.html'}\n"


def test_a_folder_that_is_none_is_refused_in_one_line(tmp_path, capsys):
    assert run(tmp_path) == 2
    assert capsys.readouterr().err.count("\n") == 1
