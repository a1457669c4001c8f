// What a user can get wrong, and what a driver can do wrong: each is a clear error, never a crash or a hang.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tools/child_process.h"
#include "tools/driver_registry.h"
#include "tools/error.h"
#include "tools/model.h"
#include "tools/scene_registry.h"
#include "tools/size.h"
#include "tools/statistics.h"

namespace pineda::tools {
namespace {

using std::chrono::milliseconds;

template <typename Action>
std::string error_of(Action&& action) {
  try {
    action();
  } catch (const ToolError& error) {
    return error.what();
  }
  return "";
}

class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& content)
      : path_(testing::TempDir() + std::to_string(getpid()) + name) {
    std::ofstream(path_) << content;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

TEST(Size, Parses) {
  EXPECT_EQ(parse_size("1920x1080").width, 1920u);
  EXPECT_EQ(parse_size("1920x1080").height, 1080u);
  for (const char* bad : {"", "x", "800", "800x", "x600", "0x1", "800x600x2", "-1x5", "99999x2", "8 x 6"}) {
    EXPECT_THROW(parse_size(bad), ToolError) << bad;
  }
}

TEST(Statistics, Quantiles) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
  EXPECT_EQ(quantile({5, 1, 3}, 0), 1);
  EXPECT_EQ(quantile({5, 1, 3}, 1), 5);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(DriverRegistry, NamesPathsAndEnvironments) {
  const TemporaryFile manifest("driver.json", "{}");
  const DriverSpec driver = parse_driver("mine=" + manifest.path() + "@A=1@B=x=y");
  EXPECT_EQ(driver.name, "mine");
  EXPECT_EQ(driver.label, "mine@A=1@B=x=y");
  EXPECT_EQ(driver.file_stem(), "mine_A_1_B_x_y");
  const Environment expected{
      {"VK_DRIVER_FILES", manifest.path()}, {"VK_ICD_FILENAMES", manifest.path()}, {"A", "1"}, {"B", "x=y"}};
  EXPECT_EQ(driver.environment, expected);
}

TEST(DriverRegistry, MistakesAreNamed) {
  EXPECT_NE(error_of([] { parse_driver("nosuch"); }).find("unknown driver 'nosuch'"), std::string::npos);
  EXPECT_NE(error_of([] { parse_driver("mine=/nonexistent.json"); }).find("/nonexistent.json does not exist"), std::string::npos);
  const TemporaryFile manifest("driver.json", "{}");
  EXPECT_NE(error_of([&] { parse_driver("mine=" + manifest.path() + "@novalue"); }).find("@novalue"), std::string::npos);
  const std::string twice = "mine=" + manifest.path();
  EXPECT_NE(error_of([&] { parse_drivers(twice + "," + twice); }).find("given twice"), std::string::npos);
}

TEST(Scenes, UnknownNamesAreErrors) {
  EXPECT_NE(error_of([] { require_scene("nosuch.glb"); }).find("no such file, and no such scene"), std::string::npos);
  EXPECT_NE(error_of([] { require_scene("/tmp"); }).find("is not a file"), std::string::npos);
  EXPECT_NO_THROW(require_scene("triangle"));
}

TEST(Models, BrokenFilesAreErrors) {
  const TemporaryFile garbage("model.obj", "v 1 nonsense\nf 1 2 900\n"), empty("empty.glb", ""),
      truncated("truncated.glb", "glTF\2\0\0");
  for (const TemporaryFile* file : {&garbage, &empty, &truncated}) EXPECT_NE(error_of([&] { load_model(file->path()); }), "");
}

TEST(Models, QuadBecomesTwoTriangles) {
  const TemporaryFile quad("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const Model model = load_model(quad.path());
  EXPECT_EQ(model.triangle_count(), 2u);
  EXPECT_EQ(model.world_positions().size(), 6u);
  EXPECT_EQ(model.vertices[0].normal, glm::vec3(0, 0, 1));
}

TEST(Models, MissingTexturesAreNoted) {
  const TemporaryFile material("quad.mtl", "newmtl m\nKd 1 1 1\nmap_Kd nosuch.png\n");
  const std::string material_name = std::filesystem::path(material.path()).filename();
  const TemporaryFile quad("quad.obj", "mtllib " + material_name + "\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl m\nf 1 2 3\n");
  const Model model = load_model(quad.path());
  ASSERT_EQ(model.notes.size(), 1u);
  EXPECT_NE(model.notes[0].find("nosuch.png"), std::string::npos);
}

TEST(ChildProcess, SpeaksInLines) {
  ChildProcess child({"/bin/sh", "-c", "read line <&3; echo \"got $line $EXTRA\" >&4; echo second >&4"}, {{"EXTRA", "more"}});
  ASSERT_TRUE(child.write_line("hello"));
  std::string line;
  ASSERT_EQ(child.read_line(line, milliseconds(5000)), ChildProcess::Status::kLine);
  EXPECT_EQ(line, "got hello more");
  ASSERT_EQ(child.read_line(line, milliseconds(5000)), ChildProcess::Status::kLine);
  EXPECT_EQ(line, "second");
  EXPECT_EQ(child.read_line(line, milliseconds(5000)), ChildProcess::Status::kClosed);
}

TEST(ChildProcess, DeathIsDescribed) {
  ChildProcess child({"/bin/sh", "-c", "echo last words; kill -SEGV $$"}, {});
  std::string line;
  EXPECT_EQ(child.read_line(line, milliseconds(5000)), ChildProcess::Status::kClosed);
  EXPECT_NE(child.wait_and_describe().find("signal 11"), std::string::npos);
  EXPECT_EQ(child.last_output(), "last words");
}

TEST(ChildProcess, SilenceTimesOut) {
  ChildProcess child({"/bin/sh", "-c", "read line <&3"}, {});
  std::string line;
  EXPECT_EQ(child.read_line(line, milliseconds(30)), ChildProcess::Status::kTimeout);
  child.kill();
  EXPECT_NE(child.wait_and_describe().find("signal 9"), std::string::npos);
}

TEST(ChildProcess, MissingProgramIsAnError) {
  EXPECT_NE(error_of([] { ChildProcess child({"/nonexistent/program"}, {}); }).find("cannot be started"), std::string::npos);
}

}  // namespace
}  // namespace pineda::tools
