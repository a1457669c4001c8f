#include "compiler/build_id.h"

#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <vector>

#include "compiler/jit/jit.h"

namespace pineda::compiler {
namespace {

// The build id among the notes of a PT_NOTE segment (gABI, "Note Section"); empty when there is none.
std::string find_note(std::span<const uint8_t> notes) {
  const auto padded = [](size_t bytes) { return (bytes + 3) & ~size_t{3}; };
  while (notes.size() >= sizeof(Elf64_Nhdr)) {
    Elf64_Nhdr header;
    std::memcpy(&header, notes.data(), sizeof header);
    const size_t name_at = sizeof header, data_at = name_at + padded(header.n_namesz), end = data_at + padded(header.n_descsz);
    if (end > notes.size()) return {};
    if (header.n_type == NT_GNU_BUILD_ID && header.n_namesz == 4 && std::memcmp(&notes[name_at], "GNU", 4) == 0)
      return {reinterpret_cast<const char*>(&notes[data_at]), header.n_descsz};
    notes = notes.subspan(end);
  }
  return {};
}

// Of the loaded object whose segments contain `address`.
struct OwnSearch {
  uintptr_t address;
  std::string id;
};
int visit_object(dl_phdr_info* info, size_t, void* opaque) {
  auto& search = *static_cast<OwnSearch*>(opaque);
  const std::span segments(info->dlpi_phdr, info->dlpi_phnum);
  const bool is_own = std::ranges::any_of(segments, [&](const ElfW(Phdr) & segment) {
    const uintptr_t begin = info->dlpi_addr + segment.p_vaddr;
    return segment.p_type == PT_LOAD && search.address >= begin && search.address - begin < segment.p_memsz;
  });
  if (!is_own) return 0;
  for (const ElfW(Phdr) & segment : segments) {
    if (segment.p_type != PT_NOTE || !search.id.empty()) continue;
    search.id = find_note({reinterpret_cast<const uint8_t*>(info->dlpi_addr + segment.p_vaddr), segment.p_memsz});
  }
  return 1;
}

// Of a file that may not have been loaded: reading its notes takes a hundredth of what opening LLVM takes.
std::string build_id_of_file(const std::string& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return {};
  std::string id;
  Elf64_Ehdr header;
  if (pread(fd, &header, sizeof header, 0) == sizeof header && std::memcmp(header.e_ident, ELFMAG, SELFMAG) == 0 &&
      header.e_phentsize == sizeof(Elf64_Phdr)) {
    for (uint32_t i = 0; i < header.e_phnum && id.empty(); ++i) {
      Elf64_Phdr segment;
      const auto at = static_cast<off_t>(header.e_phoff + i * sizeof segment);
      if (pread(fd, &segment, sizeof segment, at) != sizeof segment) break;
      if (segment.p_type != PT_NOTE || segment.p_filesz > 65536) continue;
      std::vector<uint8_t> notes(segment.p_filesz);
      if (pread(fd, notes.data(), notes.size(), static_cast<off_t>(segment.p_offset)) == static_cast<ssize_t>(notes.size()))
        id = find_note(notes);
    }
  }
  close(fd);
  return id;
}

std::string find_build_id() {
  OwnSearch own{reinterpret_cast<uintptr_t>(&build_id), {}};
  dl_iterate_phdr(&visit_object, &own);
  const std::string back_end = build_id_of_file(jit::plugin_path());
  return own.id.empty() || back_end.empty() ? std::string() : own.id + back_end;
}

}  // namespace

const std::string& build_id() {
  static const std::string id = find_build_id();
  return id;
}

}  // namespace pineda::compiler
