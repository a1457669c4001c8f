// OpType* and OpVariable. Types must be declared before they are used (SPIR-V 2.4), so no type can contain itself.
#include <algorithm>

#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

uint64_t saturating_product(uint64_t a, uint64_t b) { return a != 0 && b > (1ull << 40) / a ? 1ull << 40 : a * b; }

const Type& element_type(const Module& m, const Instruction& inst, uint32_t id) {
  const auto found = m.types.find(id);
  if (found == m.types.end()) inst.fail("%" + std::to_string(id) + " is not a type that was declared before");
  if (found->second.depth >= kMaxTypeDepth) inst.fail("types are nested too deeply");
  return found->second;
}

void numeric(Type& t, const Instruction& inst) {
  const uint32_t width = inst.word(2);
  if (width != 32) inst.fail(std::to_string(width) + "-bit numbers are not supported");
  t.kind = inst.op() == spv::OpTypeInt ? TypeKind::kInt : TypeKind::kFloat;
  t.scalar = inst.op() == spv::OpTypeInt ? ir::Type::kI32 : ir::Type::kF32;
  t.is_signed = inst.op() == spv::OpTypeInt && inst.word(3) != 0;
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
    t.scalar_count = std::min<uint64_t>(t.scalar_count + member.scalar_count, 1ull << 40);
    t.depth = std::max(t.depth, member.depth + 1);
    t.is_value = t.is_value && member.is_value;
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
  if (texel.kind != TypeKind::kFloat && texel.kind != TypeKind::kInt) inst.fail("the sampled type must be a 32-bit number");
  if (inst.word(7) != 1 && inst.word(7) != 2) inst.fail("Sampled must be 1 or 2 in Vulkan");
  const spv::Dim dim = t.image.dim;
  const bool known =
      dim == spv::Dim1D || dim == spv::Dim2D || dim == spv::Dim3D || dim == spv::DimCube || dim == spv::DimBuffer;
  if (!known) inst.fail("only 1D, 2D, 3D, Cube and Buffer images are supported");
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
    case spv::OpTypePointer:
      t.kind = TypeKind::kPointer;
      t.storage = inst.word_as<spv::StorageClass>(2);
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
    case spv::StorageClassWorkgroup:
      if (initializer != 0) inst.fail("a variable of this storage class cannot have an initializer here");
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
