// 128-bit hashes (XXH3), for keys and checksums of caches.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace pineda::compiler {

// A kernel's: over its instructions; its name does not count.
struct KernelHash {
  uint64_t high = 0, low = 0;
  bool operator==(const KernelHash&) const = default;
  auto operator<=>(const KernelHash&) const = default;
  std::string text() const;       // first 16 hexadecimal digits, for file names
  std::string full_text() const;  // all 32
};

KernelHash hash_bytes(std::string_view bytes);
KernelHash hash_words(std::span<const uint64_t> words);

}  // namespace pineda::compiler
