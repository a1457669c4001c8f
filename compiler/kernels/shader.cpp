#include "compiler/kernels/kernels.h"

namespace pineda::kernels {

Shader shader_of(const spirv::Module& module) {
  return {spirv::info(module),
          [&module](ir::Builder& b, spirv::StageInterface& stage) { return spirv::translate(module, b, stage); }};
}

}  // namespace pineda::kernels
