#include "tools/errors/shared_block.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "tools/error.h"

namespace pineda::tools {

SharedBlock::SharedBlock(uint32_t drivers) : drivers_(drivers), owner_(true) {
  char path[] = "/dev/shm/pineda-errors-XXXXXX";
  const int fd = mkostemp(path, O_CLOEXEC);
  if (fd < 0) fail("{}: {}", path, std::strerror(errno));
  path_ = path;
  if (ftruncate(fd, static_cast<off_t>(size_bytes())) != 0) fail("{}: {}", path_, std::strerror(errno));
  map(fd);
}

SharedBlock::SharedBlock(const std::string& path, uint32_t drivers) : path_(path), drivers_(drivers), owner_(false) {
  const int fd = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) fail("{}: {}", path, std::strerror(errno));
  map(fd);
}

void SharedBlock::map(int fd) {
  void* memory = mmap(nullptr, size_bytes(), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  if (memory == MAP_FAILED) fail("{}: {}", path_, std::strerror(errno));
  memory_ = static_cast<float*>(memory);
}

SharedBlock::~SharedBlock() {
  if (memory_) munmap(memory_, size_bytes());
  if (owner_) unlink(path_.c_str());
}

}  // namespace pineda::tools
