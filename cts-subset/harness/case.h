// A conformance case: a name, the section of the specification that it checks, and a function that throws unless the driver is
// right.
//
// Groups are named after the official suite's (pipeline.blend, glsl.operators, ...). All cases come from tables: a group
// registers one case for each row. Expected values are computed here, from the specification's formulas, never by the driver
// under test.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace pineda::cts {

class Device;

struct NotSupported : std::runtime_error {  // the driver does not offer what the case needs, and says so
  using std::runtime_error::runtime_error;
};
struct Failure : std::runtime_error {  // the driver is wrong; the text says where, what was expected and what came
  using std::runtime_error::runtime_error;
};

void require(bool supported, std::string_view what);    // throws NotSupported
void expect(bool holds, const std::string& otherwise);  // throws Failure

// `section` names the chapter and section of the Vulkan specification (or of the SPIR-V or GLSL one, said so).
void add_case(std::string group, std::string name, std::string section, std::function<void(Device&)> run);

// One function per file in groups/; each adds its cases.
void register_all_groups();

}  // namespace pineda::cts
