#include "compiler/disk_cache.h"

#include <fcntl.h>
#include <sys/auxv.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <vector>

#include "base/config.h"
#include "base/log.h"
#include "compiler/code_image.h"
#include "compiler/hash.h"

namespace pineda::compiler {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSuffix = ".kernel";

struct FileHeader {
  uint64_t magic = 0x314E524B444E4950;  // "PINDKRN1"
  KernelHash key;
  KernelHash checksum;  // of the blob
};

// A descriptor that closes itself.
class File {
 public:
  File(const std::string& path, int flags) : fd_(open(path.c_str(), flags | O_CLOEXEC | O_NOFOLLOW, 0600)) {}
  ~File() {
    if (fd_ >= 0) close(fd_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int fd() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }

 private:
  int fd_;
};

bool read_all(int fd, void* out, size_t size_bytes, off_t at) {
  auto* bytes = static_cast<char*>(out);
  while (size_bytes > 0) {
    const ssize_t got = pread(fd, bytes, size_bytes, at);
    if (got <= 0) return false;
    bytes += got, at += got, size_bytes -= static_cast<size_t>(got);
  }
  return true;
}

bool write_all(int fd, const void* data, size_t size_bytes) {
  const auto* bytes = static_cast<const char*>(data);
  while (size_bytes > 0) {
    const ssize_t put = write(fd, bytes, size_bytes);
    if (put <= 0) return false;
    bytes += put, size_bytes -= static_cast<size_t>(put);
  }
  return true;
}

// What is read is run, so nobody else may have written it.
bool is_ours_alone(const std::string& directory) {
  struct stat status;
  return lstat(directory.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == geteuid() &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

std::string default_directory() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value && value[0] == '/' ? value : "");  // "paths must be absolute" (XDG Base Directory Specification)
  };
  if (const std::string cache = variable("XDG_CACHE_HOME"); !cache.empty()) return cache + "/pineda";
  const std::string home = variable("HOME");
  return home.empty() ? "" : home + "/.cache/pineda";
}

}  // namespace

DiskCache::DiskCache(std::string directory, uint64_t max_bytes) : max_bytes_(max_bytes) {
  if (directory.empty()) return;
  std::error_code ignored;
  const fs::path parent = fs::path(directory).parent_path();
  if (!parent.empty()) fs::create_directories(parent, ignored);
  mkdir(directory.c_str(), 0700);
  if (is_ours_alone(directory)) {
    directory_ = std::move(directory);
  } else {
    report(Severity::kInfo, "no kernels are kept on disk: " + directory + " is not a directory that only this user can write");
  }
}

std::string DiskCache::path(const KernelHash& key) const { return directory_ + "/" + key.full_text() + kSuffix; }

CodeBlob DiskCache::find(const KernelHash& key) {
  if (!usable()) return nullptr;
  const File file(path(key), O_RDONLY);
  struct stat status;
  FileHeader header;
  if (!file || fstat(file.fd(), &status) != 0 || !S_ISREG(status.st_mode)) return nullptr;
  const auto size_bytes = static_cast<uint64_t>(status.st_size);
  if (size_bytes < sizeof header || size_bytes > kMaxImageBytes || !read_all(file.fd(), &header, sizeof header, 0))
    return nullptr;
  auto blob = std::make_shared<std::string>(size_bytes - sizeof header, '\0');
  if (!read_all(file.fd(), blob->data(), blob->size(), sizeof header)) return nullptr;
  if (header.magic != FileHeader{}.magic || header.key != key || header.checksum != hash_bytes(*blob)) {
    unlink(path(key).c_str());
    return nullptr;
  }
  futimens(file.fd(), nullptr);  // young again
  return blob;
}

void DiskCache::insert(const KernelHash& key, const CodeBlob& blob) {
  static std::atomic<uint32_t> count{0};
  if (!usable()) return;
  const uint32_t number = count++;
  const std::string temporary = directory_ + "/" + std::to_string(getpid()) + "." + std::to_string(number) + ".new";
  {
    const FileHeader header{.key = key, .checksum = hash_bytes(*blob)};
    const File file(temporary, O_WRONLY | O_CREAT | O_EXCL);
    if (!file) return;
    if (!write_all(file.fd(), &header, sizeof header) || !write_all(file.fd(), blob->data(), blob->size())) {
      unlink(temporary.c_str());
      return;
    }
  }
  if (rename(temporary.c_str(), path(key).c_str()) != 0) unlink(temporary.c_str());
  constexpr uint32_t kInsertsPerTrim = 64;
  if (number % kInsertsPerTrim == 0) trim();
}

// Also removes what processes that died left under temporary names.
void DiskCache::trim() {
  struct Entry {
    fs::path path;
    fs::file_time_type time;
    uint64_t size_bytes;
  };
  std::vector<Entry> entries;
  uint64_t total_bytes = 0;
  std::error_code error;
  const auto an_hour_ago = fs::file_time_type::clock::now() - std::chrono::hours(1);
  for (fs::directory_iterator it(directory_, error), end; !error && it != end; it.increment(error)) {
    std::error_code gone;
    Entry entry{it->path(), it->last_write_time(gone), it->file_size(gone)};
    if (gone) continue;
    if (entry.path.extension() == ".new" && entry.time < an_hour_ago) fs::remove(entry.path, gone);
    if (entry.path.extension() != kSuffix) continue;
    total_bytes += entry.size_bytes;
    entries.push_back(std::move(entry));
  }
  if (total_bytes <= max_bytes_) return;
  std::ranges::sort(entries, {}, &Entry::time);
  for (const Entry& entry : entries) {
    if (total_bytes <= max_bytes_ / 4 * 3) return;
    std::error_code gone;
    if (fs::remove(entry.path, gone)) total_bytes -= entry.size_bytes;
  }
}

DiskCache* disk_cache() {
  static DiskCache* const cache = []() -> DiskCache* {
    if (config().cache == "off" || getauxval(AT_SECURE) != 0) return nullptr;
    auto* made = new DiskCache(config().cache.empty() ? default_directory() : config().cache);  // never destroyed, as kernels
    return made->usable() ? made : nullptr;
  }();
  return cache;
}

}  // namespace pineda::compiler
