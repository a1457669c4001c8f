// Memory that `pineda errors` shares with its workers: two slots, so that the drivers compute one block of operands while the
// parent compares the results of the other. A slot holds three arrays of operands and one of results for each driver.
#pragma once

#include <cstdint>
#include <string>

namespace pineda::tools {

class SharedBlock {
 public:
  static constexpr uint32_t kElements = 1u << 20;
  static constexpr uint32_t kSlots = 2;

  explicit SharedBlock(uint32_t drivers);                  // a new one; throws ToolError
  SharedBlock(const std::string& path, uint32_t drivers);  // one that another process made
  ~SharedBlock();
  SharedBlock(const SharedBlock&) = delete;
  SharedBlock& operator=(const SharedBlock&) = delete;

  const std::string& path() const { return path_; }
  float* operands(uint32_t slot, uint32_t which) { return array(slot, which); }
  float* results(uint32_t slot, uint32_t driver) { return array(slot, 3 + driver); }

 private:
  float* array(uint32_t slot, uint32_t index) { return memory_ + (size_t{slot} * (3 + drivers_) + index) * kElements; }
  size_t size_bytes() const { return size_t{kSlots} * (3 + drivers_) * kElements * sizeof(float); }
  void map(int fd);

  std::string path_;
  uint32_t drivers_;
  bool owner_;
  float* memory_ = nullptr;
};

}  // namespace pineda::tools
