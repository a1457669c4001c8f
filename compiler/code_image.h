// Machine code of one kernel that stands at no particular address: what the caches keep. Its places refer to each other by
// distance; the few that hold an address are listed. Mapping one needs no LLVM.
//
// Images come from disk and from applications, so parse() trusts no byte of one: an image that it accepts maps without harm. What
// the code does when it runs is another matter: a cache is as trustworthy as its directory (disk_cache.h), and pipeline cache
// data as the application that brings it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/abi.h"

namespace pineda::compiler {

inline constexpr uint32_t kImagePageBytes = 4096;
inline constexpr uint64_t kMaxImageBytes = 64ull << 20;

struct ImagePiece {
  uint32_t offset;  // in the image; a page never holds both code and data
  bool executable;
  std::string bytes;
};

struct ImagePointer {  // 8 bytes at `offset` hold the address of
  enum Target : uint32_t { kImage, kFmaF64 };
  uint32_t offset;
  Target target;
  uint64_t to;  // kImage: this place of the image
};

struct CodeImage {
  uint32_t entry = 0;
  std::vector<ImagePiece> pieces;
  std::vector<ImagePointer> pointers;
};

std::string serialize(const CodeImage& image);

// Executable memory with an image in it.
class MappedImage {
 public:
  // Null when the image is malformed or there is no memory.
  static std::unique_ptr<MappedImage> map(std::string_view serialized);
  ~MappedImage();
  MappedImage(const MappedImage&) = delete;
  MappedImage& operator=(const MappedImage&) = delete;

  KernelFn entry() const { return entry_; }
  uint64_t size_bytes() const { return size_bytes_; }

 private:
  MappedImage(uint8_t* memory, uint64_t size_bytes, uint32_t entry);

  uint8_t* const memory_;
  const uint64_t size_bytes_;
  const KernelFn entry_;
};

}  // namespace pineda::compiler
