#include "compiler/spirv/instruction.h"

namespace pineda::spirv {
namespace {

constexpr uint32_t kHeaderWords = 5;
constexpr uint32_t kMaxWords = 16u << 20;  // 64 MiB
constexpr uint32_t kMaxBound = 0x3fffff;   // SPIR-V 2.17, universal limits

}  // namespace

void fail(const std::string& what, uint32_t word) { throw Fault{CompileError{what, word}}; }

void Instruction::fail(const std::string& what) const {
  throw Fault{CompileError{op_name(op()) + " (word " + std::to_string(offset_) + "): " + what + ".", offset_}};
}

uint32_t Instruction::word(uint32_t i) const {
  if (i >= size()) fail("operand " + std::to_string(i) + " is missing");
  return words_[i];
}

std::string Instruction::string(uint32_t i, uint32_t* next) const {
  std::string text;
  for (; i < size(); ++i) {
    for (uint32_t byte = 0; byte < 4; ++byte) {
      const char c = static_cast<char>(words_[i] >> (8 * byte));
      if (c == 0) {
        if (next) *next = i + 1;
        return text;
      }
      text.push_back(c);
    }
  }
  fail("a literal string does not end inside the instruction");
}

std::vector<Instruction> split_instructions(std::span<const uint32_t> words, uint32_t* bound) {
  if (words.size() < kHeaderWords) fail("The module is shorter than the SPIR-V header.");
  if (words.size() > kMaxWords) fail("The module is longer than 64 MiB.");
  if (words[0] != spv::MagicNumber) fail("The first word is not SPIR-V's magic number.");
  const uint32_t major = words[1] >> 16 & 0xff, minor = words[1] >> 8 & 0xff;
  if (major != 1 || minor > 6) fail("SPIR-V version " + std::to_string(major) + "." + std::to_string(minor) + " is unknown.", 1);
  *bound = words[3];
  if (*bound == 0 || *bound > kMaxBound) fail("The id bound " + std::to_string(*bound) + " is out of range.", 3);

  std::vector<Instruction> instructions;
  instructions.reserve(words.size() / 4);
  for (size_t at = kHeaderWords; at < words.size();) {
    const uint32_t count = words[at] >> 16;
    if (count == 0 || count > words.size() - at) {
      fail("The instruction at word " + std::to_string(at) + " has an impossible word count.", static_cast<uint32_t>(at));
    }
    instructions.emplace_back(words.subspan(at, count), static_cast<uint32_t>(at));
    at += count;
  }
  return instructions;
}

}  // namespace pineda::spirv
