// Access chains: from a pointer and indices to a pointer whose offset is known, in scalars (flat memory) or bytes (all other).
#include "compiler/spirv/pointer.h"

#include "compiler/ir/ranges.h"
#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

struct Index {
  bool is_constant = false;
  uint32_t constant = 0;
  ir::Value value;
};

Index read_index(Translator& t, const Instruction& inst, uint32_t word) {
  const uint32_t id = inst.word(word);
  if (t.m.constant(id)) return {.is_constant = true, .constant = t.m.constant_u32(inst, id)};
  return {.value = t.index(inst, word)};
}

void add_static(const Instruction& inst, Pointer& p, uint64_t amount) {
  const uint64_t sum = p.offset + amount;
  if (sum > 0xffffffffull) inst.fail("an offset is beyond 4 GiB");
  p.offset = static_cast<uint32_t>(sum);
}

void require(Translator& t, Pointer& p, bool is_known, const std::function<ir::Value()>& condition) {
  if (is_known) return;
  const ir::Value holds = condition();
  p.in_range = p.in_range ? t.b.and_(p.in_range, holds) : holds;
}

// offset += index * stride. Offsets are computed modulo 2^32: where they wrap the access is out of bounds, not somewhere else in
// the buffer (robustBufferAccess2). Flat memory is bounded by its own length.
void advance(Translator& t, const Instruction& inst, Pointer& p, const Index& index, uint64_t stride) {
  if (index.is_constant) return add_static(inst, p, index.constant * stride);
  if (stride > 0xffffffffull) inst.fail("a stride is beyond 4 GiB");
  const ir::Value scaled = t.b.imul(index.value, t.b.i32(static_cast<uint32_t>(stride)));
  if (!is_flat(p.storage) && stride != 0) {
    const auto most = static_cast<uint32_t>(ir::kAnyU32 / stride);
    require(t, p, ir::upper_bound(t.b.kernel(), index.value) <= most, [&] { return t.b.ule(index.value, t.b.i32(most)); });
  }
  const ir::Value sum = p.index ? t.b.iadd(p.index, scaled) : scaled;
  if (!is_flat(p.storage) && p.index) {
    const uint64_t most = ir::upper_bound(t.b.kernel(), p.index) + ir::upper_bound(t.b.kernel(), scaled);
    require(t, p, most <= ir::kAnyU32, [&] { return t.b.ule(scaled, sum); });
  }
  p.index = sum;
  const auto divides = static_cast<uint32_t>(stride & (0 - stride));
  if (divides != 0) p.index_alignment_bytes = std::min(p.index_alignment_bytes, divides);
}

// Constant indices of flat memory must be inside; elsewhere the limit of each access decides.
void check_range(const Instruction& inst, const Pointer& p, const Type& type, const Index& index) {
  if (index.is_constant && index.constant >= type.count && is_flat(p.storage)) inst.fail("an index is out of range");
}

void step_descriptor(Translator& t, const Instruction& inst, Pointer& p, const Type& type, const Index& index) {
  const bool is_bounded = type.kind == TypeKind::kArray;  // otherwise the pipeline layout has the length
  if (index.is_constant) {
    if (is_bounded && index.constant >= type.count) inst.fail("a descriptor index is out of range");
    p.descriptor = index.constant;
  } else {
    // Nothing beyond the binding is ever read: the kernel knows how long a runtime array is.
    p.descriptor_index = is_bounded ? t.b.umin(index.value, t.b.i32(type.count - 1)) : index.value;
  }
  p.pointee = type.element;
}

void step_struct(Translator& t, const Instruction& inst, Pointer& p, const Type& type, const Index& index) {
  if (!index.is_constant || index.constant >= type.members.size()) inst.fail("a struct index must be a constant member number");
  if (is_flat(p.storage)) {
    add_static(inst, p, type.first_scalar[index.constant]);
  } else {
    add_static(inst, p, member_offset_bytes(t.m, inst, type, index.constant, has_natural_layout(p.storage)));
    set_matrix_layout(p, t.m.member_of(type.id, index.constant));
  }
  p.pointee = type.members[index.constant];
}

