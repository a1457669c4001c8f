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
    case spv::StorageClassInput: input_variable(inst, v); break;
    case spv::StorageClassOutput:
    case spv::StorageClassPrivate: allocate(inst, v); initialise(v); break;
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
    default: break;  // UniformConstant: nothing until it is loaded
  }
  define(inst, Pointer{.variable = v.id, .pointee = v.pointee, .storage = v.storage});
}

void Translator::declare_local(const Instruction& inst) {
  const Variable& v = *m.variable(inst.word(2));
  if (!storage_.contains(v.id)) allocate(inst, v);  // a second inlining finds the memory of the first
  initialise(v);
  define(inst, Pointer{.variable = v.id, .pointee = v.pointee, .storage = v.storage});
}

uint32_t Translator::array_slot(ir::Type type) { return type == ir::Type::kB1 ? 0 : type == ir::Type::kI32 ? 1 : 2; }

void Translator::allocate(const Instruction& inst, const Variable& v) {
  Storage& s = storage_[v.id];
  s.types = m.flat_scalars(v.pointee);
  if (!v.dynamic) {
    for (ir::Type type : s.types) s.vars.push_back(variable(inst, type));
    return;
  }
  const auto count = static_cast<uint32_t>(s.types.size());
  for (ir::Type type : s.types) {
    ir::Value& array = s.arrays[array_slot(type)];
    if (array) continue;
    local_scalars_ += count;
    if (local_scalars_ > kMaxLocalScalars) inst.fail("the shader's dynamically indexed variables are too large");
    array = b.local(type, count);
  }
}

void Translator::initialise(const Variable& v) {
  const Constant* c = m.constant(v.initializer);
  if (!c) return;
  const Values values = constant_values(*c);
  const Storage& s = storage_.at(v.id);
  for (uint32_t i = 0; i < values.size(); ++i) {
    if (v.dynamic) b.local_store(s.arrays[array_slot(s.types[i])], b.i32(i), values[i]);
    else b.set(s.vars[i], values[i]);
  }
}

void Translator::input_variable(const Instruction& inst, const Variable& v) {
  if (v.dynamic) allocate(inst, v);
  Storage& s = storage_[v.id];
  s.types = m.flat_scalars(v.pointee);
  const std::vector<InterfaceEntry>& entries = m.interface_entries.at(v.id);
  for (uint32_t i = 0; i < entries.size(); ++i) {
    const ir::Value value = stage.input(b, *entries[i].scalar);
    if (!value || b.type(value) != s.types[i]) inst.fail("this input is not available here");
    if (v.dynamic) b.local_store(s.arrays[array_slot(s.types[i])], b.i32(i), value);
    else s.constants.push_back(value);
  }
}

// Outputs are given in (location, component) order of declaration; flatten_interfaces() decided which ones count.
void Translator::epilogue() {
  for (uint32_t id : m.module_variables) {
    const Variable& v = *m.variable(id);
    const auto found = m.interface_entries.find(id);
    if (v.storage != spv::StorageClassOutput || found == m.interface_entries.end()) continue;
    const Storage& s = storage_.at(id);
    for (uint32_t i = 0; i < found->second.size(); ++i) {
      const std::optional<InterfaceScalar>& scalar = found->second[i].scalar;
      if (!scalar || (scalar->built_in && !v.written_scalars[i])) continue;
      const ir::Value value = v.dynamic ? b.local_load(s.arrays[array_slot(s.types[i])], b.i32(i)) : b.get(s.vars[i]);
      stage.output(b, *scalar, value);
    }
  }
}

ir::Value Translator::array_of(const Instruction& inst, const Storage& s, ir::Type type) {
  const ir::Value array = s.arrays[array_slot(type)];
  if (!array) inst.fail("the pointer does not fit its variable");
  return array;
}

Translator::Storage& Translator::storage(const Instruction& inst, const Pointer& p) {
  const auto found = storage_.find(p.variable);
  if (found == storage_.end()) inst.fail("%" + std::to_string(p.variable) + " has no memory here");
  return found->second;
}

}  // namespace pineda::spirv
