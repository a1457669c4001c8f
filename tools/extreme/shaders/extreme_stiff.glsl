// Stiff and ill-conditioned problems: one text for GLSL and for C++ (stiff.cpp), where `real` is float or double on both sides.
// Everything is `precise`, so a driver that rounds each operation once gives the host's bits.

// ---- ordinary differential equations: the Rosenbrock method of order 2 with an error estimate of order 3 ---------------------------
// (Shampine, Reichelt, "The MATLAB ODE Suite", 1997: ode23s.) Linearly implicit and L-stable.

const int kRobertson = 0, kVanDerPol = 1;

struct Vector {
  real a, b, c;
};

Vector vector(real a, real b, real c) {
  Vector v;
  v.a = a;
  v.b = b;
  v.c = c;
  return v;
}

Vector rates(int problem, Vector y) {
  if (problem == kRobertson) {
    precise real slow = real(4) / real(100) * y.a, back = real(10000) * y.b * y.c, fast = real(30000000) * y.b * y.b;
    precise real da = back - slow, db = slow - back - fast;
    return vector(da, db, fast);
  }
  precise real curvature = real(1000) * (real(1) - y.a * y.a) * y.b - y.a;
  return vector(y.b, curvature, real(0));
}

// Solves (I - s J(y)) x = r by elimination; J is the Jacobian of rates().
Vector solve(int problem, Vector y, real s, Vector r) {
  precise real m00, m01, m02, m10, m11, m12, m21 = real(0), m22 = real(1);
  if (problem == kRobertson) {
    precise real k = real(4) / real(100), by_b = real(10000) * y.c, by_c = real(10000) * y.b, squared = real(60000000) * y.b;
    m00 = real(1) + s * k;
    m01 = -(s * by_b);
    m02 = -(s * by_c);
    m10 = -(s * k);
    m11 = real(1) + s * (by_b + squared);
    m12 = s * by_c;
    m21 = -(s * squared);
  } else {
    precise real j10 = -(real(2000) * y.a * y.b) - real(1), j11 = real(1000) * (real(1) - y.a * y.a);
    m00 = real(1);
    m01 = -s;
    m02 = real(0);
    m10 = -(s * j10);
    m11 = real(1) - s * j11;
    m12 = real(0);
  }
  precise real f1 = m10 / m00;
  precise real n11 = m11 - f1 * m01, n12 = m12 - f1 * m02, s1 = r.b - f1 * r.a;
  precise real f2 = m21 / n11;
  precise real n22 = m22 - f2 * n12, s2 = r.c - f2 * s1;
  precise real xc = s2 / n22;
  precise real xb = (s1 - n12 * xc) / n11;
  precise real xa = (r.a - m01 * xb - m02 * xc) / m00;
  return vector(xa, xb, xc);
}

real scaled(real error, real before, real after, real tolerance, real smallest) {
  precise real size = max(abs(before), abs(after));
  precise real allowed = tolerance * size + smallest;
  precise real ratio = abs(error) / allowed;
  return ratio;
}

// From y at 0 to `end`. The time is a compensated sum: in binary32 the steps are soon smaller than its last place.
Vector integrate(int problem, Vector y, real end, real tolerance, real smallest) {
  // 1 / (2 + sqrt 2) and 6 + sqrt 2, each a quotient of two numbers that binary32 holds: front ends fold longer expressions in double.
  precise real d = real(29289322) / real(100000000), e32 = real(7414214) / real(1000000);
  precise real time = real(0), lost = real(0), h = real(1) / real(1048576);
  for (int steps = 0; steps < 400000; ++steps) {
    precise real rest = (end - time) + lost;
    if (rest <= real(0)) break;
    h = min(h, rest);
    precise real s = h * d;
    Vector f0 = rates(problem, y);
    Vector k1 = solve(problem, y, s, f0);
    precise real half_a = y.a + h / real(2) * k1.a, half_b = y.b + h / real(2) * k1.b, half_c = y.c + h / real(2) * k1.c;
    Vector f1 = rates(problem, vector(half_a, half_b, half_c));
    precise real ra = f1.a - k1.a, rb = f1.b - k1.b, rc = f1.c - k1.c;
    Vector dk = solve(problem, y, s, vector(ra, rb, rc));
    precise real k2a = dk.a + k1.a, k2b = dk.b + k1.b, k2c = dk.c + k1.c;
    precise real na = y.a + h * k2a, nb = y.b + h * k2b, nc = y.c + h * k2c;
    Vector f2 = rates(problem, vector(na, nb, nc));
    precise real qa = f2.a - e32 * (k2a - f1.a) - real(2) * (k1.a - f0.a), qb = f2.b - e32 * (k2b - f1.b) - real(2) * (k1.b - f0.b),
                 qc = f2.c - e32 * (k2c - f1.c) - real(2) * (k1.c - f0.c);
    Vector k3 = solve(problem, y, s, vector(qa, qb, qc));
    precise real ea = h / real(6) * (k1.a - real(2) * k2a + k3.a), eb = h / real(6) * (k1.b - real(2) * k2b + k3.b),
                 ec = h / real(6) * (k1.c - real(2) * k2c + k3.c);
    real error = max(scaled(ea, y.a, na, tolerance, smallest),
                     max(scaled(eb, y.b, nb, tolerance, smallest), scaled(ec, y.c, nc, tolerance, smallest)));
    if (error <= real(1)) {
      y = vector(na, nb, nc);
      precise real term = h - lost, sum = time + term;
      lost = (sum - time) - term;
      time = sum;
      if (error < real(1) / real(8)) h = h * real(5) / real(4);
    } else {
      h = h / real(2);
    }
  }
  return y;
}

