// binding_model.*: descriptors of every type in arrays, sets and stages; dynamic offsets, copies and update templates.
#include <fmt/format.h>

#include <cstring>
#include <numeric>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/evaluate.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

enum class Kind { kUniform, kStorage, kCombined, kSeparate, kStorageImage, kUniformTexel, kStorageTexel };
constexpr std::pair<Kind, const char*> kKinds[] = {
    {Kind::kUniform, "uniform_buffer"},           {Kind::kStorage, "storage_buffer"},
    {Kind::kCombined, "combined_sampler"},        {Kind::kSeparate, "sampled_image_and_sampler"},
    {Kind::kStorageImage, "storage_image"},       {Kind::kUniformTexel, "uniform_texel_buffer"},
    {Kind::kStorageTexel, "storage_texel_buffer"}};

// Objects of `count` descriptors of one kind; element i holds the word 1000 + 17 i.
struct Objects {
  std::vector<Buffer> buffers;
  std::vector<Image> images;
  std::vector<BufferView> views;
  Sampler sampler;
  std::vector<Descriptor> descriptors;
};
uint32_t word_of(uint32_t i) { return 1000 + 17 * i; }

BufferView create_view(Device& device, const Buffer& buffer) {
  VkBufferViewCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
  info.buffer = buffer.handle;
  info.format = VK_FORMAT_R32_UINT;
  info.range = VK_WHOLE_SIZE;
  return make<VkBufferView, vkDestroyBufferView>(device, vkCreateBufferView, info, "vkCreateBufferView");
}

Image create_word_image(Device& device, uint32_t word, VkImageUsageFlags usage, VkImageLayout layout) {
  ImageDesc desc;
  desc.format = VK_FORMAT_R32_UINT;
  desc.extent = {2, 2, 1};
  desc.usage |= usage;
  Image image = create_image(device, desc);
  const std::array<uint32_t, 4> texels = {word, word, word, word};
  upload(device, image, std::as_bytes(std::span(texels)), 0, 0, layout);
  return image;
}

Objects create_objects(Device& device, Kind kind, uint32_t binding, uint32_t count) {
  Objects objects;
  objects.sampler = create_sampler(device);
  Descriptor d;
  d.binding = binding;
  const bool texel = kind == Kind::kUniformTexel || kind == Kind::kStorageTexel;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t word = word_of(i);
    if (kind == Kind::kUniform || kind == Kind::kStorage || texel) {
      const VkBufferUsageFlags usage =
          texel ? VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT : kAnyBuffer;
      objects.buffers.push_back(create_buffer(device, std::vector<uint32_t>(4, word), usage));
      if (texel) {
        objects.views.push_back(create_view(device, objects.buffers.back()));
        d.views.push_back(objects.views.back());
      } else {
        d.buffers.push_back({objects.buffers.back().handle, 0, VK_WHOLE_SIZE});
      }
    } else {
      const bool storage = kind == Kind::kStorageImage;
      const VkImageLayout layout = storage ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
      objects.images.push_back(
          create_word_image(device, word, storage ? VK_IMAGE_USAGE_STORAGE_BIT : VK_IMAGE_USAGE_SAMPLED_BIT, layout));
      d.images.push_back({objects.sampler, objects.images.back().view, layout});
    }
  }
  static constexpr VkDescriptorType kTypes[] = {
      VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,      VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
      VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,       VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,  VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER,
      VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER};
  d.type = kTypes[static_cast<size_t>(kind)];
  objects.descriptors.push_back(d);
  if (kind == Kind::kSeparate) {
    Descriptor s;
    s.binding = binding + 1;
    s.type = VK_DESCRIPTOR_TYPE_SAMPLER;
    s.images.push_back({objects.sampler, VK_NULL_HANDLE, VK_IMAGE_LAYOUT_UNDEFINED});
    objects.descriptors.push_back(s);
  }
  return objects;
}

std::string declaration(Kind kind, uint32_t binding, uint32_t count) {
  switch (kind) {
    case Kind::kUniform:
      return fmt::format("layout(binding = {}) uniform D {{ uint v; }} d[{}];", binding, count);
    case Kind::kStorage:
      return fmt::format("layout(binding = {}, std430) readonly buffer D {{ uint v; }} d[{}];", binding, count);
    case Kind::kCombined:
      return fmt::format("layout(binding = {}) uniform usampler2D d[{}];", binding, count);
    case Kind::kSeparate:
      return fmt::format("layout(binding = {}) uniform utexture2D d[{}]; layout(binding = {}) uniform sampler s;", binding, count,
                         binding + 1);
    case Kind::kStorageImage:
      return fmt::format("layout(binding = {}, r32ui) readonly uniform uimage2D d[{}];", binding, count);
    case Kind::kUniformTexel:
      return fmt::format("layout(binding = {}) uniform usamplerBuffer d[{}];", binding, count);
    default:
      return fmt::format("layout(binding = {}, r32ui) readonly uniform uimageBuffer d[{}];", binding, count);
  }
}

