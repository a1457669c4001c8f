// ubo.random and ssbo.random: blocks of random members; each leaf is read and written where the layout rules put it.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/float32.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

enum class Layout { kStd140, kStd430, kScalar };
enum class Base { kFloat, kInt, kUint };

// A member's type: a scalar, vector or matrix of 32-bit components; a structure; or an array of either.
struct Member {
  std::string name;
  Base base = Base::kFloat;
  uint32_t rows = 1, columns = 1;  // columns > 1: a matrix
  bool row_major = false;
  uint32_t array = 0;          // elements; 0: not an array
  std::vector<Member> fields;  // of a structure
  std::string struct_name;
};

uint32_t round_up(uint32_t value, uint32_t alignment) { return (value + alignment - 1) / alignment * alignment; }

struct Placement {
  uint32_t size = 0, alignment = 4;
};

// "Offset and Stride Assignment": base, extended (std140) and scalar alignments.
class Rules {
 public:
  explicit Rules(Layout layout) : layout_(layout) {}

  uint32_t vector_alignment(uint32_t rows) const {
    if (layout_ == Layout::kScalar || rows == 1) return 4;
    return rows == 2 ? 8 : 16;
  }
  uint32_t extended(uint32_t alignment) const { return layout_ == Layout::kStd140 ? round_up(alignment, 16) : alignment; }
  uint32_t matrix_stride(const Member& m) const {
    const uint32_t vector_size = m.row_major ? m.columns : m.rows;
    if (layout_ == Layout::kScalar) return vector_size * 4;
    return extended(vector_alignment(vector_size));
  }
  Placement element(const Member& m) const {  // without the array
    if (!m.fields.empty()) {
      Placement out{0, extended(4)};
      for (const Member& field : m.fields) {
        const Placement p = member(field);
        out.alignment = std::max(out.alignment, p.alignment);
        out.size = round_up(out.size, p.alignment) + p.size;
      }
      if (layout_ != Layout::kScalar) out.size = round_up(out.size, out.alignment);
      return out;
    }
    if (m.columns > 1) {
      const uint32_t stride = matrix_stride(m), count = m.row_major ? m.rows : m.columns;
      return {stride * count, layout_ == Layout::kScalar ? 4 : extended(vector_alignment(m.row_major ? m.columns : m.rows))};
    }
    return {m.rows * 4, vector_alignment(m.rows)};
  }
  uint32_t array_stride(const Member& m) const {
    const Placement p = element(m);
    return round_up(p.size, extended(p.alignment));
  }
  Placement member(const Member& m) const {
    const Placement p = element(m);
    if (!m.array) return p;
    return {array_stride(m) * m.array, extended(p.alignment)};
  }

 private:
  Layout layout_;
};

Member random_member(Random& random, int depth, int& serial) {
  Member m;
  m.name = fmt::format("m{}", serial++);
  if (depth > 0 && random.below(4) == 0) {
    m.struct_name = fmt::format("S{}", serial);
    const uint32_t count = 1 + random.below(3);
    for (uint32_t i = 0; i < count; ++i) m.fields.push_back(random_member(random, depth - 1, serial));
  } else {
    m.base = static_cast<Base>(random.below(3));
    m.rows = 1 + random.below(4);
    if (random.below(3) == 0) {
      m.base = Base::kFloat;
      m.rows = 2 + random.below(3);
      m.columns = 2 + random.below(3);
    }
  }
  if (random.below(3) == 0) m.array = 1 + random.below(3);
  return m;
}

// GLSL has matrix orders on the members of a block; what a member contains follows it.
void set_order(Member& m, bool row_major) {
  m.row_major = row_major;
  for (Member& field : m.fields) set_order(field, row_major);
}

std::string type_name(const Member& m) {
  if (!m.fields.empty()) return m.struct_name;
  if (m.columns > 1) return fmt::format("mat{}x{}", m.columns, m.rows);
  static constexpr const char* kScalars[] = {"float", "int", "uint"};
  static constexpr const char* kPrefixes[] = {"", "i", "u"};
  const size_t base = static_cast<size_t>(m.base);
  return m.rows == 1 ? kScalars[base] : fmt::format("{}vec{}", kPrefixes[base], m.rows);
}

std::string declaration(const Member& m) {
  return fmt::format("  {} {}{};\n", type_name(m), m.name, m.array ? fmt::format("[{}]", m.array) : "");
}

void declare_structs(const Member& m, std::string& out) {
  if (m.fields.empty()) return;
  for (const Member& field : m.fields) declare_structs(field, out);
  out += fmt::format("struct {} {{\n", m.struct_name);
  for (const Member& field : m.fields) out += declaration(field);
  out += "};\n";
}

struct Leaf {  // one 32-bit component
  std::string expression;
  uint32_t offset_bytes;
  Base base;
};

void collect(const Rules& rules, const Member& m, const std::string& path, uint32_t offset, std::vector<Leaf>& leaves) {
  for (uint32_t i = 0; i < std::max(m.array, 1u); ++i) {
    const std::string name = m.array ? fmt::format("{}[{}]", path, i) : path;
    const uint32_t at = offset + (m.array ? rules.array_stride(m) * i : 0);
    if (!m.fields.empty()) {
      uint32_t field_at = at;
      for (const Member& field : m.fields) {
        const Placement p = rules.member(field);
        field_at = round_up(field_at, p.alignment);
        collect(rules, field, name + "." + field.name, field_at, leaves);
        field_at += p.size;
      }
      continue;
    }
    for (uint32_t c = 0; c < m.columns; ++c) {
      for (uint32_t r = 0; r < m.rows; ++r) {
        const std::string column = m.columns > 1 ? fmt::format("{}[{}]", name, c) : name;
        const uint32_t inner = m.columns == 1 ? r * 4
                               : m.row_major  ? r * rules.matrix_stride(m) + c * 4
                                              : c * rules.matrix_stride(m) + r * 4;
        leaves.push_back({m.rows > 1 ? fmt::format("{}[{}]", column, r) : column, at + inner, m.base});
      }
    }
  }
}

