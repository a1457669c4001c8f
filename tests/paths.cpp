#include "tests/paths.h"

namespace pineda::tests {

std::string source_dir() { return PINEDA_SOURCE_DIR; }
std::string build_dir() { return PINEDA_BUILD_DIR; }

}  // namespace pineda::tests
