// VK_KHR_buffer_device_address through the whole driver: pointers that shaders follow, and pointers to nowhere.
#include <string>

#include "shader_client.h"

namespace pineda::test {
namespace {

constexpr auto kCompute = VK_SHADER_STAGE_COMPUTE_BIT;
constexpr auto kFragment = VK_SHADER_STAGE_FRAGMENT_BIT;
constexpr auto kVertex = VK_SHADER_STAGE_VERTEX_BIT;

struct AddressClient : ShaderClient {
  AddressClient() : ShaderClient(nullptr, {}, {VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME}) {}

  struct Addressed {
    uint32_t* data;
    VkDeviceAddress address;
  };
  Addressed addressed(VkDeviceSize size_bytes) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = size_bytes;
    info.usage = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    VkBuffer buffer = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateBuffer)(device, &info, nullptr, &buffer), VK_SUCCESS);
    const VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO, nullptr,
                                          VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT, 0};
    const VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags, size_bytes, 0};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, AllocateMemory)(device, &allocate, nullptr, &memory), VK_SUCCESS);
    EXPECT_EQ(VK(*this, BindBufferMemory)(device, buffer, memory, 0), VK_SUCCESS);
    void* mapped = nullptr;
    EXPECT_EQ(VK(*this, MapMemory)(device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), VK_SUCCESS);
    defer([this, buffer, memory] {
      VK(*this, DestroyBuffer)(device, buffer, nullptr);
      VK(*this, FreeMemory)(device, memory, nullptr);
    });
    const VkBufferDeviceAddressInfo of{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, nullptr, buffer};
    return {static_cast<uint32_t*>(mapped), VK(*this, GetBufferDeviceAddressKHR)(device, &of)};
  }
};

const std::string kReference =
    "#extension GL_EXT_buffer_reference : require\n#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require\n";

// A list whose nodes lie in eight buffers, made on the host; and a shader that follows it, writes to each node and counts.
TEST(IcdShaderFeatures, PointersAcrossBuffers) {
  AddressClient client;
  ASSERT_EQ(client.result, VK_SUCCESS);
  std::vector<AddressClient::Addressed> nodes;
  for (uint32_t i = 0; i < 8; ++i) nodes.push_back(client.addressed(64));
  for (uint32_t i = 0; i < 8; ++i) {
    const uint64_t next = i + 1 < 8 ? nodes[(i + 1) * 3 % 8].address : 0;
    uint32_t* node = nodes[i * 3 % 8].data;
    std::memcpy(node, &next, 8);
    node[2] = 100 + i;
  }
  const auto out = client.buffer(256);
  client.bind({ShaderClient::storage(out)});
  const Words words = glsl(kCompute, kReference + R"(layout(local_size_x = 32) in;
    layout(buffer_reference) buffer Node; layout(buffer_reference, buffer_reference_align = 8) buffer Node { Node next; uint value; uint seen; };
    layout(push_constant) uniform P { Node head; }; layout(binding = 0) buffer Out { uint sums[]; };
    void main() { uint sum = 0u; for (Node n = head; uint64_t(n) != 0ul; n = n.next) { sum += n.value; atomicAdd(n.seen, 1u); }
      sums[gl_LocalInvocationIndex] = sum; })",
                           "vulkan1.1");
  const uint64_t head = nodes[0].address;
  ASSERT_EQ(client.compute(words, 1, &head, 8), VK_SUCCESS);
  for (uint32_t i = 0; i < 32; ++i) EXPECT_EQ(out.as<uint32_t>()[i], 8u * 100 + 28);
  for (const auto& node : nodes) EXPECT_EQ(node.data[3], 32u);
}

// Pointers to nowhere read zero and write nothing, in every stage.
TEST(IcdShaderFeatures, PointersToNowhere) {
  AddressClient client;
  const auto memory = client.addressed(4096), other = client.addressed(4096);
  for (uint32_t i = 0; i < 1024; ++i) memory.data[i] = other.data[i] = i + 1;
  const uint64_t first = memory.address;
  const uint64_t pointers[] = {0,
                               4,
                               first - 4,
                               first + 4096,
                               first + 4097,
                               first + 4092,
                               ~uint64_t{0} - 3,
                               1ull << 47,
                               1ull << 63,
                               first + (1ull << 32),
                               first + 8};
  constexpr uint32_t kCount = std::size(pointers);
  const auto table = client.buffer(sizeof(pointers)), out = client.buffer(kCount * 4);
  std::memcpy(table.data, pointers, sizeof(pointers));
  client.bind({ShaderClient::storage(table), ShaderClient::storage(out)});
  const std::string head = kReference + R"(layout(buffer_reference, buffer_reference_align = 4) buffer Cell { uint v; };
    layout(binding = 0) buffer Table { uint64_t at[]; }; layout(binding = 1) buffer Out { uint found[]; };)";
  const std::string body = "Cell c = Cell(at[i]); found[i] = c.v + 1u; c.v = 7u; atomicAdd(c.v, 1u);";
  const auto check = [&](const char* stage) {
    for (uint32_t i = 0; i < kCount; ++i) {
      // Where two allocations touch, the end of one is the start of the other: only what is surely outside is asked for.
      const bool inside = i == 5 || i == 10;
      const bool may_be_other = i == 2 || i == 3 || i == 4;
      const uint32_t want = i == 5 ? 1025 : i == 10 ? 4 : 1;
      if (may_be_other) continue;
      EXPECT_EQ(out.as<uint32_t>()[i], inside ? want : 1) << stage << ' ' << i;
    }
    EXPECT_EQ(memory.data[1023], 8u) << stage;
    EXPECT_EQ(memory.data[2], 8u) << stage;
    for (uint32_t i = 3; i < 1023; ++i) ASSERT_EQ(memory.data[i], i + 1) << stage;
    memory.data[1023] = 1024, memory.data[2] = 3;
  };
  ASSERT_EQ(client.compute(glsl(kCompute,
                                head + "layout(local_size_x = " + std::to_string(kCount) +
                                    ") in; void main() { uint i = gl_LocalInvocationIndex;" + body + "}",
                                "vulkan1.1"),
                           1),
            VK_SUCCESS);
  check("compute");
  ASSERT_EQ(client.draw(ShaderClient::covering_vertex(),
                        glsl(kFragment,
                             head +
                                 "layout(location = 0) out uvec4 r; void main() { uint i = uint(gl_FragCoord.x); if "
                                 "(gl_FragCoord.y > 1.0 || i >= " +
                                 std::to_string(kCount) + "u) discard; " + body + " r = uvec4(1); }",
                             "vulkan1.1"),
                        3),
            VK_SUCCESS);
  check("fragment");
  ASSERT_EQ(client.draw(glsl(kVertex,
                             head + "void main() { uint i = uint(gl_VertexIndex);" + body +
                                 "gl_Position = vec4(0, 0, 0, 1); gl_PointSize = 1.0; }",
                             "vulkan1.1"),
                        glsl(kFragment, "layout(location = 0) out uvec4 r; void main() { r = uvec4(1); }"), kCount, nullptr,
                        VK_PRIMITIVE_TOPOLOGY_POINT_LIST),
            VK_SUCCESS);
  check("vertex");
}

}  // namespace
}  // namespace pineda::test