// Leaf i holds i + 1 as its own type.
uint32_t leaf_value(const Leaf& leaf, size_t i) {
  const uint32_t number = static_cast<uint32_t>(i) + 1;
  return leaf.base == Base::kFloat ? as_bits(static_cast<float>(number)) : number;
}

struct LayoutCase {
  Layout layout;
  bool uniform;
  VkShaderStageFlagBits stage = VK_SHADER_STAGE_COMPUTE_BIT;
};

void run(Device& device, const LayoutCase& c, const std::string& name) {
  require(c.layout != Layout::kScalar || device.caps().scalar_layout.scalarBlockLayout, "scalarBlockLayout");
  Random random(name);
  int serial = 0;
  Member block;
  block.struct_name = "Block";
  const uint32_t count = 2 + random.below(5);
  for (uint32_t i = 0; i < count; ++i) {
    block.fields.push_back(random_member(random, 2, serial));
    set_order(block.fields.back(), random.below(2));
  }
  const Rules rules(c.layout);
  std::vector<Leaf> leaves;
  collect(rules, block, "", 0, leaves);
  const uint32_t size = round_up(rules.element(block).size, 16) + 16;
  std::string structs, members;
  for (const Member& field : block.fields)
    declare_structs(field, structs),
        members += (field.row_major ? "  layout(row_major)" : "  layout(column_major)") + declaration(field);

  Buffer content = create_buffer(device, size, kAnyBuffer, 0xA5), out = create_buffer(device, size, kAnyBuffer, 0xA5);
  for (size_t i = 0; i < leaves.size(); ++i) {
    const uint32_t value = leaf_value(leaves[i], i);
    std::memcpy(content.mapped + leaves[i].offset_bytes, &value, 4);
  }
  const Buffer wrong = create_buffer(device, 16);
  const char* layout_name = c.layout == Layout::kStd140 ? "std140" : c.layout == Layout::kStd430 ? "std430" : "scalar";
  std::string body;
  for (size_t i = 0; i < leaves.size(); ++i) {  // expressions start with a dot
    static constexpr const char* kTypes[] = {"float", "int", "uint"};
    body += fmt::format("  if (source{0} != {1}({2})) {{ atomicAdd(wrong, 1u); first = min(first, {2}u); }}\n",
                        leaves[i].expression, kTypes[static_cast<size_t>(leaves[i].base)], i + 1);
    if (!c.uniform) body += fmt::format("  target{0} = source{0};\n", leaves[i].expression);
  }
  const std::string text = fmt::format(
      "{0}{1}layout(local_size_x = 1) in;\n"
      "layout(binding = 0, {2}) {3} Source {{\n{4}}} source;\n"
      "{5}layout(binding = 2, std430) buffer Wrong {{ uint wrong, first_wrong; }};\n"
      "void main() {{\n  uint first = 9999u;\n{6}  first_wrong = first;\n}}\n",
      c.layout == Layout::kScalar ? "#extension GL_EXT_scalar_block_layout : require\n" : "", structs, layout_name,
      c.uniform ? "uniform" : "readonly buffer", members,
      c.uniform ? "" : fmt::format("layout(binding = 1, {}) buffer Target {{\n{}}} target;\n", layout_name, members), body);
  Resources resources;
  resources.descriptors = {c.uniform ? uniform_buffer(0, content) : storage_buffer(0, content), storage_buffer(1, out),
                           storage_buffer(2, wrong)};
  dispatch(device, compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT, text), resources);
  const auto counts = wrong.as<uint32_t>();
  expect(counts[0] == 0, fmt::format("{} of {} members are read from another place, first leaf {} in\n{}{}", counts[0],
                                     leaves.size(), counts[1], structs, members));
  if (c.uniform) return;
  std::vector<std::byte> want(size, std::byte{0xA5});
  for (const Leaf& leaf : leaves) std::memcpy(want.data() + leaf.offset_bytes, content.mapped + leaf.offset_bytes, 4);
  for (uint32_t i = 0; i < size; ++i)
    expect(out.mapped[i] == want[i], fmt::format("byte {} was written wrongly in\n{}{}", i, structs, members));
}

}  // namespace

void register_block_layout() {
  struct Kind {
    const char* group;
    const char* name;
    LayoutCase c;
  };
  static constexpr Kind kKinds[] = {{"ubo", "std140", {Layout::kStd140, true}},
                                    {"ubo", "scalar", {Layout::kScalar, true}},
                                    {"ssbo", "std140", {Layout::kStd140, false}},
                                    {"ssbo", "std430", {Layout::kStd430, false}},
                                    {"ssbo", "scalar", {Layout::kScalar, false}}};
  for (const Kind& kind : kKinds) {
    for (int seed = 0; seed < 40; ++seed) {
      const std::string name = fmt::format("random.{}.{}", kind.name, seed);
      add_case(kind.group, name, "15.8.4 Offset and Stride Assignment",
               [&kind, name](Device& device) { run(device, kind.c, name); });
    }
  }
}

}  // namespace pineda::cts