std::string load(Kind kind, const std::string& index) {
  switch (kind) {
    case Kind::kUniform:
    case Kind::kStorage:
      return fmt::format("d[{}].v", index);
    case Kind::kCombined:
      return fmt::format("textureLod(d[{}], vec2(0.25), 0.0).x", index);
    case Kind::kSeparate:
      return fmt::format("textureLod(usampler2D(d[{}], s), vec2(0.25), 0.0).x", index);
    case Kind::kStorageImage:
      return fmt::format("imageLoad(d[{}], ivec2(1, 0)).x", index);
    case Kind::kUniformTexel:
      return fmt::format("texelFetch(d[{}], 3).x", index);
    default:
      return fmt::format("imageLoad(d[{}], 2).x", index);
  }
}

enum class Indexing { kConstant, kUniform };

void run_array(Device& device, Kind kind, VkShaderStageFlagBits stage, uint32_t count, Indexing indexing) {
  const VkPhysicalDeviceFeatures& features = device.caps().features;
  if (indexing == Indexing::kUniform) {
    const bool offered = kind == Kind::kUniform        ? features.shaderUniformBufferArrayDynamicIndexing
                         : kind == Kind::kStorage      ? features.shaderStorageBufferArrayDynamicIndexing
                         : kind == Kind::kStorageImage ? features.shaderStorageImageArrayDynamicIndexing
                                                       : features.shaderSampledImageArrayDynamicIndexing;
    require(offered, "dynamic indexing");
    require(kind != Kind::kUniformTexel && kind != Kind::kStorageTexel, "dynamic indexing of texel buffers");
  }
  const Objects objects = create_objects(device, kind, 2, count);
  Snippet snippet;
  snippet.functions = declaration(kind, 2, count);
  snippet.descriptors = objects.descriptors;
  if (indexing == Indexing::kConstant) {
    snippet.body = "r = uvec4(0);";
    for (uint32_t i = 0; i < count; ++i)
      snippet.body += fmt::format("if (a.x == {}u) r.x = {};", i, load(kind, std::to_string(i)));
  } else {  // the loop's counter is dynamically uniform
    snippet.body =
        fmt::format("for (uint i = 0u; i < {}u; ++i) {{ uint v = {}; if (a.x == i) r.x = v; }}", count, load(kind, "i"));
  }
  std::vector<Arguments> inputs(count);
  for (uint32_t i = 0; i < count; ++i) inputs[i].a[0] = i;
  const auto got = evaluate(device, stage, snippet, inputs);
  for (uint32_t i = 0; i < count; ++i) {
    expect(got[i][0] == word_of(i), fmt::format("element {} gave {}, not {}", i, got[i][0], word_of(i)));
  }
}

// Layout, pool and sets made by hand, for what Bindings does not do.
struct Sets {
  Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout> set_layout;
  Owned<VkPipelineLayout, vkDestroyPipelineLayout> layout;
  Owned<VkDescriptorPool, vkDestroyDescriptorPool> pool;
  std::vector<VkDescriptorSet> sets;
};

Sets create_sets(Device& device, const std::vector<VkDescriptorSetLayoutBinding>& bindings, uint32_t count) {
  Sets s;
  VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set_info.bindingCount = static_cast<uint32_t>(bindings.size());
  set_info.pBindings = bindings.data();
  s.set_layout = make<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>(device, vkCreateDescriptorSetLayout, set_info,
                                                                           "vkCreateDescriptorSetLayout");
  const std::vector<VkDescriptorSetLayout> layouts(count, s.set_layout);
  VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout_info.setLayoutCount = count;
  layout_info.pSetLayouts = layouts.data();
  s.layout =
      make<VkPipelineLayout, vkDestroyPipelineLayout>(device, vkCreatePipelineLayout, layout_info, "vkCreatePipelineLayout");
  std::vector<VkDescriptorPoolSize> sizes;
  for (const auto& b : bindings) sizes.push_back({b.descriptorType, b.descriptorCount * count});
  VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool_info.maxSets = count;
  pool_info.poolSizeCount = static_cast<uint32_t>(sizes.size());
  pool_info.pPoolSizes = sizes.data();
  s.pool = make<VkDescriptorPool, vkDestroyDescriptorPool>(device, vkCreateDescriptorPool, pool_info, "vkCreateDescriptorPool");
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = s.pool;
  allocate.descriptorSetCount = count;
  allocate.pSetLayouts = layouts.data();
  s.sets.resize(count);
  check(vkAllocateDescriptorSets(device.handle(), &allocate, s.sets.data()), "vkAllocateDescriptorSets");
  return s;
}

