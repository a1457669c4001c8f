// Loads and stores through resolved pointers, and the instructions made of them.
#include <algorithm>

#include "compiler/ir/ranges.h"
#include "compiler/spirv/image.h"
#include "compiler/spirv/opcodes.h"
#include "compiler/spirv/pointer.h"

namespace pineda::spirv {
namespace {

// Calls fn(scalar type, bytes from the pointer) for every scalar of a value in memory, in flattened order.
struct LayoutWalk {
  const Module& m;
  const Instruction& inst;
  const bool natural;
  const std::function<void(ir::Type, uint32_t)>& fn;

  void walk(uint32_t type_id, uint64_t at, const Pointer& layout) const {
    const Type& type = m.type(type_id);
    switch (type.kind) {
      case TypeKind::kBool:
        if (!natural) inst.fail("a bool cannot be in a buffer");
        [[fallthrough]];
      case TypeKind::kInt:
      case TypeKind::kFloat:
        if (at > 0xffffffffull) inst.fail("an offset is beyond 4 GiB");
        fn(type.scalar, static_cast<uint32_t>(at));
        break;
      case TypeKind::kVector:
        for (uint32_t i = 0; i < type.count; ++i) {
          walk(type.element, at + uint64_t{i} * component_stride_bytes(m, type, layout), layout);
        }
        break;
      case TypeKind::kPointer:
        if (!type.is_scalar()) inst.fail("a pointer that is not physical cannot be in a buffer");
        fn(type.scalar, static_cast<uint32_t>(at));
        break;
      case TypeKind::kMatrix:
        matrix(type, at, layout);
        break;
      case TypeKind::kArray: {
        const uint64_t stride = array_stride_bytes(m, inst, type, natural);
        for (uint32_t i = 0; i < type.count; ++i) walk(type.element, at + i * stride, layout);
        break;
      }
      case TypeKind::kStruct:
        for (uint32_t i = 0; i < type.members.size(); ++i) {
          const Decorations& d = m.member_of(type_id, i);
          Pointer inner = layout;
          set_matrix_layout(inner, d);
          walk(type.members[i], at + member_offset_bytes(m, inst, type, i, natural), inner);
        }
        break;
      default:
        inst.fail("a value of this type cannot be in a buffer");
    }
  }

