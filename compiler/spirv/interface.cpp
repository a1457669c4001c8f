// Input and Output variables, flattened to InterfaceScalars (Vulkan's "Location Assignment" and "Component Assignment"), and the
// layout of Workgroup memory (ours to choose: Type::natural_bytes, in order of declaration).
#include <algorithm>
#include <tuple>

#include "base/abi.h"
#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

constexpr uint32_t kMaxSharedBytes = 1u << 20;

struct BuiltInRow {
  spv::BuiltIn spv_built_in;
  BuiltIn built_in;
  ir::Type type;
  uint32_t scalars;  // at most
};

constexpr BuiltInRow kBuiltIns[] = {
    {spv::BuiltInPosition, BuiltIn::kPosition, ir::Type::kF32, 4},
    {spv::BuiltInPointSize, BuiltIn::kPointSize, ir::Type::kF32, 1},
    {spv::BuiltInClipDistance, BuiltIn::kClipDistance, ir::Type::kF32, kMaxClipDistances},
    {spv::BuiltInCullDistance, BuiltIn::kCullDistance, ir::Type::kF32, kMaxClipDistances},
    {spv::BuiltInVertexIndex, BuiltIn::kVertexIndex, ir::Type::kI32, 1},
    {spv::BuiltInInstanceIndex, BuiltIn::kInstanceIndex, ir::Type::kI32, 1},
    {spv::BuiltInBaseVertex, BuiltIn::kBaseVertex, ir::Type::kI32, 1},
    {spv::BuiltInBaseInstance, BuiltIn::kBaseInstance, ir::Type::kI32, 1},
    {spv::BuiltInDrawIndex, BuiltIn::kDrawIndex, ir::Type::kI32, 1},
    {spv::BuiltInFragCoord, BuiltIn::kFragCoord, ir::Type::kF32, 4},
    {spv::BuiltInFrontFacing, BuiltIn::kFrontFacing, ir::Type::kB1, 1},
    {spv::BuiltInPointCoord, BuiltIn::kPointCoord, ir::Type::kF32, 2},
    {spv::BuiltInPrimitiveId, BuiltIn::kPrimitiveId, ir::Type::kI32, 1},
    {spv::BuiltInLayer, BuiltIn::kLayer, ir::Type::kI32, 1},
    {spv::BuiltInViewportIndex, BuiltIn::kViewportIndex, ir::Type::kI32, 1},
    {spv::BuiltInSampleId, BuiltIn::kSampleId, ir::Type::kI32, 1},
    {spv::BuiltInSamplePosition, BuiltIn::kSamplePosition, ir::Type::kF32, 2},
    {spv::BuiltInSampleMask, BuiltIn::kSampleMask, ir::Type::kI32, 1},
    {spv::BuiltInFragDepth, BuiltIn::kFragDepth, ir::Type::kF32, 1},
    {spv::BuiltInFragStencilRefEXT, BuiltIn::kFragStencilRef, ir::Type::kI32, 1},
    {spv::BuiltInHelperInvocation, BuiltIn::kHelperInvocation, ir::Type::kB1, 1},
    {spv::BuiltInNumWorkgroups, BuiltIn::kNumWorkgroups, ir::Type::kI32, 3},
    {spv::BuiltInWorkgroupId, BuiltIn::kWorkgroupId, ir::Type::kI32, 3},
    {spv::BuiltInLocalInvocationId, BuiltIn::kLocalInvocationId, ir::Type::kI32, 3},
    {spv::BuiltInGlobalInvocationId, BuiltIn::kGlobalInvocationId, ir::Type::kI32, 3},
    {spv::BuiltInLocalInvocationIndex, BuiltIn::kLocalInvocationIndex, ir::Type::kI32, 1},
    {spv::BuiltInViewIndex, BuiltIn::kViewIndex, ir::Type::kI32, 1},
    {spv::BuiltInSubgroupSize, BuiltIn::kSubgroupSize, ir::Type::kI32, 1},
    {spv::BuiltInSubgroupLocalInvocationId, BuiltIn::kSubgroupLocalInvocationId, ir::Type::kI32, 1},
    {spv::BuiltInSubgroupId, BuiltIn::kSubgroupId, ir::Type::kI32, 1},
    {spv::BuiltInNumSubgroups, BuiltIn::kNumSubgroups, ir::Type::kI32, 1},
    {spv::BuiltInSubgroupEqMask, BuiltIn::kSubgroupEqMask, ir::Type::kI32, 4},
    {spv::BuiltInSubgroupGeMask, BuiltIn::kSubgroupGeMask, ir::Type::kI32, 4},
    {spv::BuiltInSubgroupGtMask, BuiltIn::kSubgroupGtMask, ir::Type::kI32, 4},
    {spv::BuiltInSubgroupLeMask, BuiltIn::kSubgroupLeMask, ir::Type::kI32, 4},
    {spv::BuiltInSubgroupLtMask, BuiltIn::kSubgroupLtMask, ir::Type::kI32, 4},
};

