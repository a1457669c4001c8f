// Labels of VK_EXT_debug_utils that are open, outermost first: of a queue, and of the command buffer that executes. Messages show
// them; nothing else depends on them. Thread-safe, as the watchdog reads what another thread executes.
#pragma once

#include <array>
#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "icd/vulkan_api.h"

namespace pineda::icd {

struct Label {
  std::string name;
  std::array<float, 4> color{};
};

class LabelStack {
 public:
  void begin(const char* name, const float (&color)[4]);
  void end();
  // A label of its own that stands until the next begin, end or insert.
  void insert(const char* name, const float (&color)[4]);
  void clear();

  std::vector<Label> snapshot() const;

 private:
  void drop_inserted_locked();

  std::atomic<bool> any_{false};  // begin() was called since clear(): who labels nothing pays for no lock
  mutable std::mutex mutex_;      // guards all below
  std::vector<Label> open_;
  bool inserted_ = false;  // the last one came by insert()
};

}  // namespace pineda::icd
