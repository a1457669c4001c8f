// pipeline.push_constant and pipeline.spec_constant: values that reach the shader without a buffer.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

// A dispatch after each of several updates; every word of the block must hold what was written last.
struct Update {
  uint32_t offset_words, count_words;
};
void run_push_updates(Device& device, const std::vector<Update>& updates, uint32_t size_words) {
  require(size_words * 4 <= device.limits().maxPushConstantsSize, "push constants of this size");
  const Buffer out = create_buffer(device, updates.size() * size_words * 4);
  Resources resources;
  resources.descriptors = {storage_buffer(0, out)};
  resources.push_constants.resize(size_words * 4);
  const Bindings bindings(device, resources, VK_SHADER_STAGE_COMPUTE_BIT);
  std::string members, stores;
  for (uint32_t i = 0; i < size_words; ++i) {
    members += fmt::format("uint w{}; ", i);
    stores += fmt::format("values[at + {0}u] = w{0};\n", i);
  }
  // The dispatch's number comes from the count of groups in y, so that no push constant is spent on it.
  const Pipeline pipeline = create_compute_pipeline(
      device,
      compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                   fmt::format("layout(local_size_x = 1) in; layout(binding = 0, std430) buffer B {{ uint values[]; }};\n"
                               "layout(push_constant) uniform P {{ {} }};\n"
                               "void main() {{ if (gl_WorkGroupID.y != gl_NumWorkGroups.y - 1u) return;\n"
                               "uint at = gl_WorkGroupID.y * {}u;\n{} }}",
                               members, size_words, stores)),
      bindings.layout(), resources);
  Random random("push");
  std::vector<uint32_t> now(size_words), want;
  device.run([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    bindings.bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, resources);
    for (size_t i = 0; i < updates.size(); ++i) {
      for (uint32_t w = 0; w < updates[i].count_words; ++w) now[updates[i].offset_words + w] = random.bits();
      vkCmdPushConstants(commands, bindings.layout(), VK_SHADER_STAGE_COMPUTE_BIT, updates[i].offset_words * 4,
                         updates[i].count_words * 4, now.data() + updates[i].offset_words);
      vkCmdDispatch(commands, 1, static_cast<uint32_t>(i + 1), 1);
      want.insert(want.end(), now.begin(), now.end());
    }
    full_barrier(commands);
  });
  for (size_t i = 0; i < want.size(); ++i) {
    expect(out.as<uint32_t>()[i] == want[i],
           fmt::format("dispatch {}, word {}: {:#x}, not {:#x}", i / size_words, i % size_words, out.as<uint32_t>()[i], want[i]));
  }
}

// Vertex and fragment stage read different ranges of the same block.
void run_push_stages(Device& device) {
  DrawState state;
  state.resources.push_constants.resize(32);
  const float offset[4] = {0.0f, 0.0f, 0.5f, 1.0f};
  const uint32_t colour[4] = {1, 0x80000000, 0xFFFFFFFF, 42};
  std::memcpy(state.resources.push_constants.data(), offset, 16);
  std::memcpy(state.resources.push_constants.data() + 16, colour, 16);
  state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                              "layout(push_constant) uniform P { vec4 offset; };\n"
                              "void main() { gl_Position = vec4(vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0, 0, 0)"
                              " + offset; }");
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                                "layout(push_constant) uniform P { layout(offset = 16) uvec4 colour; };\n"
                                "layout(location = 0) out uvec4 c; void main() { c = colour; }");
  const std::vector<std::byte> pixels = draw_once(device, state, {4, 4}, VK_FORMAT_R32G32B32A32_UINT);
  for (size_t i = 0; i < 16; ++i) {
    expect(!std::memcmp(pixels.data() + i * 16, colour, 16), fmt::format("pixel {} has another colour", i));
  }
}

// A dynamic index into an array of push constants.
void run_push_dynamic(Device& device, const char* type, uint32_t components) {
  constexpr uint32_t kCount = 8;
  Resources resources;
  Random random(type);
  std::vector<uint32_t> values(kCount * 4);
  for (uint32_t& v : values) v = random.bits();
  const Buffer out = create_buffer(device, kCount * 16);
  resources.descriptors = {storage_buffer(0, out)};
  resources.push_constants.resize(kCount * 16);
  std::memcpy(resources.push_constants.data(), values.data(), kCount * 16);
  std::string load;
  for (uint32_t c = 0; c < components; ++c) {
    load += fmt::format("r[{0}] = uint(values[i]{1}); ", c, components == 1 ? "" : fmt::format("[{}]", c));
  }
  dispatch(device,
           compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                        fmt::format("layout(local_size_x = 8) in; layout(binding = 0, std430) buffer B {{ uvec4 o[]; }};\n"
                                    "layout(push_constant, std430) uniform P {{ layout(align = 16) {} values[8]; }};\n"
                                    "void main() {{ uint i = 7u - gl_LocalInvocationID.x; uvec4 r = uvec4(0); {} o[i] = r; }}",
                                    type, load)),
           resources);
  const uint32_t stride_words = components == 1 ? 1 : components == 2 ? 2 : 4;
  for (uint32_t i = 0; i < kCount; ++i) {
    for (uint32_t c = 0; c < components; ++c) {
      expect(out.as<uint32_t>()[i * 4 + c] == values[i * stride_words + c], fmt::format("element {}, component {}", i, c));
    }
  }
}

