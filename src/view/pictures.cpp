#include "perp/view/pictures.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "perp/core/errors.hpp"
#include "view/browser.hpp"

namespace perp {

namespace fs = std::filesystem;

void write_whole(const fs::path& path, const std::string& text) {
  const auto fail = [&] {
    throw std::runtime_error(path.string() + " could not be written: " + std::strerror(errno));
  };
  std::error_code failed;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), failed);
  const std::string part = path.string() + ".part";
  std::FILE* file = std::fopen(part.c_str(), "wb");
  if (file == nullptr) fail();
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const int why = errno;
  if (std::fclose(file) != 0 || !written) {
    if (!written) errno = why;
    std::remove(part.c_str());
    fail();
  }
  if (std::rename(part.c_str(), path.c_str()) != 0) fail();
}

Camera::Camera(std::string page, const PageFacts& facts) : browser_(find_browser()) {
  if (browser_.empty())
    throw std::runtime_error(
        "pictures need Chromium (Debian: chromium), which is not on PATH; perp view --html writes the page "
        "without it");
  if (!facts.has_three)
    throw std::runtime_error("pictures need three.js (Debian: libjs-three), which is not installed");
  std::string name = (fs::temp_directory_path() / "perp-page-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("a temporary folder could not be made");
  folder_ = name;
  page_ = folder_ / "page.html";
  write_whole(page_, page);
}

Camera::~Camera() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::string Camera::picture(double t, const fs::path& png, int width, int height) const {
  std::error_code failed;
  if (png.has_parent_path()) fs::create_directories(png.parent_path(), failed);
  take_picture(browser_, page_, "bare&t=" + shortest(t), width, height, png);
  return png.string();
}

std::string Camera::strip(int count, const fs::path& svg) const {
  const std::string document = document_of(browser_, page_, "strip=" + std::to_string(count), 800, 600);
  const std::string begin = "<pre id=\"strip\">", end = "</pre>";
  const std::size_t from = document.find(begin), to = document.find(end, from);
  if (from == std::string::npos || to == std::string::npos)
    throw std::runtime_error("the page drew no strip of views");
  std::string text;
  for (std::size_t i = from + begin.size(); i < to;) {
    const auto is = [&](const char* entity) { return document.compare(i, std::strlen(entity), entity) == 0; };
    if (is("&lt;"))
      text += '<', i += 4;
    else if (is("&gt;"))
      text += '>', i += 4;
    else if (is("&amp;"))
      text += '&', i += 5;
    else
      text += document[i++];
  }
  write_whole(svg, text);
  return svg.string();
}

}  // namespace perp
