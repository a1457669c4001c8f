// draw.*: each draw command, topology and index type: which vertices and instances come, by their indices.
#include <fmt/format.h>

#include <cstring>
#include <set>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSlots = 256;

// The vertex shader marks (vertex, instance) in a storage buffer; nothing is rasterised.
constexpr const char* kMarking =
    "layout(binding = 0, std430) buffer B { uint marks[]; };\n"
    "void main() { atomicAdd(marks[uint(gl_InstanceIndex) * 256u + uint(gl_VertexIndex)], 1u); gl_Position = vec4(2.0, 2.0, 0.5, "
    "1.0);"
    " gl_PointSize = 1.0; }";

struct DrawCase {
  uint32_t first = 0, count = 6, first_instance = 0, instances = 1;
  int32_t vertex_offset = 0;
  std::vector<uint32_t> indices;  // empty: not indexed
  VkIndexType index_type = VK_INDEX_TYPE_UINT32;
  bool indirect = false;
  uint32_t draw_count = 1;  // of indirect draws: draw n starts n * 8 vertices further
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
};

std::vector<std::byte> pack_indices(const DrawCase& c) {
  const size_t size = c.index_type == VK_INDEX_TYPE_UINT16 ? 2 : c.index_type == VK_INDEX_TYPE_UINT8_EXT ? 1 : 4;
  std::vector<std::byte> bytes(std::max<size_t>(c.indices.size() * size, 4));
  for (size_t i = 0; i < c.indices.size(); ++i) std::memcpy(bytes.data() + i * size, &c.indices[i], size);
  return bytes;
}

// Every (vertex, instance) that the command names must come at least once, and no other.
std::set<std::pair<uint32_t, uint32_t>> expected(const DrawCase& c) {
  std::set<std::pair<uint32_t, uint32_t>> all;
  for (uint32_t d = 0; d < c.draw_count; ++d) {
    for (uint32_t instance = 0; instance < c.instances; ++instance) {
      for (uint32_t i = 0; i < c.count; ++i) {
        const uint32_t at = c.first + d * 8 + i;
        const uint32_t vertex = c.indices.empty() ? at : c.indices[at] + static_cast<uint32_t>(c.vertex_offset);
        all.insert({vertex, c.first_instance + instance});
      }
    }
  }
  return all;
}

void run(Device& device, const DrawCase& c) {
  require(device.caps().features.vertexPipelineStoresAndAtomics, "vertexPipelineStoresAndAtomics");
  require(c.draw_count == 1 || device.caps().features.multiDrawIndirect, "multiDrawIndirect");
  require(!c.indirect || c.first_instance == 0 || device.caps().features.drawIndirectFirstInstance, "drawIndirectFirstInstance");
  require(c.index_type != VK_INDEX_TYPE_UINT8_EXT || device.caps().index_uint8.indexTypeUint8, "indexTypeUint8");
  const Buffer marks = create_buffer(device, kSlots * 16 * 4);
  const Buffer indices = create_buffer(device, pack_indices(c));
  std::vector<uint32_t> words;
  for (uint32_t d = 0; d < c.draw_count; ++d) {
    if (c.indices.empty()) {
      words.insert(words.end(), {c.count, c.instances, c.first + d * 8, c.first_instance});
    } else {
      words.insert(words.end(),
                   {c.count, c.instances, c.first + d * 8, static_cast<uint32_t>(c.vertex_offset), c.first_instance});
    }
  }
  const Buffer parameters = create_buffer(device, words);
  DrawState state;
  state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT, kMarking);
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, "layout(location = 0) out vec4 c; void main() { c = vec4(1.0); }");
  state.topology = c.topology;
  state.resources.descriptors.push_back(storage_buffer(0, marks));
  state.draw = [&](VkCommandBuffer commands) {
    const bool indexed = !c.indices.empty();
    if (indexed) vkCmdBindIndexBuffer(commands, indices.handle, 0, c.index_type);
    if (c.indirect && indexed) {
      vkCmdDrawIndexedIndirect(commands, parameters.handle, 0, c.draw_count, sizeof(VkDrawIndexedIndirectCommand));
    } else if (c.indirect) {
      vkCmdDrawIndirect(commands, parameters.handle, 0, c.draw_count, sizeof(VkDrawIndirectCommand));
    } else if (indexed) {
      vkCmdDrawIndexed(commands, c.count, c.instances, c.first, c.vertex_offset, c.first_instance);
    } else {
      vkCmdDraw(commands, c.count, c.instances, c.first, c.first_instance);
    }
  };
  draw_once(device, state);
  const auto want = expected(c);
  const auto got = marks.as<uint32_t>();
  for (uint32_t slot = 0; slot < got.size(); ++slot) {
    const bool wanted = want.contains({slot % kSlots, slot / kSlots});
    expect((got[slot] != 0) == wanted,
           fmt::format("vertex {} of instance {} {}", slot % kSlots, slot / kSlots, wanted ? "is missing" : "came"));
  }
}

}  // namespace

void register_draw() {
  static constexpr std::pair<VkPrimitiveTopology, const char*> kTopologies[] = {
      {VK_PRIMITIVE_TOPOLOGY_POINT_LIST, "point_list"},         {VK_PRIMITIVE_TOPOLOGY_LINE_LIST, "line_list"},
      {VK_PRIMITIVE_TOPOLOGY_LINE_STRIP, "line_strip"},         {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, "triangle_list"},
      {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, "triangle_strip"}, {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN, "triangle_fan"}};
  static constexpr std::pair<VkIndexType, const char*> kIndexTypes[] = {
      {VK_INDEX_TYPE_UINT16, "uint16"}, {VK_INDEX_TYPE_UINT32, "uint32"}, {VK_INDEX_TYPE_UINT8_EXT, "uint8"}};
  const std::vector<uint32_t> indices = {7, 3, 200, 3, 9, 0, 0, 5, 6, 41, 42, 43, 44, 45, 46, 99, 98, 97, 96, 95, 94, 93, 92, 91};
  const auto add = [](const std::string& name, const DrawCase& c) {
    add_case("draw", name, "21.3 Programmable Primitive Shading", [c](Device& device) { run(device, c); });
  };
  for (const auto& [topology, topology_name] : kTopologies) {
    for (const bool indirect : {false, true}) {
      for (const uint32_t instances : {1u, 3u}) {
        for (const uint32_t first_instance : {0u, 5u}) {
          for (const uint32_t draws : {1u, 2u}) {
            if (draws > 1 && !indirect) continue;
            const std::string suffix =
                fmt::format("{}.{}_instances_{}_from_{}{}", topology_name, indirect ? "indirect" : "direct", instances,
                            first_instance, draws > 1 ? "_multi" : "");
            DrawCase c;
            c.topology = topology, c.indirect = indirect, c.instances = instances, c.first_instance = first_instance,
            c.draw_count = draws;
            c.first = 4;
            add("arrays." + suffix, c);
            for (const auto& [index_type, type_name] : kIndexTypes) {
              c.indices = indices;
              c.index_type = index_type;
              c.vertex_offset = 11;
              add(fmt::format("indexed_{}.{}", type_name, suffix), c);
            }
          }
        }
      }
    }
  }
}

}  // namespace pineda::cts