// Specialisation constants: the default when nothing is given, the given value otherwise, at every use.
struct SpecType {
  const char* glsl;
  const char* initial;
  uint32_t initial_bits, given_bits;
  const char* to_uint;  // of {}
};
constexpr SpecType kSpecTypes[] = {
    {"uint", "7u", 7, 0xFFFFFFFF, "{}"},
    {"int", "-3", 0xFFFFFFFD, 0x80000000, "uint({})"},
    {"float", "1.5", 0x3FC00000, 0x00000001, "floatBitsToUint({})"},
    {"float", "-0.0", 0x80000000, 0x7F7FFFFF, "floatBitsToUint({})"},
    {"bool", "true", 1, 0, "({} ? 1u : 0u)"},
    {"bool", "false", 0, 1, "({} ? 1u : 0u)"},
};

void run_spec_value(Device& device, const SpecType& type, bool given, uint32_t id) {
  const Buffer out = create_buffer(device, 4);
  Resources resources;
  resources.descriptors = {storage_buffer(0, out)};
  add_specialization(resources, id + 1, 0xABCD);  // ids that the module does not have are ignored
  if (given) add_specialization(resources, id, type.given_bits);
  const std::string expression = fmt::format(fmt::runtime(type.to_uint), "S");
  dispatch(device,
           compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                        fmt::format("layout(local_size_x = 1) in; layout(binding = 0, std430) buffer B {{ uint o; }};\n"
                                    "layout(constant_id = {}) const {} S = {}; void main() {{ o = {}; }}",
                                    id, type.glsl, type.initial, expression)),
           resources);
  const uint32_t want = given ? type.given_bits : type.initial_bits;
  expect(out.as<uint32_t>()[0] == want, fmt::format("{:#x}, not {:#x}", out.as<uint32_t>()[0], want));
}

// OpSpecConstantOp, as glslang emits it for constant expressions of specialisation constants.
struct SpecOp {
  const char* name;
  const char* expression;  // of uint A, B and int C
  uint32_t (*want)(uint32_t a, uint32_t b, int32_t c);
};
constexpr SpecOp kSpecOps[] = {
    {"add", "A + B", [](uint32_t a, uint32_t b, int32_t) { return a + b; }},
    {"subtract", "A - B", [](uint32_t a, uint32_t b, int32_t) { return a - b; }},
    {"multiply", "A * B", [](uint32_t a, uint32_t b, int32_t) { return a * b; }},
    {"divide", "A / B", [](uint32_t a, uint32_t b, int32_t) { return a / b; }},
    {"signed_divide", "uint(C / int(B))",
     [](uint32_t, uint32_t b, int32_t c) { return static_cast<uint32_t>(c / static_cast<int32_t>(b)); }},
    {"modulo", "A % B", [](uint32_t a, uint32_t b, int32_t) { return a % b; }},
    {"shift_left", "A << (B & 31u)", [](uint32_t a, uint32_t b, int32_t) { return a << (b & 31); }},
    {"shift_right", "A >> (B & 31u)", [](uint32_t a, uint32_t b, int32_t) { return a >> (b & 31); }},
    {"shift_right_arithmetic", "uint(C >> 3)", [](uint32_t, uint32_t, int32_t c) { return static_cast<uint32_t>(c >> 3); }},
    {"and", "A & B", [](uint32_t a, uint32_t b, int32_t) { return a & b; }},
    {"or", "A | B", [](uint32_t a, uint32_t b, int32_t) { return a | b; }},
    {"xor", "A ^ B", [](uint32_t a, uint32_t b, int32_t) { return a ^ b; }},
    {"not", "~A", [](uint32_t a, uint32_t, int32_t) { return ~a; }},
    {"negate", "uint(-C)", [](uint32_t, uint32_t, int32_t c) { return 0u - static_cast<uint32_t>(c); }},
    {"less", "uint(A < B)", [](uint32_t a, uint32_t b, int32_t) { return a < b ? 1u : 0u; }},
    {"equal", "uint(A == B)", [](uint32_t a, uint32_t b, int32_t) { return a == b ? 1u : 0u; }},
    {"select", "(A < B ? A : B)", [](uint32_t a, uint32_t b, int32_t) { return a < b ? a : b; }},
    {"logical_equal", "uint((A < B) == (C < 0))", [](uint32_t a, uint32_t b, int32_t c) { return (a < b) == (c < 0) ? 1u : 0u; }},
    {"logical_not", "uint(!(A < B))", [](uint32_t a, uint32_t b, int32_t) { return a < b ? 0u : 1u; }},
};

