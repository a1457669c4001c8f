// Which components of the vertex record a fragment kernel really reads: after dead-code elimination, its loads through
// FragmentPrim::vertex.
#include <algorithm>
#include <map>

#include "base/abi.h"
#include "compiler/ir/walk.h"
#include "compiler/kernels/kernels.h"

namespace pineda::kernels {
namespace {

using ir::Inst;
using ir::Kernel;
using ir::Op;
using ir::Value;

// Whether a pointer is FragmentPrim::vertex[i], possibly moved to the provoking vertex.
bool is_vertex_pointer(const Kernel& kernel, Value pointer) {
  const Inst* inst = &kernel.at(pointer);
  if (inst->op == Op::kPtrAdd) inst = &kernel.at(inst->operand[0]);
  if (inst->op != Op::kLoad || kernel.at(inst->operand[0]).op != Op::kPrimPtr) return false;
  const Inst& offset = kernel.at(inst->operand[1]);
  constexpr uint64_t kFirst = offsetof(FragmentPrim, vertex), kEnd = kFirst + sizeof(FragmentPrim::vertex);
  return offset.op == Op::kConst && offset.imm >= kFirst && offset.imm < kEnd;
}

std::vector<Value> varying_loads(const Kernel& kernel) {
  std::vector<Value> loads;
  for (const ir::RegionId root : {kernel.draw, kernel.prim, kernel.wave}) {
    ir::for_each_inst(kernel, root, [&](Value v) {
      const Inst& inst = kernel.at(v);
      if (inst.op == Op::kLoad && inst.type != ir::Type::kPtr && is_vertex_pointer(kernel, inst.operand[0])) loads.push_back(v);
    });
  }
  return loads;
}

// The spirv translator refuses locations from here on.
constexpr uint32_t kFirstBuiltInLocation = 1024;
constexpr struct {
  spirv::BuiltIn built_in;
  uint32_t location;
} kBuiltInLocations[] = {{spirv::BuiltIn::kClipDistance, kFirstBuiltInLocation},
                         {spirv::BuiltIn::kCullDistance, kFirstBuiltInLocation + 2},
                         {spirv::BuiltIn::kPointSize, kFirstBuiltInLocation + 4},
                         {spirv::BuiltIn::kLayer, kFirstBuiltInLocation + 5},
                         {spirv::BuiltIn::kViewportIndex, kFirstBuiltInLocation + 6}};

}  // namespace

std::optional<compiler::VaryingSlot> built_in_slot(spirv::BuiltIn built_in, uint32_t element) {
  for (const auto& row : kBuiltInLocations) {
    if (row.built_in == built_in) return compiler::VaryingSlot{row.location + element / 4, element % 4};
  }
  return {};
}

VertexOutputs add_vertex_outputs(const spirv::ModuleInfo& vertex, bool draws_points,
                                 std::vector<compiler::VaryingSlot>& varyings) {
  VertexOutputs outputs;
  // Outputs are sorted, so a shader's distances come one after the other.
  const auto add = [&](const spirv::InterfaceScalar& out) {
    varyings.push_back(*built_in_slot(*out.built_in, out.component));
    return static_cast<uint16_t>(provisional_slot(0, 0) + varyings.size() - 1);
  };
  for (const spirv::InterfaceScalar& out : vertex.outputs) {
    if (!out.built_in) continue;
    switch (*out.built_in) {
      case spirv::BuiltIn::kPointSize:
        if (draws_points) outputs.point_size = add(out);
        break;
      case spirv::BuiltIn::kLayer:
        outputs.layer = add(out);
        break;
      case spirv::BuiltIn::kViewportIndex:
        outputs.viewport_index = add(out);
        break;
      case spirv::BuiltIn::kClipDistance: {
        const uint16_t slot = add(out);
        if (outputs.clip_count++ == 0) outputs.clip_distance = slot;
        break;
      }
      case spirv::BuiltIn::kCullDistance: {
        const uint16_t slot = add(out);
        if (outputs.cull_count++ == 0) outputs.cull_distance = slot;
        break;
      }
      default:
        break;
    }
  }
  return outputs;
}

std::vector<compiler::VaryingSlot> compact_varyings(Kernel& kernel) {
  const std::vector<Value> loads = varying_loads(kernel);
  std::map<uint64_t, Value> offsets;  // provisional offset -> constant that holds the final one
  for (const Value load : loads) offsets[kernel.at(kernel.at(load).operand[1]).imm];
  std::vector<compiler::VaryingSlot> varyings;
  // The constants stand at the head of the outermost region, where they dominate every load.
  std::vector<Value> constants;
  for (auto& [offset_bytes, constant] : offsets) {
    const uint32_t provisional = static_cast<uint32_t>(offset_bytes / kVertexSlotBytes) - provisional_slot(0, 0);
    const uint64_t slot = provisional_slot(0, 0) + varyings.size();
    constant = Value{static_cast<uint32_t>(kernel.insts.size())};
    kernel.insts.push_back({.op = Op::kConst, .type = ir::Type::kI32, .rate = ir::Rate::kDraw, .imm = slot * kVertexSlotBytes});
    constants.push_back(constant);
    varyings.push_back({provisional / 4, provisional % 4});
  }
  auto& head = kernel.regions[kernel.draw].insts;
  head.insert(head.begin(), constants.begin(), constants.end());
  for (const Value load : loads) {
    Value& offset = kernel.at(load).operand[1];
    offset = offsets.at(kernel.at(offset).imm);
  }
  return varyings;
}

}  // namespace pineda::kernels
