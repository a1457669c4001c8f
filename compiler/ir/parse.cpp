// Reads what print.cpp writes. Names are any %word; a value must be defined above its use, which is all that is checked here:
// call verify() on the result.
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <unordered_map>

#include "compiler/ir/limits.h"
#include "compiler/ir/text.h"
#include "compiler/ir/walk.h"

namespace pineda::ir {
namespace {

// One line, cut into words. Words end at blanks and commas; a string keeps its quotes.
std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  size_t at = 0;
  while (true) {
    at = line.find_first_not_of(" \t\r,", at);
    if (at == std::string_view::npos || line[at] == ';') return words;  // ; starts a comment
    const bool quoted = line[at] == '"';
    size_t end = quoted ? line.find('"', at + 1) : line.find_first_of(" \t\r,", at);
    end = end == std::string_view::npos ? line.size() : end + quoted;
    words.push_back(line.substr(at, end - at));
    at = end;
  }
}

template <typename Table>
int find_name(const Table& table, std::string_view word) {
  for (size_t i = 0; i < std::size(table); ++i) {
    if (word == table[i]) return static_cast<int>(i);
  }
  return -1;
}

bool parse_uint(std::string_view word, uint64_t& out) {
  const bool hex = word.starts_with("0x");
  if (hex) word.remove_prefix(2);
  const bool negative = !hex && word.starts_with("-");
  if (negative) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out, hex ? 16 : 10);
  if (negative) out = 0 - out;
  return error == std::errc() && end == word.data() + word.size();
}

