// Pictures of a run without a screen, and the motion as glTF.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "perp/view/page.hpp"

namespace perp {

/// Takes pictures of a page by headless Chromium. Throws std::runtime_error if there is none, if the page has no moving scene, and if
/// a picture did not come.
class Camera {
 public:
  Camera(std::string page, const PageFacts& facts);
  ~Camera();
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  /// The scene at time t; the file's name.
  std::string picture(double t, const std::filesystem::path& png, int width = 800, int height = 600) const;
  /// `count` views over the run as one SVG with times and a scale bar; the file's name.
  std::string strip(int count, const std::filesystem::path& svg) const;

 private:
  std::string browser_;
  std::filesystem::path folder_, page_;
};

/// The bodies, their solids and their motion as one glTF 2.0 file (JSON, buffers inside): a node a body, with translations and
/// rotations as cubic splines. Axes are the run's, turned so that glTF's y is up.
[[nodiscard]] std::string gltf_of(const RecordedRun& run);

/// Writes `text` as `path`, whole or not at all; makes its folder. Throws std::runtime_error with the system's reason.
void write_whole(const std::filesystem::path& path, const std::string& text);

}  // namespace perp
