// Three-vectors and 3x3 matrices (row-major) by value.
#pragma once

struct Vec {
  double x, y, z;
};
struct Mat {
  double a[9];
};

inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec operator*(const Mat& m, Vec v) {
  const double* a = m.a;
  return {a[0] * v.x + a[1] * v.y + a[2] * v.z, a[3] * v.x + a[4] * v.y + a[5] * v.z,
          a[6] * v.x + a[7] * v.y + a[8] * v.z};
}
inline Mat transpose(const Mat& m) {
  const double* a = m.a;
  return {{a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]}};
}
inline Vec mul_t(const Mat& m, Vec v) {
  const double* a = m.a;
  return {a[0] * v.x + a[3] * v.y + a[6] * v.z, a[1] * v.x + a[4] * v.y + a[7] * v.z,
          a[2] * v.x + a[5] * v.y + a[8] * v.z};
}
inline Mat operator*(const Mat& l, const Mat& r) {
  Mat m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      m.a[3 * i + j] =
          l.a[3 * i] * r.a[j] + l.a[3 * i + 1] * r.a[3 + j] + l.a[3 * i + 2] * r.a[6 + j];
  return m;
}
inline Mat operator+(const Mat& l, const Mat& r) {
  Mat m;
  for (int i = 0; i < 9; ++i) m.a[i] = l.a[i] + r.a[i];
  return m;
}
inline Mat operator-(const Mat& l, const Mat& r) {
  Mat m;
  for (int i = 0; i < 9; ++i) m.a[i] = l.a[i] - r.a[i];
  return m;
}
inline Mat operator*(double s, const Mat& r) {
  Mat m;
  for (int i = 0; i < 9; ++i) m.a[i] = s * r.a[i];
  return m;
}
inline Mat identity(double s) { return {{s, 0, 0, 0, s, 0, 0, 0, s}}; }
inline Mat hat(Vec v) { return {{0, -v.z, v.y, v.z, 0, -v.x, -v.y, v.x, 0}}; }
inline Mat outer(Vec a, Vec b) {
  return {{a.x * b.x, a.x * b.y, a.x * b.z, a.y * b.x, a.y * b.y, a.y * b.z, a.z * b.x, a.z * b.y,
           a.z * b.z}};
}
inline double trace(const Mat& m) { return m.a[0] + m.a[4] + m.a[8]; }
inline Mat trace_minus(const Mat& m) { return identity(trace(m)) - m; }
// Axial vector of (A - A^T)/2.
inline Vec vee(const Mat& m) {
  const double* a = m.a;
  return {0.5 * (a[7] - a[5]), 0.5 * (a[2] - a[6]), 0.5 * (a[3] - a[1])};
}
inline Mat inverse(const Mat& m) {
  const double* a = m.a;
  const double c0 = a[4] * a[8] - a[5] * a[7], c1 = a[5] * a[6] - a[3] * a[8],
               c2 = a[3] * a[7] - a[4] * a[6];
  const double s = 1.0 / (a[0] * c0 + a[1] * c1 + a[2] * c2);
  return {{s * c0, s * (a[2] * a[7] - a[1] * a[8]), s * (a[1] * a[5] - a[2] * a[4]), s * c1,
           s * (a[0] * a[8] - a[2] * a[6]), s * (a[2] * a[3] - a[0] * a[5]), s * c2,
           s * (a[1] * a[6] - a[0] * a[7]), s * (a[0] * a[4] - a[1] * a[3])}};
}
