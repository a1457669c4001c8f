// Machine code that is kept: images map to code that computes the same, stores are asked and told, and nothing that a file or an
// application can bring does harm.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <thread>

#include "base/config.h"
#include "compiler/build_id.h"
#include "compiler/code_image.h"
#include "compiler/compile.h"
#include "compiler/disk_cache.h"
#include "compiler/ir/builder.h"
#include "compiler/spirv/test_shaders.h"

namespace pineda::compiler {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kSeed = 11;

// Before anything reads the environment: these tests leave no files behind and find none.
[[maybe_unused]] const int kNoDiskCache = setenv("PINEDA_CACHE", "off", 1);

class MemoryStore final : public CodeStore {
 public:
  CodeBlob find(const KernelHash& key) override {
    ++asked;
    const auto found = blobs.find(key);
    return found == blobs.end() ? nullptr : found->second;
  }
  void insert(const KernelHash& key, const CodeBlob& blob) override { blobs[key] = blob; }
  std::map<KernelHash, CodeBlob> blobs;
  int asked = 0;
};

// A directory that goes with the test.
struct ScratchDirectory {
  std::string path = (fs::temp_directory_path() / ("pineda-cache-test-" + std::to_string(getpid()))).string();
  ScratchDirectory() { fs::remove_all(path); }
  ~ScratchDirectory() { fs::remove_all(path); }
  size_t files() const { return static_cast<size_t>(std::distance(fs::directory_iterator(path), fs::directory_iterator())); }
};

struct Wave {
  uint32_t mask, reserved;
};

// out[lane] = sin(in[lane]) * exp2(in[lane])
ir::Kernel make_kernel(double factor = 1) {
  ir::Kernel kernel;
  kernel.name = "cached";
  kernel.wave_stride_bytes = sizeof(Wave);
  ir::Builder b(kernel);
  const auto array = [&](uint32_t i) {
    return ir::Address{.base = b.load(ir::Type::kPtr, b.draw_ptr(), 8 * i), .lane_stride = 4};
  };
  const ir::Value x = b.load(ir::Type::kF32, array(0));
  b.store(array(1), b.fmul(b.fmul(b.fsin(x), b.fexp2(x)), b.f32(factor)));
  return kernel;
}

std::vector<float> run(const KernelHandle& handle) {
  std::vector<float> in(16), out(16);
  for (int i = 0; i < 16; ++i) in[static_cast<size_t>(i)] = 0.37f * static_cast<float>(i);
  const void* draw[2] = {in.data(), out.data()};
  const Wave wave{0xffff, 0};
  const PrimRecord prim{nullptr, 0, 1};
  handle(draw, nullptr, &prim, 1, &wave);
  return out;
}

// The key and what a store keeps of make_kernel().
std::pair<KernelHash, CodeBlob> compiled_blob() {
  Result<ExecutablePtr> executable = make_executable(make_kernel(), hash_kernel(make_kernel()), nullptr);
  EXPECT_TRUE(executable && (*executable)->finish());
  return {(*executable)->key, (*executable)->blob()};
}

bool keeps_code() { return config().mode == Mode::kJit && !build_id().empty(); }

TEST(CodeCache, BuildIdIsThatOfBothLibraries) { EXPECT_EQ(build_id().size(), 40u); }

TEST(CodeCache, AStoredKernelComputesTheSame) {
  if (!keeps_code()) GTEST_SKIP();
  Result<ExecutablePtr> fresh = make_executable(make_kernel(), hash_kernel(make_kernel()), nullptr);
  ASSERT_TRUE(fresh && (*fresh)->finish());
  ASSERT_NE((*fresh)->blob(), nullptr);
  MemoryStore store;
  store.insert((*fresh)->key, (*fresh)->blob());
  Result<ExecutablePtr> stored = make_executable(make_kernel(), hash_kernel(make_kernel()), &store);
  ASSERT_TRUE(stored && (*stored)->finish());
  EXPECT_EQ(store.asked, 1);
  EXPECT_LE((*stored)->ir.insts.size(), 1u) << "it was not compiled";
  EXPECT_EQ((*stored)->ir.name, "cached");
  EXPECT_EQ(run((*stored)->handle), run((*fresh)->handle));
  EXPECT_NE((*stored)->handle.fn, (*fresh)->handle.fn);
}

TEST(CodeCache, KeysDifferWithTheKernelOnly) {
  ir::Kernel renamed = make_kernel();
  renamed.name = "other";
  EXPECT_EQ(code_key(hash_kernel(renamed)), code_key(hash_kernel(make_kernel())));
  EXPECT_NE(code_key(hash_kernel(make_kernel(2))), code_key(hash_kernel(make_kernel())));
}

TEST(CodeCache, CompilersAskAndTellTheirStore) {
  if (!keeps_code()) GTEST_SKIP();
  const auto words = spirv::test::glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                                       "layout(local_size_x = 16) in; layout(binding = 0) buffer B { float b[]; };"
                                       "void main() { b[gl_GlobalInvocationID.x] = tan(b[gl_GlobalInvocationID.x]) + 41.5; }");
  Result<spirv::ModulePtr> module = spirv::parse({.words = words, .entry_point = "main", .stage = VK_SHADER_STAGE_COMPUTE_BIT});
  ASSERT_TRUE(module);
  PipelineLayout layout;
  layout.bindings.push_back({0, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, 0, sizeof(BufferDescriptor), 0});
  MemoryStore store;
  const ComputeSource source{.module = module->get(), .layout = &layout, .name = "told", .store = &store};
  {
    const Result<ComputeKernel> first = compile_compute(source);
    ASSERT_TRUE(first) << first.error().text;
    EXPECT_EQ(store.blobs.size(), 1u);
    EXPECT_GT(first->kernel->ir.insts.size(), 1u);
  }
  const Result<ComputeKernel> second = compile_compute(source);
  ASSERT_TRUE(second);
  EXPECT_LE(second->kernel->ir.insts.size(), 1u);
}

