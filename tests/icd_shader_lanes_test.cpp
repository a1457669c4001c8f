// Which invocations of a draw live: discards of every kind, and subgroups of fragments and vertices.
#include "shader_client.h"

namespace pineda::test {
namespace {

constexpr auto kCompute = VK_SHADER_STAGE_COMPUTE_BIT;
constexpr auto kFragment = VK_SHADER_STAGE_FRAGMENT_BIT;
constexpr auto kVertex = VK_SHADER_STAGE_VERTEX_BIT;

// Fragments of even columns end or become helpers: nothing of them is seen, but derivatives of their neighbours are right.
TEST(IcdShaderFeatures, TerminateAndDemote) {
  ShaderClient client(
      nullptr, {}, {VK_KHR_SHADER_TERMINATE_INVOCATION_EXTENSION_NAME, VK_EXT_SHADER_DEMOTE_TO_HELPER_INVOCATION_EXTENSION_NAME});
  ASSERT_EQ(client.result, VK_SUCCESS);
  const struct {
    const char *extension, *discard, *after;
  } cases[] = {
      {"GL_EXT_terminate_invocation", "terminateInvocation;", "float slope = 1.0; bool helper = false;"},
      {"GL_EXT_demote_to_helper_invocation", "demote;", "float slope = dFdx(x * x + y); bool helper = helperInvocationEXT();"}};
  for (const auto& c : cases) {
    const auto count = client.buffer(64);
    client.bind({ShaderClient::storage(count)});
    Words target;
    const Words fragment = glsl(kFragment,
                                "#extension " + std::string(c.extension) + " : require\n" +
                                    R"(layout(location = 0) out uvec4 r; layout(binding = 0) buffer Count { uint n; };
      void main() { float x = gl_FragCoord.x - 0.5, y = gl_FragCoord.y; if (int(x) % 2 == 0) )" +
                                    c.discard + c.after + R"(
        atomicAdd(n, 1u); r = uvec4(1, helper ? 1 : 0, uint(slope), 9); })",
                                "vulkan1.1");
    ASSERT_EQ(client.draw(ShaderClient::covering_vertex(), fragment, 3, &target), VK_SUCCESS);
    EXPECT_EQ(count.as<uint32_t>()[0], kTargetSize * kTargetSize / 2) << c.discard;
    for (uint32_t y = 0; y < kTargetSize; ++y) {
      for (uint32_t x = 0; x < kTargetSize; ++x) {
        const uint32_t* pixel = &target[4 * (y * kTargetSize + x)];
        const uint32_t slope = c.after[14] == '1' ? 1 : 2 * (x - 1) + 1;  // of x², between the columns x - 1 and x
        const bool seen = x % 2 == 1;
        EXPECT_EQ(pixel[0], seen ? 1u : 0u) << c.discard << x << ' ' << y;
        EXPECT_EQ(pixel[1], 0u);
        EXPECT_EQ(pixel[2], seen ? slope : 0u) << c.discard << x << ' ' << y;
      }
    }
  }
}

const std::string kSubgroups =
    "#extension GL_KHR_shader_subgroup_basic : require\n#extension GL_KHR_shader_subgroup_ballot : require\n"
    "#extension GL_KHR_shader_subgroup_vote : require\n#extension GL_KHR_shader_subgroup_arithmetic : require\n"
    "#extension GL_KHR_shader_subgroup_quad : require\n#extension GL_KHR_shader_subgroup_shuffle : require\n";

