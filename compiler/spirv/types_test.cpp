// Numbers of every width: arithmetic, conversions, bit operations, storage and constants against C++ oracles. Every program runs
// twice, with and without constants known, and reads and writes memory in the width of its type.
#include <cmath>
#include <limits>
#include <random>
#include <type_traits>

#include "base/half.h"
#include "compiler/ir/semantics.h"
#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

constexpr uint32_t kSeed = 8128;
const char kExtensions[] = R"(
#extension GL_EXT_shader_explicit_arithmetic_types : require
#extension GL_EXT_shader_8bit_storage : require
#extension GL_EXT_shader_16bit_storage : require
#extension GL_EXT_shader_subgroup_extended_types_int8 : enable
)";

// Runs `body` for 16 lanes over in_[] and out_[] of the given types; `lane` is the index.
template <typename In, typename Out>
std::vector<Out> map(const std::string& in_type, const std::string& out_type, const std::string& body,
                     const std::vector<In>& in) {
  const std::string text =
      std::string(kExtensions) + "layout(local_size_x = 16) in;\n" + "layout(std430, set = 0, binding = 0) buffer A { " +
      in_type + " a_[]; };\n" + "layout(std430, set = 0, binding = 1) buffer B { " + out_type + " b_[]; };\n" +
      "void main() { uint lane = gl_LocalInvocationIndex; " + in_type + " a = a_[3 * lane], b = a_[3 * lane + 1], " +
      "c = a_[3 * lane + 2]; " + out_type + " r; " + body + "\n b_[lane] = r; }\n";
  const Words words = glsl(VK_SHADER_STAGE_COMPUTE_BIT, text, "vulkan1.1");
  std::vector<Out> out(in.size() / 3);
  for (size_t first = 0; first < out.size(); first += 16) {
    FakeStage stage;
    stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
    stage.buffers[0].words.resize(48 * sizeof(In) / 4);
    stage.buffers[10].words.resize(16 * sizeof(Out) / 4);
    const size_t lanes = std::min<size_t>(16, out.size() - first);
    std::memcpy(stage.buffers[0].words.data(), in.data() + 3 * first, 3 * lanes * sizeof(In));
    EXPECT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, words), "") << body;
    std::memcpy(static_cast<void*>(out.data() + first), stage.buffers[10].words.data(), lanes * sizeof(Out));
  }
  return out;
}

// ---- integers -------------------------------------------------------------------------------------------------------------

template <typename T>
struct IntRow {
  const char* text;
  T (*oracle)(T a, T b, T c);
};

template <typename T>
using Unsigned = std::make_unsigned_t<T>;

template <typename T>
T wrap(uint64_t v) {
  return static_cast<T>(static_cast<Unsigned<T>>(v));
}

// What holds for signed and unsigned numbers alike.
template <typename T>
std::vector<IntRow<T>> int_rows() {
  return {
      {"r = a + b;", [](T a, T b, T) { return wrap<T>(uint64_t(a) + uint64_t(b)); }},
      {"r = a - b;", [](T a, T b, T) { return wrap<T>(uint64_t(a) - uint64_t(b)); }},
      {"r = a * b;", [](T a, T b, T) { return wrap<T>(uint64_t(a) * uint64_t(b)); }},
      {"r = -a;", [](T a, T, T) { return wrap<T>(0 - uint64_t(a)); }},
      {"r = ~a;", [](T a, T, T) { return wrap<T>(~uint64_t(a)); }},
      {"r = (a & b) | (c ^ a);", [](T a, T b, T c) { return wrap<T>((a & b) | (c ^ a)); }},
      {"r = b == T(0) ? a : a / b;",
       [](T a, T b, T) { return b == 0                              ? a
                                : b == T(-1) && std::is_signed_v<T> ? wrap<T>(0 - uint64_t(a))
                                                                    : T(a / b); }},
      {"r = a << T(b & T(7));", [](T a, T b, T) { return wrap<T>(uint64_t(a) << (b & 7)); }},
      {"r = a >> T(b & T(7));", [](T a, T b, T) { return T(a >> (b & 7)); }},
      {"r = a < b ? a : c;", [](T a, T b, T c) { return a < b ? a : c; }},
      {"r = a >= b ? b : c;", [](T a, T b, T c) { return a >= b ? b : c; }},
      {"r = min(a, b) + max(b, c);", [](T a, T b, T c) { return wrap<T>(uint64_t(std::min(a, b)) + uint64_t(std::max(b, c))); }},
      {"r = clamp(a, min(b, c), max(b, c));", [](T a, T b, T c) { return std::clamp(a, std::min(b, c), std::max(b, c)); }},
      {"r = T(0); for (T i = T(0); i < T(b & T(7)); ++i) r += i * a;",
       [](T a, T b, T) {
         uint64_t r = 0;
         for (uint64_t i = 0; i < uint64_t(b & 7); ++i) r += i * uint64_t(a);
         return wrap<T>(r);
       }},
      {"bvec2 q = bvec2(a < b, b < c); r = q.x == q.y ? T(1) : T(0);", [](T a, T b, T c) { return T((a < b) == (b < c)); }},
  };
}

