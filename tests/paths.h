// Where the checkout and the build under test are. Functions rather than macros, so that object files hold no path but one.
#pragma once

#include <string>

namespace pineda::tests {

std::string source_dir();  // absolute, without a slash at the end
std::string build_dir();

}  // namespace pineda::tests
