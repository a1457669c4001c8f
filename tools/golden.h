// Golden files: lines of "scene WIDTHxHEIGHT hash". The bit contract says that every machine, thread count, tile size and
// instruction set draws the same bits, so the hashes are compared for equality.
#pragma once

#include <string>

#include "tools/driver_registry.h"

namespace pineda::tools {

// Draws every scene of the file and compares, or with `update` writes the hashes that it got. Returns the exit status.
int check_golden(const std::string& path, const DriverSpec& driver, bool update, bool validate);

}  // namespace pineda::tools
