#include "io/html.hpp"

#include <fstream>
#include <iterator>

#include "perp/version.hpp"

namespace perp {
namespace {

constexpr const char* page_style = R"(
:root { color-scheme: light; }
body { font: 16px/1.5 Helvetica, Arial, sans-serif; color: #222; background: #fff; max-width: 1080px; margin: 2.5em auto; padding: 0 1.5em; }
h1 { font-weight: 600; font-size: 1.7em; margin: 0 0 .2em; }
h2 { font-weight: 600; font-size: 1.25em; margin: 1.8em 0 .2em; border-top: 1px solid #ddd; padding-top: .8em; }
p { margin: .3em 0; } .quiet { color: #666; font-size: .92em; }
svg { width: 100%; height: auto; }
table { border-collapse: collapse; font-size: .92em; margin: .6em 0; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .22em .9em .22em 0; border-bottom: 1px solid #e8e8e8; vertical-align: top; }
th { color: #666; font-weight: 500; } td.n { text-align: right; }
.good, .bad { padding: .7em 1em; margin: 1em 0; border-left: 4px solid #009E73; background: #f1f9f6; }
.bad { border-color: #D55E00; background: #fdf3ec; }
)";

}  // namespace

std::string escaped_html(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const std::string_view special = "<>&\"";
    constexpr const char* names[] = {"&lt;", "&gt;", "&amp;", "&quot;"};
    const std::size_t at = special.find(c);
    if (at == std::string_view::npos)
      result += c;
    else
      result += names[at];
  }
  return result;
}

std::string html_page(std::string_view title, std::string_view body) {
  std::string text = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>";
  text += escaped_html(title);
  text += "</title>\n<style>";
  text += page_style;
  text += "</style>\n</head>\n<body>\n<h1>" + escaped_html(title) + "</h1>\n";
  text += body;
  text += "<p class=quiet>Written by perp " + std::string(version) + ".</p>\n</body>\n</html>\n";
  return text;
}

std::string svg_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string svg{std::istreambuf_iterator<char>(in), {}};
  const std::size_t begin = svg.find("<svg");
  if (begin == std::string::npos) return "<p class=quiet>no picture</p>\n";
  return svg.substr(begin) + "\n";
}

}  // namespace perp
