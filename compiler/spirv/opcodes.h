// The one table from opcode to handler. Each group of instructions lists its rows beside its handlers; opcodes.cpp joins them.
#pragma once

#include "compiler/spirv/translator.h"

namespace pineda::spirv {

using Handler = void (*)(Translator&, const Instruction&);

struct OpRow {
  spv::Op op;
  uint16_t min_words;
  Handler handler;  // null: not an instruction of a block's body
};
#define PINEDA_SPIRV_ROW(name, min_words, ...) \
  { spv::Op##name, min_words, __VA_ARGS__ }

std::span<const OpRow> arith_rows();
std::span<const OpRow> logic_rows();
std::span<const OpRow> composite_rows();
std::span<const OpRow> matrix_rows();
std::span<const OpRow> memory_rows();
std::span<const OpRow> pointer_rows();
std::span<const OpRow> dot_product_rows();
std::span<const OpRow> atomic_rows();
std::span<const OpRow> image_rows();
std::span<const OpRow> image_query_rows();
std::span<const OpRow> subgroup_rows();
std::span<const OpRow> other_rows();  // calls, extended instructions, derivatives, barriers, discards

const OpRow* find_op(spv::Op op);
std::string why_unsupported(spv::Op op);  // of an instruction without handler: for Instruction::fail

// GLSL.std.450 (glsl450*.cpp); operands begin at word 5.
struct ExtRow {
  uint32_t number;
  const char* name;
  uint16_t operands;
  Handler handler;
};
std::span<const ExtRow> glsl_common_rows();
std::span<const ExtRow> glsl_exponent_rows();
std::span<const ExtRow> glsl_geometry_rows();
std::span<const ExtRow> glsl_pack_rows();
std::span<const ExtRow> glsl_interpolate_rows();
void glsl_std_450(Translator& t, const Instruction& inst);

}  // namespace pineda::spirv
