"""Time acados: SQP with the exact or the Gauss-Newton Hessian, or real-time iterations.

The wheel `comma-deps-acados` brings libraries, headers and a CasADi of its own; the solver is
generated and compiled (by make and gcc) in the working directory.
"""

from __future__ import annotations

import os
import sys
from importlib import util
from pathlib import Path

import numpy as np
from common import Problem, Vector, main, quaternion

WHEEL = Path(str(util.find_spec("acados").origin)).parent


def source_tree(root: Path) -> Path:
    """Lay out links to the wheel's files as in acados' source tree: its Makefile expects that."""
    (root / "include").mkdir(parents=True)
    for header in (WHEEL / "install" / "include").iterdir():
        (root / "include" / header.name).symlink_to(header)
    for name in ("lib", "bin"):
        (root / name).symlink_to(WHEEL / "install" / name)
    (root / "interfaces" / "acados_template").mkdir(parents=True)
    (root / "interfaces" / "acados_template" / "acados_template").symlink_to(
        WHEEL / "acados_template"
    )
    return root


if "ACADOS_SOURCE_DIR" not in os.environ:
    os.environ["ACADOS_SOURCE_DIR"] = str(source_tree(Path.cwd() / "acados_source"))
    os.environ["LD_LIBRARY_PATH"] = str(WHEEL / "install" / "lib")
    os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    os.execv(sys.executable, [sys.executable, *sys.argv])  # noqa: S606  the loader reads it once

from acados.acados_template import AcadosModel, AcadosOcp, AcadosOcpSolver  # noqa: E402
from casadi import SX, dot  # noqa: E402
from symbolic import step  # noqa: E402

COST_SCALE = 1e3  # the optimal cost is of the order 1e-2
FLAGS = "-O3 -march=native"
OPTIONS = {
    "exact": {"nlp_solver_type": "SQP", "hessian_approx": "EXACT"},
    "gauss_newton": {"nlp_solver_type": "SQP", "hessian_approx": "GAUSS_NEWTON"},
    "rti": {"nlp_solver_type": "SQP_RTI", "hessian_approx": "EXACT"},
}
TOLERANCE = 1e-8
DENSE, CONVEX = 10, 20  # [steps]: up to where each is the better choice


class Acados:
    """Multiple shooting in (quaternion, momentum) with the torque limit as a constraint."""

    def __init__(self, problem: Problem, variant: str, **options: object) -> None:
        name = variant.replace("_", "-")
        self.formulation = (
            f"{name}: limit as a constraint |u|^2 <= max_torque^2, multiple shooting in "
            f"(quaternion, momentum), discrete dynamics, least squares cost, {_qp_solver(problem)}"
        )
        self.tolerance = "one iteration" if variant == "rti" else f"{TOLERANCE:g} on all residuals"
        self.scale, self.count = problem.max_torque, problem.horizon
        ocp = _ocp(problem)
        for key, value in (OPTIONS[variant] | options).items():
            setattr(ocp.solver_options, key, value)
        self.solver = _built(ocp)
        self.rti = variant == "rti"
        self.cold = True
        self.reset()

    def reset(self) -> None:
        """Forget the last solution."""
        for k in range(self.count + 1):
            self.solver.set(k, "x", np.zeros(6))
            if k < self.count:
                self.solver.set(k, "u", np.zeros(3))
                self.solver.set(k, "pi", np.zeros(6))
            self.solver.set(k, "lam", 0.0 * self.solver.get(k, "lam"))
        self.cold = True

    def solve(self, attitude: Vector, momentum: Vector) -> Vector:
        """Solve from the last solution."""
        state = np.array([*quaternion(attitude), *momentum.tolist()])
        self.solver.set(0, "lbx", state)
        self.solver.set(0, "ubx", state)
        # A real-time iteration needs a solution to start from.
        for _ in range(20 if self.rti and self.cold else 1):
            self.status = self.solver.solve()
        self.cold = False
        return self.scale * self.solver.get(0, "u")

    def outcome(self) -> tuple[int, bool]:
        """Return the SQP iterations and whether they converged."""
        return int(np.ravel(self.solver.get_stats("sqp_iter"))[0]), self.status == 0


def _qp_solver(problem: Problem) -> str:
    short = problem.horizon <= DENSE
    return "FULL_CONDENSING_QPOASES" if short else "PARTIAL_CONDENSING_HPIPM"


def _ocp(problem: Problem) -> AcadosOcp:
    x, v = SX.sym("x", 6), SX.sym("v", 3)
    model = AcadosModel()
    model.name = "case1"
    model.x, model.u = x, v
    model.disc_dyn_expr = step(problem, x, problem.max_torque * v)
    model.con_h_expr = dot(v, v)
    ocp = AcadosOcp()
    ocp.model = model
    ocp.dims.N = problem.horizon
    _set_cost(ocp, problem)
    ocp.constraints.x0 = np.zeros(6)
    ocp.constraints.lh, ocp.constraints.uh = np.array([-1.0]), np.array([1.0])
    options = ocp.solver_options
    options.integrator_type = "DISCRETE"
    options.tf = float(problem.horizon)  # acados multiplies the stage cost by the time step: 1
    # The dense active-set solver is the faster one while the horizon is short; with a long horizon
    # the exact Hessian is indefinite on the way and has to be regularized.
    options.qp_solver = _qp_solver(problem)
    if problem.horizon > CONVEX:
        options.regularize_method = "MIRROR"
    options.qp_solver_warm_start = 1
    options.nlp_solver_max_iter = 100
    options.nlp_solver_tol_stat = options.nlp_solver_tol_eq = TOLERANCE
    options.nlp_solver_tol_ineq = options.nlp_solver_tol_comp = TOLERANCE
    options.print_level = 0
    options.ext_fun_compile_flags = FLAGS
    return ocp


def _set_cost(ocp: AcadosOcp, problem: Problem) -> None:
    """State the cost as 1/2 |y|_W^2 with y = (x, v); see `symbolic` on why it is a square."""
    p, h, ones = problem, problem.time_step, np.ones(3)
    effort = h * p.stage_torque * p.max_torque**2
    stage = [h * 4 * p.stage_attitude * ones, h * p.stage_momentum * ones, effort * ones]
    end = [4 * p.terminal_attitude * ones, p.terminal_momentum * ones]
    cost = ocp.cost
    cost.cost_type = cost.cost_type_e = "LINEAR_LS"
    cost.W = 2 * COST_SCALE * np.diag(np.concatenate(stage))
    cost.W_e = 2 * COST_SCALE * np.diag(np.concatenate(end))
    cost.Vx, cost.Vu, cost.Vx_e = np.eye(9, 6), np.eye(9, 3, -6), np.eye(6)
    cost.yref, cost.yref_e = np.zeros(9), np.zeros(6)


def _built(ocp: AcadosOcp) -> object:
    """Generate and compile the solver; the Cython interface costs less than the ctypes one."""
    ocp.code_export_directory = "c_generated_code"
    if util.find_spec("Cython") is None:
        return AcadosOcpSolver(ocp, json_file="ocp.json", verbose=False)
    AcadosOcpSolver.generate(ocp, json_file="ocp.json")
    AcadosOcpSolver.build(ocp.code_export_directory, with_cython=True, verbose=False)
    sys.path.insert(0, str(Path.cwd()))
    return AcadosOcpSolver.create_cython_solver("ocp.json")


if __name__ == "__main__":
    main(Acados)