// ---- Hilbert's systems -------------------------------------------------------------------------------------------------------------

const int kLargestHilbert = 12;

// Component `wanted` of the solution of H x = H (1, ..., 1), the right side rounded; elimination with partial pivoting.
real hilbert(int n, int wanted) {
  real m[kLargestHilbert * (kLargestHilbert + 1)];
  for (int i = 0; i < n; ++i) {
    precise real sum = real(0);
    for (int j = 0; j < n; ++j) {
      precise real entry = real(1) / real(i + j + 1);
      m[i * (n + 1) + j] = entry;
      sum = sum + entry;
    }
    m[i * (n + 1) + n] = sum;
  }
  for (int k = 0; k < n; ++k) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i) {
      if (abs(m[i * (n + 1) + k]) > abs(m[pivot * (n + 1) + k])) pivot = i;
    }
    for (int j = k; j <= n; ++j) {
      real swapped = m[k * (n + 1) + j];
      m[k * (n + 1) + j] = m[pivot * (n + 1) + j];
      m[pivot * (n + 1) + j] = swapped;
    }
    for (int i = k + 1; i < n; ++i) {
      precise real factor = m[i * (n + 1) + k] / m[k * (n + 1) + k];
      for (int j = k; j <= n; ++j) {
        precise real reduced = m[i * (n + 1) + j] - factor * m[k * (n + 1) + j];
        m[i * (n + 1) + j] = reduced;
      }
    }
  }
  for (int i = n - 1; i >= 0; --i) {
    precise real sum = m[i * (n + 1) + n];
    for (int j = i + 1; j < n; ++j) sum = sum - m[i * (n + 1) + j] * m[j * (n + 1) + n];
    m[i * (n + 1) + n] = sum / m[i * (n + 1) + i];
  }
  return m[wanted * (n + 1) + n];
}

// ---- sums: 1 + 1/2 + ... + 1/n -----------------------------------------------------------------------------------------------------

real naive_sum(int n) {
  precise real sum = real(0);
  for (int k = 1; k <= n; ++k) sum = sum + real(1) / real(k);
  return sum;
}

real kahan_sum(int n) {
  precise real sum = real(0), lost = real(0);
  for (int k = 1; k <= n; ++k) {
    precise real term = real(1) / real(k) - lost;
    precise real next = sum + term;
    lost = (next - sum) - term;
    sum = next;
  }
  return sum;
}

// ---- chaos -------------------------------------------------------------------------------------------------------------------------

real logistic(real x, int steps) {
  for (int i = 0; i < steps; ++i) {
    precise real next = real(39) / real(10) * x * (real(1) - x);
    x = next;
  }
  return x;
}

real henon(real x, int steps) {
  precise real y = real(0);
  for (int i = 0; i < steps; ++i) {
    precise real next = real(1) - real(14) / real(10) * x * x + y;
    y = real(3) / real(10) * x;
    x = next;
  }
  return x;
}

// ---- what invocation `index` computes ----------------------------------------------------------------------------------------------

const int kTaskRobertson40 = 0, kTaskRobertsonLong = 3, kTaskVanDerPol = 6, kTaskNaive = 8, kTaskKahan = 9, kTaskLogistic = 10,
          kTaskHenon = 18, kTaskHilbert = 26;
const int kTaskCount = kTaskHilbert + (kLargestHilbert + 1) * kLargestHilbert;

real component(Vector v, int i) { return i == 0 ? v.a : i == 1 ? v.b : v.c; }

real stiff_task(int index, real tolerance, real smallest) {
  Vector robertson = vector(real(1), real(0), real(0));
  if (index < kTaskRobertsonLong) return component(integrate(kRobertson, robertson, real(40), tolerance, smallest), index);
  if (index < kTaskVanDerPol) {
    return component(integrate(kRobertson, robertson, real(100000) * real(1000000), tolerance, smallest), index - kTaskRobertsonLong);
  }
  if (index < kTaskNaive) {
    return component(integrate(kVanDerPol, vector(real(2), real(0), real(0)), real(2000), tolerance, smallest), index - kTaskVanDerPol);
  }
  if (index == kTaskNaive) return naive_sum(1000000);
  if (index == kTaskKahan) return kahan_sum(1000000);
  if (index < kTaskHenon) return logistic(real(index) / real(64), 10000);
  if (index < kTaskHilbert) return henon(real(index) / real(128), 10000);
  int n = (index - kTaskHilbert) / kLargestHilbert, wanted = (index - kTaskHilbert) % kLargestHilbert;
  return wanted < n ? hilbert(n, wanted) : real(0);
}
