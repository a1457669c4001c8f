// OpType* and OpVariable. Types must be declared before they are used (SPIR-V 2.4), so no type can contain itself.
#include <algorithm>

#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

constexpr uint64_t kHuge = 1ull << 40;  // where sizes saturate: far beyond every bound on them

uint64_t saturating_product(uint64_t a, uint64_t b) { return a != 0 && b > kHuge / a ? kHuge : a * b; }
uint64_t round_up(uint64_t x, uint64_t multiple) { return (x + multiple - 1) / multiple * multiple; }

const Type& element_type(const Module& m, const Instruction& inst, uint32_t id) {
  const auto found = m.types.find(id);
  if (found == m.types.end()) inst.fail("%" + std::to_string(id) + " is not a type that was declared before");
  if (found->second.depth >= kMaxTypeDepth) inst.fail("types are nested too deeply");
  return found->second;
}

ir::Type number_of(bool is_int, uint32_t width) {
  switch (width) {
    case 8:
      return is_int ? ir::Type::kI8 : ir::Type::kVoid;
    case 16:
      return is_int ? ir::Type::kI16 : ir::Type::kF16;
    case 32:
      return is_int ? ir::Type::kI32 : ir::Type::kF32;
    case 64:
      return is_int ? ir::Type::kI64 : ir::Type::kF64;
    default:
      return ir::Type::kVoid;
  }
}

void numeric(Type& t, const Instruction& inst) {
  const bool is_int = inst.op() == spv::OpTypeInt;
  const uint32_t width = inst.word(2);
  t.kind = is_int ? TypeKind::kInt : TypeKind::kFloat;
  t.scalar = number_of(is_int, width);
  if (t.scalar == ir::Type::kVoid) inst.fail("there are no " + std::to_string(width) + "-bit numbers of this kind in Vulkan");
  t.is_signed = is_int && inst.word(3) != 0;
}

// Vectors, matrices and arrays: `count` elements of inst.word(2).
void sequence(const Module& m, Type& t, const Instruction& inst, TypeKind kind, uint32_t count) {
  const Type& element = element_type(m, inst, inst.word(2));
  t.kind = kind;
  t.element = element.id;
  t.count = count;
  t.depth = element.depth + 1;
  t.is_value = element.is_value && kind != TypeKind::kRuntimeArray;
  t.scalar_count = saturating_product(element.scalar_count, count);
  t.natural_alignment_bytes = element.natural_alignment_bytes;
  t.natural_bytes = saturating_product(element.natural_bytes, count);
  if (kind == TypeKind::kVector && (!element.is_scalar() || count < 2 || count > 4)) inst.fail("must be 2 to 4 scalars");
  if (kind == TypeKind::kMatrix) {
    const bool ok = element.kind == TypeKind::kVector && m.type(element.element).kind == TypeKind::kFloat;
    if (!ok || count < 2 || count > 4) inst.fail("must be 2 to 4 float vectors");
  }
}

void structure(const Module& m, Type& t, const Instruction& inst) {
  t.kind = TypeKind::kStruct;
  t.is_value = true;
  for (uint32_t id : inst.from(2)) {
    const Type& member = element_type(m, inst, id);
    t.members.push_back(id);
    t.first_scalar.push_back(t.scalar_count);
    t.scalar_count = std::min<uint64_t>(t.scalar_count + member.scalar_count, kHuge);
    t.natural_offset_bytes.push_back(round_up(t.natural_bytes, member.natural_alignment_bytes));
    t.natural_bytes = std::min(t.natural_offset_bytes.back() + member.natural_bytes, kHuge);
    t.natural_alignment_bytes = std::max(t.natural_alignment_bytes, member.natural_alignment_bytes);
    t.depth = std::max(t.depth, member.depth + 1);
    t.is_value = t.is_value && member.is_value;
  }
  t.natural_bytes = round_up(t.natural_bytes, t.natural_alignment_bytes);
}

// Physical pointers are addresses. Pointers to storage buffers and Workgroup memory are values under the variable pointers
// capabilities: base, size and offset (translator.h). Others are resolved while the shader is translated.
void pointer(const Module& m, Type& t, spv::StorageClass storage) {
  t.kind = TypeKind::kPointer;
  t.storage = storage;
  if (storage == spv::StorageClassPhysicalStorageBuffer) {
    t.scalar = ir::Type::kI64;
  } else if (m.variable_pointers && (storage == spv::StorageClassStorageBuffer || storage == spv::StorageClassWorkgroup)) {
    t.is_value = true;
    t.scalar_count = kPointerScalars.size();
  }
}

void image(const Module& m, Type& t, const Instruction& inst) {
  const Type& texel = element_type(m, inst, inst.word(2));
  t.kind = TypeKind::kImage;
  t.element = texel.id;
  t.image = {.dim = inst.word_as<spv::Dim>(3),
             .arrayed = inst.word(5) != 0,
             .multisampled = inst.word(6) != 0,
             .storage = inst.word(7) == 2,
             .format = inst.word_as<spv::ImageFormat>(8)};
  if (texel.scalar != ir::Type::kF32 && texel.scalar != ir::Type::kI32) inst.fail("the sampled type must be a 32-bit number");
  if (inst.word(7) != 1 && inst.word(7) != 2) inst.fail("Sampled must be 1 or 2 in Vulkan");
  const spv::Dim dim = t.image.dim;
  const bool known = dim == spv::Dim1D || dim == spv::Dim2D || dim == spv::Dim3D || dim == spv::DimCube ||
                     dim == spv::DimBuffer || dim == spv::DimSubpassData;
  if (!known) inst.fail("only 1D, 2D, 3D, Cube, Buffer and SubpassData images are supported");
  if (dim == spv::DimSubpassData && (!t.image.storage || t.image.arrayed)) inst.fail("SubpassData has Sampled 2 and no layers");
  if ((dim == spv::Dim3D || dim == spv::DimBuffer) && t.image.arrayed) inst.fail("3D images and buffers cannot be arrayed");
}

}  // namespace

