// The one error type of compiler/: no exceptions cross its borders.
#pragma once

#include <expected>
#include <string>

namespace pineda {

struct CompileError {
  std::string text;   // complete sentence for a person: names the instruction, the capability, the id
  uint32_t word = 0;  // SPIR-V word offset, 0 when it does not apply
};

template <typename T>
using Result = std::expected<T, CompileError>;

inline std::unexpected<CompileError> compile_error(std::string text, uint32_t word = 0) {
  return std::unexpected(CompileError{std::move(text), word});
}

}  // namespace pineda
