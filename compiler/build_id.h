// Which build of Pineda this is: kernels that another build compiled may differ in code, layout or bits, and are not used.
#pragma once

#include <cstdint>
#include <string>

namespace pineda::compiler {

// The GNU build ids (ELF notes that the linker makes from the content) of the library that holds this code and of the back end
// beside it. Empty when either has none: then nothing is cached beyond the process.
const std::string& build_id();

}  // namespace pineda::compiler
