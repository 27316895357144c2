// The page's parts as they stand in src/view/page, put into the program when it is built.
#pragma once

#include <string_view>

namespace perp {

extern const std::string_view page_html, page_css, page_js;

}  // namespace perp
