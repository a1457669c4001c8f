#include "raster/index_reader.h"

#include <algorithm>

namespace pineda::raster {
namespace {

uint32_t index_shift(VkIndexType type) {
  switch (type) {
    case VK_INDEX_TYPE_UINT8_EXT:
      return 0;
    case VK_INDEX_TYPE_UINT16:
      return 1;
    default:
      return 2;
  }
}

template <class T>
void widen(const uint8_t* data, uint32_t count, uint32_t* out) {
  for (uint32_t i = 0; i < count; ++i) {
    T index;
    std::memcpy(&index, data + i * sizeof(T), sizeof(T));
    out[i] = index;
  }
}

}  // namespace

IndexReader::IndexReader(const IndexBuffer& buffer)
    : data_(buffer.address),
      count_(buffer.size_bytes >> index_shift(buffer.type)),
      shift_(index_shift(buffer.type)),
      restart_value_(shift_ == 2 ? ~0u : (1u << (8u << shift_)) - 1) {}

void IndexReader::read(uint64_t first, uint32_t count, uint32_t* out) const {
  const auto inside = static_cast<uint32_t>(first >= count_ ? 0 : std::min<uint64_t>(count, count_ - first));
  const uint8_t* data = data_ + (inside != 0 ? first << shift_ : 0);
  switch (shift_) {
    case 0:
      widen<uint8_t>(data, inside, out);
      break;
    case 1:
      widen<uint16_t>(data, inside, out);
      break;
    default:
      if (inside != 0) std::memcpy(out, data, inside * sizeof(uint32_t));
      break;
  }
  std::fill(out + inside, out + count, 0u);
}

const uint8_t* IndexReader::words(uint64_t first, uint32_t count, uint32_t* scratch) const {
  constexpr uint64_t kLineBytes = 64;
  const uint64_t end_bytes = (first + count) << shift_, buffer_bytes = count_ << shift_;
  const uint64_t ahead_bytes = std::min(end_bytes + (uint64_t{count} << shift_), buffer_bytes);
  for (uint64_t at = end_bytes; at < ahead_bytes; at += kLineBytes) __builtin_prefetch(data_ + at);
  if (shift_ == 2 && first + count <= count_) return data_ + first * sizeof(uint32_t);
  read(first, count, scratch);
  return reinterpret_cast<const uint8_t*>(scratch);
}

}  // namespace pineda::raster
