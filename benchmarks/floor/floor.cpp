// The method of spacecraft_gnc.ocp in plain C++17: what the compiled kernels can be compared with.
//
// Indirect single shooting on the conditions (31)-(45) of Gupta et al. 2015 with analytic
// sensitivities and backtracking, for weights s I, no zones and the identity as reference. Built as
// a program it times itself over the states of a text file; built as a shared library
// (`conditions`) it is the compiled residual that benchmarks/peers/fsolve.py differentiates by
// finite differences.
//
// floor SETTINGS_AND_STATES: a line of 9 + 8 + 3 numbers (inertia; h, q1, q2, q3, p1, p2, limit,
// penalty; horizon, tolerance, seconds), then a line of 12 numbers (R row-major, Pi) per state.
// Printed: a line per solve, "seconds u_x u_y u_z iterations solved".

#include "algebra.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

namespace {

constexpr int MAX_HORIZON = 128;

struct Settings {
  Mat J;
  double h, q1, q2, q3, p1, p2, limit, penalty;
  int N;
  double tolerance, seconds;
  Mat J_inverse, Jd;

  void prepare() {
    J_inverse = inverse(J);
    Jd = identity(0.5 * trace(J)) - J;
  }
};

struct Stage {
  Mat R, F, M;
  Vec Pi, p, l1, l2, u;
  double sigma;
};

// 2 q0 J q + 2 q x (J q) = h Pi, divided by 2 q0^2: J g + g x J g = (1 + g.g) h Pi / 2, g = q / q0.
inline void relative_rotation(const Settings& s, Vec Pi, Mat& F, Vec& p) {
  const Vec b = (0.5 * s.h) * Pi;
  Vec g = s.J_inverse * b;
  for (int i = 0; i < 20; ++i) {
    const Vec Jg = s.J * g;
    const Vec r = Jg + cross(g, Jg) - (1.0 + dot(g, g)) * b;
    const Mat D = s.J + hat(g) * s.J - hat(Jg) - 2.0 * outer(b, g);
    const Vec step = inverse(D) * r;
    g = g - step;
    if (dot(step, step) < 1e-18) break;  // converges quadratically: the next one is below 1e-16
  }
  const double c = 2.0 / (1.0 + dot(g, g));
  F = identity(c - 1.0) + c * (outer(g, g) + hat(g));
  p = mul_t(F, Pi);
}

// (38) for Q3 = q3 I: s (q3 + 2 mu0 (s^2 - limit^2)) = |lambda2| for s = |u|, by Newton.
inline void control(const Settings& s, Vec l2, Vec& u, double& sigma) {
  const double y = std::sqrt(dot(l2, l2));
  sigma = 0.0;
  if (s.limit <= 0.0 || y <= s.q3 * s.limit) {
    u = (1.0 / s.q3) * l2;
    return;
  }
  double t = 0.0;  // |u| - limit, kept apart from the limit against cancellation
  for (int i = 0; i < 50; ++i) {
    const double size = s.limit + t;
    sigma = 2.0 * s.penalty * t * (s.limit + size);
    const double step = (size * (s.q3 + sigma) - y) / (s.q3 + sigma + 4.0 * s.penalty * size * size);
    t -= step;
    if (std::fabs(step) <= 1e-10 * t) break;
  }
  sigma = 2.0 * s.penalty * t * (2.0 * s.limit + t);
  u = (1.0 / (s.q3 + sigma)) * l2;
}

struct Residual {
  Vec e1, e2;
  double norm() const { return std::sqrt(dot(e1, e1) + dot(e2, e2)); }
};

// (31)-(34), (36), (38) forward from multipliers; (44) at the end.
Residual propagate(const Settings& s, std::vector<Stage>& stages, Vec l1, Vec l2) {
  for (int k = 0; k < s.N; ++k) {
    Stage& a = stages[k];
    relative_rotation(s, a.Pi, a.F, a.p);
    if (k > 0) {
      a.M = s.h * (transpose(a.F) * inverse(trace_minus(a.F * s.Jd)));
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

inline Mat control_sensitivity(const Settings& s, const Stage& a) {
  const double w = 1.0 / (s.q3 + a.sigma);
  if (a.sigma <= 0.0) return identity(w);
  const double d = 0.25 / s.penalty + w * dot(a.u, a.u);
  return identity(w) - (w * w / d) * outer(a.u, a.u);
}

// Derivative of (44) to the first multipliers by (39)-(45): rows of E are e1, e2.
void jacobian(const Settings& s, const std::vector<Stage>& stages, double (&E)[6][7]) {
  Mat eta[2] = {identity(0), identity(0)}, d_l1[2] = {identity(1), identity(0)},
      d_l2[2] = {identity(0), identity(1)};
  const Mat U0 = s.h * control_sensitivity(s, stages[0]);
  Mat d_Pi[2] = {identity(0), U0};
  for (int k = 1; k < s.N; ++k) {
    const Stage& a = stages[k];
    const Mat Ft = transpose(a.F), Mt = transpose(a.M);
    const Mat A = Ft + hat(a.p) * a.M, C_inverse = inverse(transpose(A));
    const Mat G = (0.5 * s.h * s.q1) * trace_minus(transpose(a.R));
    const Mat D = hat(a.l1) * a.M;
    const Vec w = a.l1 - cross(a.p, a.l2);
    const Vec z = mul_t(a.F, (1.0 / s.h) * mul_t(a.M, w));
    const Mat FtJd = Ft * s.Jd;
    const Mat K = FtJd * hat(z) - hat(w) - outer(z, 2.0 * vee(FtJd));
    const Mat Z = identity(s.h * s.q2) + a.F * (hat(a.l2) * a.M) - Mt * (K * a.M + hat(a.l2) * A);
    const Mat hU = s.h * control_sensitivity(s, a);
    for (int j = 0; j < 2; ++j) {
      d_l1[j] = Ft * (d_l1[j] + G * eta[j]) + D * d_Pi[j];
      d_l2[j] = C_inverse * (d_l2[j] - Mt * d_l1[j] + Z * d_Pi[j]);
      eta[j] = Ft * eta[j] + a.M * d_Pi[j];
      d_Pi[j] = A * d_Pi[j] + hU * d_l2[j];
    }
  }
  const Mat bend = (0.5 * s.p1) * trace_minus(transpose(stages[s.N].R));
  for (int j = 0; j < 2; ++j) {
    const Mat e1 = d_l1[j] + bend * eta[j], e2 = d_l2[j] + s.p2 * d_Pi[j];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        E[r][3 * j + c] = e1.a[3 * r + c];
        E[r + 3][3 * j + c] = e2.a[3 * r + c];
      }
  }
}

// Gaussian elimination with partial pivoting; the last column of E becomes the solution.
void eliminate(double (&E)[6][7]) {
  for (int i = 0; i < 6; ++i) {
    int pivot = i;
    for (int r = i + 1; r < 6; ++r)
      if (std::fabs(E[r][i]) > std::fabs(E[pivot][i])) pivot = r;
    for (int c = i; c < 7; ++c) std::swap(E[i][c], E[pivot][c]);
    for (int r = i + 1; r < 6; ++r) {
      const double f = E[r][i] / E[i][i];
      for (int c = i + 1; c < 7; ++c) E[r][c] -= f * E[i][c];
    }
  }
  for (int i = 5; i >= 0; --i) {
    for (int c = i + 1; c < 6; ++c) E[i][6] -= E[i][c] * E[c][6];
    E[i][6] /= E[i][i];
  }
}

bool newton(const Settings& s, std::vector<Stage>& stages, Vec& l1, Vec& l2, int& iterations) {
  Residual r = propagate(s, stages, l1, l2);
  double norm = r.norm();
  for (iterations = 0; iterations < 50; ++iterations) {
    if (norm <= s.tolerance) return true;
    double E[6][7];
    jacobian(s, stages, E);
    const double b[6] = {r.e1.x, r.e1.y, r.e1.z, r.e2.x, r.e2.y, r.e2.z};
    for (int i = 0; i < 6; ++i) E[i][6] = b[i];
    eliminate(E);
    const Vec d1 = {E[0][6], E[1][6], E[2][6]}, d2 = {E[3][6], E[4][6], E[5][6]};
    const Vec x1 = l1, x2 = l2;
    double gamma = 1.0;
    for (;; gamma *= 0.5) {
      if (gamma < 1e-7) return false;
      l1 = x1 - gamma * d1;
      l2 = x2 - gamma * d2;
      r = propagate(s, stages, l1, l2);
      if (r.norm() <= (1.0 - 1e-4 * gamma) * norm) break;
    }
    norm = r.norm();
  }
  return norm <= s.tolerance;
}

}  // namespace

// The compiled residual (44) for a caller from outside: numbers as in the file, then a state and 6
// multipliers; `out` receives the 6 residuals, the first torque, the multipliers one step later.
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

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::ifstream file(argv[1]);
  Settings s;
  for (double& x : s.J.a) file >> x;
  file >> s.h >> s.q1 >> s.q2 >> s.q3 >> s.p1 >> s.p2 >> s.limit >> s.penalty;
  file >> s.N >> s.tolerance >> s.seconds;
  if (!file || s.N > MAX_HORIZON) return 3;
  s.prepare();
  std::vector<Stage> states, stages(MAX_HORIZON + 1);
  Stage state{};
  while (file >> state.R.a[0]) {
    for (int i = 1; i < 9; ++i) file >> state.R.a[i];
    file >> state.Pi.x >> state.Pi.y >> state.Pi.z;
    states.push_back(state);
  }
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;
  const auto begun = Clock::now();
  do {
    Vec l1{0, 0, 0}, l2{0, 0, 0};
    for (const Stage& start : states) {
      int iterations = 0;
      const auto tic = Clock::now();
      stages[0].R = start.R;
      stages[0].Pi = start.Pi;
      const bool solved = newton(s, stages, l1, l2, iterations);
      const double elapsed = Seconds(Clock::now() - tic).count();
      const Vec u = stages[0].u;
      std::printf("%.9g %.17g %.17g %.17g %d %d\n", elapsed, u.x, u.y, u.z, iterations, solved);
      const int next = s.N > 1 ? 1 : 0;  // shifted by one step
      l1 = solved ? stages[next].l1 : Vec{0, 0, 0};
      l2 = solved ? stages[next].l2 : Vec{0, 0, 0};
    }
  } while (Seconds(Clock::now() - begun).count() < s.seconds);
  return 0;
}
