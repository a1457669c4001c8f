// Reads index buffers of every type; what lies past the end reads as 0.
#pragma once

#include <cstdint>
#include <cstring>

#include "raster/raster.h"

namespace pineda::raster {

class IndexReader {
 public:
  explicit IndexReader(const IndexBuffer& buffer);

  bool indexed() const { return data_ != nullptr; }
  uint32_t restart_value() const { return restart_value_; }

  // Index number `position` of the buffer.
  uint32_t read(uint64_t position) const {
    if (position >= count_) return 0;
    switch (shift_) {
      case 0:
        return data_[position];
      case 1: {
        uint16_t index;
        std::memcpy(&index, data_ + position * 2, 2);
        return index;
      }
      default: {
        uint32_t index;
        std::memcpy(&index, data_ + position * 4, 4);
        return index;
      }
    }
  }

  // Positions [first, first + count) into out.
  void read(uint64_t first, uint32_t count, uint32_t* out) const;
  // The same as 32-bit words that may lie anywhere: the buffer's own where that is possible, else in `scratch`. What follows is
  // asked for ahead of time.
  const uint8_t* words(uint64_t first, uint32_t count, uint32_t* scratch) const;

 private:
  const uint8_t* data_;
  uint64_t count_;  // whole indices in the buffer
  uint32_t shift_;  // log2 of the bytes of an index
  uint32_t restart_value_;
};

}  // namespace pineda::raster
