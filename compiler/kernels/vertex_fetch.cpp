#include "compiler/kernels/vertex_fetch.h"

#include <algorithm>

#include "base/abi.h"
#include "compiler/kernels/concat.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {

using ir::Builder;
using ir::Type;
using ir::Value;

Result<Channels> fetch_attribute(Builder& b, const compiler::VertexState& state, uint32_t location, Value vertex_index,
                                 Value instance_index) {
  const auto attribute = std::ranges::find(state.attributes, location, &compiler::VertexAttribute::location);
  if (attribute == state.attributes.end()) return compile_error(concat("No vertex attribute has location ", location, "."));
  const auto binding = std::ranges::find(state.bindings, attribute->binding, &compiler::VertexBinding::binding);
  if (binding == state.bindings.end() || binding->binding >= kMaxVertexBindings) {
    return compile_error(concat("Vertex attribute ", location, " names binding ", attribute->binding, ", which does not exist."));
  }
  const FormatInfo* format = find_format(attribute->format);
  if (!format || !(format->uses & kUseVertex)) {
    return compile_error(concat("Vertex attribute ", location, " has format ", static_cast<int>(attribute->format),
                                ", which vertex buffers do not support."));
  }
  const size_t record = offsetof(DrawContext, vertex_buffers) + binding->binding * sizeof(VertexBufferBinding);
  ir::Address at{.base = load_draw(b, Type::kPtr, record + offsetof(VertexBufferBinding, address)),
                 .offset = b.i32(attribute->offset_bytes),
                 .limit = load_draw(b, Type::kI32, record + offsetof(VertexBufferBinding, size_bytes))};
  if (binding->stride_bytes != 0) {
    const Value index = binding->rate == VK_VERTEX_INPUT_RATE_INSTANCE ? instance_index : vertex_index;
    at.offset = b.iadd(b.imul(index, b.i32(binding->stride_bytes)), at.offset);
  }
  return unpack(b, *format, load_words(b, *format, at, ir::kInvariant));
}

}  // namespace pineda::kernels