// ---- images -----------------------------------------------------------------------------------------------------------------

TEST(CodeImage, DamagedOnesAreRefusedOrMapWithoutHarm) {
  if (!keeps_code()) GTEST_SKIP();
  const std::string blob = *compiled_blob().second;
  const std::string image = blob.substr(16);  // the header; there are no varyings
  ASSERT_NE(MappedImage::map(image), nullptr);
  for (size_t size = 0; size < image.size(); ++size) {
    ASSERT_EQ(MappedImage::map(std::string_view(image).substr(0, size)), nullptr) << size;
  }
  std::mt19937 random(kSeed);
  for (int i = 0; i < 20000; ++i) {  // mapped or not, never run
    std::string damaged = image;
    const size_t flips = 1 + random() % 4;
    for (size_t flip = 0; flip < flips; ++flip) {
      const size_t at = random() % 2 ? random() % damaged.size() : random() % std::min<size_t>(damaged.size(), 64);
      damaged[at] = static_cast<char>(random());
    }
    static_cast<void>(MappedImage::map(damaged));
  }
}

TEST(CodeImage, PointersAreRelocated) {
  CodeImage image;
  image.pieces.push_back({0, true, std::string("\x48\x8b\x05\xf9\x0f\x00\x00\xc3", 8)});  // mov rax, [rip + 0xff9]; ret
  image.pieces.push_back({4096, false, std::string(16, '\0')});
  image.pointers.push_back({4096, ImagePointer::kImage, 4104});
  const auto mapped = MappedImage::map(serialize(image));
  ASSERT_NE(mapped, nullptr);
  const auto place = reinterpret_cast<uint64_t (*)()>(reinterpret_cast<uintptr_t>(mapped->entry()))();
  EXPECT_EQ(place, reinterpret_cast<uint64_t>(mapped->entry()) + 4104);
}

// ---- disk -------------------------------------------------------------------------------------------------------------------

