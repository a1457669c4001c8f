// The text form, one instruction a line:
//
//     kernel fragment "name" stride 16
//     draw:
//       %1 = draw_ptr ptr @draw
//     prim:
//     wave:
//       %2 = const i32 4
//       %3 = load f32 %1, %2 limit %2 stride 4 invariant
//       %4 = if %5 {
//         yield %3
//       } else {
//         yield %6
//       }
//       %7 = result f32 %4, 0
//
// Rates other than lane are printed as @draw, @prim, @wave.
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "compiler/ir/text.h"
#include "compiler/ir/walk.h"

namespace pineda::ir {
namespace {

std::string const_text(Type type, uint64_t imm) {
  if (type == Type::kB1) return imm != 0 ? "true" : "false";
  char text[32];
  if (is_float(type)) {
    const double v = std::bit_cast<double>(imm);
    if (std::isnan(v)) return "nan";
    return std::string(text, std::to_chars(text, text + sizeof text, v).ptr);
  }
  snprintf(text, sizeof text, imm < 0x10000 ? "%llu" : "0x%llx", static_cast<unsigned long long>(imm));
  return text;
}

void append_operands(std::string& out, const Kernel& kernel, const Names& names, const Inst& inst) {
  const char* separator = " ";
  const auto item = [&](const std::string& text) {
    out += separator + text;
    separator = ", ";
  };
  for (uint32_t i = 0; i < op_info(inst.op).operands; ++i) item(names(inst.operand[i]));
  if (has_list(inst.op) && inst.list < kernel.lists.size()) {
    for (Value v : kernel.lists[inst.list]) item(names(v));
  }
  if (has_index_imm(inst.op)) item(std::to_string(inst.imm));
}

void append_memory(std::string& out, const Names& names, const Inst& inst) {
  if (const Value limit = limit_of(inst)) out += " limit " + names(limit);
  if (inst.op == Op::kAtomic && inst.operand[kComparandIndex]) out += " comparand " + names(inst.operand[kComparandIndex]);
  if (inst.lane_stride() != 0) out += " stride " + std::to_string(inst.lane_stride());
}

class Printer {
 public:
  explicit Printer(const Kernel& kernel) : kernel_(kernel), names_(kernel) {}

  void region(RegionId id, int depth) {
    for (Value v : kernel_.regions[id].insts) {
      const Inst& inst = kernel_.at(v);
      line(depth, instruction_text(kernel_, names_, v) + (has_regions(inst.op) ? " {" : ""));
      for (uint32_t r = 0; r < region_count(inst.op); ++r) {
        if (r == 1) line(depth, "} else {");
        region(inst.region[r], depth + 1);
      }
      if (has_regions(inst.op)) line(depth, "}");
    }
  }

  void line(int depth, const std::string& text) { out_ += std::string(2 * static_cast<size_t>(depth), ' ') + text + "\n"; }
  std::string take() { return std::move(out_); }

 private:
  const Kernel& kernel_;
  Names names_;
  std::string out_;
};

}  // namespace

Names::Names(const Kernel& kernel) : number_(kernel.insts.size()) {
  std::vector<bool> seen(kernel.regions.size());
  uint32_t next = 1;
  struct Cursor {
    RegionId region;
    size_t at;
  };
  std::vector<Cursor> stack;
  const auto enter = [&](RegionId region) {
    if (region == 0 || region >= seen.size() || seen[region]) return;
    seen[region] = true;
    stack.push_back({region, 0});
  };
  for (RegionId root : {kernel.draw, kernel.prim, kernel.wave}) {
    enter(root);
    while (!stack.empty()) {
      Cursor& cursor = stack.back();
      const auto& insts = kernel.regions[cursor.region].insts;
      if (cursor.at == insts.size()) {
        stack.pop_back();
        continue;
      }
      const Value v = insts[cursor.at++];
      if (v.id == 0 || v.id >= number_.size()) continue;
      const Inst& inst = kernel.at(v);
      if (is_named(inst) && number_[v.id] == 0) number_[v.id] = next++;
      for (uint32_t r = region_count(inst.op); r-- > 0;) enter(inst.region[r]);
    }
  }
}

std::string Names::operator()(Value v) const {
  if (v.id == 0) return "%none";
  if (v.id >= number_.size() || number_[v.id] == 0) return "%stray" + std::to_string(v.id);
  return "%" + std::to_string(number_[v.id]);
}

std::string instruction_text(const Kernel& kernel, const Names& names, Value v) {
  if (v.id == 0 || v.id >= kernel.insts.size()) return "%stray" + std::to_string(v.id);
  const Inst& inst = kernel.at(v);
  std::string out;
  if (is_named(inst)) out += names(v) + " = ";
  out += op_info(inst.op).name;
  if (inst.op == Op::kAtomic) {
    const auto index = static_cast<size_t>(inst.atomic_op());
    out += std::string(" ") + (index < std::size(kAtomicNames) ? kAtomicNames[index] : "?");
  }
  if (inst.type != Type::kVoid) out += std::string(" ") + type_name(inst.type);
  if (inst.op == Op::kConst) out += " " + const_text(inst.type, inst.imm);
  append_operands(out, kernel, names, inst);
  if (is_memory(inst.op)) append_memory(out, names, inst);
  for (const FlagName& flag : kFlagNames) {
    if (inst.flags & flag.bit) out += std::string(" ") + flag.text;
  }
  if (inst.rate != Rate::kLane) out += std::string(" @") + kRateNames[static_cast<size_t>(inst.rate) & 3];
  return out;
}

std::string print(const Kernel& kernel) {
  Printer printer(kernel);
  printer.line(0, std::string("kernel ") + kKindNames[static_cast<size_t>(kernel.kind)] + " \"" + kernel.name + "\" stride " +
                      std::to_string(kernel.wave_stride_bytes) + (kernel.full_waves ? " full_waves" : ""));
  const std::pair<const char*, RegionId> roots[] = {{"draw:", kernel.draw}, {"prim:", kernel.prim}, {"wave:", kernel.wave}};
  for (const auto& [title, region] : roots) {
    if (region == 0) continue;
    printer.line(0, title);
    printer.region(region, 1);
  }
  return printer.take();
}

}  // namespace pineda::ir