std::string with_type(std::string text, const std::string& type) {
  for (size_t at = 0; (at = text.find('T', at)) != std::string::npos; at += type.size()) {
    const bool is_word = (at > 0 && std::isalnum(text[at - 1])) || (at + 1 < text.size() && std::isalnum(text[at + 1]));
    if (!is_word) text.replace(at, 1, type);
  }
  return text;
}

template <typename T>
std::vector<T> int_inputs() {
  std::mt19937_64 random(kSeed);
  const T special[] = {0, 1, T(-1), std::numeric_limits<T>::min(), std::numeric_limits<T>::max(), 2, 7, T(-7)};
  std::vector<T> out;
  for (uint32_t i = 0; i < 3 * 64; ++i) out.push_back(i % 3 == 0 || random() % 2 ? special[random() % 8] : T(random()));
  return out;
}

template <typename T>
void check_ints(const std::string& type) {
  const std::vector<T> in = int_inputs<T>();
  for (const IntRow<T>& row : int_rows<T>()) {
    const std::vector<T> out = map<T, T>(type, type, with_type(row.text, type), in);
    for (size_t i = 0; i < out.size(); ++i) {
      const T a = in[3 * i], b = in[3 * i + 1], c = in[3 * i + 2];
      ASSERT_EQ(int64_t(out[i]), int64_t(row.oracle(a, b, c)))
          << type << ": " << row.text << " of " << int64_t(a) << ", " << int64_t(b) << ", " << int64_t(c);
    }
  }
}

TEST(SpirvTypes, Int8) { check_ints<int8_t>("int8_t"); }
TEST(SpirvTypes, Uint8) { check_ints<uint8_t>("uint8_t"); }
TEST(SpirvTypes, Int16) { check_ints<int16_t>("int16_t"); }
TEST(SpirvTypes, Uint16) { check_ints<uint16_t>("uint16_t"); }
TEST(SpirvTypes, Int64) { check_ints<int64_t>("int64_t"); }
TEST(SpirvTypes, Uint64) { check_ints<uint64_t>("uint64_t"); }

// Arrays too large to be kept as values: one Local for each element type.
TEST(SpirvTypes, LocalArrays) {
  for (const char* type : {"int8_t", "int16_t", "int64_t", "float16_t", "double"}) {
    const std::string body = with_type(
        "struct S { T x; int64_t y; } s[20]; for (int i = 0; i < 20; ++i) { s[i].x = T(i); s[i].y = int64_t(i) << 33; }\n"
        "s[uint(a) % 20u].x = T(77); r = int64_t(s[uint(b) % 20u].x) + s[uint(a) % 20u].y;",
        type);
    std::vector<int64_t> in;
    for (int64_t i = 0; i < 48; ++i) in.push_back(i * 7 % 31);
    const std::vector<int64_t> out = map<int64_t, int64_t>("int64_t", "int64_t", body, in);
    for (size_t i = 0; i < out.size(); ++i) {
      const int64_t a = in[3 * i] % 20, b = in[3 * i + 1] % 20;
      EXPECT_EQ(out[i], (a == b ? 77 : b) + (a << 33)) << type;
    }
  }
}

TEST(SpirvTypes, IntConversions) {
  const std::vector<int64_t> in = int_inputs<int64_t>();
  const std::vector<int64_t> out = map<int64_t, int64_t>(
      "int64_t", "int64_t",
      "r = int64_t(int8_t(a)) * 3L + int64_t(uint8_t(b)) * 5L + int64_t(int16_t(a)) * 7L + int64_t(uint16_t(c)) * 11L + "
      "int64_t(int(b)) + int64_t(uint64_t(uint(c)));",
      in);
  for (size_t i = 0; i < out.size(); ++i) {
    const int64_t a = in[3 * i], b = in[3 * i + 1], c = in[3 * i + 2];
    EXPECT_EQ(out[i], int8_t(a) * 3l + uint8_t(b) * 5l + int16_t(a) * 7l + uint16_t(c) * 11l + int32_t(b) + int64_t(uint32_t(c)));
  }
}

