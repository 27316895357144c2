// perp view: looks at what perp run wrote: a page, pictures, glTF.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/view_page.hpp"
#include "perp/core/errors.hpp"
#include "perp/view/page.hpp"
#include "perp/view/pictures.hpp"

namespace perp {
namespace {

namespace fs = std::filesystem;

struct ViewArguments {
  std::vector<std::string> folders;
  std::string html, gltf, frames;
  std::vector<double> png;
  double fps = not_set;
  int strip = 0;
  std::string size;
};

/// WxH, in pixels.
std::pair<int, int> read_size(const std::string& text) {
  if (text.empty()) return {800, 600};
  int width = 0, height = 0;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, width);
  const auto second = first.ptr != end && *first.ptr == 'x'
                          ? std::from_chars(first.ptr + 1, end, height)
                          : std::from_chars_result{first.ptr, std::errc::invalid_argument};
  constexpr int least = 100, most = 8000;  // what a browser's window takes
  if (first.ec != std::errc() || second.ec != std::errc() || second.ptr != end ||
      std::min(width, height) < least || std::max(width, height) > most)
    refuse("perp view", "--size", text, "needs to be WxH, each from 100 to 8000 pixels");
  return {width, height};
}

void say_page(const fs::path& html, const PageFacts& facts) {
  std::printf(
      "wrote %s, %.2f MB: %zu rows, %zu keys, positions within %.2g m, orientations within %.2g rad\n",
      html.c_str(), 1e-6 * static_cast<double>(facts.bytes), facts.rows, facts.keys, facts.position_error,
      facts.turning_error);
  if (!facts.has_three)
    std::printf(
        "three.js is not installed (Debian: libjs-three), so the page has plots and values, and no moving "
        "scene\n");
}

int view(const ViewArguments& arguments) {
  if (!std::isnan(arguments.fps) && arguments.frames.empty())
    refuse("perp view", "--fps", arguments.fps, "goes with --frames");
  if (!arguments.frames.empty() && !(arguments.fps > 0))
    refuse("perp view", "--fps", std::isnan(arguments.fps) ? "not given" : shortest(arguments.fps),
           "needs to be positive [1/s]");
  const auto [width, height] = read_size(arguments.size);
  if (!arguments.size.empty() && arguments.png.empty() && arguments.frames.empty())
    refuse("perp view", "--size", arguments.size, "goes with --png or --frames");
  std::vector<RecordedRun> runs;
  for (const std::string& folder : arguments.folders) runs.push_back(read_recorded_run(folder));
  const bool pictures = !arguments.png.empty() || !arguments.frames.empty() || arguments.strip > 0;
  const fs::path first = arguments.folders[0];
  if (!arguments.gltf.empty()) {
    const std::string text = gltf_of(runs[0]);
    write_whole(arguments.gltf, text);
    std::printf("wrote %s, %.2f MB of glTF 2.0\n", arguments.gltf.c_str(),
                1e-6 * static_cast<double>(text.size()));
    if (arguments.html.empty() && !pictures) return Done;
  }
  PageFacts facts;
  const std::string page = page_of(runs, facts);
  const fs::path html = arguments.html.empty() ? first / "view.html" : fs::path(arguments.html);
  if (!arguments.html.empty() || !pictures) {
    write_whole(html, page);
    say_page(html, facts);
  }
  if (!pictures) return Done;
  Camera camera(page, facts);
  std::vector<std::string> files;
  for (const double t : arguments.png)
    files.push_back(camera.picture(t, first / ("view-" + shortest(t) + ".png"), width, height));
  if (arguments.strip > 0) files.push_back(camera.strip(arguments.strip, first / "view-strip.svg"));
  if (!arguments.frames.empty()) {
    const double t_0 = runs[0].t.front(), t_1 = runs[0].t.back();
    const auto count = static_cast<int>(std::floor((t_1 - t_0) * arguments.fps * (1 + 1e-12))) + 1;
    char name[32];
    for (int i = 0; i < count; ++i) {
      std::snprintf(name, sizeof name, "frame-%05d.png", i);
      files.push_back(
          camera.picture(t_0 + i / arguments.fps, fs::path(arguments.frames) / name, width, height));
    }
  }
  for (const std::string& file : files) std::printf("wrote %s\n", file.c_str());
  return Done;
}

}  // namespace

void write_view(const std::vector<std::string>& folders, const fs::path& html, bool quiet) {
  std::vector<RecordedRun> runs;
  for (const std::string& folder : folders) runs.push_back(read_recorded_run(folder));
  PageFacts facts;
  write_whole(html, page_of(runs, facts));
  if (!quiet) say_page(html, facts);
}

void add_view_command(CLI::App& perp, int& status) {
  CLI::App* command = perp.add_subcommand(
      "view", "Show the motion that perp run wrote: a page for a browser, pictures, glTF");
  const auto arguments = std::make_shared<ViewArguments>();
  command
      ->add_option("OUT", arguments->folders, "the folder of a run; a second one is drawn over it as a ghost")
      ->required()
      ->expected(1, 2);
  command->add_option("--html", arguments->html, "the page; OUT/view.html if nothing else is asked for")
      ->type_name("FILE");
  command
      ->add_option("--gltf", arguments->gltf,
                   "the motion as glTF 2.0 (.gltf), for Blender and other programs")
      ->type_name("FILE");
  command
      ->add_option("--png", arguments->png,
                   "pictures OUT/view-T.png at these times [s], by headless Chromium")
      ->delimiter(',')
      ->type_name("T1,T2,...");
  command->add_option("--frames", arguments->frames, "a picture every 1/F s into this folder")
      ->type_name("DIR");
  command->add_option("--fps", arguments->fps, "of --frames [1/s]")->type_name("F");
  command->add_option("--size", arguments->size, "of --png and --frames [pixels]; 800x600 if not given")
      ->type_name("WxH");
  command
      ->add_option("--svg-strip", arguments->strip,
                   "N views over time with a scale bar, as OUT/view-strip.svg")
      ->type_name("N")
      ->check(CLI::Range(1, 40));
  command->callback([&status, arguments] { status = view(*arguments); });
}

}  // namespace perp
