// Variables: how each storage class becomes IR, at the shader's start and end.
#include <bit>

#include "compiler/spirv/translator.h"

namespace pineda::spirv {

void Translator::prologue() {
  const Instruction& entry = m.instructions[m.function(m.entry_point).first];
  if (m.info.uses_discard) killed_ = variable(entry, ir::Type::kB1);
  for (uint32_t id : m.module_variables) {
    const Variable& v = *m.variable(id);
    if (v.used || m.interface_entries.contains(id)) module_variable(v);
  }
}

void Translator::module_variable(const Variable& v) {
  const Instruction& inst = m.instructions[m.definition[v.id] - 1];
  switch (v.storage) {
    case spv::StorageClassInput:
      input_variable(inst, v);
      break;
    case spv::StorageClassOutput:
    case spv::StorageClassPrivate:
      allocate(inst, v);
      initialise(v);
      break;
    case spv::StorageClassWorkgroup:
      if (!shared_) shared_ = stage.shared_memory(b);
      if (!shared_) inst.fail("Workgroup memory is not available here");
      break;
    case spv::StorageClassUniform:
    case spv::StorageClassStorageBuffer:
    case spv::StorageClassPushConstant:
      // Once, here, so that the base stands where every access can use it.
      if (m.type(v.pointee).kind == TypeKind::kStruct) {
        const Pointer whole{.variable = v.id, .pointee = v.pointee, .storage = v.storage};
        buffers_[v.id] = buffer(inst, whole);
      }
      break;
    default:
      break;  // UniformConstant: nothing until it is loaded
  }
  define(inst, Pointer{.variable = v.id, .pointee = v.pointee, .storage = v.storage});
}

void Translator::declare_local(const Instruction& inst) {
  const Variable& v = *m.variable(inst.word(2));
  if (!flat_.contains(v.id)) allocate(inst, v);  // a second inlining finds the memory of the first
  initialise(v);
  define(inst, Pointer{.variable = v.id, .pointee = v.pointee, .storage = v.storage});
}

void Translator::allocate(const Instruction& inst, const Variable& v) {
  FlatMemory& memory = flat_[v.id] = FlatMemory(m.flat_scalars(v.pointee), v.dynamic_step);
  var_count_ += memory.var_count();
  local_scalars_ += memory.array_scalars();
  if (var_count_ > kMaxVars) inst.fail("the shader needs too many variables");
  if (local_scalars_ > kMaxLocalScalars) inst.fail("the shader's dynamically indexed variables are too large");
  memory.allocate(b);
}

void Translator::initialise(const Variable& v) {
  const Constant* c = m.constant(v.initializer);
  if (!c) return;
  const Values values = constant_values(*c);
  const Instruction& inst = m.instructions[m.definition[v.id] - 1];
  for (uint32_t i = 0; i < values.size(); ++i) flat_.at(v.id).store(b, inst, i, {}, values[i]);
}

void Translator::input_variable(const Instruction& inst, const Variable& v) {
  allocate(inst, v);
  const FlatMemory& memory = flat_.at(v.id);
  const std::vector<InterfaceEntry>& entries = m.interface_entries.at(v.id);
  for (uint32_t i = 0; i < entries.size(); ++i) {
    const ir::Value value = stage.input(b, *entries[i].scalar);
    if (!value || b.type(value) != memory.type(i)) inst.fail("this input is not available here");
    memory.store(b, inst, i, {}, value);
  }
}

// Outputs are given in (location, component) order of declaration; flatten_interfaces() decided which ones count.
void Translator::epilogue() {
  for (uint32_t id : m.module_variables) {
    const Variable& v = *m.variable(id);
    const auto found = m.interface_entries.find(id);
    if (v.storage != spv::StorageClassOutput || found == m.interface_entries.end()) continue;
    const Instruction& inst = m.instructions[m.definition[id] - 1];
    for (uint32_t i = 0; i < found->second.size(); ++i) {
      const std::optional<InterfaceScalar>& scalar = found->second[i].scalar;
      if (!scalar || (scalar->built_in && !v.written_scalars[i])) continue;
      const ir::Value value = flat_.at(id).load(b, inst, i, {}, scalar->type);
      stage.output(b, *scalar, value);
    }
  }
}

const FlatMemory& Translator::flat(const Instruction& inst, const Pointer& p) const {
  const auto found = flat_.find(p.variable);
  if (found == flat_.end()) inst.fail("%" + std::to_string(p.variable) + " has no memory here");
  return found->second;
}

}  // namespace pineda::spirv
