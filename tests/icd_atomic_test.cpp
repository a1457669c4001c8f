// Atomics through the whole driver: every dimension of storage images and texel buffers, 64-bit integers, floats; from compute
// and fragment shaders.
#include <algorithm>
#include <bit>

#include "shader_client.h"

namespace pineda::test {
namespace {

constexpr auto kCompute = VK_SHADER_STAGE_COMPUTE_BIT;
constexpr auto kFragment = VK_SHADER_STAGE_FRAGMENT_BIT;

// A kind of image with `texels` texels; `place` is the coordinate of texel t, `outside` one that no texel has.
struct Kind {
  const char* name;  // of the GLSL type, behind its letter
  VkImageType type;
  VkImageViewType view;
  VkExtent3D extent;
  uint32_t layers;
  const char *place, *outside;
  uint32_t texels() const { return extent.width * extent.height * extent.depth * layers; }
};
constexpr Kind kKinds[] = {
    {"image1D", VK_IMAGE_TYPE_1D, VK_IMAGE_VIEW_TYPE_1D, {48, 1, 1}, 1, "int(t)", "48"},
    {"image2D", VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_2D, {9, 7, 1}, 1, "ivec2(t % 9, t / 9)", "ivec2(0, 7)"},
    {"image3D", VK_IMAGE_TYPE_3D, VK_IMAGE_VIEW_TYPE_3D, {5, 3, 4}, 1, "ivec3(t % 5, t / 5 % 3, t / 15)", "ivec3(4, 2, 4)"},
    {"imageCube", VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_CUBE, {3, 3, 1}, 6, "ivec3(t % 3, t / 3 % 3, t / 9)", "ivec3(0, 0, 6)"},
    {"image1DArray", VK_IMAGE_TYPE_1D, VK_IMAGE_VIEW_TYPE_1D_ARRAY, {11, 1, 1}, 4, "ivec2(t % 11, t / 11)", "ivec2(0, -1)"},
    {"image2DArray",
     VK_IMAGE_TYPE_2D,
     VK_IMAGE_VIEW_TYPE_2D_ARRAY,
     {5, 4, 1},
     3,
     "ivec3(t % 5, t / 5 % 4, t / 20)",
     "ivec3(-1, 0, 2)"},
    {"imageCubeArray",
     VK_IMAGE_TYPE_2D,
     VK_IMAGE_VIEW_TYPE_CUBE_ARRAY,
     {2, 2, 1},
     12,
     "ivec3(t % 2, t / 2 % 2, t / 4)",
     "ivec3(0, 2, 0)"},
};
constexpr uint32_t kInvocations = kTargetSize * kTargetSize;

struct AtomicsClient : ShaderClient {
  using ShaderClient::ShaderClient;

  VkImageView view_of(VkImage image, VkFormat format, const Kind& kind) {
    const VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,         nullptr, 0, image, kind.view, format, {},
                                     {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, kind.layers}};
    VkImageView out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateImageView)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyImageView)(device, out, nullptr); });
    return out;
  }
  VkImage image_of(VkFormat format, const Kind& kind) {
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    const bool cube = kind.layers % 6 == 0;
    info.flags = cube ? VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT : 0;
    info.imageType = kind.type;
    info.format = format;
    info.extent = kind.extent;
    info.mipLevels = 1;
    info.arrayLayers = kind.layers;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    VkImage out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateImage)(device, &info, nullptr, &out), VK_SUCCESS);
    VkMemoryRequirements requirements;
    VK(*this, GetImageMemoryRequirements)(device, out, &requirements);
    EXPECT_EQ(VK(*this, BindImageMemory)(device, out, memory(requirements.size), 0), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyImage)(device, out, nullptr); });
    to_general(out, format);
    return out;
  }
  std::vector<uint32_t> texels_of(VkImage image, const Kind& kind) {
    const Buffer out = buffer(kind.texels() * 4);
    run([&](VkCommandBuffer cb) {
      const VkBufferImageCopy region{0, 0, 0, color_layers(0, 0, kind.layers), {}, kind.extent};
      VK(*this, CmdCopyImageToBuffer)(cb, image, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &region);
    });
    return {out.as<uint32_t>(), out.as<uint32_t>() + kind.texels()};
  }
};