void step_array(Translator& t, const Instruction& inst, Pointer& p, const Type& type, const Index& index) {
  if (type.kind == TypeKind::kArray) check_range(inst, p, type, index);
  const bool natural = has_natural_layout(p.storage);
  advance(t, inst, p, index,
          is_flat(p.storage) ? t.m.type(type.element).scalar_count : array_stride_bytes(t.m, inst, type, natural));
  p.pointee = type.element;
}

void step_matrix(Translator& t, const Instruction& inst, Pointer& p, const Type& type, const Index& index) {
  check_range(inst, p, type, index);
  if (is_flat(p.storage)) {
    advance(t, inst, p, index, t.m.type(type.element).count);
  } else {
    const MatrixStrides strides = matrix_strides(t.m, inst, type, p);
    advance(t, inst, p, index, strides.column_bytes);
    p.component_stride_bytes = strides.component_bytes;
  }
  p.pointee = type.element;
}

void step_vector(Translator& t, const Instruction& inst, Pointer& p, const Type& type, const Index& index) {
  check_range(inst, p, type, index);
  advance(t, inst, p, index, is_flat(p.storage) ? 1 : component_stride_bytes(t.m, type, p));
  p.pointee = type.element;
}

bool has_descriptors(spv::StorageClass s) {
  return s == spv::StorageClassUniformConstant || s == spv::StorageClassUniform || s == spv::StorageClassStorageBuffer;
}

// Takes the indices from `word` on.
void walk(Translator& t, const Instruction& inst, Pointer& p, uint32_t word) {
  const uint32_t root_type = p.variable != 0 ? t.m.variable(p.variable)->pointee : 0;
  for (; word < inst.size(); ++word) {
    const Type& type = t.m.type(p.pointee);
    const Index index = read_index(t, inst, word);
    const bool is_array = type.kind == TypeKind::kArray || type.kind == TypeKind::kRuntimeArray;
    if (has_descriptors(p.storage) && is_array && type.id == root_type) {
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
}

void access_chain(Translator& t, const Instruction& inst) {
  Pointer p = t.pointer(inst, 3);
  walk(t, inst, p, 4);
  t.define(inst, p);
}

// ---- pointers as operands -------------------------------------------------------------------------------------------------

// Bytes between consecutive elements of what a pointer walks over (OpPtrAccessChain, OpPtrDiff).
uint32_t element_stride_bytes(Translator& t, const Instruction& inst, const Type& pointer) {
  if (pointer.kind != TypeKind::kPointer || is_flat(pointer.storage))
    inst.fail("needs a pointer to a buffer or Workgroup memory");
  if (const auto stride = t.m.decorations_of(pointer.id).array_stride; stride && *stride != 0) return *stride;
  const uint64_t natural = t.m.type(pointer.element).natural_bytes;
  if (!has_natural_layout(pointer.storage)) inst.fail("the pointer's type has no ArrayStride");
  if (natural == 0 || natural > ~0u) inst.fail("the pointer's type has no size");
  return static_cast<uint32_t>(natural);
}

void ptr_access_chain(Translator& t, const Instruction& inst) {
  Pointer p = t.pointer(inst, 3);
  const ir::Value in_range = p.in_range;
  advance(t, inst, p, read_index(t, inst, 4), element_stride_bytes(t, inst, t.type_of(inst, 3)));
  p.in_range = in_range;  // Element may be negative: this sum wraps as it should
  walk(t, inst, p, 5);
  t.define(inst, p);
}

// Where a pointer points, as a number: only differences and equality are ever seen of a logical one.
ir::Value address_of(Translator& t, const Instruction& inst, uint32_t word) {
  const Type& type = t.type_of(inst, word);
  if (type.kind != TypeKind::kPointer || !type.is_value) inst.fail("%" + std::to_string(inst.word(word)) + " is not a pointer");
  const Values v = t.values(inst, word);
  return v.size() == 1 ? v[0] : t.b.iadd(v[0], t.b.convert(ir::Op::kZExt, ir::Type::kI64, v[2]));
}

template <bool kEqual>
void ptr_equal(Translator& t, const Instruction& inst) {
  const ir::Value a = address_of(t, inst, 3), c = address_of(t, inst, 4);
  t.define(inst, Values{kEqual ? t.b.ieq(a, c) : t.b.ine(a, c)});
}

void ptr_diff(Translator& t, const Instruction& inst) {
  const ir::Value bytes = t.b.isub(address_of(t, inst, 3), address_of(t, inst, 4));
  const ir::Value elements = t.b.sdiv(bytes, t.b.i64(element_stride_bytes(t, inst, t.type_of(inst, 3))));
  const ir::Type type = t.result_type(inst).scalar;
  if (!ir::is_int(type)) inst.fail("the result is not an integer");
  t.define(inst, Values{t.b.convert(ir::Op::kTrunc, type, elements)});
}

// ConvertPtrToU, ConvertUToPtr: zero-extended or cut to the result's width (SPIR-V 3.52.11).
void convert_pointer(Translator& t, const Instruction& inst) {
  const Type &from = t.type_of(inst, 3), &to = t.result_type(inst);
  const bool fits = from.is_scalar() && to.is_scalar() && ir::is_int(from.scalar) && ir::is_int(to.scalar) &&
                    (from.kind == TypeKind::kPointer) != (to.kind == TypeKind::kPointer);
  if (!fits) inst.fail("converts between an integer and a PhysicalStorageBuffer pointer");
  const bool narrower = ir::size_bytes(to.scalar) < ir::size_bytes(from.scalar);
  t.define(inst, Values{t.b.convert(narrower ? ir::Op::kTrunc : ir::Op::kZExt, to.scalar, t.values(inst, 3)[0])});
}

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(AccessChain, 4, access_chain),
    PINEDA_SPIRV_ROW(InBoundsAccessChain, 4, access_chain),
    PINEDA_SPIRV_ROW(PtrAccessChain, 5, ptr_access_chain),
    PINEDA_SPIRV_ROW(InBoundsPtrAccessChain, 5, ptr_access_chain),
    PINEDA_SPIRV_ROW(PtrEqual, 5, ptr_equal<true>),
    PINEDA_SPIRV_ROW(PtrNotEqual, 5, ptr_equal<false>),
    PINEDA_SPIRV_ROW(PtrDiff, 5, ptr_diff),
    PINEDA_SPIRV_ROW(ConvertPtrToU, 4, convert_pointer),
    PINEDA_SPIRV_ROW(ConvertUToPtr, 4, convert_pointer),
};

}  // namespace

