#include <sys/mman.h>
#include <unistd.h>

#include "icd/wsi/presenter.h"

namespace pineda::icd {

std::unique_ptr<Mapping> Mapping::make(size_t size_bytes) {
  const int fd = memfd_create("pineda-swapchain", MFD_CLOEXEC);
  if (fd < 0) return nullptr;
  void* data =
      ftruncate(fd, off_t(size_bytes)) == 0 ? mmap(nullptr, size_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0) : MAP_FAILED;
  if (data == MAP_FAILED) {
    close(fd);
    return nullptr;
  }
  return std::unique_ptr<Mapping>(new Mapping(static_cast<uint8_t*>(data), size_bytes, fd));
}

Mapping::~Mapping() {
  munmap(data_, size_bytes_);
  close(fd_);
}

}  // namespace pineda::icd
