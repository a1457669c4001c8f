#include "tests/validation.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pineda::test {
namespace {

constexpr const char* kLayer = "VK_LAYER_KHRONOS_validation";

// What the installed layer (Debian 12's, 1.3.239) says wrongly. A message is not counted when it has the identifier and contains
// the words.
struct FalseMessage {
  std::string_view rule, words, reason;
};
constexpr FalseMessage kFalseMessages[] = {
    {"UNASSIGNED-CoreValidation-Shader-OutputNotConsumed", "", "a warning; outputs without an attachment are allowed"},
    {"UNASSIGNED-VkSemaphore-state-timeout", "most likely a validation bug", "after 10 s of a wait without a limit for the host"},
};

// Tests that have nothing to say to a layer, or cannot run under it.
struct LeftOut {
  const char *filter, *reason;
  bool by_synchronization_only = false;  // of the synchronization validation
};
constexpr LeftOut kLeftOut[] = {
    {"IcdEntry.*:IcdAllocation.*:IcdRegistry.*:IcdVersion11.VersionIsTheSameEverywhere",
     "looks at the driver's entry points and allocations, which the loader and the layer stand before"},
    {"IcdCompute.InvalidShaders*:IcdCompute.Damaged*:IcdPipelines.AFailedOne*", "damaged SPIR-V, in which the layer crashes"},
    {"IcdDescriptor.UpdatesCrossBindings", "writes behind a set's descriptors, in which the layer crashes"},
    {"Clients*:CtsProgram.*:*Golden*:BitContract*:IcdDiskCache.*", "runs other programs"},
    {"IcdFaults.AThousandDevicesLeaveNothing", "the layer itself leaves memory", true},
    {"IcdCompute.UnboundSetsAreHarmless", "a dispatch without descriptor sets, in which the layer crashes", true},
};

// What the layer has said in the current test. Queues and compiling threads call in, too.
class Record {
 public:
  struct Message {
    int count = 0;
    std::string first_text;
  };

