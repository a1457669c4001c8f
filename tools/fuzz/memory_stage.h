// A stage made of plain memory, so that any shader can run alone: inputs and outputs are words of the wave record, buffers come
// from a table, images are made of arithmetic on their coordinates. Whatever the shader asks for is there.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "base/abi.h"
#include "compiler/spirv/translate.h"

namespace pineda::fuzz {

// What the draw pointer points to.
struct Table {
  struct Buffer {
    uint64_t address;
    uint32_t size_bytes, reserved;
  };
  static constexpr uint32_t kBuffers = 64;
  Buffer buffers[kBuffers];
  uint8_t push_constants[kMaxPushConstantBytes];
  AddressRange ranges[2];
};

inline constexpr uint32_t kMaxSlots = 4096;  // inputs and outputs: words of 16 lanes
struct WaveRecord {
  uint32_t mask, coverage;
  uint32_t words[kMaxSlots][kLanes];
};

class MemoryStage final : public spirv::StageInterface {
 public:
  ir::Value input(ir::Builder& b, const spirv::InterfaceScalar& in) override;
  ir::Value input_at(ir::Builder& b, const spirv::InterfaceScalar& in, const spirv::InterpolationPlace& place) override;
  void output(ir::Builder& b, const spirv::InterfaceScalar& out, ir::Value value) override;
  std::optional<spirv::BufferRef> buffer(ir::Builder& b, uint32_t set, uint32_t binding, ir::Value array_index) override;
  std::optional<std::array<ir::Value, 4>> sample(ir::Builder& b, const spirv::SampleRequest& request) override;
  std::optional<std::array<ir::Value, 4>> query(ir::Builder& b, const spirv::ImageQuery& query) override;
  std::optional<std::array<ir::Value, 4>> image_load(ir::Builder& b, const spirv::ImageAccess& access) override;
  bool image_store(ir::Builder& b, const spirv::ImageAccess& access, std::span<const ir::Value> texel) override;
  std::optional<ir::Address> image_texel(ir::Builder& b, const spirv::ImageAccess& access) override;
  ir::Value covered(ir::Builder& b) override;
  ir::Value shared_memory(ir::Builder& b) override;
  std::array<ir::Value, 2> address_ranges(ir::Builder& b) override;

  // Appends what keeps the shader's result alive; call it when the shader has been translated.
  void finish(ir::Builder& b, const spirv::Translation& translation);
  // Whether more was asked for than the memory holds.
  bool overflowed() const { return overflowed_; }

  static constexpr uint32_t kImage = 0, kShared = 1, kFirstBuffer = 2;  // in Table::buffers

 private:
  ir::Address slot(ir::Builder& b);
  spirv::BufferRef entry(ir::Builder& b, ir::Value index);
  ir::Value texel_offset(ir::Builder& b, const spirv::ImageAccess& access);

  uint32_t slots_ = 0;
  bool overflowed_ = false;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> buffers_;  // (set, binding) -> first of kArray entries
};

}  // namespace pineda::fuzz
