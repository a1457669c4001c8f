// How the sentences of explain.h are put together.
#pragma once

#include <cstdint>
#include <string>

namespace pineda::icd {

inline std::string number(uint64_t value) { return std::to_string(value); }

inline std::string share(uint64_t part, uint64_t whole) {
  return whole == 0 ? number(part) : number(part) + " of " + number(whole) + " (" + number(100 * part / whole) + " %)";
}

inline void line(std::string& text, const std::string& what) { text += "\n  " + what; }

}  // namespace pineda::icd