// What is inherited on the way from the variable to a scalar.
struct Place {
  std::optional<uint32_t> built_in;
  std::optional<uint32_t> location;
  uint32_t component = 0;
  Decorations flags;
};

class Flattener {
 public:
  Flattener(const Module& m, const Variable& v) : m_(m), v_(v) {}

  std::vector<InterfaceEntry> run() {
    m_.flat_scalars(v_.pointee);  // bounds the size
    Place place;
    inherit(place, m_.decorations_of(v_.id));
    walk(v_.pointee, place);
    return std::move(entries_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    fail("Variable %" + std::to_string(v_.id) + ": " + what + ".", v_.offset_words);
  }

  static void inherit(Place& place, const Decorations& d) {
    if (d.built_in) {
      place.built_in = d.built_in;
      place.component = 0;
    }
    if (d.location) place.location = d.location;
    if (d.component) place.component = *d.component;
    if (d.index) place.flags.index = d.index;
    place.flags.flat |= d.flat;
    place.flags.no_perspective |= d.no_perspective;
    place.flags.centroid |= d.centroid;
    place.flags.sample |= d.sample;
  }

  // Emits the scalars of a type and moves the place behind it: to the next location, or within a built-in to the next element.
  void walk(uint32_t type_id, Place& place) {
    const Type& t = m_.type(type_id);
    switch (t.kind) {
      case TypeKind::kBool:
      case TypeKind::kInt:
      case TypeKind::kFloat:
        vector(t, 1, place);
        break;
      case TypeKind::kVector:
        vector(m_.type(t.element), t.count, place);
        break;
      case TypeKind::kMatrix:
      case TypeKind::kArray:
        for (uint32_t i = 0; i < t.count; ++i) walk(t.element, place);
        break;
      case TypeKind::kStruct: {
        for (uint32_t i = 0; i < t.members.size(); ++i) {
          Place member = place;
          inherit(member, m_.member_of(type_id, i));
          walk(t.members[i], member);
          if (!member.built_in) place.location = member.location;
        }
        break;
      }
      default:
        refuse("its type cannot be part of a shader interface");
    }
  }

  void vector(const Type& scalar, uint32_t count, Place& place) {
    if (place.built_in) {
      for (uint32_t i = 0; i < count; ++i) built_in(scalar.scalar, *place.built_in, place.component + i);
      place.component += count;
      return;
    }
    if (!place.location) refuse("has neither a Location nor a BuiltIn decoration");
    // A 64-bit number takes two components; dvec3 and dvec4 take two Locations.
    const uint32_t words = ir::size_bytes(scalar.scalar) == 8 ? 2 : 1;
    for (uint32_t i = 0; i < count; ++i) {
      Place at = place;
      at.component = place.component + words * i;
      if (words == 2) {
        *at.location += at.component / 4;
        at.component %= 4;
      }
      located(scalar, at, words == 2);
    }
    *place.location += words == 2 && place.component + 2 * count > 4 ? 2 : 1;
  }

  void built_in(ir::Type scalar, uint32_t number, uint32_t component) {
    const auto* row =
        std::ranges::find(kBuiltIns, number, [](const BuiltInRow& r) { return static_cast<uint32_t>(r.spv_built_in); });
    if (number == static_cast<uint32_t>(spv::BuiltInDeviceIndex) && scalar == ir::Type::kI32) {  // there is one device
      entries_.push_back({.is_zero = true});
      return;
    }
    if (row == std::end(kBuiltIns)) {
      entries_.push_back({.unknown_built_in = number});
      return;
    }
    if (scalar != row->type || component >= row->scalars) refuse("built-in " + std::to_string(number) + " has the wrong type");
    entries_.push_back({.scalar = InterfaceScalar{.built_in = row->built_in, .component = component, .type = scalar}});
  }

  void located(const Type& scalar, const Place& place, bool is_wide) {
    if (*place.location >= 1024) refuse("its Location is out of range");
    if (place.component + is_wide > 3) refuse("goes past component 3 of its Location");
    if (scalar.kind != TypeKind::kInt && scalar.kind != TypeKind::kFloat) refuse("only numbers can have a Location");
    if (ir::size_bytes(scalar.scalar) == 1) refuse("an 8-bit number cannot have a Location");
    const bool interpolates = scalar.kind == TypeKind::kFloat && !is_wide;
    InterfaceScalar s{.location = *place.location,
                      .component = place.component,
                      .index = place.flags.index.value_or(0),
                      .type = interpolates ? ir::Type::kF32 : ir::Type::kI32};
    s.interpolation = place.flags.flat || !interpolates ? Interpolation::kFlat
                      : place.flags.no_perspective      ? Interpolation::kNoPerspective
                                                        : Interpolation::kPerspective;
    s.at = place.flags.sample     ? InterpolationAt::kSample
           : place.flags.centroid ? InterpolationAt::kCentroid
                                  : InterpolationAt::kCenter;
    InterfaceEntry entry{.scalar = s, .is_signed = scalar.is_signed};
    if (is_wide) {
      ++s.component;
      entry.high = s;
    }
    entries_.push_back(entry);
  }

  const Module& m_;
  const Variable& v_;
  std::vector<InterfaceEntry> entries_;
};

bool before(const InterfaceScalar& a, const InterfaceScalar& b) {
  const auto key = [](const InterfaceScalar& s) {
    return std::tuple(!s.built_in.has_value(), s.built_in.value_or(BuiltIn::kPosition), s.location, s.index, s.component);
  };
  return key(a) < key(b);
}

// Outputs: a located scalar counts when it is declared (Vulkan leaves its value undefined when it is not written; we give zero),
// a built-in only when it is written, because compilers declare all of gl_PerVertex.
void list_entries(Module& m, Variable& v) {
  const std::vector<InterfaceEntry>& entries = m.interface_entries[v.id] = Flattener(m, v).run();
  const bool is_input = v.storage == spv::StorageClassInput;
  v.written_scalars.resize(entries.size(), v.initializer != 0);
  for (size_t i = 0; i < entries.size(); ++i) {
    const bool wanted = is_input || v.written_scalars[i] || v.initializer != 0;
    if (!entries[i].scalar) {
      if (wanted && !(is_input && entries[i].is_zero))
        fail("BuiltIn " + std::to_string(entries[i].unknown_built_in) + " is not supported.", v.offset_words);
      continue;
    }
    const InterfaceScalar& s = *entries[i].scalar;
    if (!wanted && s.built_in) continue;
    std::vector<InterfaceScalar>& list = is_input ? m.info.inputs : m.info.outputs;
    list.push_back(s);
    if (entries[i].high) list.push_back(*entries[i].high);
    if (s.built_in == BuiltIn::kFragDepth) m.info.writes_depth = true;
  }
}

void place_shared(Module& m, const Variable& v) {
  const Type& type = m.type(v.pointee);
  if (!type.is_value) fail("A Workgroup variable's type has no size.", v.offset_words);
  const uint64_t alignment = type.natural_alignment_bytes;
  const uint64_t start = (m.info.shared_memory_bytes + alignment - 1) / alignment * alignment;
  if (start + type.natural_bytes > kMaxSharedBytes) fail("Workgroup variables take more than 1 MiB.", v.offset_words);
  m.shared_offset_bytes[v.id] = static_cast<uint32_t>(start);
  m.info.shared_memory_bytes = static_cast<uint32_t>(start + type.natural_bytes + 3) / 4 * 4;
}

}  // namespace

void flatten_interfaces(Module& m) {
  for (uint32_t id : m.module_variables) {
    Variable& v = m.variables.at(id);
    const bool listed = std::ranges::find(m.entry_interface, id) != m.entry_interface.end();
    if (v.storage == spv::StorageClassWorkgroup && v.used) place_shared(m, v);
    if (v.storage == spv::StorageClassInput && v.used) list_entries(m, v);
    if (v.storage == spv::StorageClassOutput && (v.used || listed)) list_entries(m, v);
  }
  std::ranges::stable_sort(m.info.inputs, before);
  std::ranges::stable_sort(m.info.outputs, before);
  const auto same_place = [](const InterfaceScalar& a, const InterfaceScalar& b) { return !before(a, b) && !before(b, a); };
  if (std::ranges::adjacent_find(m.info.outputs, same_place) != m.info.outputs.end()) {
    fail("Two outputs have the same Location and Component.");
  }
}

}  // namespace pineda::spirv
