// PINEDA_DEBUG=explain of compute pipelines and dispatches.
#include "icd/explain.h"
#include "icd/explain_text.h"

namespace pineda::icd {
namespace {

using compiler::ComputeSizes;

std::string size_text(const std::array<uint32_t, 3>& size) {
  return number(size[0]) + "x" + number(size[1]) + "x" + number(size[2]);
}

void explain_instructions(const ComputeSizes& sizes, std::string& text) {
  const compiler::KernelSizes& kernel = sizes.kernel;
  const compiler::Removed& removed = sizes.removed;
  line(text, "kernel: " + number(kernel.built) + " IR instructions as the shader spells them out, " + number(kernel.kept) +
                 " after the passes, of which " + number(kernel.per_draw) + " run once a dispatch and " +
                 number(kernel.per_primitive) + " once a workgroup; loads " + number(kernel.built_loads) + " -> " +
                 number(kernel.loads) + ", stores " + number(kernel.built_stores) + " -> " + number(kernel.stores));
  line(text, "removed in turn: " + number(removed.variables) + " variables, with " + number(removed.accesses) +
                 " loads and stores of them; " + number(removed.dead) + " instructions without effect; " +
                 number(removed.constant) + " computed at compile time; " + number(removed.equal) +
                 " equal to others, among them " + number(removed.equal_loads) + " loads");
}

void explain_specialization(const ComputeSizes& sizes, const Unspecialized& other, std::string& text) {
  line(text, "specialisation: " + number(other.given) + (other.given == 1 ? " constant" : " constants") +
                 " given; with the shader's own values the kernel has " + number(other.sizes.kernel.kept) +
                 " instructions in place of " + number(sizes.kernel.kept) + ", and " +
                 number(other.sizes.branches.uniform + other.sizes.branches.divergent) + " branches in place of " +
                 number(sizes.branches.uniform + sizes.branches.divergent));
}

void explain_branches(const ComputeSizes& sizes, std::string& text) {
  const compiler::Branches& branches = sizes.branches;
  if (branches.built == 0) return line(text, "branches: none");
  line(text, "branches: of " + number(branches.built) + " ifs and loops " + number(sizes.removed.decided) +
                 " ifs are decided or without effect, " + number(branches.flattened) + " short ones became selections, " +
                 number(branches.unrolled) + " loops straight code; of those left " + number(branches.uniform) +
                 " are uniform (a wave jumps), " + number(branches.divergent) + " may differ from lane to lane (masks)");
}

void explain_checks(const ComputeSizes& sizes, std::string& text) {
  const compiler::BoundsChecks& checks = sizes.checks;
  const uint32_t left = checks.known + checks.per_draw + checks.per_wave + checks.per_lane;
  if (checks.built == 0 && left == 0) return line(text, "bounds checks: none, no access can leave its buffer");
  line(text, "bounds checks: " + number(checks.built) + " accesses that could leave their buffer are " + number(left) +
                 " after the passes (copies of unrolled loops included); of those " + number(checks.known) +
                 " are inside by what constants tell, " + number(checks.per_draw) +
                 " are checked once a dispatch or workgroup, " + number(checks.per_wave) + " by one comparison a wave, " +
                 number(checks.per_lane) + " lane by lane, but for those that the ifs and loops around them decide" +
                 (checks.indices ? "; " + number(checks.indices) + " indices lane by lane, as their offsets might wrap" : ""));
}

void explain_barriers(const ComputeSizes& sizes, uint32_t shared_memory_bytes, std::string& text) {
  if (sizes.barriers == 0) {
    line(text, "barriers: none, a wave runs to its end without being interrupted");
  } else {
    line(text, "barriers: " + number(sizes.barriers) + ", between which each wave runs in turn; " +
                   number(sizes.group_constructs) + " ifs and loops around them are run by the whole workgroup; " +
                   number(sizes.frame_bytes) + " bytes a wave kept from one to the next");
  }
  line(text, shared_memory_bytes == 0
                 ? "workgroup memory: none"
                 : "workgroup memory: " + number(shared_memory_bytes) + " bytes, cleared for each workgroup");
}

}  // namespace

std::string explain_compute_pipeline(const std::string& name, const spirv::ModuleInfo& info, const ComputeSizes& sizes,
                                     const std::optional<Unspecialized>& unspecialized) {
  std::string text = "compute pipeline '" + name + ", workgroups of " + size_text(info.local_size);
  explain_instructions(sizes, text);
  if (unspecialized) explain_specialization(sizes, *unspecialized, text);
  explain_branches(sizes, text);
  explain_checks(sizes, text);
  explain_barriers(sizes, info.shared_memory_bytes, text);
  return text;
}

std::string explain_dispatch(const std::string& name, const std::array<uint32_t, 3>& groups,
                             const std::array<uint32_t, 3>& local_size) {
  const uint64_t count = uint64_t{groups[0]} * groups[1] * groups[2];
  const uint64_t invocations = uint64_t{local_size[0]} * local_size[1] * local_size[2];
  const uint64_t waves = (invocations + kLanes - 1) / kLanes;
  return "dispatch of '" + name + "', " + size_text(groups) + " workgroups of " + size_text(local_size) + ": " + number(count) +
         " workgroups, " + number(count * waves) + " waves, active lanes " + share(invocations, waves * kLanes) + " a workgroup";
}

}  // namespace pineda::icd