  void add(const char* rule, const char* text) {
    const std::scoped_lock lock(mutex_);
    for (const FalseMessage& known : kFalseMessages) {
      if (known.rule == rule && std::string_view(text).find(known.words) != std::string_view::npos) return;
    }
    if (device_is_lost_ && std::string_view(text).find("in use") != std::string_view::npos) return;
    Message& message = messages_[rule];
    if (message.count++ == 0) message.first_text = text;
  }
  void expect(const char* rule) {
    const std::scoped_lock lock(mutex_);
    expected_.insert(rule);
  }
  void lose_device() {
    const std::scoped_lock lock(mutex_);
    device_is_lost_ = true;
  }
  // Gives the record of the test that ends and starts the next one's.
  void take(std::map<std::string, Message>* messages, std::set<std::string>* expected) {
    const std::scoped_lock lock(mutex_);
    *messages = std::exchange(messages_, {});
    *expected = std::exchange(expected_, {});
    device_is_lost_ = false;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, Message> messages_;
  std::set<std::string> expected_;
  bool device_is_lost_ = false;
};

Record& record() {
  static Record all;
  return all;
}

VKAPI_ATTR VkBool32 VKAPI_CALL receive(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                       const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
  const std::string_view rule = data->pMessageIdName ? data->pMessageIdName : "";
  // The driver's own messages and the loader's come this way, too.
  for (const char* prefix : {"VUID-", "UNASSIGNED-", "SYNC-"}) {
    if (rule.starts_with(prefix)) record().add(data->pMessageIdName, data->pMessage);
  }
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messenger_info() {
  VkDebugUtilsMessengerCreateInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
  info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  info.pfnUserCallback = receive;
  return info;
}

std::map<VkInstance, VkDebugUtilsMessengerEXT>& messengers() {
  static std::map<VkInstance, VkDebugUtilsMessengerEXT> all;
  return all;
}
std::mutex messengers_mutex;

bool is_synchronization_validated() {
  const char* mode = std::getenv("PINEDA_TEST_VALIDATE");
  return mode && std::strcmp(mode, "sync") == 0;
}

// Fails the tests that are not clean, and counts.
class Listener : public testing::EmptyTestEventListener {
 public:
  void print() const {
    printf("clean: %d of %d tests, of which %d break a named rule on purpose\n", clean_, tests_, on_purpose_);
  }

 private:
  void OnTestEnd(const testing::TestInfo&) override {
    std::map<std::string, Record::Message> messages;
    std::set<std::string> expected;
    record().take(&messages, &expected);
    ++tests_;
    bool is_clean = true;
    for (const auto& [rule, message] : messages) {
      if (expected.contains(rule)) continue;
      is_clean = false;
      ADD_FAILURE() << rule << ", " << message.count << " times, first:\n" << message.first_text;
    }
    for (const std::string& rule : expected) {
      if (messages.contains(rule)) continue;
      is_clean = false;
      ADD_FAILURE() << "the layer did not say " << rule;
    }
    clean_ += is_clean;
    on_purpose_ += is_clean && !expected.empty();
  }

  int tests_ = 0, clean_ = 0, on_purpose_ = 0;
};

}  // namespace

bool is_validating() {
  static const bool value = std::getenv("PINEDA_TEST_VALIDATE") != nullptr;
  return value;
}

void breaks_on_purpose(std::initializer_list<const char*> rules) {
  if (!is_validating()) return;
  for (const char* rule : rules) {
    if (is_synchronization_validated() || !std::string_view(rule).starts_with("SYNC-")) record().expect(rule);
  }
}

void loses_device() {
  if (is_validating()) record().lose_device();
}

VkResult create_validated_instance(PFN_vkGetInstanceProcAddr get, const VkInstanceCreateInfo& info,
                                   const VkAllocationCallbacks* callbacks, VkInstance* instance) {
  const std::span given(info.ppEnabledExtensionNames, info.enabledExtensionCount);
  std::vector<const char*> extensions(given.begin(), given.end());
  for (const char* wanted : {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME}) {
    bool is_there = false;
    for (const char* name : given) is_there |= std::strcmp(name, wanted) == 0;
    if (!is_there) extensions.push_back(wanted);
  }
  const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  const VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, info.pNext,
                                         is_synchronization_validated() ? 1u : 0u, &synchronization};
  VkDebugUtilsMessengerCreateInfoEXT while_creating = messenger_info();
  while_creating.pNext = &features;
  VkInstanceCreateInfo wrapped = info;
  wrapped.pNext = &while_creating;
  wrapped.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  wrapped.ppEnabledExtensionNames = extensions.data();
  wrapped.enabledLayerCount = 1;
  wrapped.ppEnabledLayerNames = &kLayer;
  const VkResult result = reinterpret_cast<PFN_vkCreateInstance>(get(nullptr, "vkCreateInstance"))(&wrapped, callbacks, instance);
  if (result != VK_SUCCESS) return result;
  const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(get(*instance, "vkCreateDebugUtilsMessengerEXT"));
  const VkDebugUtilsMessengerCreateInfoEXT lasting = messenger_info();
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
  EXPECT_EQ(create(*instance, &lasting, nullptr, &messenger), VK_SUCCESS);
  const std::scoped_lock lock(messengers_mutex);
  messengers()[*instance] = messenger;
  return result;
}

void destroy_validated_instance(PFN_vkGetInstanceProcAddr get, VkInstance instance, const VkAllocationCallbacks* callbacks) {
  if (instance) {
    const std::scoped_lock lock(messengers_mutex);
    const auto found = messengers().find(instance);
    if (found != messengers().end()) {
      reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(get(instance, "vkDestroyDebugUtilsMessengerEXT"))(
          instance, found->second, nullptr);
      messengers().erase(found);
    }
  }
  reinterpret_cast<PFN_vkDestroyInstance>(get(instance, "vkDestroyInstance"))(instance, callbacks);
}

}  // namespace pineda::test

int main(int argc, char** argv) {
  using namespace pineda::test;
  testing::InitGoogleTest(&argc, argv);
  if (is_validating()) {
    std::string filter = GTEST_FLAG_GET(filter);
    for (const auto& out : kLeftOut) {
      if (out.by_synchronization_only && !is_synchronization_validated()) continue;
      filter += (filter.find('-') == std::string::npos ? "-" : ":") + std::string(out.filter);
      printf("left out: %s: %s\n", out.filter, out.reason);
    }
    GTEST_FLAG_SET(filter, filter);
    auto* listener = new Listener;  // belongs to the list
    testing::UnitTest::GetInstance()->listeners().Append(listener);
    const int status = RUN_ALL_TESTS();
    listener->print();
    return status;
  }
  return RUN_ALL_TESTS();
}
