// `pineda compare --capture FILE`: the command stream of an application, captured by GFXReconstruct, replayed on several drivers,
// and how far the frames are apart.
#pragma once

#include <string>
#include <vector>

#include "tools/driver_registry.h"
#include "tools/image_metrics.h"

namespace pineda::tools {

struct CaptureOptions {
  std::string file;                 // *.gfxr
  std::vector<DriverSpec> drivers;  // the last one is what the others are compared with
  std::string out_dir = "report";
  double threshold_share = 0.999;  // of the pixels of each frame must be within 1/255
};

struct FrameDifference {
  std::string driver, frame;  // frame: the picture's file name
  ImageMetrics metrics;
};

struct CaptureComparison {
  std::vector<FrameDifference> frames;
  std::vector<std::string> problems;  // why it did not pass; empty when it did
};

// Leaves each driver's frames in a folder of its own under out_dir. Throws ToolError when gfxrecon-replay cannot be run.
CaptureComparison compare_capture(const CaptureOptions& options);

}  // namespace pineda::tools