TEST(DiskCache, KeepsWhatItIsGiven) {
  const ScratchDirectory scratch;
  const KernelHash key{1, 2};
  const auto blob = std::make_shared<const std::string>("some code");
  {
    DiskCache cache(scratch.path);
    ASSERT_TRUE(cache.usable());
    EXPECT_EQ(cache.find(key), nullptr);
    cache.insert(key, blob);
  }
  DiskCache again(scratch.path);
  ASSERT_NE(again.find(key), nullptr);
  EXPECT_EQ(*again.find(key), *blob);
  EXPECT_EQ(again.find({1, 3}), nullptr);
  struct stat status;
  ASSERT_EQ(stat(scratch.path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0700u);
}

// Every prefix and every flipped byte of a file: not found, and the file is gone.
TEST(DiskCache, DamagedFilesAreNotUsed) {
  const ScratchDirectory scratch;
  DiskCache cache(scratch.path);
  const KernelHash key{7, 9};
  cache.insert(key, std::make_shared<const std::string>("twenty bytes of code"));
  const std::string file = fs::directory_iterator(scratch.path)->path();
  std::ifstream stream(file, std::ios::binary);
  const std::string good((std::istreambuf_iterator<char>(stream)), {});
  const auto expect_unused = [&](const std::string& content, const std::string& what) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << content;
    EXPECT_EQ(cache.find(key), nullptr) << what;
  };
  for (size_t size = 0; size < good.size(); ++size) expect_unused(good.substr(0, size), "cut to " + std::to_string(size));
  for (size_t at = 0; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] ^= 0x10;
    expect_unused(bad, "flipped " + std::to_string(at));
  }
  // Another kernel's file under this name.
  cache.insert({8, 8}, std::make_shared<const std::string>("other"));
  fs::rename(scratch.path + "/" + KernelHash{8, 8}.full_text() + ".kernel", file);
  EXPECT_EQ(cache.find(key), nullptr);
}

TEST(DiskCache, RefusesDirectoriesThatOthersCanWrite) {
  const ScratchDirectory scratch;
  fs::create_directory(scratch.path);
  chmod(scratch.path.c_str(), 0777);
  EXPECT_FALSE(DiskCache(scratch.path).usable());
  chmod(scratch.path.c_str(), 0700);
  EXPECT_TRUE(DiskCache(scratch.path).usable());
  fs::create_directory_symlink(scratch.path, scratch.path + ".link");
  EXPECT_FALSE(DiskCache(scratch.path + ".link").usable());
  fs::remove(scratch.path + ".link");
  EXPECT_FALSE(DiskCache("/proc/no/such/place").usable());
  EXPECT_FALSE(DiskCache("").usable());
}

TEST(DiskCache, ALostDirectoryDoesNoHarm) {
  const ScratchDirectory scratch;
  DiskCache cache(scratch.path);
  fs::remove_all(scratch.path);
  cache.insert({1, 1}, std::make_shared<const std::string>("code"));
  EXPECT_EQ(cache.find({1, 1}), nullptr);
}

TEST(DiskCache, TheOldestGo) {
  const ScratchDirectory scratch;
  DiskCache cache(scratch.path, 100'000);
  const auto blob = std::make_shared<const std::string>(1000, 'x');
  for (uint64_t i = 0; i < 300; ++i) cache.insert({i, 0}, blob);
  EXPECT_LT(scratch.files(), 100u + 64);  // looked at every 64 insertions
  EXPECT_NE(cache.find({299, 0}), nullptr);
}

TEST(DiskCache, ManyWritersAndReaders) {
  const ScratchDirectory scratch;
  std::vector<std::thread> threads;
  for (uint64_t t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      DiskCache cache(scratch.path);
      for (uint64_t i = 0; i < 100; ++i) {
        const std::string content = "code " + std::to_string(i % 10);
        cache.insert({i % 10, 5}, std::make_shared<const std::string>(content));
        const CodeBlob found = cache.find({i % 10, 5});
        ASSERT_NE(found, nullptr);
        ASSERT_EQ(*found, content);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(scratch.files(), 10u);
}

}  // namespace
}  // namespace pineda::compiler
