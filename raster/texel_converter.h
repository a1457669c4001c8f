// Texels of one format as texels of another, without filtering: unpack_texel and pack_clear_color (base/format.h), faster where
// that is possible with the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/format.h"

namespace pineda::raster {

class TexelConverter {
 public:
  // `texel_count`: of the whole work; tables are made only when there are enough to pay for them.
  TexelConverter(const FormatInfo& from, const FormatInfo& to, uint64_t texel_count);

  // to[i] = texel columns[i] of the row.
  void run(const uint8_t* row, const uint32_t* columns, size_t count, uint8_t* to) const;

 private:
  // kShuffle: four bytes that only change places. kTables: each component of the result depends on one of at most 2^10 codes, so
  // that a texel is the sum of an entry for each component. kTexels: one by one.
  enum class Way : uint8_t { kShuffle, kTables, kTexels };

  struct Words {
    uint64_t word[2];
  };
  struct Component {
    uint32_t shift;
    uint64_t mask;
    std::vector<Words> entries;  // by code
  };

  bool find_shuffle();
  bool make_tables();
  void shuffle(const uint8_t* row, const uint32_t* columns, size_t count, uint8_t* to) const;
  template <size_t kFromBytes>
  void look_up(const uint8_t* row, const uint32_t* columns, size_t count, uint8_t* to) const;
  template <size_t kFromBytes, size_t kToBytes>
  void look_up_all(const uint8_t* row, const uint32_t* columns, size_t count, uint8_t* to) const;

  const FormatInfo& from_;
  const FormatInfo& to_;
  Way way_ = Way::kTexels;
  std::array<uint8_t, 4> byte_from_{};  // kShuffle
  Words base_{};                        // kTables: what does not depend on the source
  std::vector<Component> components_;
};

}  // namespace pineda::raster
