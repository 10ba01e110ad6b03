// Balls among discs in a box under gravity, L at a time in packed instructions: `pinball DISCS COLLISIONS` prints
// collisions a second of its own processor time. Lower bounds find the contacts; rounding is not accounted for.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>
#ifndef L
#define L 8
#endif
typedef double v __attribute__((vector_size(8 * L)));
typedef long m __attribute__((vector_size(8 * L)));
#define INL static inline __attribute__((always_inline))
INL v S(double x) { return x - (v){}; }
INL v root(v x) { v r; for (int i = 0; i < L; i++) r[i] = __builtin_sqrt(x[i]); return r; }
INL bool any(m a) { long s = 0; for (int i = 0; i < L; i++) s |= a[i]; return s != 0; }
INL v mn(v a, v b) { return a < b ? a : b; }
INL v mx(v a, v b) { return a > b ? a : b; }
static double now() { timespec t; clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }

static void run(v &x, v &y, v &u, v &w, const double *cx, const double *cy, int N, double R, double W, double H,
                double g, long hits) {
  const v Z = S(0), BIG = S(1e300);
  const double R2 = R * R, ig = 1 / g, a4 = .25 * g * g;
  alignas(64) double tl[64 * L];
  v *TL = (v *)tl;
  for (long k = 0; k < hits; k++) {
    v tx = (u > Z ? (W - x) : -x) / u, tf = (w + root(w * w + 2 * g * mx(y, Z))) * ig;
    v D = w * w - 2 * g * (H - y), tc = 2 * (H - y) / (w + root(mx(D, Z)));
    tc = ((w > Z) & (D >= Z)) ? tc : BIG;
    v ty = mn(tf, tc);
    m wx = tx < ty;
    v T = wx ? tx : ty, tb = BIG;
    m jb = wx ^ wx;
    const v vv = u * u + w * w, c30 = -w * g;
    v sm = mn(mx(c30 * (-.5 / a4), Z), T), lo = (c30 + a4 * sm) * sm + vv;
    for (int j = 0; j < N; j++) {
      v dx = x - cx[j], dy = y - cy[j], q = mx(dx * dx + dy * dy - R2, Z), q1 = 2 * (dx * u + dy * w), kk = lo - g * dy;
      v di = q1 * q1 - 4 * kk * q, t = BIG;
      m dead = (di < Z) | ((q1 >= Z) & (kk >= Z));
      if (any(~dead)) {
        v sq = root(mx(di, Z));
        m ng = q1 < Z;
        v s = (ng ? 2 * q : -(q1 + sq)) / (ng ? sq - q1 : 2 * kk);
        t = (dead | (s >= T)) ? BIG : s;
      }
      TL[j] = t;
      m be = t < tb;
      tb = be ? t : tb;
      jb = be ? (m)(jb * 0 + j) : jb;
    }
    m hit = wx ^ wx, act = tb < T;
    v hx = Z, hy = Z;
    while (any(act)) {
      v gx, gy;
      for (int i = 0; i < L; i++) { gx[i] = cx[jb[i]]; gy[i] = cy[jb[i]]; }
      v dx = x - gx, dy = y - gy, t = act ? tb : Z;
      v a2 = vv - g * dy, a1 = 2 * (dx * u + dy * w), a0 = dx * dx + dy * dy - R2;
      v q = mx((((a4 * t + c30) * t + a2) * t + a1) * t + a0, Z), q1 = ((4 * a4 * t + 3 * c30) * t + 2 * a2) * t + a1;
      v b = (6 * a4 * t + 3 * c30) * t + a2, c3 = 4 * a4 * t + c30, rest = T - t;
      v at = mn(mx(c3 * (-.5 / a4), Z), rest), low = (c3 + a4 * at) * at, kk = b + low, di = q1 * q1 - 4 * kk * q;
      m gone = (di < Z) | ((q1 >= Z) & (kk >= Z)), ng = q1 < Z;
      v sq = root(mx(di, Z)), s = (ng ? 2 * q : -(q1 + sq)) / (ng ? sq - q1 : 2 * kk);
      v gap = -low * s * s + (c3 > 0 ? c3 * s * s * s : Z) + a4 * s * s * s * s, tol = 2e-15 * R2 + 0 * Z, t2 = t + s;
      gone |= t2 >= T;
      m done = act & ~gone & ng & ((gap <= tol) | (q <= tol));
      hit |= done;
      T = done ? t2 : T;
      hx = done ? gx : hx;
      hy = done ? gy : hy;
      act &= ~done;
      v nt = gone ? BIG : t2;
      for (int i = 0; i < L; i++) if (act[i]) tl[jb[i] * L + i] = nt[i];
      tb = BIG;
      for (int j = 0; j < N; j++) { v tt = TL[j]; m be = tt < tb; tb = be ? tt : tb; jb = be ? (m)(jb * 0 + j) : jb; }
      act &= tb < T;
    }
    v X = x + u * T, Y = y + (w - .5 * g * T) * T, w2 = w - g * T, nx = X - hx, ny = Y - hy;
    v ir = 1 / root(nx * nx + ny * ny);
    nx *= ir;
    ny *= ir;
    v dv = -2 * (u * nx + w2 * ny), un = hit ? u + dv * nx : (wx ? -u : u), wn = hit ? w2 + dv * ny : (wx ? w2 : -w2);
    x = hit ? hx + R * nx : (wx ? (u > Z ? S(W) : Z) : X);
    y = hit ? hy + R * ny : (wx ? Y : (w2 > Z ? S(H) : Z));
    u = un;
    w = wn;
  }
}

int main(int, char **a) {
  const double W = 6, H = 10, R = .5, g = 1;
  const int N = atoi(a[1]), nx = ceil(sqrt(N * W / H)), ny = ceil((double)N / nx);
  const long hits = atol(a[2]) / L;
  std::vector<double> cx, cy;
  for (int j = 0; j < ny; j++)
    for (int i = 0; i < nx; i++)
      if ((int)cx.size() < N) { cx.push_back((i + .5 + .25 * (j % 2)) * W / (nx + .25)); cy.push_back((j + .5) * H / ny); }
  v x, y, u, w;
  srand48(1);
  for (int i = 0; i < L; i++) {
  again:
    double px = W * drand48(), py = H * drand48();
    for (int j = 0; j < N; j++) if (hypot(px - cx[j], py - cy[j]) < R) goto again;
    double th = 6.283185307 * drand48(), sp = sqrt(2 * (12 - g * py));
    x[i] = px; y[i] = py; u[i] = sp * cos(th); w[i] = sp * sin(th);
  }
  double before = now();
  run(x, y, u, w, cx.data(), cy.data(), N, R, W, H, g, hits);
  double spent = now() - before, drift = 0;
  for (int i = 0; i < L; i++) drift = fmax(drift, fabs(.5 * (u[i] * u[i] + w[i] * w[i]) + g * y[i] - 12));
  printf("%.6g %.2g\n", hits * L / spent, drift);
}
