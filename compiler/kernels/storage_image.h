// Storage images: loads and stores of texels by integer coordinates (Vulkan 1.3, chapter 16). Coordinates outside load zero and
// store nothing. A shader that declares no format finds it in the descriptor: one branch for each that a storage image may have.
#pragma once

#include "compiler/kernels/texel.h"
#include "compiler/spirv/translate.h"

namespace pineda::kernels {

Result<Channels> load_storage_image(ir::Builder& b, ir::Value image, const spirv::ImageAccess& access);
// For atomics on R32 formats.
Result<ir::Address> storage_texel(ir::Builder& b, ir::Value image, const spirv::ImageAccess& access);
Result<void> store_storage_image(ir::Builder& b, ir::Value image, const spirv::ImageAccess& access,
                                 std::span<const ir::Value> texel);

}  // namespace pineda::kernels
