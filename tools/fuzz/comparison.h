// Runs one shader by the evaluator and by the machine code of each ISA over the same memory, and compares every byte they leave.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/spirv/translate.h"

namespace pineda::fuzz {

struct EntryPoint {
  std::string name;
  VkShaderStageFlagBits stage;
};
// Those of the stages that Pineda has. Reads only headers and OpEntryPoints; empty for what is no SPIR-V.
std::vector<EntryPoint> entry_points(std::span<const uint32_t> words);

struct Outcome {
  // kTooLong: compiled, but random data keep it running for longer than it was given.
  enum class Kind : uint8_t { kAgreed, kRefused, kFailed, kDiffered, kTooLong } kind;
  std::string text;  // why it was refused, what differs
};

// SPIR-V to IR that is verified and optimised. Refused with the translator's message.
struct Prepared {
  Outcome outcome;
  ir::Kernel kernel;
  uint32_t shared_bytes = 0;
};
Prepared prepare(std::span<const uint32_t> words, const EntryPoint& entry);

// On every ISA that this CPU has, over `rounds` random memories. The shader may run for long: see `with_limits`.
Outcome compare(const Prepared& prepared, uint64_t seed, uint32_t rounds);

// Runs `body`, which ends in compare(), in a child process that has `seconds` of processor time, so that neither a crash nor an
// endless loop ends the caller.
Outcome with_limits(uint32_t seconds, Outcome (*body)(void* argument), void* argument);

}  // namespace pineda::fuzz