std::span<const OpRow> pointer_rows() { return kRows; }

// ---- layouts --------------------------------------------------------------------------------------------------------------

uint32_t array_stride_bytes(const Module& m, const Instruction& inst, const Type& array, bool natural) {
  if (natural) return static_cast<uint32_t>(std::min<uint64_t>(m.type(array.element).natural_bytes, ~0u));
  const std::optional<uint32_t> stride = m.decorations_of(array.id).array_stride;
  if (!stride || *stride == 0) inst.fail("an array in a buffer has no ArrayStride");
  return *stride;
}

uint32_t member_offset_bytes(const Module& m, const Instruction& inst, const Type& structure, uint32_t member, bool natural) {
  if (natural) return static_cast<uint32_t>(std::min<uint64_t>(structure.natural_offset_bytes[member], ~0u));
  const std::optional<uint32_t> offset = m.member_of(structure.id, member).offset;
  if (!offset) inst.fail("member " + std::to_string(member) + " of a struct in a buffer has no Offset");
  return *offset;
}

void set_matrix_layout(Pointer& p, const Decorations& member) {
  if (!member.matrix_stride) return;
  p.matrix_stride_bytes = *member.matrix_stride;
  p.row_major = member.row_major;
}

MatrixStrides matrix_strides(const Module& m, const Instruction& inst, const Type& matrix, const Pointer& p) {
  const Type& column = m.type(matrix.element);
  const uint32_t scalar_bytes = ir::size_bytes(m.type(column.element).scalar);
  if (has_natural_layout(p.storage)) return {static_cast<uint32_t>(column.natural_bytes), 0};
  if (p.matrix_stride_bytes == 0) inst.fail("a matrix in a buffer has no MatrixStride");
  return p.row_major ? MatrixStrides{scalar_bytes, p.matrix_stride_bytes} : MatrixStrides{p.matrix_stride_bytes, 0};
}

uint32_t component_stride_bytes(const Module& m, const Type& vector, const Pointer& p) {
  if (p.component_stride_bytes != 0) return p.component_stride_bytes;
  return static_cast<uint32_t>(m.type(vector.element).natural_bytes);
}

}  // namespace pineda::spirv
