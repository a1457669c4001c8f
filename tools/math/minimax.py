#!/usr/bin/env python3
"""Minimax polynomials with binary32 and binary64 coefficients for the transcendental functions of compiler/passes/math_*.cpp.

For each function this prints coefficients (lowest power first) and the largest relative error of the exact polynomial, which leaves out the
rounding of the evaluation; lower_math_test.cpp measures the sum of both.

Method: Lawson's algorithm (least squares on Chebyshev points, weights multiplied by the error until it levels out; C. L. Lawson, "Contributions to
the theory of linear least maximum approximation", 1961) in 60-digit decimals; then the coefficients are rounded to binary32 one after another, lowest power first, and the rest is
fitted again, so that each rounding is made good by the later ones.
"""
import struct
import sys
from decimal import Decimal as D, getcontext

getcontext().prec = 60
LN2 = D(2).ln()


def to_f32(x):
    return D(struct.unpack("<f", struct.pack("<f", float(x)))[0])


def to_f64(x):
    return D(float(x))


def arctan(x):
    halvings = 0
    while abs(x) > D("0.01"):
        x = x / (1 + (1 + x * x).sqrt())
        halvings += 1
    total, term, k = D(0), x, 1
    while abs(term) > D(10) ** -58:
        total += term / k
        term *= -x * x
        k += 2
    return total * 2 ** halvings


PI = 4 * arctan(D(1))


def series(x, first, start):
    total, term, k = D(0), first, start
    while abs(term) > D(10) ** -58:
        total += term
        term *= -x * x / ((k + 1) * (k + 2))
        k += 2
    return total


def sin(x):
    return series(x, x, 1)


def cos(x):
    return series(x, D(1), 0)


def arcsin(x):
    return arctan(x / (1 - x * x).sqrt())


def solve(a, y):
    n = len(y)
    for i in range(n):
        p = max(range(i, n), key=lambda r: abs(a[r][i]))
        a[i], a[p], y[i], y[p] = a[p], a[i], y[p], y[i]
        for r in range(i + 1, n):
            m = a[r][i] / a[i][i]
            if m:
                a[r] = [u - m * v for u, v in zip(a[r], a[i])]
                y[r] -= m * y[i]
    x = [D(0)] * n
    for i in reversed(range(n)):
        x[i] = (y[i] - sum(a[i][j] * x[j] for j in range(i + 1, n))) / a[i][i]
    return x


def horner(c, x):
    total = D(0)
    for k in reversed(c):
        total = total * x + k
    return total


def power(x, p):
    return x ** p if p else D(1)


def minimax(target, weight, low, high, powers):
    """Coefficients of the given powers that nearly minimise max |weight * (target - p)| on [low, high]."""
    count = 12 * len(powers) + 10
    grid = [(low + high) / 2 - (high - low) / 2 * cos(PI * D(i) / (count - 1)) for i in range(count)]
    t, w = [target(x) for x in grid], [weight(x) for x in grid]
    basis = [[w[i] * power(x, p) for p in powers] for i, x in enumerate(grid)]
    goal = [w[i] * t[i] for i in range(count)]
    emphasis = [D(1)] * count
    best, best_error = None, None
    for _ in range(40):
        rows = [[sum(e * u[a] * u[c] for e, u in zip(emphasis, basis)) for c in range(len(powers))] for a in range(len(powers))]
        right = [sum(e * u[a] * g for e, u, g in zip(emphasis, basis, goal)) for a in range(len(powers))]
        coefficients = solve(rows, right)
        errors = [abs(goal[i] - sum(c * v for c, v in zip(coefficients, basis[i]))) for i in range(count)]
        if best is None or max(errors) < best_error:
            best, best_error = coefficients, max(errors)
        emphasis = [e * d for e, d in zip(emphasis, errors)]
        total = sum(emphasis)
        if total == 0:
            break
        emphasis = [e / total for e in emphasis]
    return best


