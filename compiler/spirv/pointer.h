// Pointers into memory that is counted in bytes, and its layouts: the shader's own (Vulkan, "Offset and Stride Assignment":
// std140, std430, scalar or any other, since accesses need no alignment) or Type::natural_bytes for Workgroup memory.
#pragma once

#include "compiler/spirv/translator.h"

namespace pineda::spirv {

constexpr bool is_flat(spv::StorageClass s) {
  return s == spv::StorageClassFunction || s == spv::StorageClassPrivate || s == spv::StorageClassInput ||
         s == spv::StorageClassOutput;
}
constexpr bool has_natural_layout(spv::StorageClass s) { return s == spv::StorageClassWorkgroup; }

uint32_t array_stride_bytes(const Module& m, const Instruction& inst, const Type& array, bool natural);
uint32_t member_offset_bytes(const Module& m, const Instruction& inst, const Type& structure, uint32_t member, bool natural);

// How the matrices of a struct member lie, or of memory with the natural layout.
void set_matrix_layout(Pointer& p, const Decorations& member);
struct MatrixStrides {
  uint32_t column_bytes, component_bytes;
};
MatrixStrides matrix_strides(const Module& m, const Instruction& inst, const Type& matrix, const Pointer& p);
uint32_t component_stride_bytes(const Module& m, const Type& vector, const Pointer& p);

}  // namespace pineda::spirv
