// Messages from parts: concat("binding ", 3).
#pragma once

#include <sstream>
#include <string>

namespace pineda::kernels {

template <typename... Parts>
std::string concat(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

}  // namespace pineda::kernels
