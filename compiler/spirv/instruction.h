// One SPIR-V instruction with bounds-checked operands, and the way errors travel inside this folder.
//
// Faults are exceptions: a translator makes thousands of checks at every depth of recursion, and each must end the whole
// translation. They never leave compiler/spirv; parse() and translate() turn them into CompileError.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#define SPV_ENABLE_UTILITY_CODE
#include <spirv/unified1/spirv.hpp>

#include "compiler/error.h"

namespace pineda::spirv {

struct Fault {
  CompileError error;
};

class Instruction {
 public:
  Instruction(std::span<const uint32_t> words, uint32_t offset) : words_(words), offset_(offset) {}

  spv::Op op() const { return static_cast<spv::Op>(words_[0] & 0xffff); }
  uint32_t size() const { return static_cast<uint32_t>(words_.size()); }
  uint32_t offset_words() const { return offset_; }  // in the module

  uint32_t word(uint32_t i) const;  // i = 0: opcode word; fails past the end
  // As one of SPIR-V's enumerations, which C++ gives values up to 0x7fffffff: larger ones become that.
  template <typename Enum>
  Enum word_as(uint32_t i) const {
    return static_cast<Enum>(std::min(word(i), 0x7fffffffu));
  }
  uint32_t word_or(uint32_t i, uint32_t fallback) const { return i < size() ? words_[i] : fallback; }
  std::span<const uint32_t> from(uint32_t i) const { return i < size() ? words_.subspan(i) : std::span<const uint32_t>(); }
  // The literal string that begins at word i; *next (if given) becomes the word behind it.
  std::string string(uint32_t i, uint32_t* next = nullptr) const;

  // Throws a Fault: "OpFAdd (word 123): <what>.".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::span<const uint32_t> words_;
  uint32_t offset_;
};

[[noreturn]] void fail(const std::string& what, uint32_t word = 0);

// "OpFAdd", or "opcode 5000" for one that is in no table.
std::string op_name(spv::Op op);

// Checks the header and every word count. `bound` becomes the module's id bound.
std::vector<Instruction> split_instructions(std::span<const uint32_t> words, uint32_t* bound);

}  // namespace pineda::spirv