void write_buffer(Device& device, VkDescriptorSet set, uint32_t binding, VkDescriptorType type, const Buffer& buffer,
                  VkDeviceSize range = VK_WHOLE_SIZE, uint32_t element = 0) {
  const VkDescriptorBufferInfo info{buffer.handle, 0, range};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set;
  write.dstBinding = binding;
  write.dstArrayElement = element;
  write.descriptorCount = 1;
  write.descriptorType = type;
  write.pBufferInfo = &info;
  vkUpdateDescriptorSets(device.handle(), 1, &write, 0, nullptr);
}

// Several dispatches, each with other dynamic offsets into one buffer.
void run_dynamic_offsets(Device& device, bool storage, uint32_t bindings_count) {
  const VkDescriptorType type = storage ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC : VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC;
  const uint32_t step = 256, dispatches = 5;
  std::vector<uint32_t> words(step / 4 * 16);
  std::iota(words.begin(), words.end(), 1u);
  const Buffer in = create_buffer(device, words);
  // The offsets of the outputs must respect minStorageBufferOffsetAlignment, too.
  const Buffer out = create_buffer(device, VkDeviceSize{dispatches} * step);
  std::vector<VkDescriptorSetLayoutBinding> bindings = {
      {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}};
  std::string blocks = "layout(binding = 0, std430) buffer O { uint o; };\n", sum;
  for (uint32_t i = 1; i <= bindings_count; ++i) {
    bindings.push_back({i, type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    blocks += fmt::format("layout(binding = {0}, {1}) {2} B{0} {{ uint v{0}; }};\n", i, storage ? "std430" : "std140",
                          storage ? "readonly buffer" : "uniform");
    sum += fmt::format(" + v{0} * {0}u", i);
  }
  const Sets s = create_sets(device, bindings, 1);
  write_buffer(device, s.sets[0], 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC, out, 4);
  for (uint32_t i = 1; i <= bindings_count; ++i) write_buffer(device, s.sets[0], i, type, in, 16);
  const Resources none;
  const Pipeline pipeline = create_compute_pipeline(
      device,
      compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                   fmt::format("layout(local_size_x = 1) in; {} void main() {{ o = 0u{}; }}", blocks, sum)),
      s.layout, none);
  device.run([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    for (uint32_t k = 0; k < dispatches; ++k) {
      std::vector<uint32_t> offsets = {k * step};
      for (uint32_t i = 1; i <= bindings_count; ++i) offsets.push_back((k * 3 + i) % 16 * step);
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, s.layout, 0, 1, s.sets.data(),
                              static_cast<uint32_t>(offsets.size()), offsets.data());
      vkCmdDispatch(commands, 1, 1, 1);
    }
    full_barrier(commands);
  });
  for (uint32_t k = 0; k < dispatches; ++k) {
    uint32_t want = 0;
    for (uint32_t i = 1; i <= bindings_count; ++i) want += words[(k * 3 + i) % 16 * step / 4] * i;
    const uint32_t got = out.as<uint32_t>()[k * step / 4];
    expect(got == want, fmt::format("dispatch {}: {}, not {}", k, got, want));
  }
}