// `body` for each of kInvocations invocations, i being its number; fragments with an odd i are discarded before.
Words shader(VkShaderStageFlagBits stage, const std::string& head, const std::string& body) {
  if (stage == kCompute) {
    return glsl(
        stage, head + "layout(local_size_x = 64) in; void main() { uint i = gl_GlobalInvocationID.x; if (i % 2u == 1u) return; " +
                   body + "}");
  }
  return glsl(stage, head + "layout(location = 0) out uvec4 r; void main() { uint i = uint(gl_FragCoord.x) + " +
                         std::to_string(kTargetSize) + "u * uint(gl_FragCoord.y); if (i % 2u == 1u) discard; " + body +
                         " r = uvec4(1); }");
}

void run_shader(ShaderClient& client, VkShaderStageFlagBits stage, const std::string& head, const std::string& body) {
  const Words words = shader(stage, head, body);
  const VkResult result =
      stage == kCompute ? client.compute(words, kInvocations / 64) : client.draw(ShaderClient::covering_vertex(), words, 3);
  EXPECT_EQ(result, VK_SUCCESS);
}

TEST(IcdAtomic, ImagesOfEveryDimension) {
  AtomicsClient client;
  for (const VkFormat format : {VK_FORMAT_R32_UINT, VK_FORMAT_R32_SINT}) {
    VkFormatProperties properties;
    VK(client, GetPhysicalDeviceFormatProperties)(client.physical, format, &properties);
    EXPECT_TRUE(properties.optimalTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_ATOMIC_BIT);
    EXPECT_TRUE(properties.linearTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_ATOMIC_BIT);
    const bool is_signed = format == VK_FORMAT_R32_SINT;
    for (const Kind& kind : kKinds) {
      for (const auto stage : {kCompute, kFragment}) {
        SCOPED_TRACE(std::string(kind.name) + (is_signed ? " signed" : " unsigned") +
                     (stage == kCompute ? " compute" : " fragment"));
        const VkImage image = client.image_of(format, kind);
        const auto found = client.buffer(kInvocations * 8);
        client.bind({{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, VK_NULL_HANDLE, client.view_of(image, format, kind)},
                     ShaderClient::storage(found)});
        const std::string number = is_signed ? "int" : "uint", letter = is_signed ? "i" : "u";
        const std::string head = "layout(binding = 0, r32" + letter + (is_signed ? "" : "i") + ") uniform " + letter + kind.name +
                                 " texels; layout(binding = 1) buffer Found { uint found[]; };";
        const std::string body = "uint t = i % " + std::to_string(kind.texels()) +
                                 "u; found[2u * i] = uint(imageAtomicAdd(texels, " + kind.place + ", " + number +
                                 "(i + 1u))); found[2u * i + 1u] = uint(imageAtomicAdd(texels, " + kind.outside + ", " + number +
                                 "(1))) + 5u;";
        run_shader(client, stage, head, body);
        std::vector<uint32_t> want(kind.texels());
        for (uint32_t i = 0; i < kInvocations; i += 2) want[i % kind.texels()] += i + 1;
        EXPECT_EQ(client.texels_of(image, kind), want);
        for (uint32_t i = 0; i < kInvocations; ++i) {
          EXPECT_EQ(found.as<uint32_t>()[2 * i + 1], i % 2 == 0 ? 5u : 0u) << "a texel outside";
        }
      }
    }
  }
}

