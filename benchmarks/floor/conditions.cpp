// The residual (44) of Gupta et al. 2015 as a function of the first multipliers, for
// benchmarks/peers/fsolve.py, which differentiates it by finite differences.

#include <vector>

#include "stage.hpp"

namespace {

constexpr int MAX_HORIZON = 128;

struct Residual {
  Vec e1, e2;
};

// (31)-(34), (36), (38) forward from multipliers; (44) at the end.
Residual propagate(const Settings& s, std::vector<Stage>& stages, Vec l1, Vec l2) {
  for (int k = 0; k < s.N; ++k) {
    Stage& a = stages[k];
    relative_rotation(s, a.Pi, a.F, a.p);
    if (k > 0) {
      a.M = momentum_map(s, a.F);
      l1 = mul_t(a.F, l1 - (s.h * s.q1) * vee(transpose(a.R)));
      const Mat C = a.F + transpose(hat(a.p) * a.M);
      l2 = inverse(C) * (l2 + (s.h * s.q2) * a.Pi - mul_t(a.M, l1));
    }
    a.l1 = l1;
    a.l2 = l2;
    control(s, l2, a.u, a.sigma);
    stages[k + 1].R = a.R * a.F;
    stages[k + 1].Pi = a.p + s.h * a.u;
  }
  const Stage& end = stages[s.N];
  return {l1 - s.p1 * vee(transpose(end.R)), l2 + s.p2 * end.Pi};
}

}  // namespace

// Settings as in the file of floor.cpp, a state (R row-major, Pi) and 6 multipliers; `out` receives
// the 6 residuals, the first torque, the multipliers one step later.
extern "C" void conditions(const double* settings, const double* state, const double* multipliers,
                           double* out) {
  Settings s;
  for (int i = 0; i < 9; ++i) s.J.a[i] = settings[i];
  const double* n = settings + 9;
  s.h = n[0], s.q1 = n[1], s.q2 = n[2], s.q3 = n[3], s.p1 = n[4], s.p2 = n[5];
  s.limit = n[6], s.penalty = n[7], s.N = static_cast<int>(n[8]);
  s.prepare();
  static std::vector<Stage> stages(MAX_HORIZON + 1);
  for (int i = 0; i < 9; ++i) stages[0].R.a[i] = state[i];
  stages[0].Pi = {state[9], state[10], state[11]};
  const double* m = multipliers;
  const Residual r = propagate(s, stages, {m[0], m[1], m[2]}, {m[3], m[4], m[5]});
  const Stage& next = stages[s.N > 1 ? 1 : 0];
  const Vec values[5] = {r.e1, r.e2, stages[0].u, next.l1, next.l2};
  for (int i = 0; i < 5; ++i) {
    out[3 * i] = values[i].x;
    out[3 * i + 1] = values[i].y;
    out[3 * i + 2] = values[i].z;
  }
}
