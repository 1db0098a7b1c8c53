// The method of spacecraft_gnc.ocp in plain C++17: what the compiled kernels can be compared with.
//
// Newton's method on the conditions (31)-(38) of Gupta et al. 2015 in the multipliers lambda2_k of
// all stages: rollout, costates backward, one backward sweep for the step, backtracking on the
// residual. For weights s I, no zones, the identity as reference; no certificate of a minimum.
//
// floor SETTINGS_AND_STATES: a line of 9 + 8 + 3 numbers (inertia; h, q1, q2, q3, p1, p2, limit,
// penalty; horizon, tolerance, seconds), then a line of 12 numbers (R row-major, Pi) per state.
// Printed: a line per solve, "seconds u_x u_y u_z iterations solved".

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

#include "stage.hpp"

namespace {

// Second derivative of the cost to go in (eta, delta Pi), and what a stage keeps of its sweep.
struct Factors {
  Mat U, S_inverse, K1, K2, L1, L2;
};

struct Sweep {
  const Settings& s;
  std::vector<Stage> stages;
  std::vector<Factors> factors;
  std::vector<Vec> guess, trial, residual, step;

  explicit Sweep(const Settings& settings)
      : s(settings), stages(s.N + 1), factors(s.N), guess(s.N), trial(s.N), residual(s.N),
        step(s.N) {}

  // Rollout under the controls of `g`, costates (34)-(37) backward; the norm of lambda2 - g.
  double evaluate(const std::vector<Vec>& g) {
    for (int k = 0; k < s.N; ++k) {
      Stage& a = stages[k];
      relative_rotation(s, a.Pi, a.F, a.p);
      a.M = momentum_map(s, a.F);
      a.A = transpose(a.F) + hat(a.p) * a.M;
      control(s, g[k], a.u, a.sigma);
      stages[k + 1].R = a.R * a.F;
      stages[k + 1].Pi = a.p + s.h * a.u;
    }
    const Stage& end = stages[s.N];
    Vec l1 = s.p1 * vee(transpose(end.R)), l2 = -s.p2 * end.Pi;
    double total = 0.0;
    for (int k = s.N - 1; k >= 0; --k) {
      Stage& a = stages[k];
      a.l1 = l1;
      a.l2 = l2;
      residual[k] = l2 - g[k];
      total += dot(residual[k], residual[k]);
      l2 = mul_t(a.A, l2) + mul_t(a.M, l1) - (s.h * s.q2) * a.Pi;
      l1 = a.F * l1 + (s.h * s.q1) * vee(transpose(a.R));
    }
    return std::sqrt(total);
  }

  // delta lambda_k = -V_k delta x_{k+1} + v_k, backward.
  void factorize() {
    Mat V11 = (0.5 * s.p1) * trace_minus(transpose(stages[s.N].R));
    Mat V12 = identity(0), V21 = identity(0), V22 = identity(s.p2);
    for (int k = s.N - 1; k >= 0; --k) {
      const Stage& a = stages[k];
      Factors& f = factors[k];
      const Mat Ft = transpose(a.F), Mt = transpose(a.M), At = transpose(a.A);
      f.U = control_sensitivity(s, a);
      f.L2 = s.h * (V22 * f.U);
      f.S_inverse = inverse(identity(1) + f.L2);
      const Mat Y11 = V11 * Ft, Y21 = V21 * Ft;
      const Mat Y12 = V11 * a.M + V12 * a.A, Y22 = V21 * a.M + V22 * a.A;
      f.K1 = f.S_inverse * Y21;
      f.K2 = f.S_inverse * Y22;
      if (k == 0) return;
      f.L1 = s.h * (V12 * f.U);
      const Mat X11 = Y11 - f.L1 * f.K1, X12 = Y12 - f.L1 * f.K2;
      const Mat X21 = Y21 - f.L2 * f.K1, X22 = Y22 - f.L2 * f.K2;
      V11 = a.F * X11 + (0.5 * s.h * s.q1) * trace_minus(transpose(a.R));
      V12 = a.F * (X12 + hat(a.l1) * a.M);
      V21 = Mt * X11 + At * X21;
      V22 = Mt * X12 + At * X22 + curvature(a);
    }
  }