// One texel, hit by all: what each invocation finds is what those before it left.
TEST(IcdAtomic, EveryOperationOnATexel) {
  struct Operation {
    const char* call;  // on `texels`, at p, with the value v
    uint32_t first;
    uint32_t (*combine)(uint32_t old, uint32_t v);
  };
  const Operation operations[] = {
      {"imageAtomicMin(texels, p, v)", 0x80000000u, [](uint32_t o, uint32_t v) { return std::min(o, v); }},
      {"imageAtomicMax(texels, p, v)", 7, [](uint32_t o, uint32_t v) { return std::max(o, v); }},
      {"imageAtomicAnd(texels, p, ~v)", ~0u, [](uint32_t o, uint32_t v) { return o & ~v; }},
      {"imageAtomicOr(texels, p, v)", 0, [](uint32_t o, uint32_t v) { return o | v; }},
      {"imageAtomicXor(texels, p, v)", 0x55555555u, [](uint32_t o, uint32_t v) { return o ^ v; }},
  };
  const Kind& kind = kKinds[1];
  AtomicsClient client;
  for (const Operation& operation : operations) {
    for (const auto stage : {kCompute, kFragment}) {
      SCOPED_TRACE(operation.call);
      const VkImage image = client.image_of(VK_FORMAT_R32_UINT, kind);
      const auto found = client.buffer(kInvocations * 4);
      client.bind({{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, VK_NULL_HANDLE, client.view_of(image, VK_FORMAT_R32_UINT, kind)},
                   ShaderClient::storage(found)});
      const std::string head =
          "layout(binding = 0, r32ui) uniform uimage2D texels; layout(binding = 1) buffer Found { uint found[]; };";
      run_shader(client, kCompute, head,
                 "if (i == 0u) imageAtomicExchange(texels, ivec2(8, 6), " + std::to_string(operation.first) + "u);");
      run_shader(client, stage, head,
                 "const ivec2 p = ivec2(8, 6); uint v = i * 2654435761u; found[i] = " + std::string(operation.call) + ";");
      uint32_t want = operation.first;
      for (uint32_t i = 0; i < kInvocations; i += 2) want = operation.combine(want, i * 2654435761u);
      EXPECT_EQ(client.texels_of(image, kind)[6 * 9 + 8], want);
    }
  }
}

// Each of 32 increments by compare and swap; and exchanges that hand a token on.
TEST(IcdAtomic, CompareAndSwapAndExchangeOnATexel) {
  const Kind& kind = kKinds[5];
  AtomicsClient client;
  const VkImage image = client.image_of(VK_FORMAT_R32_SINT, kind);
  const auto found = client.buffer(kInvocations * 4);
  client.bind({{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, VK_NULL_HANDLE, client.view_of(image, VK_FORMAT_R32_SINT, kind)},
               ShaderClient::storage(found)});
  const std::string head =
      "layout(binding = 0, r32i) uniform iimage2DArray texels; layout(binding = 1) buffer Found { int found[]; };";
  run_shader(
      client, kCompute, head,
      "int seen = 0; for (int n = 0; n < 100000; ++n) { int now = imageAtomicCompSwap(texels, ivec3(1, 2, 1), seen, seen + 3);"
      "if (now == seen) break; seen = now; } found[i] = imageAtomicExchange(texels, ivec3(0), int(i) + 1);");
  const std::vector<uint32_t> texels = client.texels_of(image, kind);
  EXPECT_EQ(texels[20 + 2 * 5 + 1], 3 * kInvocations / 2);
  std::vector<uint32_t> tokens{texels[0]}, want{0};
  for (uint32_t i = 0; i < kInvocations; i += 2) {
    tokens.push_back(found.as<uint32_t>()[i]);
    want.push_back(i + 1);
  }
  std::ranges::sort(tokens);
  EXPECT_EQ(tokens, want);
}

