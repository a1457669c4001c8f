#include "tools/size.h"

#include <charconv>

#include "tools/error.h"

namespace pineda::tools {

Size parse_size(const std::string& text) {
  constexpr uint32_t kLargest = 16384;
  Size size;
  const char* const end = text.data() + text.size();
  const auto [separator, first_error] = std::from_chars(text.data(), end, size.width);
  if (first_error == std::errc() && separator != end && *separator == 'x') {
    const auto [rest, second_error] = std::from_chars(separator + 1, end, size.height);
    const auto in_range = [](uint32_t value) { return value >= 1 && value <= kLargest; };
    if (second_error == std::errc() && rest == end && in_range(size.width) && in_range(size.height)) return size;
  }
  fail("'{}' is not a size like 800x600 (1 to {})", text, kLargest);
}

}  // namespace pineda::tools
