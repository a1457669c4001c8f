#include "icd/texture_state.h"

#include <algorithm>

namespace pineda::icd {
namespace {

uint32_t intern(std::vector<compiler::TextureState>& known, const compiler::TextureState& state) {
  const auto found = std::ranges::find(known, state);
  const auto index = static_cast<uint32_t>(found - known.begin());
  if (found == known.end()) known.push_back(state);
  return index + 1;
}

}  // namespace

uint32_t TextureStates::intern_view(const compiler::TextureState& view_half) {
  const std::scoped_lock lock(mutex_);
  return intern(views_, view_half);
}

uint32_t TextureStates::intern_sampler(const compiler::TextureState& sampler_half) {
  const std::scoped_lock lock(mutex_);
  return intern(samplers_, sampler_half);
}

compiler::TextureState TextureStates::combine(uint32_t view, uint32_t sampler) const {
  const std::scoped_lock lock(mutex_);
  compiler::TextureState state = sampler ? samplers_[sampler - 1] : compiler::TextureState{};
  if (view) {
    const compiler::TextureState& half = views_[view - 1];
    state.format = half.format;
    state.view_type = half.view_type;
    state.swizzle = half.swizzle;
    state.single_level = half.single_level;
  } else {
    state.format = VK_FORMAT_R8G8B8A8_UNORM;  // never written: the descriptor's zero size makes every read zero
  }
  return state;
}

}  // namespace pineda::icd
