// Random structured programs, with arithmetic of every width and arrays under dynamic indices: the same syntax tree is printed as
// GLSL and interpreted in C++.
#include <memory>
#include <random>

#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

constexpr uint32_t kSeed = 20240607;
constexpr uint32_t kFunctions = 60;
constexpr int kMaxDepth = 4;

enum class Kind { kAdd, kCast, kArray, kIf, kFor, kSwitch, kBreak, kContinue, kReturn };

// r ^= uint(T(r * 5 + number) * T(x + 3)) in each integer type T
template <typename T>
uint32_t cast_product(uint32_t r, uint32_t x, uint32_t number) {
  using U = std::make_unsigned_t<T>;
  const T a = static_cast<T>(r * 5 + number), b = static_cast<T>(x + 3);
  const T product = static_cast<T>(static_cast<U>(uint64_t(a) * uint64_t(b)));
  return r ^ static_cast<uint32_t>(product);
}
struct CastRow {
  const char* type;
  uint32_t (*oracle)(uint32_t r, uint32_t x, uint32_t number);
};
constexpr CastRow kCasts[] = {{"int8_t", cast_product<int8_t>},   {"uint8_t", cast_product<uint8_t>},
                              {"int16_t", cast_product<int16_t>}, {"uint16_t", cast_product<uint16_t>},
                              {"int64_t", cast_product<int64_t>}, {"uint64_t", cast_product<uint64_t>}};

// One array is kept as values, the other is memory (flat_memory.h).
constexpr uint32_t kSmall = 5, kLarge = 19;

struct Node {
  Kind kind;
  uint32_t number = 0;                    // constant of the statement
  std::vector<std::vector<Node>> bodies;  // If: then, else; For: body; Switch: cases, the last one is the default
  std::vector<bool> falls;                // Switch: case i has no break
};

// Where the program is: r is hashed by each statement, so that order and count of what ran show in the result.
enum class Signal { kNone, kBreak, kContinue, kReturn };

struct Machine {
  uint32_t x, r = 1;
  uint32_t small[kSmall] = {}, large[kLarge] = {};

  // A condition that depends on the lane, on what ran so far and on the statement.
  bool test(const Node& n) const { return ((r ^ (x * 7)) % 11) < n.number % 11; }

  Signal run(const std::vector<Node>& body) {
    for (const Node& n : body) {
      if (const Signal s = run(n); s != Signal::kNone) return s;
    }
    return Signal::kNone;
  }

  Signal run(const Node& n) {
    switch (n.kind) {
      case Kind::kAdd:
        r = r * 31 + n.number;
        return Signal::kNone;
      case Kind::kCast:
        r = kCasts[n.number % std::size(kCasts)].oracle(r, x, n.number);
        return Signal::kNone;
      case Kind::kArray:
        large[(r + n.number) % kLarge] += r;
        small[(r >> 3) % kSmall] ^= n.number;
        r = r * 3 + large[r % kLarge] + small[n.number % kSmall] + small[r % kSmall];
        return Signal::kNone;
      case Kind::kIf:
        return run(n.bodies[test(n) ? 0 : 1]);
      case Kind::kFor:
        for (uint32_t i = 0; i < n.number % 5; ++i) {
          r += i;
          const Signal s = run(n.bodies[0]);
          if (s == Signal::kBreak) break;
          if (s == Signal::kReturn) return s;
        }
        return Signal::kNone;
      case Kind::kSwitch: {
        const uint32_t last = static_cast<uint32_t>(n.bodies.size()) - 1;
        uint32_t c = std::min((r ^ x) % (last + 2), last);
        for (;; ++c) {
          const Signal s = run(n.bodies[c]);
          if (s == Signal::kContinue || s == Signal::kReturn) return s;
          if (s == Signal::kBreak || !n.falls[c] || c == last) return Signal::kNone;
        }
      }
      case Kind::kBreak:
        return Signal::kBreak;
      case Kind::kContinue:
        return Signal::kContinue;
      case Kind::kReturn:
        r = r * 31 + n.number;
        return Signal::kReturn;
    }
    return Signal::kNone;
  }
};

struct Writer {
  std::mt19937 random{kSeed};
  uint32_t loops = 0;
  uint32_t below(uint32_t n) { return random() % n; }

  std::vector<Node> body(int depth, bool in_loop, bool in_switch) {
    std::vector<Node> out;
    for (uint32_t i = 0, n = 1 + below(3); i < n; ++i) out.push_back(node(depth, in_loop, in_switch));
    return out;
  }

  Node node(int depth, bool in_loop, bool in_switch) {
    Node n{.kind = Kind::kAdd, .number = 1 + below(97)};
    const uint32_t pick = below(20);
    if (depth >= kMaxDepth || pick < 6) {
      constexpr Kind kSimple[] = {Kind::kAdd, Kind::kAdd, Kind::kCast, Kind::kArray};
      n.kind = kSimple[below(4)];
      return n;
    }
    if (pick < 11) {
      n.kind = Kind::kIf;
      n.bodies = {body(depth + 1, in_loop, in_switch), body(depth + 1, in_loop, in_switch)};
    } else if (pick < 14) {
      n.kind = Kind::kFor;
      n.bodies = {body(depth + 1, true, false)};
    } else if (pick < 17) {
      n.kind = Kind::kSwitch;
      for (uint32_t i = 0, cases = 2 + below(3); i < cases; ++i) {
        n.bodies.push_back(body(depth + 1, in_loop, true));
        n.falls.push_back(below(2) == 0);
      }
    } else if (pick == 17 && (in_loop || in_switch)) {
      n.kind = Kind::kBreak;
    } else if (pick == 18 && in_loop) {
      n.kind = Kind::kContinue;
    } else if (pick == 19 && depth > 0) {
      n.kind = Kind::kReturn;
    }
    return n;
  }