def fit(name, target, weight, low, high, degree, nearest=to_f32):
    """`weight` turns the polynomial's error into a relative error of the function; `nearest` rounds a coefficient to its format."""
    low, high = D(low), D(high)
    done = []
    while len(done) <= degree:
        rest = lambda x: target(x) - horner(done, x)  # noqa: E731
        powers = list(range(len(done), degree + 1))
        if nearest is to_f64 and len(done) == 3:  # the rounding of the others is far below the error
            done += [nearest(c) for c in minimax(rest, weight, low, high, powers)]
        else:
            done.append(nearest(minimax(rest, weight, low, high, powers)[0]))
    error = max(abs(weight(x) * (target(x) - horner(done, x)))
                for x in (low + (high - low) * D(i) / 1499 for i in range(1500)))
    print(f"{name}: on [{float(low):.6g}, {float(high):.6g}], degree {degree}, error 2^{float(error.ln() / LN2):.1f}")
    print("    " + ", ".join(float(c).hex() for c in done))


TINY = D("1e-12")  # stands for zero where a quotient has a limit


def sinh(x):
    total, term, k = D(0), x, 1
    while abs(term) > D(10) ** -58:
        total += term
        term *= x * x / ((k + 1) * (k + 2))
        k += 2
    return total


def tanh(x):
    e = (2 * x).exp()
    return 2 * sinh(x) * x.exp() / (e + 1)


def two_atanh(s):
    return ((1 + s) / (1 - s)).ln()


def odd_rest(f):
    """p of f(x) = x + x^3 * p(z), z = x^2"""
    return lambda z: (f((z or TINY).sqrt()) / (z or TINY).sqrt() - 1) / (z or TINY)


def odd_weight(f):
    return lambda z: (z + TINY) * (z or TINY).sqrt() / f((z or TINY).sqrt())


def exponent_of(x):
    return int((x.ln() / LN2).to_integral_value(rounding="ROUND_FLOOR"))


