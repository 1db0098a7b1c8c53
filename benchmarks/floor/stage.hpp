// One stage of the horizon: integrator step (31), (32), control law (38) and its derivative.
#pragma once

#include <cmath>

#include "algebra.hpp"

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
  Mat R, F, M, A;
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
    const double slope = s.q3 + sigma + 4.0 * s.penalty * size * size;
    const double step = (size * (s.q3 + sigma) - y) / slope;
    t -= step;
    if (std::fabs(step) <= 1e-10 * t) break;
  }
  sigma = 2.0 * s.penalty * t * (2.0 * s.limit + t);
  u = (1.0 / (s.q3 + sigma)) * l2;
}

inline Mat control_sensitivity(const Settings& s, const Stage& a) {
  const double w = 1.0 / (s.q3 + a.sigma);
  if (a.sigma <= 0.0) return identity(w);
  const double d = 0.25 / s.penalty + w * dot(a.u, a.u);
  return identity(w) - (w * w / d) * outer(a.u, a.u);
}

// Fact 2: M = h F^T (tr(F Jd) I - F Jd)^-1, so that F^T delta F = hat(M delta Pi).
inline Mat momentum_map(const Settings& s, const Mat& F) {
  return s.h * (transpose(F) * inverse(trace_minus(F * s.Jd)));
}
