// Pieces of pages.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace perp {

[[nodiscard]] std::string escaped_html(std::string_view text);

/// A page with this title and body, in the style of perp's pages.
[[nodiscard]] std::string html_page(std::string_view title, std::string_view body);

/// The <svg> of a file; a sentence where there is none.
[[nodiscard]] std::string svg_of(const std::filesystem::path& file);

}  // namespace perp
