#pragma once

#include <string>
#include <utility>
#include <vector>

namespace pineda::tools {

// What this machine is, as (name, value) for reports: processor, instruction sets, cores, memory, system.
std::vector<std::pair<std::string, std::string>> machine_info();

}  // namespace pineda::tools
