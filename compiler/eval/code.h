// The evaluator's form of a kernel: instructions whose operands are places in one block of storage ("slots" of kLanes raw
// values).
#pragma once

#include <cstdint>
#include <vector>

#include "compiler/eval/eval.h"
#include "compiler/ir/semantics.h"

namespace pineda::eval {

using Slot = uint32_t;  // index of the first raw value; a multiple of kLanes; slot 0 belongs to no value

struct Step {
  ir::Op op;
  ir::Type type = ir::Type::kVoid;  // of the value that is computed, loaded or stored
  uint8_t flags = 0;
  ir::LaneFn fn = nullptr;  // set: fn(out, in[0], in[1], in[2]) is all there is to do
  Slot out = 0;
  std::array<Slot, ir::kMaxOperands> in{};
  uint64_t imm = 0;                  // Inst::imm; Local accesses: the number of elements
  std::array<uint32_t, 2> block{};   // If, Loop
  bool for_group = false;            // If, Loop: holds a Barrier
  uint64_t identity = 0, first = 0;  // Reduce: raw values of inactive lanes, and of the first lane of an exclusive scan
  ir::LaneFn combine = nullptr;      // Reduce
};

struct Copy {
  Slot from, to;
};

struct Block {
  std::vector<Step> steps;
  std::vector<Copy> yields;   // side of an If: value -> Result; loop body: next value -> Result
  std::vector<Copy> carried;  // loop body: Result -> LoopArg
  std::vector<Copy> initial;  // loop body: initial value -> LoopArg
  Slot again = 0;
};

struct Constant {
  Slot slot;
  uint64_t raw;
};

struct Code {
  ir::Floats floats = ir::Floats::kNative;
  uint32_t wave_stride_bytes = 0;
  uint32_t draw = 0, prim = 0, wave = 0;  // blocks; 0 is an empty one
  bool has_barriers = false;
  std::vector<Block> blocks{1};
  std::vector<Constant> constants;
  uint64_t value_count = kLanes;  // raw values of all slots, Locals included
  uint64_t locals_begin = 0;      // [locals_begin, value_count) is zero at the start of a wave
};

Code flatten(const ir::Kernel& kernel, Mode mode);

}  // namespace pineda::eval