// Counts by elected invocations are the counts of fragments, with triangles that cover blocks in part, and discards.
TEST(IcdShaderFeatures, FragmentSubgroupsHaveNoHelpers) {
  ShaderClient client;
  VkPhysicalDeviceSubgroupProperties properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 all{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &properties, {}};
  VK(client, GetPhysicalDeviceProperties2)(client.physical, &all);
  EXPECT_EQ(properties.supportedStages, VkShaderStageFlags{kVertex | kFragment | kCompute});
  const Words vertex =
      glsl(kVertex,
           "void main() { gl_Position = vec4(gl_VertexIndex == 1 ? 0.93 : -0.81, gl_VertexIndex == 2 ? 0.77 : -0.9, 0, 1); }");
  for (const std::string discard : {"", "if ((x + y) % 3u == 0u) discard;"}) {
    SCOPED_TRACE(discard);
    const auto out = client.buffer(256);
    client.bind({ShaderClient::storage(out)});
    const Words fragment = glsl(
        kFragment,
        kSubgroups +
            R"(layout(location = 0) out uvec4 r; layout(binding = 0) buffer Out { uint n, by_ballot, by_add, sum, all_wrong, rounds; };
      void main() { uint x = uint(gl_FragCoord.x), y = uint(gl_FragCoord.y); float slope = dFdx(gl_FragCoord.x);)" +
            discard + R"(
        atomicAdd(n, 1u); uint ones = subgroupAdd(1u), weight = subgroupAdd(x * 100u + y); uvec4 ballot = subgroupBallot(true);
        if (subgroupElect()) { atomicAdd(by_ballot, subgroupBallotBitCount(ballot)); atomicAdd(by_add, ones); atomicAdd(sum, weight); }
        if (subgroupAny(gl_HelperInvocation) || !subgroupAll(!gl_HelperInvocation)) atomicAdd(all_wrong, 1u);
        uint wanted = x % 5u, mine = 0u; for (int i = 0; i < 64; ++i) { uint first = subgroupBroadcastFirst(wanted); if (first == wanted) { mine = first + 1u; break; } }
        if (mine != x % 5u + 1u) atomicAdd(rounds, 1u);
        r = uvec4(1, ones, weight, uint(slope)); })",
        "vulkan1.1");
    Words target;
    ASSERT_EQ(client.draw(vertex, fragment, 3, &target), VK_SUCCESS);
    uint32_t fragments = 0, sum = 0;
    for (uint32_t i = 0; i < kTargetSize * kTargetSize; ++i) {
      if (target[4 * i] == 0) continue;
      ++fragments;
      sum += i % kTargetSize * 100 + i / kTargetSize;
      EXPECT_EQ(target[4 * i + 3], 1u) << "a derivative";
      EXPECT_GE(target[4 * i + 1], 1u);
    }
    EXPECT_GT(fragments, 30u);
    const uint32_t want[] = {fragments, fragments, fragments, sum, 0, 0};
    for (uint32_t i = 0; i < 6; ++i) EXPECT_EQ(out.as<uint32_t>()[i], want[i]) << i;
  }
}

// Quads of fragments: neighbours' values, those of helpers included.
TEST(IcdShaderFeatures, FragmentQuads) {
  ShaderClient client;
  client.bind({});
  const Words vertex =
      glsl(kVertex,
           "void main() { gl_Position = vec4(gl_VertexIndex == 1 ? 0.93 : -0.81, gl_VertexIndex == 2 ? 0.77 : -0.9, 0, 1); }");
  const Words fragment = glsl(
      kFragment,
      kSubgroups + R"(layout(location = 0) out uvec4 r; void main() { uint v = uint(gl_FragCoord.x) + 64u * uint(gl_FragCoord.y);
    r = uvec4(subgroupQuadSwapHorizontal(v), subgroupQuadSwapVertical(v), subgroupQuadSwapDiagonal(v), subgroupQuadBroadcast(v, 2u) + 1u); })",
      "vulkan1.1");
  Words target;
  ASSERT_EQ(client.draw(vertex, fragment, 3, &target), VK_SUCCESS);
  uint32_t seen = 0;
  for (uint32_t y = 0; y < kTargetSize; ++y) {
    for (uint32_t x = 0; x < kTargetSize; ++x) {
      const uint32_t* pixel = &target[4 * (y * kTargetSize + x)];
      if (pixel[3] == 0) continue;
      ++seen;
      EXPECT_EQ(pixel[0], (x ^ 1) + 64 * y);
      EXPECT_EQ(pixel[1], x + 64 * (y ^ 1));
      EXPECT_EQ(pixel[2], (x ^ 1) + 64 * (y ^ 1));
      EXPECT_EQ(pixel[3], (x & ~1u) + 64 * (y | 1) + 1);
    }
  }
  EXPECT_GT(seen, 30u);
}

TEST(IcdShaderFeatures, VertexSubgroups) {
  ShaderClient client;
  const auto out = client.buffer(256);
  client.bind({ShaderClient::storage(out)});
  const Words vertex = glsl(kVertex, kSubgroups + R"(layout(binding = 0) buffer Out { uint n, by_ballot, sum, by_add, wrong; };
    void main() { uint v = uint(gl_VertexIndex) + 1u; atomicAdd(n, 1u); atomicAdd(sum, v); uvec4 ballot = subgroupBallot(true); uint weight = subgroupAdd(v);
      if (subgroupElect()) { atomicAdd(by_ballot, subgroupBallotBitCount(ballot)); atomicAdd(by_add, weight); }
      if (subgroupBroadcastFirst(v) != subgroupMin(v) || subgroupInclusiveAdd(1u) != gl_SubgroupInvocationID + 1u) atomicAdd(wrong, 1u);
      gl_Position = vec4(0, 0, 0, 1); gl_PointSize = 1.0; })",
                            "vulkan1.1");
  ASSERT_EQ(client.draw(vertex, glsl(kFragment, "layout(location = 0) out uvec4 r; void main() { r = uvec4(1); }"), 77, nullptr,
                        VK_PRIMITIVE_TOPOLOGY_POINT_LIST),
            VK_SUCCESS);
  const uint32_t* got = out.as<uint32_t>();
  EXPECT_GE(got[0], 77u);
  EXPECT_EQ(got[1], got[0]);
  EXPECT_EQ(got[3], got[2]);
  EXPECT_EQ(got[4], 0u);
}

}  // namespace
}  // namespace pineda::test