TEST(SpirvTypes, Bits64) {
  const std::vector<uint64_t> in = int_inputs<uint64_t>();
  const std::vector<uint64_t> out = map<uint64_t, uint64_t>(
      "uint64_t", "uint64_t",
      "uvec2 u = unpackUint2x32(a); u16vec4 h = unpackUint4x16(b); r = packUint2x32(u.yx) ^ packUint4x16(h.wzyx) + "
      "uint64_t(unpack8(u.x).y) + (a == b ? 1UL : 0UL) + uint64_t(pack32(unpack16(u.y).yx));",
      in);
  for (size_t i = 0; i < out.size(); ++i) {
    const uint64_t a = in[3 * i], b = in[3 * i + 1];
    const uint64_t swapped = a >> 32 | a << 32;
    const uint64_t reversed = (b & 0xffff) << 48 | (b >> 16 & 0xffff) << 32 | (b >> 32 & 0xffff) << 16 | b >> 48;
    const uint32_t high = static_cast<uint32_t>(a >> 32);
    EXPECT_EQ(out[i], swapped ^ (reversed + (a >> 8 & 0xff) + (a == b) + (high >> 16 | high << 16)));
  }
}

// ---- floats ---------------------------------------------------------------------------------------------------------------

struct Half {
  uint16_t bits = 0;
  Half() = default;
  explicit Half(double v) : bits(ir::half_from_double(v)) {}
  double value() const { return ir::double_from_half(bits); }
};

struct FloatRow {
  const char* text;
  double (*oracle)(double a, double b, double c);  // rounded once, to the type, by the caller
};

// One rounding each: computed in double (or long double) and rounded to the type they are exact by the theorem quoted in
// compiler/ir/semantics.cpp.
const FloatRow kFloatRows[] = {
    {"r = a + b;", [](double a, double b, double) { return a + b; }},
    {"r = a - b;", [](double a, double b, double) { return a - b; }},
    {"r = a * b;", [](double a, double b, double) { return a * b; }},
    {"r = a / b;", [](double a, double b, double) { return a / b; }},
    {"r = -a;", [](double a, double, double) { return -a; }},
    {"r = abs(a);", [](double a, double, double) { return std::fabs(a); }},
    {"r = sqrt(abs(a));", [](double a, double, double) { return std::sqrt(std::fabs(a)); }},
    {"r = floor(a);", [](double a, double, double) { return std::floor(a); }},
    {"r = ceil(a);", [](double a, double, double) { return std::ceil(a); }},
    {"r = trunc(a);", [](double a, double, double) { return std::trunc(a); }},
    {"r = roundEven(a);", [](double a, double, double) { return std::nearbyint(a); }},
    {"r = sign(a);", [](double a, double, double) { return double(a > 0) - double(a < 0); }},
    {"r = step(a, b);", [](double a, double b, double) { return b < a ? 0.0 : 1.0; }},
    {"r = a < b ? c : a;", [](double a, double b, double c) { return a < b ? c : a; }},
    {"r = a != b ? c : b;", [](double a, double b, double c) { return a != b ? c : b; }},
    {"r = isnan(a) ? T(1.0) : isinf(a) ? T(2.0) : T(3.0);",
     [](double a, double, double) { return std::isnan(a)   ? 1.0
                                           : std::isinf(a) ? 2.0
                                                           : 3.0; }},
    {"T whole; T part = modf(a, whole); r = b < T(0.0) ? whole : part;",
     [](double a, double b, double) { return b < 0           ? std::trunc(a)
                                             : std::isinf(a) ? 0.0
                                                             : a - std::trunc(a); }},
    {"int e; T m = frexp(a, e); r = b < T(0.0) ? T(e) : m;",
     [](double a, double b, double) {
       int e = 0;
       const double m = std::frexp(a, &e);
       if (!std::isfinite(a)) return b < 0 ? 0.0 : a;
       return b < 0 ? double(e) : m;
     }},
    {"r = ldexp(a, int(lane) * 3 - 30);", nullptr},  // checked by Ldexp
};