void declare_type(Module& m, const Instruction& inst) {
  Type t;
  t.id = inst.word(1);
  switch (inst.op()) {
    case spv::OpTypeVoid:
      break;
    case spv::OpTypeBool:
      t.kind = TypeKind::kBool;
      t.scalar = ir::Type::kB1;
      break;
    case spv::OpTypeInt:
    case spv::OpTypeFloat:
      numeric(t, inst);
      break;
    case spv::OpTypeVector:
      sequence(m, t, inst, TypeKind::kVector, inst.word(3));
      break;
    case spv::OpTypeMatrix:
      sequence(m, t, inst, TypeKind::kMatrix, inst.word(3));
      break;
    case spv::OpTypeArray: {
      const uint32_t count = m.constant_u32(inst, inst.word(3));
      if (count == 0) inst.fail("an array needs at least one element");
      sequence(m, t, inst, TypeKind::kArray, count);
      break;
    }
    case spv::OpTypeRuntimeArray:
      sequence(m, t, inst, TypeKind::kRuntimeArray, 0);
      break;
    case spv::OpTypeStruct:
      structure(m, t, inst);
      break;
    case spv::OpTypeForwardPointer:
      if (m.types.contains(t.id)) inst.fail("stands behind the declaration of %" + std::to_string(t.id));
      pointer(m, t, inst.word_as<spv::StorageClass>(2));
      if (!t.is_scalar()) inst.fail("only PhysicalStorageBuffer pointers can be declared ahead");
      break;
    case spv::OpTypePointer:
      pointer(m, t, inst.word_as<spv::StorageClass>(2));
      if (const auto ahead = m.types.find(t.id); ahead != m.types.end() && ahead->second.storage != t.storage)
        inst.fail("the storage class is not that of OpTypeForwardPointer");
      t.element = element_type(m, inst, inst.word(3)).id;
      break;
    case spv::OpTypeImage:
      image(m, t, inst);
      break;
    case spv::OpTypeSampler:
      t.kind = TypeKind::kSampler;
      break;
    case spv::OpTypeSampledImage:
      t.kind = TypeKind::kSampledImage;
      t.element = element_type(m, inst, inst.word(2)).id;
      if (m.type(t.element).kind != TypeKind::kImage) inst.fail("the operand is not an image type");
      break;
    case spv::OpTypeFunction:
      t.kind = TypeKind::kFunction;
      t.element = element_type(m, inst, inst.word(2)).id;
      for (uint32_t id : inst.from(3)) t.members.push_back(element_type(m, inst, id).id);
      break;
    default:
      inst.fail("this type is not supported");
  }
  if (t.is_scalar()) {
    t.is_value = true;
    t.scalar_count = 1;
    // A bool in Workgroup memory is 32 bits wide.
    t.natural_bytes = t.natural_alignment_bytes = t.kind == TypeKind::kBool ? 4 : ir::size_bytes(t.scalar);
  }
  m.types[t.id] = std::move(t);
}

void declare_variable(Module& m, const Instruction& inst) {
  const Type& pointer = m.type(inst.word(1));
  const auto storage = inst.word_as<spv::StorageClass>(3);
  if (pointer.kind != TypeKind::kPointer) inst.fail("the type is not a pointer");
  if (pointer.storage != storage) inst.fail("the storage class is not its type's");
  const uint32_t initializer = inst.word_or(4, 0);
  const Constant* constant = m.constant(initializer);
  if (initializer != 0 && (!constant || constant->type != pointer.element)) {
    inst.fail("the initializer is not a constant of the variable's type");
  }
  switch (storage) {
    case spv::StorageClassFunction:
    case spv::StorageClassPrivate:
    case spv::StorageClassOutput:
      break;
    case spv::StorageClassInput:
    case spv::StorageClassUniform:
    case spv::StorageClassStorageBuffer:
    case spv::StorageClassPushConstant:
    case spv::StorageClassUniformConstant:
      if (initializer != 0) inst.fail("a variable of this storage class cannot have an initializer here");
      break;
    case spv::StorageClassWorkgroup:  // always starts at zero
      if (initializer != 0 && m.instructions[m.definition[initializer] - 1].op() != spv::OpConstantNull) {
        inst.fail("a Workgroup variable's initializer must be OpConstantNull");
      }
      break;
    default:
      inst.fail("storage class " + std::to_string(storage) + " is not supported");
  }
  m.variables[inst.word(2)] = {.id = inst.word(2),
                               .pointee = pointer.element,
                               .storage = storage,
                               .initializer = initializer,
                               .offset_words = inst.offset_words()};
}

}  // namespace pineda::spirv