  std::string print(const std::vector<Node>& body) {
    std::string out;
    for (const Node& n : body) out += print(n);
    return out;
  }

  std::string print(const Node& n) {
    const std::string number = std::to_string(n.number) + "u";
    switch (n.kind) {
      case Kind::kAdd:
        return "r = r * 31u + " + number + ";\n";
      case Kind::kCast: {
        const std::string type = kCasts[n.number % std::size(kCasts)].type;
        return "r ^= uint(" + type + "(r * 5u + " + number + ") * " + type + "(x + 3u));\n";
      }
      case Kind::kArray:
        return "large[(r + " + number + ") % 19u] += r; small[(r >> 3) % 5u] ^= " + number +
               ";\nr = r * 3u + large[r % 19u] + small[" + number + " % 5u] + small[r % 5u];\n";
      case Kind::kIf:
        return "if (((r ^ (x * 7u)) % 11u) < " + std::to_string(n.number % 11) + "u) {\n" + print(n.bodies[0]) + "} else {\n" +
               print(n.bodies[1]) + "}\n";
      case Kind::kFor: {
        const std::string i = "i" + std::to_string(loops++);
        return "for (uint " + i + " = 0u; " + i + " < " + std::to_string(n.number % 5) + "u; ++" + i + ") {\nr += " + i + ";\n" +
               print(n.bodies[0]) + "}\n";
      }
      case Kind::kSwitch: {
        const size_t last = n.bodies.size() - 1;
        std::string out = "switch ((r ^ x) % " + std::to_string(last + 2) + "u) {\n";
        for (size_t c = 0; c <= last; ++c) {
          out += c == last ? "default:\n" : "case " + std::to_string(c) + "u:\n";
          out += print(n.bodies[c]);
          if (!n.falls[c] || c == last) out += "break;\n";
        }
        return out + "}\n";
      }
      case Kind::kBreak:
        return "break;\n";
      case Kind::kContinue:
        return "continue;\n";
      case Kind::kReturn:
        return "{ r = r * 31u + " + number + "; return r; }\n";
    }
    return "";
  }
};

// The program's functions as one shader, called inside `depth` Ifs, rewritten by spirv-opt (empty: as it is).
void check_against_interpreter(const std::string& passes, uint32_t depth = 0) {
  Writer writer;
  std::vector<std::vector<Node>> programs;
  std::string functions, calls;
  for (uint32_t f = 0; f < kFunctions; ++f) {
    programs.push_back(writer.body(0, false, false));
    functions += "uint f" + std::to_string(f) +
                 "(uint x) {\nuint r = 1u; uint small[5] = uint[](0u, 0u, 0u, 0u, 0u); uint large[19];\n" +
                 "for (uint i = 0u; i < 19u; ++i) large[i] = 0u;\n" + writer.print(programs.back()) + "return r;\n}\n";
    calls += "d[lane + " + std::to_string(16 * f) + "u] = f" + std::to_string(f) + "(lane);\n";
  }
  std::string ifs;
  for (uint32_t i = 0; i < depth; ++i) ifs += "if ((d[lane] & " + std::to_string(1u << i) + "u) == 0u) {\n";
  const Words plain =
      glsl(VK_SHADER_STAGE_COMPUTE_BIT,
           "#extension GL_EXT_shader_explicit_arithmetic_types : require\nlayout(local_size_x = 16) in;\n"
           "layout(std430, set = 0, binding = 0) buffer Data { uint d[]; };\n" +
               functions + "void main() { uint lane = gl_LocalInvocationIndex;\n" + ifs + calls + std::string(depth + 1, '}'),
           "vulkan1.1");
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
  stage.buffers[0].words.resize(16 * kFunctions);
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, passes.empty() ? plain : rewritten(plain, passes)), "");
  for (uint32_t f = 0; f < kFunctions; ++f) {
    for (uint32_t x = 0; x < 16; ++x) {
      Machine machine{.x = x};
      machine.run(programs[f]);
      ASSERT_EQ(stage.buffers[0].words[16 * f + x], machine.r) << "seed " << kSeed << ", x = " << x << " " << passes << "\n"
                                                               << writer.print(programs[f]);
    }
  }
}

TEST(SpirvRandomFlow, AgreesWithAnInterpreter) { check_against_interpreter(""); }
// Where nesting is deep, early exits take another form (flow.h, kNestedDepth).
TEST(SpirvRandomFlow, DeepInside) { check_against_interpreter("", 18); }
TEST(SpirvRandomFlow, DeepInsideWithPhis) {
  check_against_interpreter("--inline-entry-points-exhaustive --eliminate-dead-functions --ssa-rewrite --if-conversion", 18);
}
TEST(SpirvRandomFlow, OptimisedForSpeed) { check_against_interpreter("-O"); }
TEST(SpirvRandomFlow, MergedReturnsAndPhis) {
  check_against_interpreter(
      "--merge-return --inline-entry-points-exhaustive --eliminate-dead-functions --ssa-rewrite --if-conversion");
}
TEST(SpirvRandomFlow, OneIterationLoops) {  // returns become breaks of loops that run once
  check_against_interpreter("--wrap-opkill --merge-return --eliminate-dead-branches --merge-blocks --loop-unroll-partial 2");
}

}  // namespace
}  // namespace pineda::spirv::test