template <typename T>
std::vector<T> float_inputs(double largest, double smallest) {
  std::mt19937_64 random(kSeed);
  const double special[] = {0.0,     -0.0,     1.0,     -1.5,          2.5,
                            1.0 / 3, smallest, largest, -smallest * 3, std::numeric_limits<double>::infinity(),
                            -7.25,   1000.5};
  std::vector<T> out;
  for (uint32_t i = 0; i < 3 * 64; ++i) {
    const double ordinary =
        std::ldexp(static_cast<double>(static_cast<int64_t>(random())) * 0x1p-63, static_cast<int>(random() % 20) - 8);
    out.push_back(T(random() % 3 ? ordinary : special[random() % 12]));
  }
  return out;
}

double value_of(double v) { return v; }
double value_of(Half v) { return v.value(); }

template <typename T>
void check_floats(const std::string& type, double largest, double smallest) {
  const std::vector<T> in = float_inputs<T>(largest, smallest);
  for (const FloatRow& row : kFloatRows) {
    if (!row.oracle) continue;
    const std::vector<T> out = map<T, T>(type, type, with_type(row.text, type), in);
    for (size_t i = 0; i < out.size(); ++i) {
      const double a = value_of(in[3 * i]), b = value_of(in[3 * i + 1]), c = value_of(in[3 * i + 2]);
      const double want = value_of(T(row.oracle(a, b, c))), got = value_of(out[i]);
      if (std::isnan(want)) {
        ASSERT_TRUE(std::isnan(got)) << type << ": " << row.text << " of " << a << ", " << b << ", " << c;
      } else {
        ASSERT_EQ(got, want) << type << ": " << row.text << " of " << a << ", " << b << ", " << c;
      }
    }
  }
}

TEST(SpirvTypes, Float16) { check_floats<Half>("float16_t", 65504, 0x1p-24); }
TEST(SpirvTypes, Float64) { check_floats<double>("double", 1.7e308, 4.9e-324); }

TEST(SpirvTypes, Ldexp) {
  for (int shift : {-2000, -1074, -60, 0, 60, 1023, 2000}) {
    const std::vector<double> in = float_inputs<double>(1.7e308, 4.9e-324);
    const std::string text = "r = ldexp(a, " + std::to_string(shift) + ");";
    const std::vector<double> out = map<double, double>("double", "double", text, in);
    for (size_t i = 0; i < out.size(); ++i) EXPECT_EQ(out[i], std::ldexp(in[3 * i], shift)) << in[3 * i] << " " << shift;
  }
  const std::vector<Half> in = float_inputs<Half>(65504, 0x1p-24);
  const std::vector<Half> out = map<Half, Half>("float16_t", "float16_t", "r = ldexp(a, int(lane) * 3 - 24);", in);
  for (size_t i = 0; i < out.size(); ++i) {
    EXPECT_EQ(out[i].value(), Half(std::ldexp(in[3 * i].value(), static_cast<int>(i % 16) * 3 - 24)).value());
  }
}

TEST(SpirvTypes, DoublePacking) {
  const std::vector<double> in = float_inputs<double>(1.7e308, 4.9e-324);
  const std::vector<double> out =
      map<double, double>("double", "double", "uvec2 u = unpackDouble2x32(a); u.y ^= 0x80000000u; r = packDouble2x32(u);", in);
  for (size_t i = 0; i < out.size(); ++i) EXPECT_EQ(std::bit_cast<uint64_t>(out[i]), std::bit_cast<uint64_t>(-in[3 * i]));
}