// Descriptors copied from one set to another, element ranges included; the update runs over into the next binding.
void run_copy(Device& device, uint32_t from_element, uint32_t to_element, uint32_t count) {
  constexpr uint32_t kArray = 6;
  const std::vector<VkDescriptorSetLayoutBinding> bindings = {
      {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, kArray, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
      {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}};
  const Sets s = create_sets(device, bindings, 2);
  std::vector<Buffer> a, b;
  const Buffer out = create_buffer(device, kArray * 4);
  for (uint32_t i = 0; i < kArray; ++i) {
    a.push_back(create_buffer(device, std::vector<uint32_t>{100 + i}));
    b.push_back(create_buffer(device, std::vector<uint32_t>{200 + i}));
    write_buffer(device, s.sets[0], 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, a[i], VK_WHOLE_SIZE, i);
    write_buffer(device, s.sets[1], 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, b[i], VK_WHOLE_SIZE, i);
  }
  write_buffer(device, s.sets[1], 1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, out);
  VkCopyDescriptorSet copy{VK_STRUCTURE_TYPE_COPY_DESCRIPTOR_SET};
  copy.srcSet = s.sets[0];
  copy.srcArrayElement = from_element;
  copy.dstSet = s.sets[1];
  copy.dstArrayElement = to_element;
  copy.descriptorCount = count;
  vkUpdateDescriptorSets(device.handle(), 0, nullptr, 1, &copy);
  std::string body;
  for (uint32_t i = 0; i < kArray; ++i) body += fmt::format("o[{0}] = d[{0}].v; ", i);
  const Pipeline pipeline = create_compute_pipeline(
      device,
      compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                   fmt::format("layout(local_size_x = 1) in; layout(set = 1, binding = 0, std430) buffer D {{ uint v; }} d[{}];\n"
                               "layout(set = 1, binding = 1, std430) buffer O {{ uint o[]; }};\nvoid main() {{ {} }}",
                               kArray, body)),
      s.layout, Resources{});
  device.run([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, s.layout, 1, 1, &s.sets[1], 0, nullptr);
    vkCmdDispatch(commands, 1, 1, 1);
    full_barrier(commands);
  });
  for (uint32_t i = 0; i < kArray; ++i) {
    const bool copied = i >= to_element && i < to_element + count;
    const uint32_t want = copied ? 100 + i - to_element + from_element : 200 + i;
    expect(out.as<uint32_t>()[i] == want, fmt::format("element {} is {}, not {}", i, out.as<uint32_t>()[i], want));
  }
}

// Sets bound one by one, and rebound in part, stay as the rules of layout compatibility say.
void run_sets(Device& device, uint32_t count, uint32_t rebound) {
  require(count <= device.limits().maxBoundDescriptorSets, "as many sets");
  const std::vector<VkDescriptorSetLayoutBinding> bindings = {
      {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}};
  const Sets s = create_sets(device, bindings, count);
  std::vector<Buffer> buffers;
  std::string blocks, body;
  for (uint32_t i = 0; i < count; ++i) {
    buffers.push_back(create_buffer(device, std::vector<uint32_t>{i, 0}));
    write_buffer(device, s.sets[i], 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, buffers[i]);
    blocks += fmt::format("layout(set = {0}, binding = 0, std430) buffer B{0} {{ uint v{0}, n{0}; }};\n", i);
    body += fmt::format("atomicAdd(n{0}, v{0} + 1u + {0}u * 256u); ", i);
  }
  const Pipeline pipeline =
      create_compute_pipeline(device,
                              compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                                           fmt::format("layout(local_size_x = 1) in; {} void main() {{ {} }}", blocks, body)),
                              s.layout, Resources{});
  device.run([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    for (uint32_t i = count; i-- > 0;)
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, s.layout, i, 1, &s.sets[i], 0, nullptr);
    vkCmdDispatch(commands, 1, 1, 1);
    full_barrier(commands);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, s.layout, rebound, 1, &s.sets[(rebound + 1) % count], 0,
                            nullptr);
    vkCmdDispatch(commands, 1, 1, 1);
    full_barrier(commands);
  });
  for (uint32_t i = 0; i < count; ++i) {
    uint32_t want = i + 1 + i * 256;
    if (i != rebound) want += i + 1 + i * 256;
    if (i == (rebound + 1) % count) want += i + 1 + rebound * 256;
    expect(buffers[i].as<uint32_t>()[1] == want, fmt::format("set {}: {}, not {}", i, buffers[i].as<uint32_t>()[1], want));
  }
}

