#include "compiler/code_image.h"

#include <sys/mman.h>

#include <cmath>
#include <cstring>
#include <optional>

namespace pineda::compiler {
namespace {

constexpr uint32_t kMagic = 0x31494350;  // "PCI1"

struct Header {
  uint32_t magic = kMagic, entry = 0, pieces = 0, pointers = 0;
};
struct PieceHeader {
  uint32_t offset, size_bytes, executable;
};
struct PointerRecord {
  uint32_t offset, target;
  uint64_t to;
};

double fma_f64(double a, double b, double c) { return std::fma(a, b, c); }

template <typename T>
void append(std::string& out, const T& record) {
  out.append(reinterpret_cast<const char*>(&record), sizeof record);
}

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  template <typename T>
  bool read(T* out) {
    std::string_view raw;
    if (!take(sizeof *out, &raw)) return false;
    std::memcpy(out, raw.data(), sizeof *out);
    return true;
  }
  bool take(uint64_t size_bytes, std::string_view* out) {
    if (size_bytes > bytes_.size()) return false;
    *out = bytes_.substr(0, size_bytes);
    bytes_.remove_prefix(size_bytes);
    return true;
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
};

struct View {  // pieces that refer to the serialized bytes
  struct Piece {
    uint32_t offset;
    bool executable;
    std::string_view bytes;
  };
  uint32_t entry = 0;
  uint64_t size_bytes = 0;  // whole pages
  std::vector<Piece> pieces;
  std::vector<PointerRecord> pointers;
};

// Whether [offset, offset + size) lies in one piece.
bool inside(const View& view, uint64_t offset, uint64_t size, bool executable) {
  for (const View::Piece& piece : view.pieces) {
    if (piece.executable == executable && offset >= piece.offset && offset - piece.offset + size <= piece.bytes.size())
      return true;
  }
  return false;
}

std::optional<View> parse(std::string_view serialized) {
  Reader reader(serialized);
  Header header;
  View view;
  if (serialized.size() > kMaxImageBytes || !reader.read(&header) || header.magic != kMagic) return {};
  view.entry = header.entry;
  for (uint32_t i = 0; i < header.pieces; ++i) {
    PieceHeader piece;
    std::string_view bytes;
    if (!reader.read(&piece) || !reader.take(piece.size_bytes, &bytes)) return {};
    if (piece.offset > kMaxImageBytes || bytes.empty() || piece.executable > 1) return {};
    view.pieces.push_back({piece.offset, piece.executable == 1, bytes});
    view.size_bytes = std::max(view.size_bytes, uint64_t{piece.offset} + bytes.size());
  }
  for (uint32_t i = 0; i < header.pointers; ++i) {
    PointerRecord pointer;
    if (!reader.read(&pointer) || pointer.target > ImagePointer::kFmaF64) return {};
    const bool in_piece = inside(view, pointer.offset, 8, false) || inside(view, pointer.offset, 8, true);
    if (!in_piece || (pointer.target == ImagePointer::kImage && pointer.to >= view.size_bytes)) return {};
    view.pointers.push_back(pointer);
  }
  if (!reader.at_end() || !inside(view, view.entry, 1, true)) return {};
  view.size_bytes = (view.size_bytes + kImagePageBytes - 1) & ~uint64_t{kImagePageBytes - 1};
  return view;
}

// Protections of the pages; false when a page would hold both code and data.
bool page_kinds(const View& view, std::vector<uint8_t>* executable) {
  constexpr uint8_t kUnused = 2;
  executable->assign(view.size_bytes / kImagePageBytes, kUnused);
  for (const View::Piece& piece : view.pieces) {
    for (uint64_t page = piece.offset / kImagePageBytes; page <= (piece.offset + piece.bytes.size() - 1) / kImagePageBytes;
         ++page) {
      uint8_t& kind = (*executable)[page];
      if (kind != kUnused && kind != piece.executable) return false;
      kind = piece.executable;
    }
  }
  return true;
}

}  // namespace

std::string serialize(const CodeImage& image) {
  std::string out;
  append(out,
         Header{kMagic, image.entry, static_cast<uint32_t>(image.pieces.size()), static_cast<uint32_t>(image.pointers.size())});
  for (const ImagePiece& piece : image.pieces) {
    append(out, PieceHeader{piece.offset, static_cast<uint32_t>(piece.bytes.size()), piece.executable});
    out += piece.bytes;
  }
  for (const ImagePointer& pointer : image.pointers) append(out, PointerRecord{pointer.offset, pointer.target, pointer.to});
  return out;
}

MappedImage::MappedImage(uint8_t* memory, uint64_t size_bytes, uint32_t entry)
    : memory_(memory), size_bytes_(size_bytes), entry_(reinterpret_cast<KernelFn>(memory + entry)) {}

MappedImage::~MappedImage() { munmap(memory_, size_bytes_); }

std::unique_ptr<MappedImage> MappedImage::map(std::string_view serialized) {
  const std::optional<View> view = parse(serialized);
  std::vector<uint8_t> executable;
  if (!view || !page_kinds(*view, &executable)) return nullptr;
  void* raw = mmap(nullptr, view->size_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (raw == MAP_FAILED) return nullptr;
  auto* const memory = static_cast<uint8_t*>(raw);
  std::unique_ptr<MappedImage> mapped(new MappedImage(memory, view->size_bytes, view->entry));
  for (const View::Piece& piece : view->pieces) std::memcpy(memory + piece.offset, piece.bytes.data(), piece.bytes.size());
  for (const PointerRecord& pointer : view->pointers) {
    const uint64_t address = pointer.target == ImagePointer::kFmaF64 ? reinterpret_cast<uint64_t>(&fma_f64)
                                                                     : reinterpret_cast<uint64_t>(memory) + pointer.to;
    std::memcpy(memory + pointer.offset, &address, sizeof address);
  }
  // Never writable and executable at once.
  for (size_t page = 0; page < executable.size();) {
    size_t end = page + 1;
    while (end < executable.size() && executable[end] == executable[page]) ++end;
    const int protection = executable[page] == 1 ? PROT_READ | PROT_EXEC : PROT_READ;
    if (mprotect(memory + page * kImagePageBytes, (end - page) * kImagePageBytes, protection) != 0) return nullptr;
    page = end;
  }
  return mapped;
}

}  // namespace pineda::compiler