const std::unordered_map<std::string_view, Op>& op_names() {
  static const auto* names = [] {
    auto* map = new std::unordered_map<std::string_view, Op>;
    for (size_t i = 1; i < static_cast<size_t>(Op::kCount); ++i)
      map->emplace(op_info(static_cast<Op>(i)).name, static_cast<Op>(i));
    return map;
  }();
  return *names;
}

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  ParseResult run() {
    while (!text_.empty() && error_.empty()) {
      const size_t end = text_.find('\n');
      words_ = split(text_.substr(0, end));
      text_ = end == std::string_view::npos ? std::string_view() : text_.substr(end + 1);
      ++line_;
      at_ = 0;
      if (!words_.empty()) line();
    }
    if (error_.empty() && !open_.empty()) fail("a region is not closed");
    if (error_.empty() && kernel_.wave == 0) fail("no wave region");
    return {std::move(kernel_), std::move(error_)};
  }

 private:
  bool fail(const std::string& text) {
    if (error_.empty()) error_ = "line " + std::to_string(line_) + ": " + text;
    return false;
  }

  std::string_view peek() const { return at_ < words_.size() ? words_[at_] : std::string_view(); }
  std::string_view next() { return at_ < words_.size() ? words_[at_++] : std::string_view(); }
  bool accept(std::string_view word) { return peek() == word && ++at_ != 0; }

  void line() {
    if (peek() == "kernel") {
      header();
    } else if (words_.size() == 1 && peek().ends_with(':')) {
      section();
    } else if (peek() == "}") {
      close();
    } else if (region_ == 0) {
      fail("instruction outside of a region");
    } else {
      instruction();
    }
    if (error_.empty() && at_ < words_.size()) fail("unexpected '" + std::string(peek()) + "'");
  }

  void header() {
    next();
    const int kind = find_name(kKindNames, next());
    if (kind < 0) return void(fail("unknown kind of kernel"));
    kernel_.kind = static_cast<KernelKind>(kind);
    const std::string_view name = next();
    if (name.size() < 2 || name.front() != '"' || name.back() != '"') return void(fail("kernel name must be quoted"));
    kernel_.name = name.substr(1, name.size() - 2);
    uint64_t stride = 0;
    if (!accept("stride") || !parse_uint(next(), stride) || stride > UINT32_MAX) return void(fail("expected stride"));
    kernel_.wave_stride_bytes = static_cast<uint32_t>(stride);
    kernel_.full_waves = accept("full_waves");
  }

  RegionId add_region() {
    kernel_.regions.emplace_back();
    return static_cast<RegionId>(kernel_.regions.size() - 1);
  }

  void section() {
    const std::string_view name = next();
    RegionId* root = name == "draw:"   ? &kernel_.draw
                     : name == "prim:" ? &kernel_.prim
                     : name == "wave:" ? &kernel_.wave
                                       : nullptr;
    if (root == nullptr || *root != 0) return void(fail("unknown or repeated section"));
    if (!open_.empty()) return void(fail("a region is not closed"));
    region_ = *root = add_region();
  }

  void close() {
    next();
    if (open_.empty()) return void(fail("'}' without a region"));
    const Value owner = open_.back().owner;
    if (accept("else")) {
      if (!accept("{") || kernel_.at(owner).op != Op::kIf || kernel_.at(owner).region[1] != 0) return void(fail("bad else"));
      region_ = add_region();
      kernel_.at(owner).region[1] = region_;
      return;
    }
    if (kernel_.at(owner).op == Op::kIf && kernel_.at(owner).region[1] == 0) return void(fail("if has no else region"));
    region_ = open_.back().outer;
    open_.pop_back();
  }

  bool value(Value& out) {
    const std::string_view word = next();
    if (!word.starts_with('%')) return fail("expected a value, found '" + std::string(word) + "'");
    const auto found = names_.find(std::string(word));
    if (found == names_.end()) return fail(std::string(word) + " is not defined");
    out = found->second;
    return true;
  }

  void instruction() {
    std::string_view name;
    if (peek().starts_with('%')) {
      name = next();
      if (!accept("=")) return void(fail("expected '='"));
    }
    const auto op = op_names().find(next());
    if (op == op_names().end()) return void(fail("unknown operation"));
    Inst inst{.op = op->second};
    if (!atomic_and_type(inst) || !constant(inst) || !operands(inst) || !attributes(inst)) return;
    if (is_named(inst) == name.empty()) return void(fail(name.empty() ? "needs a name" : "has no value to name"));
    const Value v{static_cast<uint32_t>(kernel_.insts.size())};
    kernel_.insts.push_back(inst);
    kernel_.regions[region_].insts.push_back(v);
    if (!name.empty() && !names_.emplace(name, v).second) return void(fail(std::string(name) + " is defined twice"));
    if (!has_regions(inst.op)) return;
    if (!accept("{")) return void(fail("expected '{'"));
    if (open_.size() > kMaxRegionDepth) return void(fail("regions are nested too deeply"));
    open_.push_back({v, region_});
    region_ = add_region();
    kernel_.at(v).region[0] = region_;
  }

  bool atomic_and_type(Inst& inst) {
    if (inst.op == Op::kAtomic) {
      const int kind = find_name(kAtomicNames, next());
      if (kind < 0) return fail("unknown atomic operation");
      inst.imm = static_cast<uint64_t>(kind);
    }
    if (op_info(inst.op).rule == TypeRule::kVoid) return true;
    const std::string_view word = next();
    for (uint8_t t = 1; t <= static_cast<uint8_t>(Type::kPtr); ++t) {
      if (word == type_name(static_cast<Type>(t))) inst.type = static_cast<Type>(t);
    }
    return inst.type != Type::kVoid ? true : fail("expected a type");
  }

  bool constant(Inst& inst) {
    if (inst.op != Op::kConst) return true;
    const std::string_view word = next();
    if (inst.type == Type::kB1) {
      inst.imm = word == "true";
      return word == "true" || word == "false" ? true : fail("expected true or false");
    }
    if (!is_float(inst.type)) {
      if (!parse_uint(word, inst.imm)) return fail("expected an integer");
      const uint32_t bits = 8 * size_bytes(inst.type);
      if (word.starts_with('-') && bits < 64) inst.imm &= (1ull << bits) - 1;
      return true;
    }
    double v = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), v);
    if (error != std::errc() || end != word.data() + word.size()) return fail("expected a number");
    if (std::isnan(v)) v = std::numeric_limits<double>::quiet_NaN();
    inst.imm = std::bit_cast<uint64_t>(v);
    return true;
  }

  bool operands(Inst& inst) {
    for (uint32_t i = 0; i < op_info(inst.op).operands; ++i) {
      if (!value(inst.operand[i])) return false;
    }
    if (has_list(inst.op)) {
      std::vector<Value> values;
      while (peek().starts_with('%')) {
        if (!value(values.emplace_back())) return false;
      }
      inst.list = static_cast<uint32_t>(kernel_.lists.size());
      kernel_.lists.push_back(std::move(values));
    }
    return !has_index_imm(inst.op) || parse_uint(next(), inst.imm) ? true : fail("expected a number");
  }

  bool attributes(Inst& inst) {
    while (at_ < words_.size() && peek() != "{") {
      const std::string_view word = next();
      if (word == "limit" && is_memory(inst.op)) {
        if (!value(inst.operand[limit_index(inst.op)])) return false;
      } else if (word == "comparand" && inst.op == Op::kAtomic) {
        if (!value(inst.operand[kComparandIndex])) return false;
      } else if (word == "stride" && is_memory(inst.op)) {
        uint64_t stride = 0;
        if (!parse_uint(next(), stride) || stride > UINT32_MAX) return fail("expected a stride");
        inst.imm |= stride << 32;
      } else if (word.starts_with('@') && find_name(kRateNames, word.substr(1)) >= 0) {
        inst.rate = static_cast<Rate>(find_name(kRateNames, word.substr(1)));
      } else if (!flag(inst, word)) {
        return fail("unexpected '" + std::string(word) + "'");
      }
    }
    return true;
  }

  static bool flag(Inst& inst, std::string_view word) {
    for (const FlagName& name : kFlagNames) {
      if (word != name.text) continue;
      inst.flags |= name.bit;
      return true;
    }
    return false;
  }

  struct Open {
    Value owner;
    RegionId outer;
  };

  std::string_view text_;
  std::vector<std::string_view> words_;
  size_t at_ = 0;
  int line_ = 0;
  Kernel kernel_;
  RegionId region_ = 0;
  std::vector<Open> open_;
  std::unordered_map<std::string, Value> names_;
  std::string error_;
};

}  // namespace

ParseResult parse(const std::string& text) { return Parser(text).run(); }

}  // namespace pineda::ir
