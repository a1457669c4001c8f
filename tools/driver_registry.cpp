#include "tools/driver_registry.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "tools/error.h"

namespace pineda::tools {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  size_t begin = 0;
  for (size_t end = text.find(separator); end != std::string::npos; end = text.find(separator, begin)) {
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

std::string pineda_manifest() {
  const fs::path manifest = fs::read_symlink("/proc/self/exe").parent_path() / "pineda_icd.json";
  if (!fs::exists(manifest)) fail("driver pineda: {} does not exist; build first (./run)", manifest.string());
  return manifest.string();
}

std::string lavapipe_manifest() {
  const fs::path folder = "/usr/share/vulkan/icd.d";
  std::vector<std::string> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string file_name = entry.path().filename().string();
    if (file_name.starts_with("lvp_icd") && file_name.ends_with(".json")) found.push_back(entry.path().string());
  }
  if (found.empty()) fail("driver lavapipe: no lvp_icd*.json in {} (install mesa-vulkan-drivers)", folder.string());
  const auto native =
      std::ranges::find_if(found, [](const std::string& path) { return path.find("x86_64") != std::string::npos; });
  return native != found.end() ? *native : found.front();
}

}  // namespace

std::string DriverSpec::file_stem() const {
  std::string stem = label;
  for (char& c : stem) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-') c = '_';
  }
  return stem;
}

DriverSpec parse_driver(const std::string& text) {
  const std::vector<std::string> parts = split(text, '@');
  DriverSpec driver{.label = text, .name = parts[0]};
  if (const size_t equals = parts[0].find('='); equals != std::string::npos) {
    driver.name = parts[0].substr(0, equals);
    const fs::path manifest = parts[0].substr(equals + 1);
    if (!fs::exists(manifest)) fail("driver {}: {} does not exist", driver.name, manifest.string());
    driver.manifest_path = fs::absolute(manifest).string();
    driver.label = driver.name + text.substr(parts[0].size());
  } else if (driver.name == "pineda") {
    driver.manifest_path = pineda_manifest();
  } else if (driver.name == "lavapipe") {
    driver.manifest_path = lavapipe_manifest();
  } else {
    fail("unknown driver '{}' (known: pineda, lavapipe, or NAME=path.json)", driver.name);
  }
  driver.environment = {{"VK_DRIVER_FILES", driver.manifest_path}, {"VK_ICD_FILENAMES", driver.manifest_path}};
  for (size_t i = 1; i < parts.size(); ++i) {
    const size_t equals = parts[i].find('=');
    if (equals == std::string::npos || equals == 0) fail("driver {}: '@{}' is not @VARIABLE=value", driver.name, parts[i]);
    driver.environment.emplace_back(parts[i].substr(0, equals), parts[i].substr(equals + 1));
  }
  return driver;
}

std::vector<DriverSpec> parse_drivers(const std::string& comma_separated) {
  std::vector<DriverSpec> drivers;
  for (const std::string& part : split(comma_separated, ',')) drivers.push_back(parse_driver(part));
  for (size_t i = 0; i < drivers.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (drivers[i].label == drivers[j].label) fail("driver {} is given twice", drivers[i].label);
    }
  }
  return drivers;
}

}  // namespace pineda::tools
