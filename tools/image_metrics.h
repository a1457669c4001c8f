// How far two pictures are apart.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tools/image.h"

namespace pineda::tools {

// A pixel's difference is the largest over its four channels, in units of 1/255.
struct ImageMetrics {
  uint32_t largest_difference = 0;
  double rmse = 0;              // over all channels, in units of 1/255
  double psnr_db = 0;           // infinite for equal pictures
  double differing_share = 0;   // pixels that differ at all
  double within_one_share = 0;  // pixels whose difference is at most 1/255
  uint64_t pixel_count = 0, beyond_one_count = 0;
};

std::string percent_text(double share);  // "99.9998 %": rounded down, so that only all of them are 100 %

ImageMetrics measure(const Image& a, const Image& b);  // throws ToolError when the sizes differ

// A map of the differences that makes a single step visible: black where equal, blue for 1/255, green to yellow for up to 8/255,
// red to white beyond.
Image difference_map(const Image& a, const Image& b);

}  // namespace pineda::tools
