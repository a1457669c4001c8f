// self_test.*: one case of each end that a case can come to, with --self-test in place of all others. tests/cts_program_test.cpp
// knows what the program must make of them.
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"

namespace pineda::cts {

void register_self_test() {
  constexpr const char* kGroup = "self_test";
  constexpr const char* kSection = "none";
  add_case(kGroup, "passes", kSection, [](Device&) {});
  add_case(kGroup, "crashes", kSection, [](Device&) { std::raise(SIGSEGV); });
  add_case(kGroup, "fails", kSection, [](Device&) { expect(false, "1 < 2 & \"so\""); });
  add_case(kGroup, "is_not_supported", kSection, [](Device&) { require(false, "a feature"); });
  add_case(kGroup, "hangs", kSection, [](Device&) {
    for (;;) pause();
  });
  add_case(kGroup, "exits", kSection, [](Device&) { std::_Exit(5); });
  add_case(kGroup, "passes_behind_them", kSection, [](Device&) {});
}

}  // namespace pineda::cts