// Every pair of widths, to even.
TEST(SpirvTypes, FloatConversions) {
  std::vector<double> in = float_inputs<double>(1.7e308, 4.9e-324);
  for (double v :
       {2049.0, 2051.0, 65519.9, 65520.0, 0x1p-25, 0x1.8p-25, 0x1.002p0, 0x1.006p0, 0x1.0000011p0, -1e-9, 3e38, 3.5e38, 1e-46})
    in.insert(in.end(), {v, -v, v});
  while (in.size() % 3 != 0) in.push_back(0);
  struct Row {
    const char* text;
    double (*oracle)(double);
  };
  const Row rows[] = {
      {"r = double(float16_t(a));", [](double a) { return ir::double_from_half(ir::half_from_double(a)); }},
      {"r = double(float(a));", [](double a) { return double(float(a)); }},
      {"r = double(float16_t(float(a)));", [](double a) { return ir::double_from_half(float_to_half(float(a))); }},
      {"r = double(int64_t(a));", [](double a) { return double(a >= 0x1p63 ? INT64_MAX : int64_t(a)); }},
      {"r = double(uint16_t(abs(a)));", [](double a) { return double(uint16_t(std::min(std::fabs(a), 65535.0))); }},
      {"r = double(float16_t(int16_t(a)));",
       [](double a) { return Half(double(int16_t(std::clamp(a, -32768.0, 32767.0)))).value(); }},
      {"r = double(float(int64_t(a)));", [](double a) { return double(float(a >= 0x1p63 ? INT64_MAX : int64_t(a))); }},
  };
  for (const Row& row : rows) {
    const std::vector<double> out = map<double, double>("double", "double", row.text, in);
    for (size_t i = 0; i < out.size(); ++i) EXPECT_EQ(out[i], row.oracle(in[3 * i])) << row.text << " of " << in[3 * i];
  }
}

// FPRoundingMode: the neighbour toward zero where the number is not representable.
TEST(SpirvTypes, RoundingModes) {
  const std::string head = R"(
OpCapability Shader
OpCapability Float16
OpCapability Int16
OpCapability StorageBuffer16BitAccess
OpExtension "SPV_KHR_16bit_storage"
OpMemoryModel Logical GLSL450
OpEntryPoint GLCompute %main "main" %index
OpExecutionMode %main LocalSize 16 1 1
OpDecorate %index BuiltIn LocalInvocationIndex
OpDecorate %array ArrayStride 4
OpMemberDecorate %block 0 Offset 0
OpDecorate %block BufferBlock
OpDecorate %data DescriptorSet 0
OpDecorate %data Binding 0
OpDecorate %h FPRoundingMode RTZ
%void = OpTypeVoid
%fn = OpTypeFunction %void
%uint = OpTypeInt 32 0
%half = OpTypeFloat 16
%float = OpTypeFloat 32
%array = OpTypeRuntimeArray %float
%block = OpTypeStruct %array
%p_block = OpTypePointer Uniform %block
%p_float = OpTypePointer Uniform %float
%p_in = OpTypePointer Input %uint
%data = OpVariable %p_block Uniform
%index = OpVariable %p_in Input
%u0 = OpConstant %uint 0
%main = OpFunction %void None %fn
%entry = OpLabel
%x = OpLoad %uint %index
%p = OpAccessChain %p_float %data %u0 %x
%a = OpLoad %float %p
%h = OpFConvert %half %a
%f = OpFConvert %float %h
OpStore %p %f
OpReturn
OpFunctionEnd
)";
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
  const float in[16] = {1.0f,       1.0009765f,  -1.0009765f, 0x1.ffep0f, 0x1.fffp0f,
                        65519.0f,   65520.0f,    1e30f,       -1e30f,     0x1p-25f,
                        0x1.8p-24f, -0x1.cp-24f, 0.0f,        -0.0f,      std::numeric_limits<float>::infinity(),
                        3.14159f};
  for (float v : in) stage.buffers[0].words.push_back(word(v));
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, assembly(head)), "");
  for (uint32_t i = 0; i < 16; ++i) {
    const double a = std::fabs(in[i]);
    double want = a;
    if (std::isfinite(a)) {
      const double unit = a < 0x1p-14 ? 0x1p-24 : std::ldexp(1.0, std::ilogb(a) - 10);
      want = std::min(65504.0, std::trunc(a / unit) * unit);
    }
    EXPECT_EQ(real(stage.buffers[0].words[i]), std::copysign(static_cast<float>(want), in[i])) << in[i];
  }
}

// ---- storage --------------------------------------------------------------------------------------------------------------

