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
  array_bytes_ += memory.array_bytes();
  if (var_count_ > kMaxVars) inst.fail("the shader needs too many variables");
  if (array_bytes_ > kMaxArrayBytes) inst.fail("the shader's dynamically indexed variables are too large");
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
    if (entries[i].is_zero) {
      memory.store(b, inst, i, {}, b.zero(memory.type(i)));
      continue;
    }
    const ir::Value low = stage.input(b, *entries[i].scalar);
    const ir::Value high = entries[i].high ? stage.input(b, *entries[i].high) : ir::Value{};
    const bool fits =
        low && b.type(low) == entries[i].scalar->type && (!entries[i].high || (high && b.type(high) == ir::Type::kI32));
    if (!fits) inst.fail("this input is not available here");
    memory.store(b, inst, i, {}, from_words(memory.type(i), low, high));
  }
}

// ---- numbers that are not 32 bits wide, between stages: see InterfaceEntry ----

ir::Value Translator::from_words(ir::Type type, ir::Value low, ir::Value high) {
  if (high) {
    const ir::Value upper = b.shl(b.convert(ir::Op::kZExt, ir::Type::kI64, high), b.i64(32));
    return b.bitcast(type, b.or_(b.convert(ir::Op::kZExt, ir::Type::kI64, low), upper));
  }
  if (b.type(low) == type) return low;
  return b.convert(ir::is_float(type) ? ir::Op::kFConvert : ir::Op::kTrunc, type, low);
}

void Translator::write_output(const InterfaceEntry& entry, ir::Value value) {
  const ir::Type type = b.type(value);
  if (entry.high) {
    const ir::Value bits = b.bitcast(ir::Type::kI64, value);
    stage.output(b, *entry.scalar, b.convert(ir::Op::kTrunc, ir::Type::kI32, bits));
    stage.output(b, *entry.high, b.convert(ir::Op::kTrunc, ir::Type::kI32, b.lshr(bits, b.i64(32))));
  } else if (type == entry.scalar->type) {
    stage.output(b, *entry.scalar, value);
  } else {
    const ir::Op widen = ir::is_float(type) ? ir::Op::kFConvert : entry.is_signed ? ir::Op::kSExt : ir::Op::kZExt;
    stage.output(b, *entry.scalar, b.convert(widen, entry.scalar->type, value));
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
      const FlatMemory& memory = flat_.at(id);
      write_output(found->second[i], memory.load(b, inst, i, {}, memory.type(i)));
    }
  }
}

const FlatMemory& Translator::flat(const Instruction& inst, const Pointer& p) const {
  const auto found = flat_.find(p.variable);
  if (found == flat_.end()) inst.fail("%" + std::to_string(p.variable) + " has no memory here");
  return found->second;
}

}  // namespace pineda::spirv
