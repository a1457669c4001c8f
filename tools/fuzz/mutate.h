// Mutants of a SPIR-V module: mostly well formed, so that they get past the parser's first checks.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "compiler/ir/random.h"

namespace pineda::fuzz {

using ir::Random;

// One to three edits: bits, words, ids, whole instructions left out, doubled, moved or cut short.
std::vector<uint32_t> mutate(std::span<const uint32_t> words, Random& random);

}  // namespace pineda::fuzz