void run_update_template(Device& device, uint32_t count, size_t stride) {
  require(device.caps().api_version >= VK_API_VERSION_1_1, "Vulkan 1.1");
  const std::vector<VkDescriptorSetLayoutBinding> bindings = {
      {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, count, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
      {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}};
  const Sets s = create_sets(device, bindings, 1);
  const Buffer out = create_buffer(device, count * 4);
  std::vector<Buffer> buffers;
  std::vector<std::byte> data(16 + stride * count + sizeof(VkDescriptorBufferInfo));
  std::string body;
  for (uint32_t i = 0; i < count; ++i) {
    buffers.push_back(create_buffer(device, std::vector<uint32_t>{word_of(i)}));
    const VkDescriptorBufferInfo info{buffers.back().handle, 0, VK_WHOLE_SIZE};
    std::memcpy(data.data() + 16 + stride * i, &info, sizeof(info));
    body += fmt::format("o[{0}] = d[{0}].v; ", i);
  }
  const VkDescriptorBufferInfo out_info{out.handle, 0, VK_WHOLE_SIZE};
  std::memcpy(data.data() + 16 + stride * count, &out_info, sizeof(out_info));
  const VkDescriptorUpdateTemplateEntry entries[] = {{0, 0, count, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 16, stride},
                                                     {1, 0, 1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 16 + stride * count, 0}};
  VkDescriptorUpdateTemplateCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_UPDATE_TEMPLATE_CREATE_INFO};
  info.descriptorUpdateEntryCount = 2;
  info.pDescriptorUpdateEntries = entries;
  info.templateType = VK_DESCRIPTOR_UPDATE_TEMPLATE_TYPE_DESCRIPTOR_SET;
  info.descriptorSetLayout = s.set_layout;
  const auto update = make<VkDescriptorUpdateTemplate, vkDestroyDescriptorUpdateTemplate>(
      device, vkCreateDescriptorUpdateTemplate, info, "vkCreateDescriptorUpdateTemplate");
  vkUpdateDescriptorSetWithTemplate(device.handle(), s.sets[0], update, data.data());
  const Pipeline pipeline = create_compute_pipeline(
      device,
      compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                   fmt::format("layout(local_size_x = 1) in; layout(binding = 0, std430) buffer D {{ uint v; }} d[{}];\n"
                               "layout(binding = 1, std430) buffer O {{ uint o[]; }};\nvoid main() {{ {} }}",
                               count, body)),
      s.layout, Resources{});
  device.run([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, s.layout, 0, 1, s.sets.data(), 0, nullptr);
    vkCmdDispatch(commands, 1, 1, 1);
    full_barrier(commands);
  });
  for (uint32_t i = 0; i < count; ++i) expect(out.as<uint32_t>()[i] == word_of(i), fmt::format("element {}", i));
}

}  // namespace

void register_binding_model() {
  constexpr const char* kSection = "14.2 Descriptor Sets";
  for (const auto& [kind, kind_name] : kKinds) {
    for (const StageName& stage : kStages) {
      for (const uint32_t count : {1u, 4u}) {
        for (const Indexing indexing : {Indexing::kConstant, Indexing::kUniform}) {
          add_case(
              "binding_model.shader_access",
              fmt::format("{}.{}_{}_{}", stage.name, kind_name, count, indexing == Indexing::kConstant ? "constant" : "dynamic"),
              kSection, [=, kind = kind, &stage](Device& device) { run_array(device, kind, stage.stage, count, indexing); });
        }
      }
    }
  }
  for (const bool storage : {false, true}) {
    for (const uint32_t count : {1u, 2u, 3u}) {
      add_case("binding_model.dynamic_offset", fmt::format("{}_{}", storage ? "storage" : "uniform", count), kSection,
               [=](Device& device) { run_dynamic_offsets(device, storage, count); });
    }
  }
  for (const auto& [from, to, count] : {std::tuple{0u, 0u, 6u}, {2u, 0u, 3u}, {0u, 5u, 1u}, {5u, 0u, 1u}, {1u, 3u, 2u}}) {
    add_case("binding_model.descriptor_copy", fmt::format("{}_to_{}_count_{}", from, to, count), kSection,
             [from = from, to = to, count = count](Device& device) { run_copy(device, from, to, count); });
  }
  for (uint32_t count = 2; count <= 4; ++count) {
    for (uint32_t rebound = 0; rebound < count; ++rebound) {
      add_case("binding_model.descriptor_sets", fmt::format("{}_sets_rebind_{}", count, rebound), "14.2.2 Pipeline Layouts",
               [=](Device& device) { run_sets(device, count, rebound); });
    }
  }
  for (const uint32_t count : {1u, 3u}) {
    for (const size_t stride : {sizeof(VkDescriptorBufferInfo), size_t{40}}) {
      add_case("binding_model.update_template", fmt::format("{}_stride_{}", count, stride), kSection,
               [=](Device& device) { run_update_template(device, count, stride); });
    }
  }
}

}  // namespace pineda::cts
