"""The page of plans in a browser: no error, no network, every diagram drawn with its bounds."""

from __future__ import annotations

import numpy as np
import pytest
from analysis.report_pages import page
from browser import WINDOW, console_errors, requested_urls, wait_until
from transfer_cases import figure_4, paper_transfer

from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.vehicles.rigid_body.planner.file import save_plan

CURVES = """
return document.getElementById(arguments[0])._fullData.map(
  (trace) => ({ name: trace.name, axis: trace.yaxis, y: Array.from(trace.y) }));
"""
CHARTS = (
    "torque", "momentum", "co_momentum", "attitude_co_state", "torque_multipliers",
    "momentum_multipliers", "error", "attitude",
)  # fmt: skip
PLAN = TransferSolver().solve(figure_4())
OTHER = TransferSolver().solve(paper_transfer(60.0, (0.0, 1.0, 1.0), 20.0, torque=(-18.0, 20.0)))


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plans")
    one, two = save_plan(folder / "one.npz", PLAN), save_plan(folder / "two.npz", OTHER)
    return page(folder / "one.html", [one], ["one"]), page(folder / "b.html", [one, two], "ab")


def opened(browser, path):
    browser.set_window_size(*WINDOW)
    browser.get(path.as_uri())
    ready = "return document.documentElement.dataset.ready === 'true'"
    wait_until(browser, lambda: browser.execute_script(ready), "the page is drawn")
    return browser


def rows(curves, name):
    """Curves of a name by the row of their diagram."""
    return {one["axis"]: np.array(one["y"]) for one in curves if one["name"] == name}


@pytest.mark.parametrize("which", [0, 1], ids=["one", "two"])
def test_page_draws_everything_from_the_file_alone(module_browser, pages, which):
    browser = opened(module_browser, pages[which])
    assert console_errors(browser) == []
    assert requested_urls(browser) == [pages[which].as_uri()]
    for name in CHARTS:
        assert browser.execute_script(CURVES, name), name


def test_components_are_drawn_with_their_bounds(module_browser, pages):
    browser = opened(module_browser, pages[0])
    curves = browser.execute_script(CURVES, "torque")
    for j, (name, axis) in enumerate(zip("xyz", ("y", "y2", "y3"), strict=True)):
        drawn = rows(curves, name)[axis]
        assert np.array_equal(drawn, [*PLAN.torque[:, j], PLAN.torque[-1, j]])
        for bound in ("bound -20", "bound 20"):
            assert set(rows(curves, bound)[axis]) == {float(bound.split()[1])}
    curves = browser.execute_script(CURVES, "momentum")
    assert np.array_equal(rows(curves, "y")["y2"], PLAN.momentum[:, 1])
    assert set(rows(curves, "bound 70")["y3"]) == {70.0}


def test_co_state_of_the_attitude_is_constant_in_the_inertial_frame(module_browser, pages):
    browser = opened(module_browser, pages[0])
    curves = browser.execute_script(CURVES, "attitude_co_state")
    body = np.column_stack(
        [rows(curves, n)[a] for n, a in zip("xyz", ("y", "y2", "y3"), strict=True)]
    )
    inertial = np.einsum("kij,kj->ki", PLAN.attitude[1:], body[:-1])
    assert np.allclose(inertial, inertial[0], rtol=1e-12, atol=1e-12 * np.abs(inertial).max())
    first = PLAN.attitude[1] @ PLAN.zeta
    assert np.allclose(inertial[0], first, rtol=1e-12)


def test_two_plans_are_drawn_over_each_other_each_with_its_bounds(module_browser, pages):
    browser = opened(module_browser, pages[1])
    curves = browser.execute_script(CURVES, "torque")
    assert len(rows(curves, "a")["y"]) == 191
    assert len(rows(curves, "b")["y"]) == 201
    assert {one["name"] for one in curves} == {"a", "b", "bound -20", "bound -18", "bound 20"}
