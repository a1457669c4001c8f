#include "tools/fuzz/mutate.h"

#include <algorithm>

namespace pineda::fuzz {
namespace {

constexpr size_t kHeaderWords = 5, kBoundWord = 3;

struct Span {
  size_t at, count;
};

// The instructions, as far as their word counts make sense.
std::vector<Span> instructions(const std::vector<uint32_t>& words) {
  std::vector<Span> out;
  for (size_t at = kHeaderWords; at < words.size();) {
    const size_t count = words[at] >> 16;
    if (count == 0 || count > words.size() - at) break;
    out.push_back({at, count});
    at += count;
  }
  return out;
}

void edit_word(std::vector<uint32_t>& words, Random& random) {
  uint32_t& word = words[random.below(words.size())];
  switch (random.below(6)) {
    case 0:
      word = static_cast<uint32_t>(random.next());
      break;
    case 1:
      word ^= 1u << random.below(32);
      break;
    case 2:  // another id
      word = random.below(words.size() > kBoundWord ? std::max(words[kBoundWord], 1u) : 1);
      break;
    case 3:
      word = words[random.below(words.size())];
      break;
    case 4:  // another opcode of the same size
      word = (word & 0xffff0000) | random.below(400);
      break;
    default:
      word += random.below(5) - 2;
      break;
  }
}

void edit_instruction(std::vector<uint32_t>& words, Random& random) {
  const std::vector<Span> all = instructions(words);
  if (all.empty()) return edit_word(words, random);
  const Span i = all[random.below(all.size())];
  const auto first = words.begin() + static_cast<ptrdiff_t>(i.at), last = first + static_cast<ptrdiff_t>(i.count);
  const std::vector<uint32_t> copy(first, last);
  switch (random.below(4)) {
    case 0:
      words.erase(first, last);
      break;
    case 1:
      words.insert(last, copy.begin(), copy.end());
      break;
    case 2: {  // somewhere else
      words.erase(first, last);
      const std::vector<Span> rest = instructions(words);
      const size_t to = rest.empty() ? words.size() : rest[random.below(rest.size())].at;
      words.insert(words.begin() + static_cast<ptrdiff_t>(to), copy.begin(), copy.end());
      break;
    }
    default:  // without its last operands
      if (i.count < 2) break;
      const size_t kept = 1 + random.below(i.count - 1);
      words[i.at] = static_cast<uint32_t>(kept) << 16 | (words[i.at] & 0xffff);
      words.erase(words.begin() + static_cast<ptrdiff_t>(i.at + kept), words.begin() + static_cast<ptrdiff_t>(i.at + i.count));
      break;
  }
}

}  // namespace

std::vector<uint32_t> mutate(std::span<const uint32_t> words, Random& random) {
  std::vector<uint32_t> out(words.begin(), words.end());
  for (uint32_t edits = 1 + random.below(3); edits > 0 && !out.empty(); --edits) {
    if (random.one_in(3))
      edit_instruction(out, random);
    else
      edit_word(out, random);
  }
  if (random.one_in(16)) out.resize(random.below(out.size() + 1));
  return out;
}

}  // namespace pineda::fuzz
