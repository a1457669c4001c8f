#include "tools/capture.h"

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "tools/error.h"

namespace pineda::tools {
namespace {

namespace fs = std::filesystem;

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

// Nothing for a good end, else a description.
std::string replay(const std::string& file, const DriverSpec& driver, const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);  // gfxrecon-replay makes none
  std::string command =
      "env VK_DRIVER_FILES=" + quoted(driver.manifest_path) + " VK_ICD_FILENAMES=" + quoted(driver.manifest_path);
  for (const auto& [name, value] : driver.environment) command += " " + quoted(name + "=" + value);
  // rebind: the memory types and sizes of the capture need not be those of the driver.
  command += " gfxrecon-replay -m rebind --screenshot-all --screenshot-prefix frame --screenshot-dir " + quoted(folder.string()) +
             " " + quoted(file) + " > " + quoted((folder / "replay.log").string()) + " 2>&1";
  const int status = std::system(command.c_str());
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) fail("gfxrecon-replay is not installed (Debian package gfxreconstruct)");
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return fmt::format("{}: gfxrecon-replay ended with status {}; see {}", driver.label, status, (folder / "replay.log").string());
}

std::vector<std::string> frames_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".bmp") names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace

CaptureComparison compare_capture(const CaptureOptions& options) {
  if (!fs::exists(options.file)) fail("{}: no such file", options.file);
  CaptureComparison result;
  const auto folder_of = [&](const DriverSpec& driver) { return fs::path(options.out_dir) / driver.file_stem(); };
  for (const DriverSpec& driver : options.drivers) {
    if (const std::string problem = replay(options.file, driver, folder_of(driver)); !problem.empty()) {
      result.problems.push_back(problem);
    }
  }
  const DriverSpec& reference = options.drivers.back();
  const std::vector<std::string> frames = frames_in(folder_of(reference));
  if (frames.empty()) result.problems.push_back(reference.label + ": the capture has no frames");
  for (const DriverSpec& driver : options.drivers) {
    if (&driver == &reference) continue;
    if (frames_in(folder_of(driver)) != frames) {
      result.problems.push_back(driver.label + ": other frames than " + reference.label);
      continue;
    }
    for (const std::string& frame : frames) {
      const Image picture = load_image((folder_of(driver) / frame).string());
      const Image expected = load_image((folder_of(reference) / frame).string());
      const ImageMetrics metrics = measure(picture, expected);
      result.frames.push_back({driver.label, frame, metrics});
      if (metrics.within_one_share >= options.threshold_share) continue;
      result.problems.push_back(fmt::format("{} {}: only {} of the pixels are within 1/255 of {}'s", driver.label, frame,
                                            percent_text(metrics.within_one_share), reference.label));
      save_png((folder_of(driver) / (frame + ".difference.png")).string(), difference_map(picture, expected));
    }
  }
  return result;
}

}  // namespace pineda::tools
