// The standard sample locations (Vulkan 1.3, section 25.3 "Multisampling", table "Standard sample locations").
#pragma once

#include <cstdint>

namespace pineda {

inline constexpr uint32_t kMaxSamples = 16;
inline constexpr uint32_t kSampleCounts = 1 | 2 | 4 | 8 | 16;  // VkSampleCountFlags

struct SampleLocation {
  uint8_t x, y;  // 1/16 px from the pixel's top left corner
};

inline constexpr SampleLocation kSampleLocations1[1] = {{8, 8}};
inline constexpr SampleLocation kSampleLocations2[2] = {{12, 12}, {4, 4}};
inline constexpr SampleLocation kSampleLocations4[4] = {{6, 2}, {14, 6}, {2, 10}, {10, 14}};
inline constexpr SampleLocation kSampleLocations8[8] = {{9, 5}, {7, 11}, {13, 9}, {5, 3}, {3, 13}, {1, 7}, {11, 15}, {15, 1}};
inline constexpr SampleLocation kSampleLocations16[16] = {{9, 9},  {7, 5}, {5, 10}, {12, 7}, {3, 6}, {10, 13}, {13, 11}, {11, 3},
                                                          {6, 14}, {8, 1}, {4, 2},  {2, 12}, {0, 8}, {15, 4},  {14, 15}, {1, 0}};

// `samples`: 1, 2, 4, 8 or 16.
constexpr const SampleLocation* sample_locations(uint32_t samples) {
  switch (samples) {
    case 2:
      return kSampleLocations2;
    case 4:
      return kSampleLocations4;
    case 8:
      return kSampleLocations8;
    case 16:
      return kSampleLocations16;
    default:
      return kSampleLocations1;
  }
}

}  // namespace pineda