TEST(IcdAtomic, TexelBuffers) {
  AtomicsClient client;
  constexpr uint32_t kTexels = 50;
  for (const VkFormat format : {VK_FORMAT_R32_UINT, VK_FORMAT_R32_SINT}) {
    VkFormatProperties properties;
    VK(client, GetPhysicalDeviceFormatProperties)(client.physical, format, &properties);
    EXPECT_TRUE(properties.bufferFeatures & VK_FORMAT_FEATURE_STORAGE_TEXEL_BUFFER_ATOMIC_BIT);
    for (const auto stage : {kCompute, kFragment}) {
      const auto memory = client.buffer((kTexels + 8) * 4);
      const VkBufferViewCreateInfo info{
          VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO, nullptr, 0, memory.handle, format, 0, kTexels * 4};
      VkBufferView texels = VK_NULL_HANDLE;
      ASSERT_EQ(VK(client, CreateBufferView)(client.device, &info, nullptr, &texels), VK_SUCCESS);
      client.defer([&client, texels] { VK(client, DestroyBufferView)(client.device, texels, nullptr); });
      client.bind({{VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, VK_NULL_HANDLE, VK_NULL_HANDLE, texels}});
      const std::string letter = format == VK_FORMAT_R32_UINT ? "u" : "i", number = letter == "u" ? "uint" : "int";
      run_shader(
          client, stage,
          "layout(binding = 0, r32" + std::string(letter == "u" ? "ui" : "i") + ") uniform " + letter + "imageBuffer texels;",
          "imageAtomicAdd(texels, int(i % 53u), " + number + "(i));");
      std::vector<uint32_t> want(kTexels + 8);
      for (uint32_t i = 0; i < kInvocations; i += 2) want[i % 53] += i % 53 < kTexels ? i : 0;
      EXPECT_EQ(std::vector<uint32_t>(memory.as<uint32_t>(), memory.as<uint32_t>() + kTexels + 8), want);
    }
  }
}

// 64-bit integers in buffers and Workgroup memory.
TEST(IcdAtomic, Integers64) {
  ShaderClient client(nullptr, {}, {VK_KHR_SHADER_ATOMIC_INT64_EXTENSION_NAME});
  ASSERT_EQ(client.result, VK_SUCCESS);
  const auto out = client.buffer(256);
  client.bind({ShaderClient::storage(out)});
  out.as<uint64_t>()[2] = ~uint64_t{0};
  const std::string head =
      "#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require\n#extension GL_EXT_shader_atomic_int64 : require\n"
      "layout(binding = 0) buffer Out { uint64_t sum, most, least, bits, swapped; int64_t low; uint64_t shared_sum[8]; }; ";
  const std::string body =
      "uint64_t v = (uint64_t(i) << 33) + uint64_t(i); atomicAdd(sum, v); atomicMax(most, v); atomicMin(least, v + 3ul); "
      "atomicXor(bits, v); "
      "atomicMin(low, -int64_t(v)); uint64_t seen = 0ul; for (int n = 0; n < 100000; ++n) { uint64_t now = "
      "atomicCompSwap(swapped, seen, seen + (1ul << 40)); if (now == seen) break; seen = now; }";
  uint64_t sum = 0, bits = 0;
  for (uint64_t i = 0; i < kInvocations; i += 2) {
    sum += (i << 33) + i;
    bits ^= (i << 33) + i;
  }
  constexpr uint64_t kLast = (uint64_t{kInvocations - 2} << 33) + kInvocations - 2;
  for (const auto stage : {kCompute, kFragment}) {
    std::memset(out.data, 0, 256);
    out.as<uint64_t>()[2] = ~uint64_t{0};
    run_shader(client, stage, head, body);
    const uint64_t want[] = {sum, kLast, 3, bits, uint64_t{kInvocations / 2} << 40, 0 - kLast};
    for (uint32_t k = 0; k < 6; ++k) EXPECT_EQ(out.as<uint64_t>()[k], want[k]) << k;
  }
  const Words words = glsl(
      kCompute,
      head +
          "layout(local_size_x = 64) in; shared uint64_t s; void main() { if (gl_LocalInvocationIndex == 0u) s = 0ul; barrier(); "
          "atomicAdd(s, uint64_t(gl_LocalInvocationIndex) << 36); barrier(); shared_sum[gl_WorkGroupID.x] = s; }");
  ASSERT_EQ(client.compute(words, 4), VK_SUCCESS);
  for (uint32_t g = 0; g < 4; ++g) EXPECT_EQ(out.as<uint64_t>()[6 + g], uint64_t{2016} << 36);
}

