// What print, parse and verify share: the spelling of names and of one instruction.
#pragma once

#include <string>
#include <vector>

#include "compiler/ir/ir.h"

namespace pineda::ir {

inline constexpr const char* kRateNames[] = {"draw", "prim", "wave", "lane"};
inline constexpr const char* kKindNames[] = {"vertex", "fragment", "compute"};
inline constexpr const char* kAtomicNames[] = {
    "add", "and", "or", "xor", "smin", "smax", "umin", "umax", "exchange", "fadd", "compare_exchange"};

struct FlagName {
  uint8_t bit;
  const char* text;
};
inline constexpr FlagName kFlagNames[] = {{kInvariant, "invariant"},    {kSpeculate, "speculate"}, {kAllLanes, "all_lanes"},
                                          {kNoContract, "no_contract"}, {kVolatile, "volatile"},   {kLikely, "likely"},
                                          {kPrivate, "private"}};

// Instructions that have a %name: those with a value, and If and Loop, which Result refers to.
inline bool is_named(const Inst& inst) { return inst.type != Type::kVoid || inst.op == Op::kIf || inst.op == Op::kLoop; }

// Dense names in program order, so that the text does not depend on what passes left behind. Safe on malformed kernels.
class Names {
 public:
  explicit Names(const Kernel& kernel);
  std::string operator()(Value v) const;

 private:
  std::vector<uint32_t> number_;  // by instruction index; 0: not in any region
};

// One line without its regions and without the newline. Safe on malformed kernels.
std::string instruction_text(const Kernel& kernel, const Names& names, Value v);

}  // namespace pineda::ir
