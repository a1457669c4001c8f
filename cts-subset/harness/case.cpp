#include "cts-subset/harness/case.h"

#include <gtest/gtest.h>

#include "cts-subset/harness/device.h"

namespace pineda::cts {
namespace {

class Case : public testing::Test {
 public:
  Case(std::string section, std::function<void(Device&)> run) : section_(std::move(section)), run_(std::move(run)) {}

  void TestBody() override {
    RecordProperty("section", section_);
    try {
      run_(shared_device());
    } catch (const NotSupported& reason) {
      GTEST_SKIP() << reason.what();
    } catch (const std::exception& failure) {
      discard_shared_device();  // whatever state it is in: the next case gets a new one
      ADD_FAILURE() << failure.what() << "\n  checks: " << section_;
    }
  }

 private:
  std::string section_;
  std::function<void(Device&)> run_;
};

}  // namespace

void require(bool supported, std::string_view what) {
  if (!supported) throw NotSupported(std::string(what));
}

void expect(bool holds, const std::string& otherwise) {
  if (!holds) throw Failure(otherwise);
}

void add_case(std::string group, std::string name, std::string section, std::function<void(Device&)> run) {
  testing::RegisterTest(
      group.c_str(), name.c_str(), nullptr, nullptr, __FILE__, __LINE__,
      [section = std::move(section), run = std::move(run)]() -> testing::Test* { return new Case(section, run); });
}

}  // namespace pineda::cts
