#include "tools/machine_info.h"

#include <fmt/format.h>
#include <sched.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <fstream>

namespace pineda::tools {
namespace {

// The value of the first line that begins with `key`, after its separator and blanks.
std::string value_in_file(const char* path, const std::string& key, char separator) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key)) continue;
    const size_t begin = line.find(separator);
    if (begin == std::string::npos) continue;
    const size_t first = line.find_first_not_of(" \t\"", begin + 1), last = line.find_last_not_of(" \t\"");
    if (first != std::string::npos) return line.substr(first, last - first + 1);
  }
  return "unknown";
}

std::string instruction_sets() {
  const std::string flags = " " + value_in_file("/proc/cpuinfo", "flags", ':') + " ";
  std::string result;
  for (const char* flag : {"sse4_2", "avx", "avx2", "fma", "avx512f", "avx512bw", "avx512vl"}) {
    if (flags.find(fmt::format(" {} ", flag)) != std::string::npos)
      result += fmt::format("{}{}", result.empty() ? "" : ", ", flag);
  }
  return result.empty() ? "unknown" : result;
}

int usable_core_count() {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
}

}  // namespace

std::vector<std::pair<std::string, std::string>> machine_info() {
  utsname system{};
  uname(&system);
  const double memory_gib = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 30);
  return {
      {"Processor", value_in_file("/proc/cpuinfo", "model name", ':')},
      {"Instruction sets", instruction_sets()},
      {"Cores", fmt::format("{}", usable_core_count())},
      {"Memory", fmt::format("{:.1f} GiB", memory_gib)},
      {"System", fmt::format("{}, {} {}", value_in_file("/etc/os-release", "PRETTY_NAME", '='), system.sysname, system.release)}};
}

}  // namespace pineda::tools
