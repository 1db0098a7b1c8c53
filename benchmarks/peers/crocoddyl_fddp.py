"""Time crocoddyl's FDDP with an action model in Python over functions compiled by CasADi."""

from __future__ import annotations

import casadi as ca
import crocoddyl
import numpy as np
from common import Problem, Vector, main, quaternion
from nlp import COMPILED, COST_SCALE
from symbolic import penalty, stage_cost, step, terminal_cost

STOP = 1e-14  # of the sum of squared gradients, cost scaled


class Compiled:
    """A CasADi function on buffers of its own: a call then costs a microsecond."""

    def __init__(self, name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> None:
        function = ca.Function(name, inputs, [ca.densify(y) for y in outputs], COMPILED)
        self.arguments = [np.zeros(x.shape[0]) for x in inputs]
        flat = [np.zeros(y.numel()) for y in outputs]
        self.results = [x.reshape(y.shape, order="F") for x, y in zip(flat, outputs, strict=True)]
        self._buffer, self._call = function.buffer()
        for i, x in enumerate(self.arguments):
            self._buffer.set_arg(i, memoryview(x))
        for i, y in enumerate(flat):
            self._buffer.set_res(i, memoryview(y))

    def __call__(self, *arguments: Vector) -> list[Vector]:
        """Return the outputs; they are overwritten by the next call."""
        for own, x in zip(self.arguments, arguments, strict=False):
            own[:] = x
        self._call()
        return self.results


class Stage(crocoddyl.ActionModelAbstract):
    """One step: dynamics and cost, or the cost at the end."""

    def __init__(self, problem: Problem, last: bool) -> None:
        super().__init__(crocoddyl.StateVector(6), 0 if last else 3, 0)
        x, v = ca.SX.sym("x", 6), ca.SX.sym("v", 3)
        torque = problem.max_torque * v
        cost = stage_cost(problem, x, torque) + penalty(problem, torque)
        following = step(problem, x, torque)
        if last:
            cost, following = terminal_cost(problem, x), x
        cost = COST_SCALE * cost
        z = ca.vertcat(x, v)
        hessian, gradient = ca.hessian(cost, z)
        slope = ca.jacobian(following, z)
        outputs = [slope[:, :6], slope[:, 6:], gradient[:6], gradient[6:]]
        outputs += [hessian[:6, :6], hessian[:6, 6:], hessian[6:, 6:]]
        self.values = Compiled("values", [x, v], [following, cost])
        self.slopes = Compiled("slopes", [x, v], outputs)
        self.last = last

    def calc(self, data: object, x: Vector, u: Vector | None = None) -> None:
        """Evaluate step and cost."""
        following, cost = self.values(x) if u is None or self.last else self.values(x, u)
        data.xnext, data.cost = following[:, 0], cost[0, 0]

    def calcDiff(self, data: object, x: Vector, u: Vector | None = None) -> None:  # noqa: N802
        """Evaluate their derivatives."""
        if u is None or self.last:
            results = self.slopes(x)
            data.Lx, data.Lxx = results[2][:, 0], results[4]
            return
        data.Fx, data.Fu, lx, lu, data.Lxx, data.Lxu, data.Luu = self.slopes(x, u)
        data.Lx, data.Lu = lx[:, 0], lu[:, 0]


class Fddp:
    """Warm-started from its last trajectory, shifted."""

    formulation = (
        "penalized, (quaternion, momentum), action model in Python over functions compiled by gcc "
        "-O3; FDDP leaves the second derivatives of the dynamics out"
    )
    tolerance = f"th_stop {STOP:g}, cost scaled by 1e3"

    def __init__(self, problem: Problem) -> None:
        self.scale, self.count = problem.max_torque, problem.horizon
        stages = [Stage(problem, last=False)] * problem.horizon
        self.shooting = crocoddyl.ShootingProblem(np.zeros(6), stages, Stage(problem, last=True))
        self.solver = crocoddyl.SolverFDDP(self.shooting)
        self.solver.th_stop = STOP
        self.reset()

    def reset(self) -> None:
        """Forget the last trajectory."""
        self.states: list[Vector] = [np.zeros(6)] * (self.count + 1)
        self.controls: list[Vector] = [np.zeros(3)] * self.count
        self.cold = True

    def solve(self, attitude: Vector, momentum: Vector) -> Vector:
        """Solve from the last trajectory, shifted."""
        state = np.array([*quaternion(attitude), *momentum.tolist()])
        self.shooting.x0 = state
        self.states[0] = state
        self.solved = self.solver.solve(self.states, self.controls, 200, False, 1e-9)
        controls, states = list(self.solver.us), list(self.solver.xs)
        self.controls = [*controls[1:], controls[-1]]
        self.states = [*states[1:], states[-1]]
        return self.scale * np.array(controls[0])

    def outcome(self) -> tuple[int, bool]:
        """Return the iterations and whether the criterion was met."""
        return self.solver.iter, self.solved


if __name__ == "__main__":
    main(Fddp)
