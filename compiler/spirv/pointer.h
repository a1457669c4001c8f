// Explicit layouts (Vulkan, "Offset and Stride Assignment") as pointer.cpp and memory.cpp read them.
#pragma once

#include "compiler/spirv/translator.h"

namespace pineda::spirv {

// Every scalar is 4 bytes here, so layouts that could misalign one are refused.
uint32_t multiple_of_4(const Instruction& inst, uint32_t bytes, const char* what);
uint32_t array_stride_bytes(const Module& m, const Instruction& inst, const Type& array);
uint32_t member_offset_bytes(const Module& m, const Instruction& inst, const Type& structure, uint32_t member);

void access_chain(Translator& t, const Instruction& inst);  // OpAccessChain, OpInBoundsAccessChain

}  // namespace pineda::spirv
