"""The closed loop of Gupta's Case I against its published and independent figures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import _lgvi_kernels
from spacecraft_gnc.errors import ParameterError, RecordingError
from spacecraft_gnc.loop import ClosedLoop, Source
from spacecraft_gnc.ocp import (
    NeighboringExtremal,
    Status,
    _neighboring_kernels,
    _solve_kernels,
    _sweep_kernels,
)
from spacecraft_gnc.vehicles.rigid_body.flight import RigidBodyFlight
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant

REFERENCE = Path(__file__).parents[1] / "data" / "gupta2015_case1_ipopt.npz"


def test_case_1_reaches_its_figures(build):
    trajectory = build().run()
    assert trajectory.n_steps == 375
    assert trajectory.time[-1] == pytest.approx(149.6)
    error = np.degrees(lie.angle_between(trajectory.final_attitude, np.eye(3)))
    assert error == pytest.approx(0.21364, abs=1e-4)  # PAPER_NOTES
    assert np.linalg.norm(trajectory.final_momentum) == pytest.approx(4.14e-4, abs=1e-6)
    norms = np.linalg.norm(trajectory.torque, axis=1)
    assert norms.max() == pytest.approx(0.01, abs=1e-8)
    assert np.count_nonzero(norms > 0.01 - 1e-9) == 32
    assert trajectory.iterations[0] == 3
    assert np.median(trajectory.iterations) == 2
    assert trajectory.iterations.max() == 3
    assert set(trajectory.status) == {Status.CONVERGED}
    assert set(trajectory.source) == {Source.OPTIMAL}
    assert trajectory.cost[0] == pytest.approx(0.01587107410188242, abs=1e-12)


def test_case_1_equals_the_solution_of_casadi_and_ipopt(build):
    trajectory = build().run()
    with np.load(REFERENCE) as ipopt:
        assert np.abs(trajectory.torque - ipopt["torque"]).max() < 1e-9
        assert np.abs(trajectory.momentum - ipopt["momentum"][:-1]).max() < 1e-9
        assert np.abs(trajectory.attitude - ipopt["attitude"][:-1]).max() < 1e-9


def test_two_runs_of_one_loop_are_equal_bit_for_bit(build):
    loop = build(50)
    first, second = loop.run(), loop.run()
    assert np.array_equal(first.torque, second.torque)
    assert np.array_equal(first.final_attitude, second.final_attitude)


class OwnPlant(RigidBodyPlant):
    """A plant that may do anything in a step."""


def test_progress_is_told_after_every_step_that_is_flown_by_itself(build):
    seen, loop = [], build(5)
    loop.plant = OwnPlant(loop.plant.body, np.eye(3), np.zeros(3), 5)
    loop.run(lambda step, n: seen.append((step, n)))
    assert seen == [(k, 5) for k in range(1, 6)]


def test_a_finer_integrator_changes_little(build):
    coarse, fine = build(50).run(), build(50, substeps=10).run()
    assert fine.period == pytest.approx(coarse.period)
    difference = lie.angle_between(coarse.final_attitude, fine.final_attitude)
    assert 1e-6 < difference < 0.05


def test_periods_must_agree(build):
    loop, other = build(5), build(5)
    loop.controller.period = 0.5
    with pytest.raises(ParameterError, match=r"0\.5 s.*0\.4"):
        ClosedLoop(other.plant, loop.controller, loop.governor)


def test_a_flight_survives_the_disk(build, tmp_path):
    trajectory = build(10).run()
    back = RigidBodyFlight.load(trajectory.save(tmp_path / "flight.npz"))
    assert back.period == trajectory.period
    for name in ("time", "attitude", "torque", "status", "final_attitude"):
        assert np.array_equal(getattr(back, name), getattr(trajectory, name))
    assert RigidBodyFlight.load_scenario(tmp_path / "flight.npz") == ""


def test_a_flight_keeps_the_text_of_its_scenario(build, tmp_path):
    text = "plant:\n  ros__parameters:\n    # Größe\n    duration: 4.0\n"
    file = build(2).run().save(tmp_path / "flight.npz", text)
    assert RigidBodyFlight.load_scenario(file) == text
    assert RigidBodyFlight.load(file).n_steps == 2
    whole = file.read_bytes()
    at = whole.index(b"scenario.npy") + 60  # in its compressed content
    file.write_bytes(whole[:at] + b"\xff" * 8 + whole[at + 8 :])
    with pytest.raises(RecordingError, match="gnc simulate"):
        RigidBodyFlight.load_scenario(file)


def test_a_file_is_written_whole_or_not_at_all(build, tmp_path):
    with pytest.raises(RecordingError, match="writable folder"):
        build(2).run().save(tmp_path / "missing" / "flight.npz")
    (tmp_path / "taken.npz").mkdir()
    with pytest.raises(RecordingError, match="cannot be written"):
        build(2).run().save(tmp_path / "taken.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["taken.npz"]


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 torn", b"text"])
def test_a_file_that_is_no_flight_is_refused(tmp_path, content):
    path = tmp_path / "flight.npz"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match="gnc simulate"):
        RigidBodyFlight.load(path)
    with pytest.raises(RecordingError):
        RigidBodyFlight.load(tmp_path / "absent.npz")


def test_nothing_is_compiled_after_warm_up(build):
    """No new signature, whatever the arrays are like: one would cost half a minute."""
    kernels = (
        _lgvi_kernels.advance, _solve_kernels.solve, _sweep_kernels.factorize,
        _neighboring_kernels.correct, _solve_kernels.solve_batch,
    )  # fmt: skip
    loop, R, Pi = build(3), np.eye(3), np.zeros(3)
    solver = loop.controller.solver
    near = NeighboringExtremal(solver.ocp)
    loop.controller.warm_up()
    loop.plant.warm_up()
    near.warm_up()
    solver.solve_batch(R[None], Pi[None])
    # Not one each: kernels that others call count those calls, where they were compiled just now.
    before = [len(kernel.signatures) for kernel in kernels]
    assert min(before) >= 1
    loop.run()
    frozen = np.zeros((5, 6))
    frozen.setflags(write=False)
    for attitude in (R.tolist(), np.asfortranarray(R), R.astype(np.float32), R[::1, ::1].T):
        starts = (None, frozen, np.zeros((6, 5)).T, np.zeros((5, 6), np.float32), [[0] * 6] * 5)
        for start in starts:
            assert solver.solve(attitude, Pi.tolist(), R.T, start).converged
            assert near.solve(attitude, Pi[::-1], R.T, start).converged
            many = None if start is None else [start]
            assert solver.solve_batch([attitude], [Pi], R.T, many).converged.all()
    assert [len(kernel.signatures) for kernel in kernels] == before