// Structs of mixed widths in the std430 and scalar layouts, in shared memory and in push constants.
TEST(SpirvTypes, Layouts) {
  const std::string text = std::string(kExtensions) + R"(
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 16) in;
struct Mixed { uint8_t a; f16vec3 b; double c; i16vec2 d; int64_t e[2]; };
layout(scalar, set = 0, binding = 0) buffer A { Mixed s[]; };
layout(std430, set = 0, binding = 1) buffer B { Mixed t[]; };
layout(std430, row_major, set = 0, binding = 2) buffer C { layout(row_major) dmat2x3 m[2]; f16mat3 h; };
layout(std430, push_constant) uniform P { uint8_t small[4]; uint16_t middle; int64_t large; } push;
shared Mixed tile[16];
void main() { uint i = gl_LocalInvocationIndex;
  tile[i] = s[i]; tile[i].e[i & 1u] += push.large; tile[i].a += push.small[i & 3u]; tile[i].d.y = int16_t(push.middle);
  t[i] = tile[i];
  if (i == 0u) { m[1] = 2.0lf * m[0]; m[1][1][2] = 0.5lf; h[2] = h[0] + f16vec3(m[0][1]); } })";
  struct alignas(8) Scalar {  // scalar: each member at its own alignment
    uint8_t a;
    uint16_t b[3];
    double c;
    int16_t d[2];
    int64_t e[2];
  };
  static_assert(sizeof(Scalar) == 40);
  struct Std430 {
    uint8_t a, pad[7];
    uint16_t b[3], pad2;
    double c;
    int16_t d[2];
    uint32_t pad3;
    int64_t e[2];
  };
  static_assert(sizeof(Std430) == 48);
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
  std::vector<Scalar> in(16);
  for (int i = 0; i < 16; ++i) {
    in[i] = {static_cast<uint8_t>(250 + i),
             {float_to_half(i + 0.5f), float_to_half(-i), float_to_half(3)},
             i * 1e100,
             {static_cast<int16_t>(-i), 7},
             {int64_t{i} << 40, -int64_t{i}}};
  }
  stage.buffers[0].words.resize(16 * sizeof(Scalar) / 4);
  std::memcpy(stage.buffers[0].words.data(), in.data(), 16 * sizeof(Scalar));
  stage.buffers[10].words.resize(16 * sizeof(Std430) / 4);
  // row-major 2 columns, 3 rows: rows of two doubles, 16 bytes apart; then halves in columns? rows 8 bytes apart
  std::vector<double> matrices(12);
  for (int k = 0; k < 6; ++k) matrices[k] = k + 0.25;
  stage.buffers[20].words.resize(2 * 12 + 8);
  std::memcpy(stage.buffers[20].words.data(), matrices.data(), 96);
  uint16_t h[3][4] = {};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) h[r][c] = float_to_half(10.0f * r + c);
  }
  std::memcpy(stage.buffers[20].words.data() + 24, h, 24);
  stage.buffers[9999].words = {0x04030201, 0xfff9, 0x89abcdef, 0x01234567};
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, glsl(VK_SHADER_STAGE_COMPUTE_BIT, text, "vulkan1.2")), "");
  std::vector<Std430> out(16);
  std::memcpy(out.data(), stage.buffers[10].words.data(), 16 * sizeof(Std430));
  for (int i = 0; i < 16; ++i) {
    EXPECT_EQ(out[i].a, static_cast<uint8_t>(in[i].a + 1 + i % 4));
    for (int k = 0; k < 3; ++k) EXPECT_EQ(out[i].b[k], in[i].b[k]);
    EXPECT_EQ(out[i].c, in[i].c);
    EXPECT_EQ(out[i].d[0], in[i].d[0]);
    EXPECT_EQ(out[i].d[1], -7);
    for (int k = 0; k < 2; ++k) EXPECT_EQ(out[i].e[k], in[i].e[k] + (k == i % 2 ? 0x0123456789abcdef : 0));
  }
  std::memcpy(matrices.data(), stage.buffers[20].words.data(), 96);
  for (int k = 0; k < 6; ++k) EXPECT_EQ(matrices[6 + k], k == 5 ? 0.5 : 2 * (k + 0.25)) << k;  // row 2, column 1 is the last one
  std::memcpy(h, stage.buffers[20].words.data() + 24, 24);
  for (int r = 0; r < 3; ++r) EXPECT_EQ(half_to_float(h[r][2]), 10.0f * r + float(2 * r + 1 + 0.25)) << r;
}