void run_spec_op(Device& device, const SpecOp& op, uint32_t a, uint32_t b, int32_t c) {
  const Buffer out = create_buffer(device, 4);
  Resources resources;
  resources.descriptors = {storage_buffer(0, out)};
  add_specialization(resources, 10, a);
  add_specialization(resources, 11, b);
  add_specialization(resources, 12, static_cast<uint32_t>(c));
  dispatch(device,
           compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                        fmt::format("layout(local_size_x = 1) in; layout(binding = 0, std430) buffer B_ {{ uint o; }};\n"
                                    "layout(constant_id = 10) const uint A = 1u; layout(constant_id = 11) const uint B = 1u;\n"
                                    "layout(constant_id = 12) const int C = 1; const uint R = {};\n"
                                    "void main() {{ o = R; }}",
                                    op.expression)),
           resources);
  const uint32_t want = op.want(a, b, c);
  expect(out.as<uint32_t>()[0] == want, fmt::format("{:#x}, not {:#x}", out.as<uint32_t>()[0], want));
}

// The length of an array is a specialisation constant.
void run_spec_array(Device& device, uint32_t length) {
  const Buffer out = create_buffer(device, 8);
  Resources resources;
  resources.descriptors = {storage_buffer(0, out)};
  add_specialization(resources, 0, length);
  dispatch(device,
           compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                        "layout(local_size_x = 1) in; layout(binding = 0, std430) buffer B { uint sum, count; };\n"
                        "layout(constant_id = 0) const uint N = 3u; shared uint s[N];\n"
                        "void main() { uint p[N]; for (uint i = 0u; i < N; ++i) { p[i] = i * i; s[N - 1u - i] = i; }\n"
                        "uint t = 0u; for (uint i = 0u; i < N; ++i) t += p[i] * s[i]; sum = t; count = uint(p.length()); }"),
           resources);
  uint32_t want = 0;
  for (uint32_t i = 0; i < length; ++i) want += i * i * (length - 1 - i);
  expect(out.as<uint32_t>()[0] == want && out.as<uint32_t>()[1] == length, "the array has another length");
}

}  // namespace

void register_pipeline_constants() {
  constexpr const char* kPush = "14.6.1 Push Constant Interface";
  const std::vector<std::pair<const char*, std::vector<Update>>> updates = {
      {"whole", {{0, 32}}},
      {"whole_twice", {{0, 32}, {0, 32}}},
      {"first_word_again", {{0, 32}, {0, 1}}},
      {"last_word_again", {{0, 32}, {31, 1}}},
      {"middle_again", {{0, 32}, {5, 11}, {9, 2}}},
      {"halves", {{0, 16}, {16, 16}, {8, 16}}},
  };
  for (const auto& [name, list] : updates) {
    add_case("pipeline.push_constant", fmt::format("update.{}", name), kPush,
             [list = list](Device& device) { run_push_updates(device, list, 32); });
  }
  for (const uint32_t words : {1u, 2u, 3u, 5u, 8u, 13u, 31u}) {
    add_case("pipeline.push_constant", fmt::format("size.{}_words", words), kPush, [words](Device& device) {
      run_push_updates(device, {{0, words}}, words);
    });
  }
  add_case("pipeline.push_constant", "two_stages", kPush, run_push_stages);
  for (const auto& [type, components] : {std::pair{"uint", 1u}, {"int", 1u}, {"uvec2", 2u}, {"ivec2", 2u}, {"uvec4", 4u}}) {
    add_case("pipeline.push_constant", fmt::format("dynamic_index.{}", type), kPush,
             [type = type, components = components](Device& device) { run_push_dynamic(device, type, components); });
  }
  constexpr const char* kSpec = "10.8 Specialization Constants";
  for (const SpecType& type : kSpecTypes) {
    for (const bool given : {false, true}) {
      for (const uint32_t id : {0u, 5u, 1000u}) {
        add_case("pipeline.spec_constant",
                 fmt::format("value.{}_{}_{}_id_{}", type.glsl, type.initial_bits, given ? "given" : "default", id), kSpec,
                 [&type, given, id](Device& device) { run_spec_value(device, type, given, id); });
      }
    }
  }
  for (const SpecOp& op : kSpecOps) {
    for (const auto& [a, b, c] : {std::tuple{17u, 5u, -9}, {5u, 17u, 1000000}, {0xFFFFFFFFu, 3u, -2147483647}}) {
      add_case("pipeline.spec_constant", fmt::format("operation.{}_{}_{}", op.name, a, b), kSpec,
               [&op, a = a, b = b, c = c](Device& device) { run_spec_op(device, op, a, b, c); });
    }
  }
  for (const uint32_t length : {1u, 2u, 7u, 64u, 300u}) {
    add_case("pipeline.spec_constant", fmt::format("array_length.{}", length), kSpec,
             [length](Device& device) { run_spec_array(device, length); });
  }
}

}  // namespace pineda::cts
