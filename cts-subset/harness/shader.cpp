#include "cts-subset/harness/shader.h"

#include <glslang/Include/glslang_c_interface.h>
#include <glslang/Public/resource_limits_c.h>

#include <memory>
#include <spirv-tools/libspirv.hpp>
#include <stdexcept>

namespace pineda::cts {
namespace {

glslang_stage_t stage_of(VkShaderStageFlagBits stage) {
  switch (stage) {
    case VK_SHADER_STAGE_VERTEX_BIT:
      return GLSLANG_STAGE_VERTEX;
    case VK_SHADER_STAGE_FRAGMENT_BIT:
      return GLSLANG_STAGE_FRAGMENT;
    case VK_SHADER_STAGE_COMPUTE_BIT:
      return GLSLANG_STAGE_COMPUTE;
    default:
      throw std::logic_error("stage without cases");
  }
}

struct ShaderDeleter {
  void operator()(glslang_shader_t* shader) const { glslang_shader_delete(shader); }
};
struct ProgramDeleter {
  void operator()(glslang_program_t* program) const { glslang_program_delete(program); }
};

}  // namespace

Spirv compile_glsl(VkShaderStageFlagBits stage, std::string_view source, int spirv_minor) {
  static const bool initialized = glslang_initialize_process();
  if (!initialized) throw std::logic_error("glslang does not start");
  const std::string text = "#version 450\n" + std::string(source);
  glslang_input_t input{};
  input.language = GLSLANG_SOURCE_GLSL;
  input.stage = stage_of(stage);
  input.client = GLSLANG_CLIENT_VULKAN;
  input.client_version = spirv_minor ? GLSLANG_TARGET_VULKAN_1_1 : GLSLANG_TARGET_VULKAN_1_0;
  input.target_language = GLSLANG_TARGET_SPV;
  input.target_language_version = spirv_minor ? GLSLANG_TARGET_SPV_1_3 : GLSLANG_TARGET_SPV_1_0;
  input.code = text.c_str();
  input.default_version = 450;
  input.default_profile = GLSLANG_NO_PROFILE;
  input.messages = GLSLANG_MSG_DEFAULT_BIT;
  input.resource = glslang_default_resource();
  const std::unique_ptr<glslang_shader_t, ShaderDeleter> shader(glslang_shader_create(&input));
  if (!glslang_shader_preprocess(shader.get(), &input) || !glslang_shader_parse(shader.get(), &input)) {
    throw std::logic_error(std::string(glslang_shader_get_info_log(shader.get())) + text);
  }
  const std::unique_ptr<glslang_program_t, ProgramDeleter> program(glslang_program_create());
  glslang_program_add_shader(program.get(), shader.get());
  if (!glslang_program_link(program.get(), GLSLANG_MSG_SPV_RULES_BIT | GLSLANG_MSG_VULKAN_RULES_BIT)) {
    throw std::logic_error(std::string(glslang_program_get_info_log(program.get())) + text);
  }
  glslang_program_SPIRV_generate(program.get(), input.stage);
  Spirv words(glslang_program_SPIRV_get_size(program.get()));
  glslang_program_SPIRV_get(program.get(), words.data());
  return words;
}

Spirv assemble(std::string_view assembly, int spirv_minor) {
  spvtools::SpirvTools tools(spirv_minor ? SPV_ENV_VULKAN_1_1 : SPV_ENV_VULKAN_1_0);
  std::string log;
  tools.SetMessageConsumer([&](spv_message_level_t, const char*, const spv_position_t& position, const char* message) {
    log += "line " + std::to_string(position.line + 1) + ": " + message + "\n";
  });
  Spirv words;
  if (!tools.Assemble(assembly.data(), assembly.size(), &words) || !tools.Validate(words)) {
    throw std::logic_error(log + std::string(assembly));
  }
  return words;
}

}  // namespace pineda::cts