  // Changes of F, M and p in (36) at fixed multipliers, and the weight of the momentum.
  Mat curvature(const Stage& a) const {
    const Vec w = a.l1 - cross(a.p, a.l2);
    const Vec z = mul_t(a.F, (1.0 / s.h) * mul_t(a.M, w));
    const Mat FtJd = transpose(a.F) * s.Jd;
    const Mat K = FtJd * hat(z) - hat(w) - outer(z, 2.0 * vee(FtJd));
    const Mat bent = K * a.M + hat(a.l2) * a.A;
    return identity(s.h * s.q2) + a.F * (hat(a.l2) * a.M) - transpose(a.M) * bent;
  }

  // The Newton step: backward for the feedforward, forward for the change of the guess.
  void substitute() {
    Vec v1{0, 0, 0}, v2{0, 0, 0};
    for (int k = s.N - 1; k >= 0; --k) {
      const Stage& a = stages[k];
      const Factors& f = factors[k];
      step[k] = f.S_inverse * (residual[k] - v2);
      if (k == 0) break;
      const Vec w1 = v1 + f.L1 * step[k], w2 = v2 + f.L2 * step[k];
      v1 = a.F * w1;
      v2 = mul_t(a.M, w1) + mul_t(a.A, w2);
    }
    Vec eta{0, 0, 0}, d_Pi{0, 0, 0};
    for (int k = 0; k < s.N; ++k) {
      const Stage& a = stages[k];
      const Factors& f = factors[k];
      step[k] = step[k] - f.K1 * eta - f.K2 * d_Pi;
      eta = mul_t(a.F, eta) + a.M * d_Pi;
      d_Pi = a.A * d_Pi + s.h * (f.U * step[k]);
    }
  }

  bool solve(const Stage& start, int& iterations) {
    stages[0].R = start.R;
    stages[0].Pi = start.Pi;
    double norm = evaluate(guess);
    for (iterations = 0; norm > s.tolerance; ++iterations) {
      if (iterations == 50) return false;
      factorize();
      substitute();
      double found = norm, gamma = 1.0;
      do {
        if (gamma < 1e-7) return false;
        for (int k = 0; k < s.N; ++k) trial[k] = guess[k] + gamma * step[k];
        found = evaluate(trial);
        gamma *= 0.5;
      } while (!(found <= (1.0 - 2e-4 * gamma) * norm));
      std::swap(guess, trial);
      norm = found;
    }
    return true;
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::ifstream file(argv[1]);
  Settings s;
  for (double& x : s.J.a) file >> x;
  file >> s.h >> s.q1 >> s.q2 >> s.q3 >> s.p1 >> s.p2 >> s.limit >> s.penalty;
  file >> s.N >> s.tolerance >> s.seconds;
  if (!file || s.N < 1) return 3;
  s.prepare();
  std::vector<Stage> states;
  Stage state{};
  while (file >> state.R.a[0]) {
    for (int i = 1; i < 9; ++i) file >> state.R.a[i];
    file >> state.Pi.x >> state.Pi.y >> state.Pi.z;
    states.push_back(state);
  }
  Sweep sweep(s);
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;
  const auto begun = Clock::now();
  do {
    for (Vec& g : sweep.guess) g = {0, 0, 0};
    for (const Stage& start : states) {
      int iterations = 0;
      const auto tic = Clock::now();
      const bool solved = sweep.solve(start, iterations);
      const double elapsed = Seconds(Clock::now() - tic).count();
      const Vec u = sweep.stages[0].u;
      std::printf("%.9g %.17g %.17g %.17g %d %d\n", elapsed, u.x, u.y, u.z, iterations, solved);
      for (int k = 0; k < s.N; ++k)  // shifted by one step
        sweep.guess[k] = solved ? sweep.stages[std::min(k + 1, s.N - 1)].l2 : Vec{0, 0, 0};
    }
  } while (Seconds(Clock::now() - begun).count() < s.seconds);
  return 0;
}
