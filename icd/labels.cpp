#include "icd/labels.h"

#include <algorithm>

#include "icd/api.h"
#include "icd/command_buffer.h"
#include "icd/executor.h"
#include "icd/queue.h"

namespace pineda::icd {
namespace {

Label make_label(const char* name, const float (&color)[4]) {
  Label label{name ? name : "", {}};
  std::ranges::copy(color, label.color.begin());
  return label;
}

}  // namespace

void LabelStack::drop_inserted_locked() {
  if (inserted_) open_.pop_back();
  inserted_ = false;
}

void LabelStack::begin(const char* name, const float (&color)[4]) {
  Label label = make_label(name, color);
  any_.store(true, std::memory_order_relaxed);
  const std::scoped_lock lock(mutex_);
  drop_inserted_locked();
  open_.push_back(std::move(label));
}

void LabelStack::end() {
  const std::scoped_lock lock(mutex_);
  drop_inserted_locked();
  if (!open_.empty()) open_.pop_back();
}

void LabelStack::insert(const char* name, const float (&color)[4]) {
  begin(name, color);
  const std::scoped_lock lock(mutex_);
  inserted_ = true;
}

void LabelStack::clear() {
  if (!any_.load(std::memory_order_relaxed)) return;
  any_.store(false, std::memory_order_relaxed);
  const std::scoped_lock lock(mutex_);
  open_.clear();
  inserted_ = false;
}

std::vector<Label> LabelStack::snapshot() const {
  const std::scoped_lock lock(mutex_);
  return open_;
}

void api::QueueBeginDebugUtilsLabelEXT(VkQueue queue, const VkDebugUtilsLabelEXT* label) {
  (void)guarded([&] {
    from(queue)->labels.begin(label->pLabelName, label->color);
    return VK_SUCCESS;
  });
}

void api::QueueEndDebugUtilsLabelEXT(VkQueue queue) { from(queue)->labels.end(); }

void api::QueueInsertDebugUtilsLabelEXT(VkQueue queue, const VkDebugUtilsLabelEXT* label) {
  (void)guarded([&] {
    from(queue)->labels.insert(label->pLabelName, label->color);
    return VK_SUCCESS;
  });
}

namespace {

cmd::LabelText copy_label(CommandBuffer& cb, const VkDebugUtilsLabelEXT& label) {
  const std::string_view name = label.pLabelName ? label.pLabelName : "";
  cmd::LabelText text{cb.copy(name.data(), name.size() + 1).data(), {}};  // with its end
  std::ranges::copy(label.color, text.color);
  return text;
}

}  // namespace

void api::CmdBeginDebugUtilsLabelEXT(VkCommandBuffer handle, const VkDebugUtilsLabelEXT* label) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::BeginDebugUtilsLabelEXT{copy_label(cb, *label)}); });
}

void api::CmdEndDebugUtilsLabelEXT(VkCommandBuffer handle) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::EndDebugUtilsLabelEXT{}); });
}

void api::CmdInsertDebugUtilsLabelEXT(VkCommandBuffer handle, const VkDebugUtilsLabelEXT* label) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::InsertDebugUtilsLabelEXT{copy_label(cb, *label)}); });
}

void Executor::execute(const cmd::BeginDebugUtilsLabelEXT& command) { labels_.begin(command.label.name, command.label.color); }
void Executor::execute(const cmd::EndDebugUtilsLabelEXT&) { labels_.end(); }
void Executor::execute(const cmd::InsertDebugUtilsLabelEXT& command) { labels_.insert(command.label.name, command.label.color); }

}  // namespace pineda::icd
