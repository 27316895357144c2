// A browser without a screen, to take pictures of pages.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace perp {

/// Path of Chromium (chromium, chromium-browser, google-chrome on PATH); empty if there is none.
[[nodiscard]] std::string find_browser();

/// A picture of `page` as its fragment (the part after #) asks, `width` x `height` pixels, into `png`. Throws std::runtime_error with
/// what the browser said if there is no picture after it ended.
void take_picture(const std::string& browser, const std::filesystem::path& page, const std::string& fragment,
                  int width, int height, const std::filesystem::path& png);

/// The document that `page` has become once its scripts have run, as HTML. Throws likewise.
[[nodiscard]] std::string document_of(const std::string& browser, const std::filesystem::path& page,
                                      const std::string& fragment, int width, int height);

}  // namespace perp
