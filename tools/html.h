// What the report pages share.
#pragma once

#include <string>

namespace pineda::tools {

std::string escape_html(const std::string& text);
std::string date_text();                                               // now, for a page's header
void write_file(const std::string& path, const std::string& content);  // throws ToolError

}  // namespace pineda::tools