// Sums of multiples of 1/4 that are exact in every order; loads, stores and exchanges; a NaN is the one that Pineda stores.
TEST(IcdAtomic, Floats) {
  AtomicsClient client(nullptr, {}, {VK_EXT_SHADER_ATOMIC_FLOAT_EXTENSION_NAME});
  ASSERT_EQ(client.result, VK_SUCCESS);
  const Kind& kind = kKinds[1];
  const std::string head = R"(#extension GL_EXT_shader_atomic_float : require
#extension GL_KHR_memory_scope_semantics : require
layout(binding = 0, r32f) uniform image2D texels; layout(binding = 1) buffer Out { double wide, wide_shared[4]; float sum, stored, nan, sum_shared[4]; };
)";
  const std::string body =
      "atomicAdd(sum, float(i) * 0.25); atomicAdd(wide, double(i) * 0.25LF); imageAtomicAdd(texels, ivec2(4, 5), float(i) * 0.5);"
      "imageAtomicExchange(texels, ivec2(2, 3), 7.5); atomicStore(stored, 3.25, gl_ScopeDevice, gl_StorageSemanticsBuffer, "
      "gl_SemanticsRelease);"
      "float back = atomicLoad(stored, gl_ScopeDevice, gl_StorageSemanticsBuffer, gl_SemanticsAcquire); atomicExchange(stored, "
      "back + 1.0); "
      "atomicAdd(nan, i % 4u == 0u ? uintBitsToFloat(0x7f800000u) : uintBitsToFloat(0xff800000u));";
  struct Out {
    double wide, wide_shared[4];
    float sum, stored;
    uint32_t nan;
    float sum_shared[4];
  };
  constexpr float kSum = 2 * (kInvocations / 2) * (kInvocations / 2 - 1) / 2;  // of the even numbers below kInvocations
  for (const auto stage : {kCompute, kFragment}) {
    const VkImage image = client.image_of(VK_FORMAT_R32_SFLOAT, kind);
    const auto out = client.buffer(sizeof(Out));
    client.bind({{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, VK_NULL_HANDLE, client.view_of(image, VK_FORMAT_R32_SFLOAT, kind)},
                 ShaderClient::storage(out)});
    run_shader(client, stage, head, body);
    const Out& got = *out.as<Out>();
    EXPECT_EQ(got.sum, kSum / 4);
    EXPECT_EQ(got.wide, kSum / 4);
    EXPECT_EQ(got.nan, 0x7fc00000u);
    EXPECT_TRUE(got.stored == 3.25f || got.stored == 4.25f) << got.stored;
    const std::vector<uint32_t> texels = client.texels_of(image, kind);
    EXPECT_EQ(std::bit_cast<float>(texels[5 * 9 + 4]), kSum / 2);
    EXPECT_EQ(std::bit_cast<float>(texels[3 * 9 + 2]), 7.5f);
    const Words words =
        glsl(kCompute, head +
                           "layout(local_size_x = 64) in; shared float s; shared double d; void main() { if "
                           "(gl_LocalInvocationIndex == 0u) { s = 0.0; d = 0.0LF; } barrier();"
                           "atomicAdd(s, float(gl_LocalInvocationIndex)); atomicAdd(d, double(gl_LocalInvocationIndex)); "
                           "barrier(); sum_shared[gl_WorkGroupID.x] = s; wide_shared[gl_WorkGroupID.x] = d; }");
    ASSERT_EQ(client.compute(words, 4), VK_SUCCESS);
    for (uint32_t g = 0; g < 4; ++g) EXPECT_TRUE(got.sum_shared[g] == 2016 && got.wide_shared[g] == 2016) << g;
  }
}

}  // namespace
}  // namespace pineda::test