def main():
    which = set(sys.argv[1:])

    def want(name):
        return not which or name in which

    half = D("0.5")
    if want("exp2"):  # 2^x = 1 + x * p(x)
        g = lambda x: (((x or TINY) * LN2).exp() - 1) / (x or TINY)  # noqa: E731
        fit("exp2", g, lambda x: (abs(x) + TINY) / (x * LN2).exp(), -half, half, 5)
    if want("exp"):  # e^x = 1 + x + x^2 * p(x)
        g = lambda x: ((x or TINY).exp() - 1 - (x or TINY)) / (x or TINY) ** 2  # noqa: E731
        fit("exp", g, lambda x: (x * x + TINY) / x.exp(), -LN2 / 2 - D("0.001"), LN2 / 2 + D("0.001"), 4)
    sqrt2 = D(2).sqrt()
    if want("log"):  # ln(1 + t) = t + t^2 * p(t)
        g = lambda t: ((1 + (t or TINY)).ln() - (t or TINY)) / (t or TINY) ** 2  # noqa: E731
        w = lambda t: t * t / abs((1 + t).ln()) if t else TINY  # noqa: E731
        fit("log", g, w, 1 / sqrt2 - 1, sqrt2 - 1, 8)
    if want("log2"):  # log2(1 + t) = t / ln 2 + t^2 * p(t)
        g = lambda t: ((1 + (t or TINY)).ln() - (t or TINY)) / (t or TINY) ** 2 / LN2  # noqa: E731
        w = lambda t: LN2 * t * t / abs((1 + t).ln()) if t else TINY  # noqa: E731
        fit("log2", g, w, 1 / sqrt2 - 1, sqrt2 - 1, 8)
        print("    1/ln2 high, low:", float(to_f32(1 / LN2)).hex(), float(to_f32(1 / LN2 - to_f32(1 / LN2))).hex())
    if want("pow"):  # log2(1 + t) = t * (c0 + t * (c1 + t * (c2 + t * p(t)))), c_k = (-1)^k / ((k + 1) ln 2) in two parts
        c = [1 / LN2, -1 / (2 * LN2), 1 / (3 * LN2)]
        parts = [(to_f32(k), to_f32(k - to_f32(k))) for k in c]
        head = lambda t: sum((h + l) * t ** (i + 1) for i, (h, l) in enumerate(parts))  # noqa: E731
        g = lambda t: ((1 + t).ln() / LN2 - head(t)) / t ** 4 if abs(t) > D("1e-6") else -1 / (4 * LN2)  # noqa: E731
        w = lambda t: LN2 * t ** 4 / abs((1 + t).ln()) if t else TINY  # noqa: E731
        for h, l in parts:
            print("    head:", float(h).hex(), float(l).hex())
        fit("pow", g, w, 1 / sqrt2 - 1, sqrt2 - 1, 9)
    quarter = PI / 4 + D("0.01")
    if want("sin"):  # sin x = x + x^3 * p(x^2), in z = x^2
        g = lambda z: (sin((z or TINY).sqrt()) / (z or TINY).sqrt() - 1) / (z or TINY)  # noqa: E731
        fit("sin", g, lambda z: (z + TINY) * (z or TINY).sqrt() / sin((z or TINY).sqrt()), 0, quarter ** 2, 3)
    if want("cos"):  # cos x = 1 - x^2 / 2 + x^4 * p(x^2)
        g = lambda z: (cos((z or TINY).sqrt()) - 1 + (z or TINY) / 2) / (z or TINY) ** 2  # noqa: E731
        fit("cos", g, lambda z: (z * z + TINY) / cos(z.sqrt()), 0, quarter ** 2, 2)
    if want("asin"):  # asin x = x + x^3 * p(x^2) up to x = 1/2
        g = lambda z: (arcsin((z or TINY).sqrt()) / (z or TINY).sqrt() - 1) / (z or TINY)  # noqa: E731
        fit("asin", g, lambda z: (z + TINY) * (z or TINY).sqrt() / arcsin((z or TINY).sqrt()), 0, D("0.25"), 5)
    if want("atan"):  # atan x = x + x^3 * p(x^2) up to x = 1
        g = lambda z: (arctan((z or TINY).sqrt()) / (z or TINY).sqrt() - 1) / (z or TINY)  # noqa: E731
        fit("atan", g, lambda z: (z + TINY) * (z or TINY).sqrt() / arctan((z or TINY).sqrt()), 0, 1, 8)
    if want("sinh"):  # sinh x = x + x^3 * p(x^2) up to x = 1
        fit("sinh", odd_rest(sinh), odd_weight(sinh), 0, 1, 3)
    if want("tanh"):  # tanh x = x + x^3 * p(x^2) up to x = 0.55
        fit("tanh", odd_rest(tanh), odd_weight(tanh), 0, D("0.3025"), 4)
    # ---- PINEDA_PRECISION=fast ----
    if want("fast_exp2"):  # 2^x = 1 + x * p(x)
        g = lambda x: (((x or TINY) * LN2).exp() - 1) / (x or TINY)  # noqa: E731
        fit("fast exp2", g, lambda x: (abs(x) + TINY) / (x * LN2).exp(), -half, half, 4)
    if want("fast_log2"):  # log2(1 + t) = t * p(t)
        g = lambda t: (1 + (t or TINY)).ln() / (t or TINY) / LN2  # noqa: E731
        fit("fast log2", g, lambda t: LN2 * t / (1 + t).ln() if t else D(1), 1 / sqrt2 - 1, sqrt2 - 1, 8)
    if want("fast_sin"):
        fit("fast sin", odd_rest(sin), odd_weight(sin), 0, quarter ** 2, 1)
    if want("fast_cos"):  # cos x = 1 - x^2 / 2 + x^4 * p(x^2)
        g = lambda z: (cos((z or TINY).sqrt()) - 1 + (z or TINY) / 2) / (z or TINY) ** 2  # noqa: E731
        fit("fast cos", g, lambda z: (z * z + TINY) / cos(z.sqrt()), 0, quarter ** 2, 1)
    if want("fast_asin"):
        fit("fast asin", odd_rest(arcsin), odd_weight(arcsin), 0, D("0.25"), 2)
    if want("fast_atan"):
        fit("fast atan", odd_rest(arctan), odd_weight(arctan), 0, 1, 4)
    # ---- PINEDA_PRECISION=exact: binary64 ----
    if want("exact_exp2"):  # 2^x = 1 + x * p(x)
        g = lambda x: (((x or TINY) * LN2).exp() - 1) / (x or TINY)  # noqa: E731
        fit("exact exp2", g, lambda x: (abs(x) + TINY) / (x * LN2).exp(), -half, half, 12, to_f64)
    if want("exact_exp"):  # e^x = 1 + x + x^2 * p(x)
        g = lambda x: ((x or TINY).exp() - 1 - (x or TINY)) / (x or TINY) ** 2  # noqa: E731
        fit("exact exp", g, lambda x: (x * x + TINY) / x.exp(), -LN2 / 2 - D("0.001"), LN2 / 2 + D("0.001"), 10, to_f64)
    if want("exact_log"):  # ln((1 + s) / (1 - s)) = 2 s + s^3 * p(s^2)
        g = lambda z: (two_atanh((z or TINY).sqrt()) / (z or TINY).sqrt() - 2) / (z or TINY)  # noqa: E731
        w = lambda z: (z + TINY) * (z or TINY).sqrt() / two_atanh((z or TINY).sqrt())  # noqa: E731
        fit("exact log", g, w, 0, D("0.02945"), 8, to_f64)
    if want("exact_sin"):
        fit("exact sin", odd_rest(sin), odd_weight(sin), 0, quarter ** 2, 6, to_f64)
    if want("exact_cos"):
        g = lambda z: (cos((z or TINY).sqrt()) - 1 + (z or TINY) / 2) / (z or TINY) ** 2  # noqa: E731
        fit("exact cos", g, lambda z: (z * z + TINY) / cos(z.sqrt()), 0, quarter ** 2, 6, to_f64)
    if want("exact_asin"):
        fit("exact asin", odd_rest(arcsin), odd_weight(arcsin), 0, D("0.25"), 12, to_f64)
    if want("exact_atan"):  # up to tan(pi/8)
        fit("exact atan", odd_rest(arctan), odd_weight(arctan), 0, D("0.1717"), 10, to_f64)
    if want("exact_sinh"):
        fit("exact sinh", odd_rest(sinh), odd_weight(sinh), 0, 1, 8, to_f64)
    if want("exact_constants"):
        getcontext().prec = 120
        rest = 2 * machin()
        parts = []
        for bits in (33, 33, 53):
            scale = D(2) ** (bits - 1 - exponent_of(rest))
            parts.append(D(int(rest * scale)) / scale)
            rest -= parts[-1]
        print("pi/2 in 33, 33, 53 bits:", [float(p).hex() for p in parts], "2/pi:", float(1 / (2 * machin())).hex())
        ln2 = D(2).ln()
        high = D(int(ln2 * 2 ** 32)) / 2 ** 32
        print("ln2 high (32 bits), low:", float(high).hex(), float(ln2 - high).hex(), "log2(e):", float(1 / ln2).hex())
        bits = int(2 / (4 * machin()) * 2 ** 320)
        print("2/pi in 32-bit words:", [hex(bits >> (288 - 32 * i) & 0xFFFFFFFF) for i in range(10)])
    if want("constants"):
        rest = PI / 2
        parts = []
        for _ in range(3):
            parts.append(to_f32(rest))
            rest -= parts[-1]
        print("pi/2:", [float(p).hex() for p in parts], "2/pi:", float(to_f32(2 / PI)).hex())
        high = D(int(LN2 * 2 ** 16)) / 2 ** 16
        print("ln2 high (16 bits), low:", float(high).hex(), float(to_f32(LN2 - high)).hex(), "log2(e):", float(to_f32(1 / LN2)).hex())
        getcontext().prec = 120
        digits = 4 * machin()
        bits = int(2 / digits * 2 ** 256)
        print("2/pi in 32-bit words:", [hex(bits >> (224 - 32 * i) & 0xFFFFFFFF) for i in range(8)])


def machin():
    """pi / 4 = 4 atan(1/5) - atan(1/239), to the context's precision."""
    def inverse(n):
        total, term, k = D(0), D(1) / n, 1
        while abs(term) > D(10) ** -118:
            total += term / k
            term /= -n * n
            k += 2
        return total
    return 4 * inverse(5) - inverse(239)


if __name__ == "__main__":
    main()