TEST(SpirvTypes, SpecialisationOfEveryWidth) {
  const std::string text = std::string(kExtensions) + R"(
layout(local_size_x = 1) in;
layout(constant_id = 0) const bool kB = false; layout(constant_id = 4) const int kI = -5;
layout(constant_id = 5) const double kD = 1.0lf; layout(constant_id = 6) const int64_t kL = 3L;
layout(constant_id = 7) const int16_t kS = int16_t(2); layout(constant_id = 8) const float16_t kH = float16_t(0.5);
const int64_t kSum = kL * 1000000000000L + int64_t(kI); const int64_t kShift = kL << 40; const uint kPicked = kB ? 17u : uint(kI) >> 28;
layout(set = 0, binding = 0) buffer A { int64_t sum, shift; double d; uint picked; int s; float h; };
void main() { sum = kSum; shift = kShift; d = kD; picked = kPicked; s = int(kS) * 100; h = float(kH); })";
  const auto bytes = [](auto v) {
    std::vector<uint8_t> out(sizeof v);
    std::memcpy(out.data(), &v, sizeof v);
    return out;
  };
  const std::vector<SpecializationConstant> values{
      {5, bytes(-2.5)}, {6, bytes(int64_t{-7})}, {7, bytes(int16_t{-3})}, {8, bytes(uint16_t{0x4400})}};
  for (bool specialised : {false, true}) {
    FakeStage stage;
    stage.buffers[0].words.resize(10);
    Options options;
    if (specialised) options.specialization = values;
    ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, glsl(VK_SHADER_STAGE_COMPUTE_BIT, text, "vulkan1.1"), options), "");
    int64_t sum[2];
    double d;
    std::memcpy(sum, stage.buffers[0].words.data(), 16);
    std::memcpy(&d, stage.buffers[0].words.data() + 4, 8);
    const int64_t l = specialised ? -7 : 3;
    EXPECT_EQ(sum[0], l * 1000000000000 - 5);
    EXPECT_EQ(sum[1], static_cast<int64_t>(static_cast<uint64_t>(l) << 40));
    EXPECT_EQ(d, specialised ? -2.5 : 1.0);
    EXPECT_EQ(stage.buffers[0].words[6], 15u);
    EXPECT_EQ(static_cast<int>(stage.buffers[0].words[7]), specialised ? -300 : 200);
    EXPECT_EQ(real(stage.buffers[0].words[8]), specialised ? 4.0f : 0.5f);
  }
}

// Built-in inputs that the stage need not know of.
TEST(SpirvTypes, DeviceIndex) {
  const std::string text =
      "#extension GL_EXT_device_group : require\nlayout(location = 0) out uint r;"
      "void main() { r = uint(gl_DeviceIndex) + 5u; gl_Position = vec4(0); }";
  FakeStage stage;
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_VERTEX_BIT, glsl(VK_SHADER_STAGE_VERTEX_BIT, text, "vulkan1.1")), "");
  EXPECT_EQ(stage.at(0)[3], 5u);
}

// 16-bit and 64-bit numbers between stages: widened to words, or two words.
TEST(SpirvTypes, Interfaces) {
  const std::string text = std::string(kExtensions) + R"(
layout(location = 0) flat in dvec3 a; layout(location = 2) in f16vec2 b; layout(location = 3) flat in i16vec2 c;
layout(location = 0) out vec4 sum; layout(location = 1) out f16vec2 half_; layout(location = 2) out i16vec2 short_;
void main() { sum = vec4(a, b.x); half_ = b * float16_t(2.0); short_ = c - int16_t(1); })";
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar& s) -> uint32_t {
    if (s.location < 2) {  // the doubles (lane + 1.5) * 2^k
      const uint32_t k = (s.location * 4 + s.component) / 2;
      const auto bits = std::bit_cast<uint64_t>(std::ldexp(lane + 1.5, static_cast<int>(k)));
      return static_cast<uint32_t>(s.component % 2 ? bits >> 32 : bits);
    }
    if (s.location == 2) return word(lane + 0.25f * s.component);
    return lane == 0 ? 0u : lane + s.component;
  };
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_FRAGMENT_BIT, glsl(VK_SHADER_STAGE_FRAGMENT_BIT, text, "vulkan1.1")), "");
  for (uint32_t lane = 0; lane < 16; ++lane) {
    for (uint32_t k = 0; k < 3; ++k) EXPECT_EQ(real(stage.at(0, k)[lane]), std::ldexp(lane + 1.5f, static_cast<int>(k)));
    EXPECT_EQ(real(stage.at(0, 3)[lane]), static_cast<float>(lane));
    EXPECT_EQ(real(stage.at(1, 1)[lane]), 2 * (lane + 0.25f));
    EXPECT_EQ(static_cast<int>(stage.at(2, 0)[lane]), static_cast<int>(lane) - 1);
  }
}

}  // namespace
}  // namespace pineda::spirv::test