  void matrix(const Type& type, uint64_t at, const Pointer& layout) const {
    const MatrixStrides strides = matrix_strides(m, inst, type, layout);
    Pointer column = layout;
    column.component_stride_bytes = strides.component_bytes;
    for (uint32_t c = 0; c < type.count; ++c) walk(type.element, at + uint64_t{c} * strides.column_bytes, column);
  }
};

void for_each_in_memory(const Module& m, const Instruction& inst, const Pointer& p,
                        const std::function<void(ir::Type, uint32_t)>& fn) {
  m.flat_scalars(p.pointee);  // bounds the size
  LayoutWalk{m, inst, has_natural_layout(p.storage), fn}.walk(p.pointee, 0, p);
}

// The struct that a buffer variable points to, or to an array of which it points.
const Type& block_type(const Module& m, uint32_t variable) {
  const Type& type = m.type(m.variable(variable)->pointee);
  return type.kind == TypeKind::kArray || type.kind == TypeKind::kRuntimeArray ? m.type(type.element) : type;
}

}  // namespace

// ---- addresses ------------------------------------------------------------------------------------------------------------

bool Translator::is_writable(const Pointer& p) const {
  return p.storage == spv::StorageClassStorageBuffer || p.storage == spv::StorageClassPhysicalStorageBuffer ||
         (p.storage == spv::StorageClassUniform && m.decorations_of(block_type(m, p.variable).id).buffer_block);
}

BufferRef Translator::buffer(const Instruction& inst, const Pointer& p) {
  if (const auto cached = buffers_.find(p.variable); cached != buffers_.end()) return cached->second;
  const Decorations& d = m.decorations_of(p.variable);
  std::optional<BufferRef> ref;
  if (p.storage == spv::StorageClassPushConstant) {
    ref = stage.buffer(b, StageInterface::kPushConstants, 0, b.i32(0));
  } else {
    if (!d.set || !d.binding) inst.fail("buffer %" + std::to_string(p.variable) + " has no DescriptorSet or Binding");
    ref = stage.buffer(b, *d.set, *d.binding, p.descriptor_index ? p.descriptor_index : b.i32(p.descriptor));
  }
  if (!ref) inst.fail("buffer %" + std::to_string(p.variable) + " is not in the pipeline layout");
  return *ref;
}

BufferRef Translator::memory_of(const Instruction& inst, const Pointer& p) {
  if (p.base) return {.base = p.base, .size_bytes = p.size_bytes};
  if (p.storage == spv::StorageClassWorkgroup) return {.base = shared_, .size_bytes = b.i32(m.info.shared_memory_bytes)};
  return buffer(inst, p);
}

uint64_t Translator::static_offset_bytes(const Pointer& p) const {
  const bool is_shared = p.storage == spv::StorageClassWorkgroup && p.variable != 0;
  return uint64_t{p.offset} + (is_shared ? m.shared_offset_bytes.at(p.variable) : 0);
}

ir::Address Translator::address(const Instruction& inst, const Pointer& p, uint32_t extra_bytes) {
  const BufferRef ref = memory_of(inst, p);
  const uint64_t start = static_offset_bytes(p) + extra_bytes;
  if (start > 0xffffffffull) inst.fail("an offset is beyond 4 GiB");
  ir::Value offset = b.i32(static_cast<uint32_t>(start));
  if (!p.index) return {.base = ref.base, .offset = offset, .limit = ref.size_bytes};
  offset = b.iadd(p.index, offset);
  // The dynamic part is a multiple of its alignment, so a smaller constant cannot make it wrap.
  ir::Value in_range = p.in_range;
  if (start >= p.index_alignment_bytes && p.index_alignment_bytes > 1) {
    const auto most = static_cast<uint32_t>((ir::kAnyU32 - start) / p.index_alignment_bytes * p.index_alignment_bytes);
    if (ir::upper_bound(b.kernel(), p.index) > most) {
      const ir::Value fits = b.ule(p.index, b.i32(most));
      in_range = in_range ? b.and_(in_range, fits) : fits;
    }
  }
  return {.base = ref.base, .offset = offset, .limit = in_range ? b.select(in_range, ref.size_bytes, b.i32(0)) : ref.size_bytes};
}

// Memory that begins where a descriptor points is aligned by the rules for descriptors; what lies in it may not be.
ir::Address Translator::atomic_address(const Instruction& inst, const Pointer& p) {
  const uint32_t size_bytes = ir::size_bytes(m.type(p.pointee).scalar);
  ir::Address at = address(inst, p);
  const bool is_aligned = static_offset_bytes(p) % size_bytes == 0 && (!p.index || p.index_alignment_bytes >= size_bytes);
  if (!is_aligned) at.offset = b.and_(at.offset, b.i32(0 - size_bytes));
  return at;
}

// Memory that nothing writes during the kernel may be read earlier: uniform memory always, storage buffers when this shader
// writes none.
uint8_t Translator::load_flags(const Pointer& from) const {
  if (from.storage == spv::StorageClassWorkgroup) return 0;
  return !is_writable(from) || !m.info.writes_memory ? ir::kInvariant : 0;
}

// ---- loads ----------------------------------------------------------------------------------------------------------------

Values Translator::load(const Instruction& inst, const Pointer& from) {
  switch (from.storage) {
    case spv::StorageClassFunction:
    case spv::StorageClassPrivate:
    case spv::StorageClassInput:
    case spv::StorageClassOutput:
      return load_flat(inst, from);
    case spv::StorageClassWorkgroup:
    case spv::StorageClassUniform:
    case spv::StorageClassStorageBuffer:
    case spv::StorageClassPushConstant:
    case spv::StorageClassPhysicalStorageBuffer:
      return load_memory(inst, from);
    default:
      inst.fail("this storage class cannot be read here");
  }
}

Values Translator::load_flat(const Instruction& inst, const Pointer& from) {
  const FlatMemory& memory = flat(inst, from);
  const std::vector<ir::Type> types = m.flat_scalars(from.pointee);
  Values out;
  out.reserve(types.size());
  for (uint32_t i = 0; i < types.size(); ++i) out.push_back(memory.load(b, inst, from.offset + i, from.index, types[i]));
  return out;
}

Values Translator::load_memory(const Instruction& inst, const Pointer& from) {
  Values out;
  const uint8_t flags = load_flags(from);
  for_each_in_memory(m, inst, from, [&](ir::Type type, uint32_t at) {
    const bool is_bool = type == ir::Type::kB1;  // 0 or 1 in memory
    const ir::Value v = b.load(is_bool ? ir::Type::kI32 : type, address(inst, from, at), flags);
    out.push_back(is_bool ? b.ine(v, b.i32(0)) : v);
  });
  return out;
}

// ---- stores ---------------------------------------------------------------------------------------------------------------

void Translator::store(const Instruction& inst, const Pointer& to, const Values& values) {
  const std::vector<ir::Type> types = m.flat_scalars(to.pointee);
  if (types.size() != values.size()) inst.fail("the object does not have the pointee's type");
  for (size_t i = 0; i < values.size(); ++i) {
    if (b.type(values[i]) != types[i]) inst.fail("the object does not have the pointee's type");
  }
  switch (to.storage) {
    case spv::StorageClassFunction:
    case spv::StorageClassPrivate:
    case spv::StorageClassOutput:
      return store_flat(inst, to, values);
    case spv::StorageClassWorkgroup:
      return store_memory(inst, to, values);
    case spv::StorageClassUniform:
    case spv::StorageClassStorageBuffer:
    case spv::StorageClassPhysicalStorageBuffer:
      if (!is_writable(to)) inst.fail("uniform buffers cannot be written");
      return effect([&] { store_memory(inst, to, values); });
    default:
      inst.fail("this storage class cannot be written");
  }
}

void Translator::store_flat(const Instruction& inst, const Pointer& to, const Values& values) {
  const FlatMemory& memory = flat(inst, to);
  for (uint32_t i = 0; i < values.size(); ++i) memory.store(b, inst, to.offset + i, to.index, values[i]);
}

void Translator::store_memory(const Instruction& inst, const Pointer& to, const Values& values) {
  uint32_t i = 0;
  for_each_in_memory(m, inst, to, [&](ir::Type type, uint32_t at) {
    const ir::Value v = values[i++];
    b.store(address(inst, to, at), type == ir::Type::kB1 ? b.convert(ir::Op::kZExt, ir::Type::kI32, v) : v);
  });
}

// ---- instructions ---------------------------------------------------------------------------------------------------------

Opaque opaque_of(Translator& t, const Instruction& inst, const Pointer& p) {
  const Type& type = t.m.type(p.pointee);
  const Decorations& d = t.m.decorations_of(p.variable);
  if (!d.set || !d.binding) inst.fail("%" + std::to_string(p.variable) + " has no DescriptorSet or Binding");
  const ImageRef ref{.set = *d.set, .binding = *d.binding, .array_index = p.descriptor, .index = p.descriptor_index};
  switch (type.kind) {
    case TypeKind::kImage:
      return {.image_type = type.id, .image = ref};
    case TypeKind::kSampledImage:
      return {.image_type = type.element, .has_sampler = true, .image = ref, .sampler = ref};
    case TypeKind::kSampler:
      return {.has_sampler = true, .sampler = ref};
    default:
      inst.fail("this type cannot be loaded");
  }
}

namespace {

void op_load(Translator& t, const Instruction& inst) {
  const Pointer p = t.pointer(inst, 3);
  if (p.pointee != inst.word(1)) inst.fail("the result type is not what is pointed to");
  if (p.storage == spv::StorageClassUniformConstant)
    t.define(inst, opaque_of(t, inst, p));
  else
    t.define(inst, t.load(inst, p));
}

void op_store(Translator& t, const Instruction& inst) { t.store(inst, t.pointer(inst, 1), t.values(inst, 2)); }

void op_copy_memory(Translator& t, const Instruction& inst) {
  t.store(inst, t.pointer(inst, 1), t.load(inst, t.pointer(inst, 2)));
}

// A constant number of bytes between objects of one type that is as long, as glslang and LLVM write it.
void op_copy_memory_sized(Translator& t, const Instruction& inst) {
  const Pointer to = t.pointer(inst, 1), from = t.pointer(inst, 2);
  const uint64_t size_bytes = t.m.type(to.pointee).natural_bytes;
  if (to.pointee != from.pointee || t.m.constant_u32(inst, inst.word(3)) != size_bytes) {
    inst.fail("only whole objects of one type can be copied, of " + std::to_string(size_bytes) + " bytes here");
  }
  t.store(inst, to, t.load(inst, from));
}

void op_array_length(Translator& t, const Instruction& inst) {
  const Pointer p = t.pointer(inst, 3);
  const Type& type = t.m.type(p.pointee);
  const uint32_t member = inst.word(4);
  const bool fits = type.kind == TypeKind::kStruct && member + 1 == type.members.size() &&
                    t.m.type(type.members[member]).kind == TypeKind::kRuntimeArray && p.storage != spv::StorageClassWorkgroup &&
                    !is_flat(p.storage);
  if (!fits) inst.fail("the member is not a runtime array at the end of a buffer's struct");
  const ir::Value start = t.b.i32(member_offset_bytes(t.m, inst, type, member, false));
  ir::Value size = t.memory_of(inst, p).size_bytes;
  if (p.index) size = t.b.isub(size, t.b.umin(size, p.index));  // a variable pointer to the struct
  const ir::Value bytes = t.b.isub(t.b.umax(size, start), start);
  t.define(inst, Values{t.b.udiv(bytes, t.b.i32(array_stride_bytes(t.m, inst, t.m.type(type.members[member]), false)))});
}

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(Load, 4, op_load),
    PINEDA_SPIRV_ROW(Store, 3, op_store),
    PINEDA_SPIRV_ROW(CopyMemory, 3, op_copy_memory),
    PINEDA_SPIRV_ROW(CopyMemorySized, 4, op_copy_memory_sized),
    PINEDA_SPIRV_ROW(ArrayLength, 5, op_array_length),
};

}  // namespace

std::span<const OpRow> memory_rows() { return kRows; }

}  // namespace pineda::spirv
