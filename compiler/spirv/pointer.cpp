// Access chains: from a pointer and indices to a pointer whose offset is known, in scalars (flat memory) or bytes (buffers).
#include "compiler/spirv/pointer.h"

namespace pineda::spirv {
namespace {

bool is_buffer(spv::StorageClass s) {
  return s == spv::StorageClassUniform || s == spv::StorageClassStorageBuffer || s == spv::StorageClassPushConstant;
}

struct Index {
  bool is_constant = false;
  uint32_t constant = 0;
  ir::Value value;
};

Index read_index(Translator& t, const Instruction& inst, uint32_t word) {
  if (const Constant* c = t.m.constant(inst.word(word))) {
    if (t.m.type(c->type).kind != TypeKind::kInt) inst.fail("an index is not an integer");
    return {.is_constant = true, .constant = c->scalars.empty() ? 0 : c->scalars[0]};
  }
  return {.value = t.scalar(inst, word, ir::Type::kI32)};
}

void add_static(const Instruction& inst, Pointer& p, uint64_t amount) {
  const uint64_t sum = p.offset + amount;
  if (sum > 0xffffffffull) inst.fail("an offset is beyond 4 GiB");
  p.offset = static_cast<uint32_t>(sum);
}

// offset += index * stride
void advance(Translator& t, const Instruction& inst, Pointer& p, const Index& index, uint64_t stride) {
  if (index.is_constant) return add_static(inst, p, index.constant * stride);
  if (stride > 0xffffffffull) inst.fail("a stride is beyond 4 GiB");
  const ir::Value scaled = t.b.imul(index.value, t.b.i32(static_cast<uint32_t>(stride)));
  p.index = p.index ? t.b.iadd(p.index, scaled) : scaled;
}

// Constant indices of flat memory must be inside; in buffers the limit of each access decides.
void check_range(const Instruction& inst, const Pointer& p, const Type& type, const Index& index) {
  if (index.is_constant && index.constant >= type.count && !is_buffer(p.storage)) inst.fail("an index is out of range");
}

void step_descriptor(Translator& t, const Instruction& inst, Pointer& p, const Type& type, const Index& index) {
  if (index.is_constant) {
    if (type.kind == TypeKind::kArray && index.constant >= type.count) inst.fail("a descriptor index is out of range");
    p.descriptor = index.constant;
  } else {
    // Nothing beyond the binding is ever read: the kernel knows how long a runtime array is.
    p.descriptor_index = type.kind == TypeKind::kArray ? t.b.umin(index.value, t.b.i32(type.count - 1)) : index.value;
  }
  p.pointee = type.element;
}

void step_struct(Translator& t, const Instruction& inst, Pointer& p, const Type& type, const Index& index) {
  if (!index.is_constant || index.constant >= type.members.size()) inst.fail("a struct index must be a constant member number");
  if (is_buffer(p.storage)) {
    const Decorations& d = t.m.member_of(type.id, index.constant);
    add_static(inst, p, member_offset_bytes(t.m, inst, type, index.constant));
    if (d.matrix_stride) {
      p.matrix_stride_bytes = multiple_of_4(inst, *d.matrix_stride, "MatrixStride");
      p.row_major = d.row_major;
    }
  } else {
    add_static(inst, p, type.first_scalar[index.constant]);
  }
  p.pointee = type.members[index.constant];
}

void step_array(Translator& t, const Instruction& inst, Pointer& p, const Type& type, const Index& index) {
  const bool bytes = is_buffer(p.storage);
  if (type.kind == TypeKind::kArray) check_range(inst, p, type, index);
  advance(t, inst, p, index, bytes ? array_stride_bytes(t.m, inst, type) : t.m.type(type.element).scalar_count);
  p.pointee = type.element;
}

void step_matrix(Translator& t, const Instruction& inst, Pointer& p, const Type& type, const Index& index) {
  check_range(inst, p, type, index);
  if (is_buffer(p.storage)) {
    if (p.matrix_stride_bytes == 0) inst.fail("a matrix in a buffer has no MatrixStride");
    advance(t, inst, p, index, p.row_major ? 4 : p.matrix_stride_bytes);
    p.component_stride_bytes = p.row_major ? p.matrix_stride_bytes : 4;
  } else {
    advance(t, inst, p, index, t.m.type(type.element).count);
  }
  p.pointee = type.element;
}

void step_vector(Translator& t, const Instruction& inst, Pointer& p, const Type& type, const Index& index) {
  check_range(inst, p, type, index);
  advance(t, inst, p, index, is_buffer(p.storage) ? p.component_stride_bytes : 1);
  p.pointee = type.element;
}

}  // namespace

uint32_t multiple_of_4(const Instruction& inst, uint32_t bytes, const char* what) {
  if (bytes % 4 != 0) inst.fail(std::string(what) + " " + std::to_string(bytes) + " is not a multiple of 4");
  return bytes;
}

uint32_t array_stride_bytes(const Module& m, const Instruction& inst, const Type& array) {
  const std::optional<uint32_t> stride = m.decorations_of(array.id).array_stride;
  if (!stride || *stride == 0) inst.fail("an array in a buffer has no ArrayStride");
  return multiple_of_4(inst, *stride, "ArrayStride");
}

uint32_t member_offset_bytes(const Module& m, const Instruction& inst, const Type& structure, uint32_t member) {
  const std::optional<uint32_t> offset = m.member_of(structure.id, member).offset;
  if (!offset) inst.fail("member " + std::to_string(member) + " of a struct in a buffer has no Offset");
  return multiple_of_4(inst, *offset, "Offset");
}

void access_chain(Translator& t, const Instruction& inst) {
  Pointer p = t.pointer(inst, 3);
  const uint32_t root_type = t.m.variable(p.variable)->pointee;
  for (uint32_t word = 4; word < inst.size(); ++word) {
    const Type& type = t.m.type(p.pointee);
    const Index index = read_index(t, inst, word);
    const bool has_descriptors = p.storage == spv::StorageClassUniformConstant || p.storage == spv::StorageClassUniform ||
                                 p.storage == spv::StorageClassStorageBuffer;
    const bool is_array = type.kind == TypeKind::kArray || type.kind == TypeKind::kRuntimeArray;
    if (has_descriptors && is_array && type.id == root_type) {
      step_descriptor(t, inst, p, type, index);
      continue;
    }
    switch (type.kind) {
      case TypeKind::kStruct:
        step_struct(t, inst, p, type, index);
        break;
      case TypeKind::kArray:
      case TypeKind::kRuntimeArray:
        step_array(t, inst, p, type, index);
        break;
      case TypeKind::kMatrix:
        step_matrix(t, inst, p, type, index);
        break;
      case TypeKind::kVector:
        step_vector(t, inst, p, type, index);
        break;
      default:
        inst.fail("has more indices than its type has levels");
    }
  }
  t.define(inst, p);
}

}  // namespace pineda::spirv
