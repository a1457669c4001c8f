// What the waves of a kernel with barriers keep between the parts that run without interruption.
//
// A barrier splits a region that the whole workgroup runs (the wave region, and those of an If or Loop that holds a barrier) into
// phases: each is a loop over the waves. Pure values of draw or primitive rate are computed once, outside of these loops. Of the
// others, those that a later phase reads live in the wave's frame, as do what such an If or Loop carries, its masks, and Locals.
//
// The frame is laid out for all back ends alike: a value of wave rate takes 8 bytes, one of lane rate 16 elements (B1: 8 bytes of
// mask), a Local 16 elements for each of its own.
#pragma once

#include <cstdint>
#include <vector>

#include "compiler/ir/ir.h"

namespace pineda::ir {

struct WaveFrame {
  static constexpr uint32_t kNone = ~0u;
  static constexpr uint32_t kAlignmentBytes = 64;

  // By value, bytes from the frame's start; kNone: not kept. LoopArgs, Results and Locals included; a LoopArg and the Result of
  // the same number share a place when they have one rate.
  std::vector<uint32_t> offset;
  // By If or Loop: of the 16-bit masks of a construct whose condition varies in the workgroup (If: then, else; Loop: lanes still
  // in it), each in 8 bytes.
  std::vector<uint32_t> masks;
  uint64_t bytes = 0;  // a multiple of kAlignmentBytes; 0 when the kernel has no barrier
};

// The kernel must have its rates.
WaveFrame wave_frame(const Kernel& kernel);

// Sources that a phase computes again instead of keeping them.
constexpr bool is_recomputed(Op op) { return op == Op::kLane || op == Op::kWavePtr; }

}  // namespace pineda::ir
