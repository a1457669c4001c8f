#include <algorithm>
#include <cmath>
#include <cstdint>

#include "shaders/extreme_stiff_f32_comp.h"
#include "shaders/extreme_stiff_f64_comp.h"
#include "tools/error.h"
#include "tools/extreme/rig.h"

// GLSL's text, compiled for the host with each operation rounded once (-ffp-contract=off): what IEEE 754 gives.
#define precise
namespace pineda::tools::host_f32 {
using real = float;
using std::abs, std::max, std::min;
#include "tools/extreme/shaders/extreme_stiff.glsl"
}  // namespace pineda::tools::host_f32
namespace pineda::tools::host_f64 {
using real = double;
using std::abs, std::max, std::min;
#include "tools/extreme/shaders/extreme_stiff.glsl"
}  // namespace pineda::tools::host_f64
#undef precise

namespace pineda::tools {
namespace {

using namespace host_f64;  // its constants

template <typename Real>
struct Problem {
  Spirv shader;
  Real tolerance, smallest;
  Real (*host)(int, Real, Real);
  double unit;  // half a unit in the last place of 1
};

const Problem<float> kSingle{extreme_stiff_f32_comp, 1e-4f, 1e-12f, host_f32::stiff_task, 0x1p-24};
const Problem<double> kDouble{extreme_stiff_f64_comp, 1e-7, 1e-20, host_f64::stiff_task, 0x1p-53};

template <typename Real>
std::vector<Real> run_tasks(ExtremeRig& rig, const Problem<Real>& problem, int first, int count) {
  std::vector<std::byte> input(2 * sizeof(Real) + static_cast<size_t>(count) * sizeof(int));
  const Real parameters[] = {problem.tolerance, problem.smallest};
  std::memcpy(input.data(), parameters, sizeof parameters);
  for (int i = 0; i < count; ++i) {
    const int task = first + i;
    std::memcpy(input.data() + sizeof parameters + static_cast<size_t>(i) * sizeof task, &task, sizeof task);
  }
  return rig.compute_as<Real>(problem.shader, input, static_cast<size_t>(count), static_cast<uint32_t>(count));
}

template <typename Real>
std::vector<Real> on_host(const Problem<Real>& problem, int first, int count) {
  std::vector<Real> results;
  for (int i = 0; i < count; ++i) results.push_back(problem.host(first + i, problem.tolerance, problem.smallest));
  return results;
}

template <typename Real>
bool same_bits(const std::vector<Real>& a, const std::vector<Real>& b) {
  return std::memcmp(a.data(), b.data(), a.size() * sizeof(Real)) == 0;
}

template <typename Real>
bool lacks(ExtremeRig& rig) {
  return sizeof(Real) == 8 && !rig.features().shaderFloat64;
}

// Published values, and a bound on the relative error of each component.
template <typename Real>
Outcome solve_ode(ExtremeRig& rig, const Problem<Real>& problem, int first, const std::vector<double>& published, double bound) {
  if (lacks<Real>(rig)) return {};
  const int count = static_cast<int>(published.size());
  const std::vector<Real> results = run_tasks(rig, problem, first, count), ieee = on_host(problem, first, count);
  double worst = 0;
  std::string values, wanted;
  for (size_t i = 0; i < published.size(); ++i) {
    worst = std::max(worst, std::abs(results[i] - published[i]) / std::abs(published[i]));
    values += fmt::format("{}{:.7g}", i ? ", " : "", results[i]);
    wanted += fmt::format("{}{:.10g}", i ? ", " : "", published[i]);
  }
  const bool within = worst <= bound, same = same_bits(results, ieee);
  return {.verdict = !within ? Verdict::kWrong
                     : same  ? Verdict::kExact
                             : Verdict::kWithin,
          .measured = fmt::format("{} (relative error {:.1e}{})", values, worst, same ? "; the bits of IEEE 754" : ""),
          .truth = wanted,
          .bound = fmt::format("{:.0e} relative to the published values, the method's error; exact: the bits of IEEE 754", bound),
          .bytes = bytes_of(results)};
}

// At t = 40 the digits are those that the example program of CVODE (SUNDIALS) prints, and more of the same; the others are of the
// Test Set for IVP Solvers (Mazzia, Magherini, 2008), problems ROBER and VDPOL.
const std::vector<double> kRobertsonAt40{0.7158270687, 0.9185534764e-5, 0.2841637457};
const std::vector<double> kRobertsonAtEnd{0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050};
const std::vector<double> kVanDerPolAtEnd{0.1706167732170469e1, -0.8928097010248125e-3};

Outcome robertson_f32(ExtremeRig& rig) { return solve_ode(rig, kSingle, kTaskRobertson40, kRobertsonAt40, 1e-3); }
Outcome robertson_f64(ExtremeRig& rig) { return solve_ode(rig, kDouble, kTaskRobertson40, kRobertsonAt40, 1e-5); }
Outcome robertson_long(ExtremeRig& rig) { return solve_ode(rig, kDouble, kTaskRobertsonLong, kRobertsonAtEnd, 1e-4); }
Outcome van_der_pol_f32(ExtremeRig& rig) { return solve_ode(rig, kSingle, kTaskVanDerPol, kVanDerPolAtEnd, 1e-2); }
Outcome van_der_pol_f64(ExtremeRig& rig) { return solve_ode(rig, kDouble, kTaskVanDerPol, kVanDerPolAtEnd, 1e-5); }

// ---- Hilbert
// -----------------------------------------------------------------------------------------------------------------------

// cond_2 of Hilbert's matrices, n = 2 to 12 (Higham, "Accuracy and Stability of Numerical Algorithms", 2nd edition,
// section 28.1).
constexpr double kCondition[] = {0,      0,       1.93e1,  5.24e2,  1.55e4,  4.77e5, 1.50e7,
                                 4.75e8, 1.53e10, 4.93e11, 1.60e13, 5.22e14, 1.68e16};

template <typename Real>
Outcome solve_hilbert(ExtremeRig& rig, const Problem<Real>& problem) {
  if (lacks<Real>(rig)) return {};
  constexpr int kCount = (kLargestHilbert + 1) * kLargestHilbert;
  const std::vector<Real> results = run_tasks(rig, problem, kTaskHilbert, kCount), ieee = on_host(problem, kTaskHilbert, kCount);
  bool wrong = false;
  std::string errors;
  for (int n = 2; n <= kLargestHilbert; ++n) {
    double worst = 0;
    for (int i = 0; i < n; ++i) worst = std::max(worst, std::abs(results[static_cast<size_t>(n * kLargestHilbert + i)] - 1.0));
    const double bound = 8.0 * n * kCondition[n] * problem.unit;
    wrong |= bound < 1 && !(worst <= bound);
    if (n % 2 == 0) errors += fmt::format("{}{}: {:.0e}", errors.empty() ? "" : ", ", n, worst);
  }
  const bool same = same_bits(results, ieee);
  return {.verdict = wrong  ? Verdict::kWrong
                     : same ? Verdict::kExact
                            : Verdict::kWithin,
          .measured = fmt::format("errors {}{}", errors, same ? "; the bits of IEEE 754" : ""),
          .truth = "1 in every component",
          .bound = "8 n cond(H) u, where that is below 1",
          .bytes = bytes_of(results)};
}

Outcome hilbert_f32(ExtremeRig& rig) { return solve_hilbert(rig, kSingle); }
Outcome hilbert_f64(ExtremeRig& rig) { return solve_hilbert(rig, kDouble); }

// ---- sums
// --------------------------------------------------------------------------------------------------------------------------

template <typename Real>
Outcome sum(ExtremeRig& rig, const Problem<Real>& problem, int task, double bound_in_units) {
  if (lacks<Real>(rig)) return {};
  // H(n) = ln n + gamma + 1 / (2 n) - 1 / (12 n²) + ..., by the Euler-Maclaurin formula; the next term is below 10^-26.
  constexpr double n = 1e6, kEulerGamma = 0.57721566490153286;
  const double harmonic = std::log(n) + kEulerGamma + 1 / (2 * n) - 1 / (12 * n * n);
  const std::vector<Real> results = run_tasks(rig, problem, task, 1), ieee = on_host(problem, task, 1);
  const double error = std::abs(results[0] - harmonic) / harmonic, bound = bound_in_units * problem.unit;
  return {.verdict = !(error <= bound)          ? Verdict::kWrong
                     : same_bits(results, ieee) ? Verdict::kExact
                                                : Verdict::kWithin,
          .measured = fmt::format("{:.17g} (relative error {:.1e})", results[0], error),
          .truth = fmt::format("{:.17g}; IEEE 754 in this order: {:.17g}", harmonic, ieee[0]),
          .bound = fmt::format("relative error {:.1e}", bound),
          .bytes = bytes_of(results)};
}

// Naive: (n - 1) u. Kahan: 2 u, and 2.5 ULP for Vulkan's division (Higham, section 4.3).
Outcome naive_f32(ExtremeRig& rig) { return sum(rig, kSingle, kTaskNaive, 1e6); }
Outcome naive_f64(ExtremeRig& rig) { return sum(rig, kDouble, kTaskNaive, 1e6); }
Outcome kahan_f32(ExtremeRig& rig) { return sum(rig, kSingle, kTaskKahan, 8); }
Outcome kahan_f64(ExtremeRig& rig) { return sum(rig, kDouble, kTaskKahan, 8); }

// ---- chaos
// -------------------------------------------------------------------------------------------------------------------------

template <typename Real>
Outcome chaos(ExtremeRig& rig, const Problem<Real>& problem, int task, double low, double high) {
  if (lacks<Real>(rig)) return {};
  constexpr int kStarts = 8;
  const std::vector<Real> results = run_tasks(rig, problem, task, kStarts), ieee = on_host(problem, task, kStarts);
  const bool inside = std::ranges::all_of(results, [&](Real x) { return x >= low && x <= high; });
  return {.verdict = same_bits(results, ieee) ? Verdict::kExact
                     : inside                 ? Verdict::kWithin
                                              : Verdict::kWrong,
          .measured = fmt::format("{:.9g}, {:.9g}, ...", results[0], results[1]),
          .truth = fmt::format("IEEE 754: {:.9g}, {:.9g}, ...", ieee[0], ieee[1]),
          .bound = fmt::format("the attractor, {:g} to {:g}: no truth is near, but bits must not vary", low, high),
          .bytes = bytes_of(results)};
}

Outcome logistic_f32(ExtremeRig& rig) { return chaos(rig, kSingle, kTaskLogistic, 0, 1); }
Outcome logistic_f64(ExtremeRig& rig) { return chaos(rig, kDouble, kTaskLogistic, 0, 1); }
Outcome henon_f32(ExtremeRig& rig) { return chaos(rig, kSingle, kTaskHenon, -1.3, 1.3); }
Outcome henon_f64(ExtremeRig& rig) { return chaos(rig, kDouble, kTaskHenon, -1.3, 1.3); }

constexpr const char* kTestSet = "Test Set for IVP Solvers (Mazzia, Magherini 2008), ROBER and VDPOL; t = 40: CVODE's example";
constexpr const char* kHigham = "Higham, Accuracy and Stability of Numerical Algorithms; IEEE 754 on the host";
constexpr const char* kOnHost = "IEEE 754: the same text compiled for the host; NoContraction forbids anything else";

constexpr ExtremeCase kCases[] = {
    {"stiff", "Robertson to t = 40, f32", "Three reactions, rates from 0.04 to 3e7, by a Rosenbrock method of order 2", kTestSet,
     robertson_f32},
    {"stiff", "Robertson to t = 40, f64", "The same in double precision", kTestSet, robertson_f64},
    {"stiff", "Robertson to t = 10^11, f64", "Seventeen decades of time", kTestSet, robertson_long},
    {"stiff", "Van der Pol, mu = 1000, f32", "Relaxation oscillations to t = 2000, with compensated time", kTestSet,
     van_der_pol_f32},
    {"stiff", "Van der Pol, mu = 1000, f64", "The same in double precision", kTestSet, van_der_pol_f64},
    {"stiff", "Hilbert systems, f32", "Elimination with pivoting, n = 2 to 12", kHigham, hilbert_f32},
    {"stiff", "Hilbert systems, f64", "The same in double precision", kHigham, hilbert_f64},
    {"stiff", "naive sum, f32", "1 + 1/2 + ... + 1/10^6 from the front", kHigham, naive_f32},
    {"stiff", "Kahan's sum, f32", "The same, compensated", kHigham, kahan_f32},
    {"stiff", "naive sum, f64", "In double precision", kHigham, naive_f64},
    {"stiff", "Kahan's sum, f64", "The same, compensated", kHigham, kahan_f64},
    {"stiff", "logistic map, f32", "10,000 steps from 8 places: every rounding shows", kOnHost, logistic_f32},
    {"stiff", "logistic map, f64", "In double precision", kOnHost, logistic_f64},
    {"stiff", "Henon's map, f32", "The same for another map", kOnHost, henon_f32},
    {"stiff", "Henon's map, f64", "In double precision", kOnHost, henon_f64},
};

}  // namespace

std::span<const ExtremeCase> stiff_cases() { return kCases; }

}  // namespace pineda::tools
